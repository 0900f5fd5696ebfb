#include "fvvsynth/charts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <unordered_map>

namespace fvv::synth {

namespace {

constexpr uint32_t nothing = UINT32_MAX;
constexpr double least_cosine = 0.36; // between a face and the axis that it is projected along
constexpr double agreement = 0.30;    // what one neighbour's direction is worth, as cosine
constexpr int rounds = 12;
constexpr double touch = 1e-7;  // metres by which triangles that share an edge may overlap by rounding
constexpr double bucket = 0.02; // metres: about the length of an edge

// +x, -x, +y, -y, +z, -z of a region.
Vec3 direction(const Mat3 &axes, int side) {
  const Vec3 axis = side < 2 ? axes.x : side < 4 ? axes.y : axes.z;
  return side % 2 ? -axis : axis;
}

using Adjacent = std::array<uint32_t, 3>; // the faces across a face's edges

std::vector<Adjacent> adjacency(const std::vector<uint32_t> &faces) {
  std::vector<Adjacent> result(faces.size() / 3, Adjacent{nothing, nothing, nothing});
  std::map<std::pair<uint32_t, uint32_t>, std::pair<size_t, size_t>> open; // edge: its face and its place
  for (size_t face = 0; face < result.size(); face++)
    for (size_t c = 0; c < 3; c++) {
      const uint32_t from = faces[3 * face + c], to = faces[3 * face + (c + 1) % 3];
      const auto other = open.find({to, from});
      if (other == open.end()) {
        open[{from, to}] = {face, c};
        continue;
      }
      result[face][c] = uint32_t(other->second.first);
      result[other->second.first][other->second.second] = uint32_t(face);
      open.erase(other);
    }
  return result;
}

using Triangle = std::array<Flat, 3>;

// Whether two counter-clockwise triangles have more in common than a border (separating axes).
bool overlap(const Triangle &a, const Triangle &b) {
  const auto separated = [](const Triangle &one, const Triangle &other) {
    for (size_t c = 0; c < 3; c++) {
      const Flat &from = one[c], &to = one[(c + 1) % 3];
      const double x = to[1] - from[1], y = from[0] - to[0], size = std::sqrt(x * x + y * y); // outwards
      double nearest = std::numeric_limits<double>::infinity();
      for (const Flat &p : other) nearest = std::min(nearest, (p[0] - from[0]) * x + (p[1] - from[1]) * y);
      if (nearest > -touch * size) return true;
    }
    return false;
  };
  return !separated(a, b) && !separated(b, a);
}

// The triangles of a chart on its plane, found by place.
class Plane {
public:
  // False when the triangle overlaps one that is there.
  bool add(const Triangle &triangle) {
    const auto range = [&](size_t axis) {
      const auto [low, high] = std::minmax({triangle[0][axis], triangle[1][axis], triangle[2][axis]});
      return std::pair(int64_t(std::floor(low / bucket)), int64_t(std::floor(high / bucket)));
    };
    const auto [left, right] = range(0);
    const auto [low, high] = range(1);
    const auto each = [&](const auto &visit) {
      for (int64_t row = low; row <= high; row++)
        for (int64_t column = left; column <= right; column++)
          if (!visit(buckets[row * (int64_t(1) << 32) + column])) return false;
      return true;
    };
    if (!each([&](const std::vector<size_t> &there) {
          return std::none_of(there.begin(), there.end(),
                              [&](size_t i) { return overlap(triangles[i], triangle); });
        }))
      return false;
    each([&](std::vector<size_t> &there) {
      there.push_back(triangles.size());
      return true;
    });
    triangles.push_back(triangle);
    return true;
  }

private:
  std::vector<Triangle> triangles;
  std::unordered_map<int64_t, std::vector<size_t>> buckets;
};

class Cutter {
public:
  Cutter(const Surface &of, const std::vector<uint8_t> &regions, const std::vector<Mat3> &frames)
      : surface(of), region(regions), axes(frames), around(adjacency(of.faces)), normals(of.faces.size() / 3),
        side(normals.size()) {
    for (size_t i = 0; i < normals.size(); i++)
      normals[i] = normalised(cross(corner(i, 1) - corner(i, 0), corner(i, 2) - corner(i, 0)));
  }

  std::vector<Chart> run() {
    for (size_t i = 0; i < side.size(); i++) side[i] = best(i, 0);
    for (int round = 0; round < rounds; round++)
      for (size_t i = 0; i < side.size(); i++) side[i] = best(i, agreement);
    std::vector<Chart> charts;
    std::vector<bool> taken(side.size());
    for (size_t i = 0; i < side.size(); i++)
      if (!taken[i]) charts.push_back(grow(uint32_t(i), taken));
    return charts;
  }

private:
  Vec3 corner(size_t face, size_t c) const { return surface.vertices[surface.faces[3 * face + c]]; }

  // The direction that suits a face and, by weight, those beside it (iterated conditional modes; Besag, "On
  // the statistical analysis of dirty pictures", 1986).
  int best(size_t face, double weight) const {
    int chosen = 0;
    double most = -1;
    for (int s = 0; s < 6; s++) {
      const double cosine = dot(normals[face], direction(axes[region[face]], s));
      double value = cosine;
      for (const uint32_t next : around[face])
        if (next != nothing && region[next] == region[face] && side[next] == s) value += weight;
      if (cosine > least_cosine && value > most) {
        chosen = s;
        most = value;
      }
    }
    return chosen;
  }

  // Breadth first from a face, as far as its region and direction go and nothing overlaps.
  Chart grow(uint32_t first, std::vector<bool> &taken) const {
    const Mat3 &frame = axes[region[first]];
    const Vec3 front = direction(frame, side[first]);
    Chart chart;
    chart.up = side[first] / 2 == 1 ? frame.z : frame.y;
    chart.right = cross(chart.up, front);
    Plane plane;
    std::vector<bool> refused(taken.size());
    const auto take = [&](uint32_t face) {
      if (face == nothing || taken[face] || refused[face] || region[face] != region[first] ||
          side[face] != side[first])
        return;
      if (plane.add(
              {chart.flat(corner(face, 0)), chart.flat(corner(face, 1)), chart.flat(corner(face, 2))})) {
        taken[face] = true;
        chart.faces.push_back(face);
      } else {
        refused[face] = true;
      }
    };
    take(first);
    for (size_t i = 0; i < chart.faces.size(); i++)
      for (const uint32_t next : around[chart.faces[i]]) take(next);
    return chart;
  }

  const Surface &surface;
  const std::vector<uint8_t> &region;
  const std::vector<Mat3> &axes;
  const std::vector<Adjacent> around;
  std::vector<Vec3> normals;
  std::vector<int> side;
};

} // namespace

std::vector<Chart> make_charts(const Surface &surface, const std::vector<uint8_t> &region,
                               const std::vector<Mat3> &axes) {
  return Cutter(surface, region, axes).run();
}

} // namespace fvv::synth
