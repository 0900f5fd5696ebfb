// Two sequences compared, frame by frame and as a whole.
#pragma once

#include "fvv_compare/measure.h"
#include "fvv_compare/sequence.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace fvv::compare {

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
