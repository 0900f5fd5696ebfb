// How far two sequences of meshes are apart, frame by frame and as a whole. docs/tools/fvvcompare.md has the
// formulas and their sources.
#pragma once

#include "fvv/types.h"
#include "fvv_cxx/values.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fvv::media {
struct MemoryLimit;
}

namespace fvv::compare {

// A capture, a stream or meshes in memory as a sequence of surfaces in one unit.
class Sequence {
public:
  // path: a capture.json (any name that ends in .json), the folder of one, or a stream. Throws Error when it
  // cannot be opened or holds no meshes.
  // limit: of a mesh file of a capture, and of a frame's mesh in a stream.
  Sequence(const std::string &path, const media::MemoryLimit &limit);
  explicit Sequence(const std::string &path); // without a limit
  // A stream. name: in messages. stream, its reader and limits (NULL: defaults) live as long as this object,
  // and one thread at a time reads. rung: of a ladder of quality.
  Sequence(const fvv_input &stream, const std::string &name, size_t rung = 0,
           const fvv_limits *limits = nullptr);
  // Meshes in memory, numbered from 0, in the unit and of the frame rate of what they are compared with. Each
  // is valid (fvv_cxx/values.h); texture coordinates are ignored. name: in messages.
  Sequence(const std::string &name, std::vector<geometry::Mesh> meshes);
  ~Sequence();
  Sequence(const Sequence &) = delete;
  Sequence &operator=(const Sequence &) = delete;

  const std::string &path() const;
  bool is_capture() const;
  bool is_in_memory() const;
  bool scale_unknown() const;
  fvv_rational frame_duration() const; // seconds, in lowest terms; not of memory
  // Warnings, a sentence each: damage, times between frames.
  const std::vector<std::string> &warnings() const;

  struct Frame {
    int64_t number; // in file names of a capture; of a stream its place
    int64_t place;  // frame durations since the beginning
    size_t index;   // of a stream
  };
  // Those that have a mesh; both numbers rise.
  const std::vector<Frame> &frames() const;

  // Positions in metres, or units of the source when the scale is unknown. i: index in frames(). Throws
  // Error, also when the frame has no mesh or an empty one. With the normals that a stream or the memory has;
  // with those of a capture's file, if it has some and they are requested. Several threads may call it.
  geometry::Mesh mesh(size_t i, bool normals = false) const;

  // Calls visit with the path of every file that this object opened or opens.
  void visit_files(const std::function<void(const std::string &)> &visit) const;

private:
  class State;
  std::unique_ptr<State> state;
};

struct FramePair {
  size_t a, b; // indices in Sequence::frames()
};

struct Figures {
  double rms = 0, mean = 0, p99 = 0, max = 0;
};

// Which points D1 and D2 are measured at: the vertices, or these and the samples of the surface.
enum class Points { vertices, samples };

// Of one frame against the one before it, over all vertices of B that faces use.
struct MotionError {
  double rms = 0, max = 0; // |motion of B - motion of A|
  double motion = 0;       // rms motion of A, to compare with
};

constexpr size_t default_samples = 50000;

struct Options {
  std::optional<fvv::Range> frames; // numbers of A
  std::optional<int64_t> start;     // number in A of B's first frame
  size_t samples = default_samples;
  Points points = Points::vertices;
  std::optional<double> peak; // of PSNR, in the sequences' unit
  uint32_t threads = 1;       // the figures are the same for any number
  // Called on the calling thread, with 0 and then after each pair of frames. What it throws ends the work.
  std::function<void(size_t done, size_t pairs)> progress;
};

// From A to B, from B to A, and the worse of the two.
enum Direction { a_to_b, b_to_a, symmetric, direction_count };

struct Errors {
  std::array<Figures, direction_count> distance; // max: the Hausdorff distance
  std::array<double, direction_count> d1, d2;    // mean squared errors
  std::array<Figures, direction_count> angle;    // degrees
  std::array<double, direction_count> turned;    // shares
};

struct FrameResult {
  FramePair pair = {};
  int64_t number_a = 0, number_b = 0;
  size_t vertices_a = 0, faces_a = 0, vertices_b = 0, faces_b = 0;
  Errors errors = {};
  std::optional<MotionError> motion; // against the frame before
};

// Over all pairs of frames that follow each other while neither sequence changes its faces.
struct Temporal {
  size_t pairs = 0, by_order = 0; // by_order: those of which vertices have the same order
  double rms = 0, max = 0, motion = 0;
  double furthest = 0; // of vertices that were matched by nearness, where that was done
};

struct Result {
  bool scale_unknown = false;
  double peak = 0;
  size_t frames_a = 0, frames_b = 0; // of the sequences
  std::vector<FrameResult> frames;   // those that were compared
  Errors errors = {};                // of all of them
  std::optional<Temporal> temporal;  // none: no two frames have constant topology
  std::vector<std::string> warnings; // warnings
  std::vector<std::string> losses;   // one line for each frame that could not be compared
};

// 10 log10(peak^2 / mse); infinite for 0.
double psnr(double peak, double mse);

// The meshes of a pair of frames as they are compared: with normals if those of both, or of a stream and the
// other's own, are compared.
struct Meshes {
  geometry::Mesh a, b;
};
Meshes load(const Sequence &a, const Sequence &b, const FramePair &pair);

// Throws Error if nothing can be compared; result has the losses even then. result: empty.
void compare(const Sequence &a, const Sequence &b, const Options &options, Result &result);

} // namespace fvv::compare
