// Frames of a mesh that share their faces, into one glTF file, which plays them.
#pragma once

#include "fvv_scene/mesh_file.h"

#include <cstdint>
#include <string>
#include <vector>

namespace fvv::scene {

// One frame or more, with the vertices and faces of each other. positions: indices of a lattice, 3 a vertex.
// normals: of any frame that has positions, 3 a vertex, or empty in all. texture: indices u v of a vertex, in
// steps of 2^-texture_bits, v down, or empty. colours: R G B of a vertex, display values, or empty. times: of
// the frames, in seconds, from 0 on, and increasing as float32. held_until: later, before the next frame's
// time, if the mesh of a frame rests; else not above its time. names: of the frames.
struct MeshRun {
  struct Frame {
    std::vector<int32_t> positions;
    std::vector<float> normals;
    double time = 0;
    std::string name;
    double held_until = 0;
  };
  std::vector<Frame> frames;
  std::vector<uint32_t> faces;
  std::vector<uint32_t> texture;
  unsigned texture_bits = 0;
  std::vector<uint8_t> colours;

  size_t vertex_count() const { return frames[0].positions.size() / 3; }
};

// draco: KHR_draco_mesh_compression. meshopt: EXT_meshopt_compression, with positions as integers
// (KHR_mesh_quantization) where 16 bits hold them. Both keep every coordinate on its lattice point.
enum class Compression { none, draco, meshopt };

// A GLB, the same bytes for the same run everywhere. Frames after the first are morph targets, which carry
// their names, and the animation "frames" shows each at its time, and until held_until; between two frames it
// interpolates. A run
// of one frame has no animation. picture: a file of PNG or JPEG for texture coordinates, shown without
// lighting; empty: none, and the mesh has its colours (not with Draco), else it is grey. Compressed, vertices
// have another order and those of no face are left out; with Draco, which takes a run of one frame only,
// faces have another order too, and with meshopt some begin with another of their corners. Positions that
// float32 does not hold, as in map coordinates, are relative to an origin, which is in the translation of the
// node and in "extras": {"origin": [x, y, z]}; *is_local: whether they are. Error for a coordinate that a
// float32 would take to another point of the lattice all the same.
std::string format_run(const MeshRun &run, const Lattice &lattice, const std::string &picture,
                       Compression compression, const std::string &name, bool *is_local = nullptr);

} // namespace fvv::scene
