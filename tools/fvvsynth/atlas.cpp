// Charts, their layout, and colours of the texture map.
#include "fvvsynth/atlas.h"

#include "fvv_cxx/parallel.h"
#include "fvv_geometry/rect_pack.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <unordered_map>

namespace fvv::synth {

namespace {

constexpr uint32_t nothing = UINT32_MAX;
constexpr double least_cosine = 0.36; // between a face and the axis that it is projected along
constexpr double agreement = 0.30;    // weight of one neighbour's direction, as cosine
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

namespace {

constexpr uint32_t most_size = 16384;

struct Bounds {
  Flat low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  Flat high{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
};

Bounds bounds(const Surface &surface, const Chart &chart) {
  Bounds result;
  for (const uint32_t face : chart.faces)
    for (size_t c = 0; c < 3; c++) {
      const Flat p = chart.flat(surface.vertices[surface.faces[3 * face + c]]);
      for (size_t axis = 0; axis < 2; axis++) {
        result.low[axis] = std::min(result.low[axis], p[axis]);
        result.high[axis] = std::max(result.high[axis], p[axis]);
      }
    }
  return result;
}

// The charts' places at a density; none if they do not fit.
std::vector<ChartBox> pack(const std::vector<Bounds> &charts, double density, uint32_t size) {
  std::vector<stbrp_rect> rects;
  for (const Bounds &one : charts) {
    double side[2];
    for (size_t axis = 0; axis < 2; axis++)
      side[axis] = std::ceil((one.high[axis] - one.low[axis]) * density) + 2 * chart_margin;
    if (side[0] > size || side[1] > size) return {};
    stbrp_rect rect = {};
    rect.id = int(rects.size());
    rect.w = stbrp_coord(side[0]);
    rect.h = stbrp_coord(side[1]);
    rects.push_back(rect);
  }
  std::vector<stbrp_node> nodes(size);
  stbrp_context context;
  stbrp_init_target(&context, int(size), int(size), nodes.data(), int(size));
  if (!stbrp_pack_rects(&context, rects.data(), int(rects.size()))) return {};
  std::vector<ChartBox> places;
  for (const stbrp_rect &rect : rects)
    places.push_back({uint32_t(rect.x), uint32_t(rect.y), uint32_t(rect.w), uint32_t(rect.h)});
  return places;
}

} // namespace

Layout lay_out(const Surface &surface, const std::vector<Chart> &charts, uint32_t size) {
  std::vector<Bounds> all;
  for (const Chart &chart : charts) all.push_back(bounds(surface, chart));
  Layout layout;
  layout.size = size;
  // In whole texels per metre: the bisection ends where no rounding decides.
  uint32_t fits = 0, fails = most_size;
  while (size <= most_size && fits + 1 < fails) {
    const uint32_t density = fits + (fails - fits) / 2;
    std::vector<ChartBox> places = pack(all, density, size);
    (places.empty() ? fails : fits) = density;
    if (!places.empty()) layout.places = std::move(places);
  }
  if (!fits)
    throw std::invalid_argument("an atlas of " + std::to_string(size) + " x " + std::to_string(size) +
                                " texels cannot hold " + std::to_string(charts.size()) + " charts");
  layout.density = fits;

  const size_t vertex_count = surface.vertices.size();
  layout.faces.resize(surface.faces.size());
  layout.texels.resize(vertex_count);
  for (size_t i = 0; i < vertex_count; i++) layout.source.push_back(uint32_t(i));
  // Which chart a vertex was last seen in, and as which copy: charts come one after the other.
  constexpr size_t none = SIZE_MAX;
  std::vector<size_t> chart_of(vertex_count, none);
  std::vector<uint32_t> copy_of(vertex_count);
  for (size_t i = 0; i < charts.size(); i++)
    for (const uint32_t face : charts[i].faces)
      for (size_t c = 0; c < 3; c++) {
        const uint32_t vertex = surface.faces[3 * face + c];
        if (chart_of[vertex] != i) {
          const Flat p = charts[i].flat(surface.vertices[vertex]);
          const Flat texel = {layout.places[i].x + chart_margin + (p[0] - all[i].low[0]) * layout.density,
                              layout.places[i].y + chart_margin + (all[i].high[1] - p[1]) * layout.density};
          if (chart_of[vertex] == none) {
            copy_of[vertex] = vertex;
            layout.texels[vertex] = texel;
          } else {
            copy_of[vertex] = uint32_t(layout.source.size());
            layout.source.push_back(vertex);
            layout.texels.push_back(texel);
          }
          chart_of[vertex] = i;
        }
        layout.faces[3 * face + c] = copy_of[vertex];
      }
  return layout;
}

namespace {

using render::Rgb;

constexpr uint32_t fine = 4; // samples of a texel, each way

// A square picture some of whose texels have a colour yet: sums of linear light and their weights.
struct Sheet {
  uint32_t size;
  std::vector<Rgb> sum;
  std::vector<double> weight;

