#include "fvv_geometry/hull.h"
#include "fvv_cxx/error.h"
#include "fvv_cxx/parallel.h"
#include "fvv_geometry/rig.h"
#include "hull_mesh.h"
#include "octree.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fvv::hull {

namespace {

constexpr size_t block = Octree::block, block_points = block * block * block;

class Carving : public Field {
public:
  Carving(const Grid &points, const std::vector<Silhouette> &views, const Options &how)
      : grid(points), silhouettes(views), options(how), octree(points, views, how),
        slots(octree.blocks[0] * octree.blocks[1] * octree.blocks[2], outside) {}

  void fill() {
    const Octree::Leaves leaves = octree.refine();
    for (const Cube &cube : leaves.inside)
      for (size_t z = cube.z; z < cube.z + cube.size; z++)
        for (size_t y = cube.y; y < cube.y + cube.size; y++)
          for (size_t x = cube.x; x < cube.x + cube.size; x++) slots[slot_at(x, y, z)] = inside;
    values.resize(leaves.mixed.size() * block_points);
    for (size_t i = 0; i < leaves.mixed.size(); i++)
      slots[slot_at(leaves.mixed[i].x, leaves.mixed[i].y, leaves.mixed[i].z)] = int32_t(i);
    constexpr size_t together = 16; // blocks that a thread fills in one piece of work
    fvv::parallel(options.threads, (leaves.mixed.size() + together - 1) / together, [&](size_t piece) {
      std::vector<double> distances;
      for (size_t i = piece * together; i < std::min(leaves.mixed.size(), (piece + 1) * together); i++)
        fill_block(leaves.mixed[i], &values[i * block_points], distances);
    });
    for (const Cube &leaf : leaves.mixed) collect_mixed(leaf);
    std::sort(mixed.begin(), mixed.end());
  }

  // Every bit of a block that is not certainly outside.
  std::vector<uint8_t> occupancy() const {
    std::vector<uint8_t> bits((grid.points() + 7) / 8);
    for (size_t z = 0; z < octree.blocks[2]; z++)
      for (size_t y = 0; y < octree.blocks[1]; y++)
        for (size_t x = 0; x < octree.blocks[0]; x++) {
          if (slots[slot_at(x, y, z)] == outside) continue;
          for_points(x, y, z, [&](size_t i, size_t j, size_t k) {
            const size_t point = grid.at(i, j, k);
            if (value_at(i, j, k) < 0) bits[point / 8] |= uint8_t(1u << point % 8);
          });
        }
    return bits;
  }

  double value(size_t point) const override {
    const std::array<size_t, 3> p = grid.place(point);
    return value_at(p[0], p[1], p[2]);
  }

  void set(size_t point, double to) override {
    const std::array<size_t, 3> p = grid.place(point);
    const size_t x = p[0] / block, y = p[1] / block, z = p[2] / block;
    if (slots[slot_at(x, y, z)] < 0) {
      std::vector<double> known(block_points);
      for_points(x, y, z, [&](size_t i, size_t j, size_t k) { known[within(i, j, k)] = value_at(i, j, k); });
      slots[slot_at(x, y, z)] = int32_t(values.size() / block_points);
      values.insert(values.end(), known.begin(), known.end());
    }
    values[size_t(slots[slot_at(x, y, z)]) * block_points + within(p[0], p[1], p[2])] = to;
  }

  std::vector<size_t> mixed; // cells, as march() has them

private:
  static constexpr int32_t outside = -1, inside = -2; // in slots

  size_t slot_at(size_t x, size_t y, size_t z) const {
    return (z * octree.blocks[1] + y) * octree.blocks[0] + x;
  }
  static size_t within(size_t i, size_t j, size_t k) {
    return (k % block * block + j % block) * block + i % block;
  }

  template <class Visit> void for_points(size_t x, size_t y, size_t z, Visit visit) const {
    for (size_t k = z * block; k < std::min((z + 1) * block, grid.count[2]); k++)
      for (size_t j = y * block; j < std::min((y + 1) * block, grid.count[1]); j++)
        for (size_t i = x * block; i < std::min((x + 1) * block, grid.count[0]); i++) visit(i, j, k);
  }

  double value_at(size_t i, size_t j, size_t k) const {
    const int32_t slot = slots[slot_at(i / block, j / block, k / block)];
    if (slot >= 0) return values[size_t(slot) * block_points + within(i, j, k)];
    return slot == inside ? -grid.cell : value_outside(grid.point(double(i), double(j), double(k)));
  }

  // Of points that are known to be outside: where one is next to a full block at the floor, the depth below
  // it decides.
  double value_outside(Vec3 p) const {
    const double below = depth_below(options.floor, p);
    return below > 0 ? std::min(below, grid.cell) : grid.cell;
  }

  void fill_block(const Cube &leaf, double *out, std::vector<double> &distances) const {
    for_points(leaf.x, leaf.y, leaf.z, [&](size_t i, size_t j, size_t k) {
      const Vec3 p = grid.point(double(i), double(j), double(k));
      const size_t at[3] = {i, j, k};
      bool border = false;
      for (size_t a = 0; a < 3; a++) border = border || at[a] == 0 || at[a] + 1 == grid.count[a];
      out[within(i, j, k)] = border ? value_outside(p) : octree.value(p, leaf, distances);
    });
  }

