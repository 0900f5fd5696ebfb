// Shared by the parts of fvvcodecs: meshes, one line of its table, and the clock.
#pragma once

#include "fvv_scene/mesh_file.h"

#include "compare/src/measure.h"

#include <algorithm>
#include <ctime>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace fvv::codecs {

using geometry::Mesh;

// One codec at one setting over some frames of a sequence.
struct Row {
  Row(const std::string &of, const std::string &at, double with_step)
      : codec(of), setting(at), step(with_step) {}

  std::string codec, setting;
  double step; // metres from one position that can be coded to the next
  // Sums over frames.
  size_t frames = 0;
  double bytes = 0, vertices = 0; // of the source
  double encode = 0, decode = 0;  // seconds
  // Surface to surface as fvvcompare measures it, from the source and to it; metres.
  double squares[2] = {0, 0};
  size_t measured = 0;
  compare::Histogram distances[2];

  void measure(const Mesh &source, const Mesh &decoded);
  void take_errors(const Row &other) {
    std::copy(other.squares, other.squares + 2, squares);
    std::copy(other.distances, other.distances + 2, distances);
    measured = other.measured;
  }
  // One more frame. Times in seconds.
  void count(const Mesh &source, size_t bytes_of_frame, double encode_time, double decode_time) {
    frames++;
    bytes += double(bytes_of_frame);
    vertices += double(source.vertex_count());
    encode += encode_time;
    decode += decode_time;
  }
  nlohmann::ordered_json json() const;
};

// Of the processor, so that other load on the machine changes it least: all codecs run on one thread.
template <class Body> double seconds(const Body &body) {
  const std::clock_t begin = std::clock();
  body();
  return double(std::clock() - begin) / CLOCKS_PER_SEC;
}

// The faster of two runs.
template <class Body> double faster(const Body &body) {
  const double first = seconds(body);
  return std::min(first, seconds(body));
}

// Draco at several levels, and meshoptimizer alone and after zstd, each with this number of bits for a
// coordinate over the box of each mesh.
std::vector<Row> peer_rows(const std::vector<Mesh> &frames, int bits);

// Draco's own encoder as its command line drives it: corners of the faces in single precision, identical ones
// merged, positions quantised over the box of the mesh.
struct PlainDraco {
  explicit PlainDraco(const Mesh &mesh);
  // The largest number of bits whose step is no finer than this one; returns that step too.
  int bits_for(double step, double *coarser) const;
  // level: 0 (fastest) to 10 (smallest). bits: of a coordinate.
  std::string encode(const Mesh &mesh, int bits, int level) const;
  // On the lattice with origin 0 and this step, as fvv has it.
  std::string encode_on_lattice(const Mesh &mesh, double step, int level) const;
  static void decode(const std::string &bytes);
  double low[3], extent; // of the box, its longest side
};

} // namespace fvv::codecs