  explicit Sheet(uint32_t side) : size(side), sum(size_t(side) * side), weight(sum.size()) {}
  size_t at(size_t x, size_t y) const { return y * size + x; }
};

// Calls visit(face, column, row, weights) for every fine sample of the chart's place that lies in a face; one
// on an edge belongs to the first.
template <class Visit>
void for_samples(const Chart &chart, const Layout &layout, const ChartBox &place, const Visit &visit) {
  const int64_t columns = int64_t(place.width) * fine, rows = int64_t(place.height) * fine;
  std::vector<bool> taken(size_t(columns * rows));
  for (const uint32_t face : chart.faces) {
    Flat p[3]; // in samples from the place's corner, the first sample at 0
    for (size_t c = 0; c < 3; c++) {
      const Flat &texel = layout.texels[layout.faces[3 * face + c]];
      p[c] = {(texel[0] - place.x) * fine - 0.5, (texel[1] - place.y) * fine - 0.5};
    }
    const auto area = [](const Flat &a, const Flat &b, const Flat &c) {
      return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    };
    const double whole = area(p[0], p[1], p[2]);
    const auto [left, right] = std::minmax({p[0][0], p[1][0], p[2][0]});
    const auto [top, bottom] = std::minmax({p[0][1], p[1][1], p[2][1]});
    for (int64_t row = std::max<int64_t>(0, int64_t(std::ceil(top))); row < rows && double(row) <= bottom;
         row++)
      for (int64_t column = std::max<int64_t>(0, int64_t(std::ceil(left)));
           column < columns && double(column) <= right; column++) {
        const Flat at = {double(column), double(row)};
        const std::array<double, 3> weights = {area(p[1], p[2], at) / whole, area(p[2], p[0], at) / whole,
                                               area(p[0], p[1], at) / whole};
        const size_t index = size_t(row * columns + column);
        if (taken[index] || *std::min_element(weights.begin(), weights.end()) < 0) continue;
        taken[index] = true;
        visit(face, size_t(column), size_t(row), weights);
      }
  }
}

// Colours that have one go on into texels beside them, one texel further each time.
void spread(Sheet &sheet, uint32_t texels) {
  for (uint32_t round = 0; round < texels; round++) {
    const Sheet before = sheet;
    for (size_t y = 0; y < sheet.size; y++)
      for (size_t x = 0; x < sheet.size; x++) {
        if (before.weight[sheet.at(x, y)] > 0) continue;
        Rgb sum;
        double count = 0;
        for (size_t j = y - (y > 0); j <= std::min<size_t>(y + 1, sheet.size - 1); j++)
          for (size_t i = x - (x > 0); i <= std::min<size_t>(x + 1, sheet.size - 1); i++) {
            const double weight = before.weight[sheet.at(i, j)];
            if (!(weight > 0)) continue;
            sum += before.sum[sheet.at(i, j)] * (1 / weight);
            count++;
          }
        sheet.sum[sheet.at(x, y)] = sum;
        sheet.weight[sheet.at(x, y)] = count;
      }
  }
}

// Gives every texel a colour: that of the finest level of a pyramid that has one there, between its texels
// bilinear (pull and push; Gortler et al., "The lumigraph", 1996). All weights are then above 0.
void fill(Sheet &sheet) {
  if (sheet.size == 1) return;
  Sheet coarse(sheet.size / 2);
  const auto parent = [&](size_t x, size_t y) {
    return coarse.at(std::min<size_t>(x / 2, coarse.size - 1), std::min<size_t>(y / 2, coarse.size - 1));
  };
  for (size_t y = 0; y < sheet.size; y++)
    for (size_t x = 0; x < sheet.size; x++) {
      const size_t i = sheet.at(x, y);
      if (!(sheet.weight[i] > 0)) continue;
      coarse.sum[parent(x, y)] += sheet.sum[i] * (1 / sheet.weight[i]);
      coarse.weight[parent(x, y)] += 1;
    }
  fill(coarse);
  for (size_t y = 0; y < sheet.size; y++)
    for (size_t x = 0; x < sheet.size; x++) {
      const size_t i = sheet.at(x, y);
      if (sheet.weight[i] > 0) continue;
      // The four coarse texels around the middle of this one.
      Rgb colour;
      for (const auto &[column, share] : {std::pair(x, 0.75), std::pair(x % 2 ? x + 1 : x - (x > 0), 0.25)})
        for (const auto &[row, part] : {std::pair(y, 0.75), std::pair(y % 2 ? y + 1 : y - (y > 0), 0.25)})
          colour += coarse.sum[parent(column, row)] * (share * part / coarse.weight[parent(column, row)]);
      sheet.sum[i] = colour;
      sheet.weight[i] = 1;
    }
}

} // namespace

media::Image bake(const std::vector<Chart> &charts, const Layout &layout, const Paint &paint,
                  uint32_t threads) {
  Sheet sheet(layout.size);
  fvv::parallel(threads, charts.size(), [&](size_t i) {
    const ChartBox &place = layout.places[i];
    for_samples(charts[i], layout, place,
                [&](uint32_t face, size_t column, size_t row, const std::array<double, 3> &weights) {
                  const size_t texel = sheet.at(place.x + column / fine, place.y + row / fine);
                  sheet.sum[texel] += paint(face, weights);
                  sheet.weight[texel] += 1;
                });
  });
  spread(sheet, chart_margin);
  fill(sheet);
  media::Image image = media::make_image(layout.size, layout.size, 3, 0);
  for (size_t i = 0; i < sheet.sum.size(); i++) {
    const Rgb colour = sheet.sum[i] * (1 / sheet.weight[i]);
    size_t channel = 3 * i;
    for (const double value : {colour.x, colour.y, colour.z})
      image.pixels[channel++] = render::to_display(value);
  }
  return image;
}

namespace {

// The pieces of a player that are cut off from each other: limbs, which are straight at rest, with hands and
// feet, and the rest with the head.
enum Piece : uint8_t { trunk, left_arm, right_arm, left_leg, right_leg, piece_count };

constexpr Piece piece_of(Joint joint) {
  return joint < left_upper_arm    ? trunk
         : joint < right_upper_arm ? left_arm
         : joint < left_thigh      ? right_arm
         : joint < right_thigh     ? left_leg
                                   : right_leg;
}

// y against the direction of a limb, z as near to the player's front as it can be.
Mat3 limb_axes(Vec3 direction) {
  const Vec3 y = -direction, front{0, 0, 1};
  const Vec3 z = normalised(front - y * dot(front, y));
  return {cross(y, z), y, z};
}

// Which of a player's pieces a face belongs to: the one whose bones carry most of it.
Piece piece_of(const Body &body, size_t face) {
  std::array<double, piece_count> weight{};
  for (size_t c = 0; c < 3; c++) {
    const Influence &influence = body.influences[body.rest.faces[3 * face + c]];
    for (size_t k = 0; k < 4; k++) weight[piece_of(influence.joint[k])] += double(influence.weight[k]);
  }
  return Piece(std::max_element(weight.begin(), weight.end()) - weight.begin());
}

} // namespace

Atlas make_atlas(const Scene &scene, uint32_t size, uint32_t threads) {
  Surface surface;
  surface.faces = scene.faces();
  std::vector<uint8_t> region;
  for (const Body &body : scene.players()) {
    surface.vertices.insert(surface.vertices.end(), body.rest.vertices.begin(), body.rest.vertices.end());
    for (size_t face = 0; face < body.rest.faces.size() / 3; face++) region.push_back(piece_of(body, face));
  }
  region.resize(surface.faces.size() / 3, trunk); // the ball, whose axes are the trunk's
  const std::vector<float> &solid = scene.solid();
  const auto place = [&](uint32_t vertex) {
    return Vec3{solid[3 * vertex], solid[3 * vertex + 1], solid[3 * vertex + 2]};
  };
  while (surface.vertices.size() < scene.vertex_count())
    surface.vertices.push_back(place(uint32_t(surface.vertices.size())) * ball_radius);

  Atlas atlas;
  atlas.charts = make_charts(surface, region,
                             {Mat3{}, limb_axes(rest_arm(1)), limb_axes(rest_arm(-1)), limb_axes(rest_leg(1)),
                              limb_axes(rest_leg(-1))});
  atlas.layout = lay_out(surface, atlas.charts, size);
  atlas.picture = bake(
      atlas.charts, atlas.layout,
      [&](uint32_t face, const std::array<double, 3> &weights) {
        Vec3 at;
        for (size_t c = 0; c < 3; c++) at += place(scene.faces()[3 * face + c]) * weights[c];
        return scene.reflectance(face, at).colour;
      },
      threads);
  return atlas;
}

} // namespace fvv::synth
