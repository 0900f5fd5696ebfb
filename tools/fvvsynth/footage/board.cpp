// The pattern, the walk and the mesh of the board.
#include "fvvsynth/footage/board.h"

#include <cmath>

namespace fvv::synth {

namespace {

// Markers 0 to 14 of OpenCV's DICT_4X4_50, 16 bits row by row, the first bit the highest, 1 white. They are
// facts of the dictionary; a test detects the board with OpenCV.
constexpr uint16_t markers[] = {0xb532, 0x0f9a, 0x332d, 0x9946, 0x549e, 0x79cd, 0x9e2e, 0xc4f2,
                                0xfeda, 0xcf56, 0xf991, 0x11a7, 0x0eb7, 0x2a0f, 0x24b1};
constexpr int bits = 4, cells = bits + 2; // with a black border

constexpr double turn = 6.283185307179586;
constexpr double thickness = 0.002;
constexpr uint32_t divisions = 28; // of each side of a sheet: pieces of about 5 cm

// From the direction that the face of a board looks to, and how it is turned in its plane.
render::Mat3 facing(Vec3 normal, Vec3 above, double roll) {
  const Vec3 z = -normal;
  const Vec3 down = -normalised(above - normal * dot(above, normal)), right = cross(down, z);
  const double c = std::cos(roll), s = std::sin(roll);
  return {right * c + down * s, down * c - right * s, z};
}

} // namespace

bool board_is_white(double x, double y) {
  using Pattern = BoardPattern;
  if (x < 0 || y < 0 || x >= Pattern::width || y >= Pattern::height) return true;
  const auto column = uint32_t(x / Pattern::square), row = uint32_t(y / Pattern::square);
  if ((column + row) % 2 == 0) return false;
  constexpr double margin = (Pattern::square - Pattern::marker) / 2, cell = Pattern::marker / cells;
  const int across = int(std::floor((x - column * Pattern::square - margin) / cell)),
            along = int(std::floor((y - row * Pattern::square - margin) / cell));
  if (across < 0 || along < 0 || across >= cells || along >= cells) return true;
  if (across == 0 || along == 0 || across == cells - 1 || along == cells - 1) return false;
  const uint32_t number = row * Pattern::columns / 2 + column / 2;
  return markers[number] >> (bits * bits - 1 - (along - 1) * bits - (across - 1)) & 1;
}

std::vector<BoardPose> board_walk(uint64_t seed, size_t count) {
  using Pattern = BoardPattern;
  constexpr double golden = 0.6180339887498949; // directions that stay even for any number of poses
  Random random(seed ^ 0xb0a4d);
  std::vector<BoardPose> walk;
  const auto hold = [&](const render::Mat3 &axes, Vec3 middle) {
    walk.push_back({axes, middle - axes.x * (Pattern::width / 2) - axes.y * (Pattern::height / 2)});
  };
  hold(facing({0, 1, 0}, {0, 0, -1}, 0), {0, thickness, 0});
  for (size_t i = 1; i < count; i++) {
    const double yaw = turn * (double(i) * golden + random.between(-0.04, 0.04)),
                 tilt = turn * random.between(-0.03, 0.10), roll = turn * random.between(-0.08, 0.08);
    const Vec3 normal{std::cos(yaw) * std::cos(tilt), std::sin(tilt), std::sin(yaw) * std::cos(tilt)};
    // High enough for the longest diagonal, and so far around that lenses are seen to their corners.
    const Vec3 middle{random.between(-3.0, 3.0), random.between(1.05, 2.1), random.between(-2.4, 2.4)};
    hold(facing(normal, {0, 1, 0}, roll), middle);
  }
  return walk;
}

Board::Board(const BoardPose &pose) {
  add_sheet(pose, 0, 0);
  add_sheet(pose, thickness, 1);
}

// side: 0 in front, 1 behind.
void Board::add_sheet(const BoardPose &pose, double depth, double side) {
  using Pattern = BoardPattern;
  const uint32_t first = uint32_t(positions.size() / 3), row = divisions + 1;
  const auto append = [](std::vector<float> &to, Vec3 value) {
    for (const double one : {value.x, value.y, value.z}) to.push_back(float(one));
  };
  for (uint32_t j = 0; j <= divisions; j++)
    for (uint32_t i = 0; i <= divisions; i++) {
      const double x = (Pattern::width + 2 * Pattern::rim) * i / divisions - Pattern::rim,
                   y = (Pattern::height + 2 * Pattern::rim) * j / divisions - Pattern::rim;
      append(positions, pose.origin + pose.axes * Vec3{x, y, depth});
      append(normals, side == 0 ? -pose.axes.z : pose.axes.z);
      append(texture, {x, y, side});
      exposure.push_back(1);
      if (i == divisions || j == divisions) continue;
      const uint32_t corner = first + j * row + i;
      faces.insert(faces.end(),
                   {corner, corner + row, corner + 1, corner + 1, corner + row, corner + row + 1});
    }
}

render::Reflectance Board::material(uint32_t, Vec3 at) {
  constexpr double white = 0.55, black = 0.03, grey = 0.25; // matt
  const double value = at.z > 0.5 ? grey : board_is_white(at.x, at.y) ? white : black;
  return {{value, value, value}, 0};
}

} // namespace fvv::synth