  // The cells from points of a leaf whose corners differ in sign. Cells from points of other blocks have
  // none: what is certain of a block holds for the neighbours of its points.
  void collect_mixed(const Cube &leaf) {
    constexpr size_t side = block + 1;
    bool negative[side][side][side] = {};
    const size_t from[3] = {leaf.x * block, leaf.y * block, leaf.z * block};
    size_t points[3];
    for (size_t a = 0; a < 3; a++) points[a] = std::min(side, grid.count[a] - from[a]);
    size_t found = 0;
    for (size_t k = 0; k < points[2]; k++)
      for (size_t j = 0; j < points[1]; j++)
        for (size_t i = 0; i < points[0]; i++) {
          negative[k][j][i] = value_at(from[0] + i, from[1] + j, from[2] + k) < 0;
          found += negative[k][j][i];
        }
    if (found == 0 || found == points[0] * points[1] * points[2]) return;
    for (size_t k = 0; k + 1 < points[2]; k++)
      for (size_t j = 0; j + 1 < points[1]; j++)
        for (size_t i = 0; i + 1 < points[0]; i++) {
          int corners = 0;
          for (size_t c = 0; c < 8; c++) corners += negative[k + (c >> 2)][j + (c >> 1 & 1)][i + (c & 1)];
          if (corners > 0 && corners < 8) mixed.push_back(grid.at(from[0] + i, from[1] + j, from[2] + k));
        }
  }

  const Grid &grid;
  const std::vector<Silhouette> &silhouettes;
  const Options &options;
  const Octree octree;
  std::vector<int32_t> slots; // of each block: where its values are, or outside or inside
  std::vector<double> values; // metres, negative inside; the border of the grid is outside
};

void check_size(const Grid &grid) {
  double points = 1;
  for (const size_t count : grid.count) points *= double(count);
  if (!(points <= double(most_points)))
    throw Error("cell: expected a grid of at most " + std::to_string(most_points) + " points, found " +
                    std::to_string(grid.count[0]) + " x " + std::to_string(grid.count[1]) + " x " +
                    std::to_string(grid.count[2]) + ": use a larger cell or smaller bounds",
                Error::usage);
  for (const size_t count : grid.count)
    if (count < 2) throw Error("bounds: expected an extent on every axis, found none", Error::usage);
}

} // namespace

Hull carve(const Grid &grid, const std::vector<Silhouette> &silhouettes, const Options &options) {
  check_size(grid);
  Carving carving(grid, silhouettes, options);
  carving.fill();
  Hull out;
  out.grid = grid;
  out.surface = march(grid, carving, std::move(carving.mixed), [&](size_t point, int axis) {
    return interpolated_crossing(carving.value(point), carving.value(point + grid.stride(axis)));
  });
  out.occupancy = carving.occupancy();
  drop_components(out, options.min_share);
  if (options.smoothing) smooth(out, silhouettes, options);
  return out;
}

namespace {

// Ranges of blocks along each axis, high exclusive.
struct Range {
  std::array<size_t, 3> low{SIZE_MAX, SIZE_MAX, SIZE_MAX}, high{0, 0, 0};

  void add(size_t axis, size_t from, size_t to) {
    low[axis] = std::min(low[axis], from);
    high[axis] = std::max(high[axis], to);
  }
  void add(const Range &other) {
    for (size_t a = 0; a < 3; a++) add(a, other.low[a], other.high[a]);
  }
  size_t longest() const {
    size_t most = 0;
    for (size_t a = 0; a < 3; a++) most = std::max(most, high[a] - std::min(low[a], high[a]));
    return most;
  }
};

// What an octree leaves, block by block.
class Blocks {
public:
  Blocks(const Octree &of, const Grid &points)
      : octree(of), grid(points), states(of.blocks[0] * of.blocks[1] * of.blocks[2], empty) {
    const Octree::Leaves leaves = octree.refine();
    for (const Cube &cube : leaves.inside)
      for (uint32_t z = cube.z; z < cube.z + cube.size; z++)
        for (uint32_t y = cube.y; y < cube.y + cube.size; y++)
          for (uint32_t x = cube.x; x < cube.x + cube.size; x++) states[at(x, y, z)] = inside;
    bool any = !leaves.inside.empty();
    const auto set = [&](const Cube &cube, bool is_inside) {
      states[at(cube.x, cube.y, cube.z)] = is_inside ? inside : possible;
      any = any || is_inside;
    };
    std::vector<double> distances;
    constexpr double half = (block - 1) / 2.0;
    for (const Cube &cube : leaves.mixed) set(cube, is_inside(cube, half, half, half, distances));
    // Of bodies that are thinner than a block the middles of blocks may miss all.
    for (size_t i = 0; !any && i < leaves.mixed.size(); i++)
      for (size_t p = 0; !any && p < block_points; p++)
        set(leaves.mixed[i], is_inside(leaves.mixed[i], double(p % block), double(p / block % block),
                                       double(p / (block * block)), distances));
  }

