// A capture, a stream or meshes in memory as a sequence of surfaces in one unit, and the pairs of frames that
// are compared.
#pragma once

#include "fvv/stream.h"
#include "fvv_cxx/input_file.h"
#include "fvv_cxx/range.h"
#include "fvv_scene/capture.h"

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace fvv::compare {

class Sequence {
public:
  // path: a capture.json (any name that ends in .json), the folder of one, or a stream.
  // Error when it cannot be opened or holds no meshes.
  explicit Sequence(const std::string &path);
  // A stream; stream and limits (NULL: defaults) live as long as this object, and one thread at a time reads.
  // rung: of a ladder of quality (fvv_cxx/rung.h).
  explicit Sequence(const InputFile &stream, size_t rung = 0, const fvv_limits *limits = nullptr);
  // Meshes in memory, numbered from 0, in the unit and of the frame rate of what they are compared with. Each
  // is valid (fvv_geometry/mesh.h); texture coordinates are ignored. name: in messages.
  Sequence(const std::string &name, std::vector<geometry::Mesh> meshes);
  Sequence(const Sequence &) = delete;
  Sequence &operator=(const Sequence &) = delete;

  const std::string &path() const { return name; }
  bool is_capture() const { return kind == Kind::capture; }
  bool is_in_memory() const { return kind == Kind::memory; }
  bool scale_unknown() const { return unknown_scale; }
  fvv_rational frame_duration() const { return duration; } // seconds, in lowest terms; not of memory
  // Warnings, a sentence each: damage, times between frames.
  const std::vector<std::string> &warnings() const { return notes; }

  struct Frame {
    int64_t number; // in file names of a capture; of a stream its place
    int64_t place;  // frame durations since the beginning
    size_t index;   // of a stream
  };
  // Those that have a mesh; both numbers rise.
  const std::vector<Frame> &frames() const { return list; }

  // Positions in metres, or units of the source when the scale is unknown. i: index in frames(). Throws
  // Error, also when the frame has no mesh or an empty one. With the normals that a stream or the memory has;
  // with those of a capture's file, if it has some and they are requested. Several threads may call it.
  geometry::Mesh mesh(size_t i, bool normals = false) const;

  // Calls visit with the path of every file that this object opened or opens.
  void visit_files(const std::function<void(const std::string &)> &visit) const;

private:
  void open_stream(size_t rung, const fvv_limits *limits);
  void open_capture();
  void number_frames(uint64_t ticks, size_t count, const fvv_limits *limits);
  geometry::Mesh stream_mesh(const Frame &wanted) const;
  std::set<int64_t> mesh_times(const fvv_limits *limits) const;

  enum class Kind { capture, stream, memory } kind;
  std::string name;
  bool unknown_scale = false;
  fvv_rational duration = {1, 25};
  std::vector<std::string> notes;
  std::vector<Frame> list;
  scene::Capture capture;
  std::vector<geometry::Mesh> meshes; // in memory
  std::unique_ptr<InputFile> own;
  const InputFile *file = nullptr;
  std::unique_ptr<fvv_stream, void (*)(fvv_stream *)> stream{nullptr, fvv_stream_close};
  mutable std::mutex one_at_a_time; // a stream's handle is not thread-safe
  uint16_t track = 0;
};

struct FramePair {
  size_t a, b; // indices in frames()
};

struct Matching {
  std::vector<FramePair> pairs;      // in order
  std::vector<std::string> warnings; // frames that have no partner, a sentence for each sequence
};

// Frames of two captures belong together when they have the same number, otherwise when they come as many
// frame durations after the first ones. frames: only these numbers of A. start: the number in A of the frame
// that B's first one shows. Error when units or frame rates are unlike, or no frame has a partner.
Matching match(const Sequence &a, const Sequence &b, const std::optional<fvv::Range> &frames,
               std::optional<int64_t> start);

} // namespace fvv::compare
