// The ChArUco board that is walked through the volume: its pattern, its mesh, and where it is held.
#pragma once

#include "fvv_render/picture.h"
#include "fvvsynth/random.h"

#include <cstdint>
#include <vector>

namespace fvv::synth {

// As OpenCV's CharucoBoard makes it: the first square is black, and the markers of the dictionary 4x4_50
// (also the first of 4x4_100) are in the white squares, row by row. All lengths in metres.
struct BoardPattern {
  static constexpr uint32_t columns = 6, rows = 5; // squares
  static constexpr double square = 0.24, marker = 0.18;
  static constexpr double rim = 0.04; // white, around the squares
  static constexpr double width = columns * square, height = rows * square;
};

// Whether the pattern is white at (x, y), x to the right and y down from the corner of the first square.
bool board_is_white(double x, double y);

// Where a board is: its axes in the world, x to the right and y down as its pattern is seen, z away from who
// sees it, and the corner of the first square.
struct BoardPose {
  render::Mat3 axes;
  Vec3 origin;
};

// The first pose lies on the floor in the middle, face up. All others are held above it, turned to all sides,
// up and down.
std::vector<BoardPose> board_walk(uint64_t seed, size_t count);

// The board as an object of the scene: a sheet with the pattern on the front, grey behind, so finely divided
// that its edges follow a lens.
class Board {
public:
  explicit Board(const BoardPose &pose);
  render::Mesh mesh() const {
    return {positions.data(), positions.size() / 3, faces.data(), faces.size() / 3};
  }
  render::Attributes attributes() const { return {normals.data(), texture.data(), exposure.data()}; }
  static render::Reflectance material(uint32_t face, Vec3 texture);

private:
  void add_sheet(const BoardPose &pose, double depth, double side);

  std::vector<float> positions, normals, texture, exposure;
  std::vector<uint32_t> faces;
};

} // namespace fvv::synth