  // around: the connected components that matter; those with few blocks inside are phantoms that few cameras
  // see, mostly beside a camera. If no block is inside, all. inside: their blocks that are inside.
  struct Found {
    Range around, inside;
  };
  Found find() {
    constexpr double least_share = 0.005; // of the largest component's blocks inside
    std::vector<Component> components;
    for (size_t i = 0; i < states.size(); i++)
      if (states[i] != empty) components.push_back(take(i));
    size_t most = 0;
    for (const Component &component : components) most = std::max(most, component.count);
    Found out;
    for (const Component &component : components) {
      if (double(component.count) < least_share * double(most)) continue;
      out.around.add(component.around);
      out.inside.add(component.inside);
    }
    return out;
  }

private:
  static constexpr uint8_t empty = 0, possible = 1, inside = 2; // in states

  struct Component {
    Range around, inside;
    size_t count = 0; // inside
  };

  size_t at(size_t x, size_t y, size_t z) const { return (z * octree.blocks[1] + y) * octree.blocks[0] + x; }

  // Whether a point of a block is.
  bool is_inside(const Cube &cube, double x, double y, double z, std::vector<double> &distances) const {
    const Vec3 p = grid.point(cube.x * block + x, cube.y * block + y, cube.z * block + z);
    return octree.value(p, cube, distances) < 0;
  }

  // The component of a block, whose blocks are empty afterwards.
  Component take(size_t first) {
    Component out;
    const size_t stride[3] = {1, octree.blocks[0], octree.blocks[0] * octree.blocks[1]};
    std::vector<size_t> stack;
    const auto visit = [&](size_t here) {
      if (states[here] == empty) return;
      const bool is_inside = states[here] == inside;
      out.count += is_inside;
      for (size_t a = 0; a < 3; a++) {
        const size_t place = here / stride[a] % octree.blocks[a];
        out.around.add(a, place, place + 1);
        if (is_inside) out.inside.add(a, place, place + 1);
      }
      states[here] = empty;
      stack.push_back(here);
    };
    visit(first);
    while (!stack.empty()) {
      const size_t here = stack.back();
      stack.pop_back();
      for (size_t a = 0; a < 3; a++) {
        const size_t place = here / stride[a] % octree.blocks[a];
        if (place > 0) visit(here - stride[a]);
        if (place + 1 < octree.blocks[a]) visit(here + stride[a]);
      }
    }
    return out;
  }

  const Octree &octree;
  const Grid &grid;
  std::vector<uint8_t> states;
};

} // namespace

std::optional<Box> bounds(const std::vector<Silhouette> &silhouettes, const Options &options) {
  // Blocks along the longest side of the box that is searched: near cameras, coarse ones are never certain.
  constexpr size_t coarse = 64, finest = 256;
  constexpr double worthwhile = 0.8; // a pass that leaves more of the box than this needs smaller blocks
  constexpr double tight = 0.8;      // inside is this much of what is possible: the box is good enough
  if (silhouettes.size() < options.least_views || silhouettes.empty()) return std::nullopt;
  std::vector<fvv_camera> cameras;
  for (const Silhouette &silhouette : silhouettes) cameras.push_back(silhouette.calibration());
  const geometry::RigSpace space = geometry::rig_space(cameras);
  const Vec3 half = Vec3{1, 1, 1} * space.radius;
  Box box{space.centre - half, space.centre + half};
  bool any = false;
  for (size_t blocks = coarse; blocks <= finest;) {
    const Vec3 extent = box.high - box.low;
    const double longest = std::max({extent.x, extent.y, extent.z});
    const Grid grid = grid_over(box.low, box.high, longest / double(blocks * block));
    const Octree octree(grid, silhouettes, options);
    const Blocks::Found found = Blocks(octree, grid).find();
    const Range &around = found.around;
    if (around.longest() == 0) return std::nullopt;
    const auto corner = [&](const std::array<size_t, 3> &b) {
      return grid.point(double(b[0] * block), double(b[1] * block), double(b[2] * block));
    };
    box = {corner(around.low), corner(around.high)};
    any = found.inside.longest() > 0;
    if (double(found.inside.longest()) > tight * double(around.longest())) break;
    if (double(around.longest()) > worthwhile * double(blocks)) blocks *= 2;
  }
  if (!any) return std::nullopt;
  return box;
}

double cell_for(const std::vector<Silhouette> &silhouettes, const Box &box, double pixels) {
  double finest = std::numeric_limits<double>::infinity();
  for (const Silhouette &silhouette : silhouettes) {
    const fvv_camera &camera = silhouette.calibration();
    double c[3];
    fvv_camera_centre(&camera, c);
    const double away = std::hypot(std::max({box.low.x - c[0], 0.0, c[0] - box.high.x}),
                                   std::max({box.low.y - c[1], 0.0, c[1] - box.high.y}),
                                   std::max({box.low.z - c[2], 0.0, c[2] - box.high.z}));
    finest = std::min(finest, away / std::max(camera.fx, camera.fy));
  }
  return pixels * finest;
}

} // namespace fvv::hull
