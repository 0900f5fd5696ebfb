#include "fvvsynth/studio.h"

#include "fvvsynth/body/body.h"
#include "fvvsynth/look.h"
#include "fvvsynth/random.h"
#include "fvvsynth/rig.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace fvv::synth {

namespace {

constexpr uint32_t map_side = 448;
constexpr uint32_t coarse_side = 8;   // of the map's squares that are known to block some light or none
constexpr double lamp_distance = 100; // to the lamp, so far that its rays are nearly parallel

fvv_camera at_lamp(Vec3 towards, double cell) {
  fvv_camera camera = {};
  camera.lens = FVV_LENS_NONE;
  camera.width = camera.height = map_side;
  camera.fx = camera.fy = lamp_distance / cell;
  camera.cx = camera.cy = map_side / 2.0;
  camera.r_max = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 9; i += 4) camera.rotation[i] = 1;
  const Vec3 eye = towards * lamp_distance;
  camera.translation[0] = -eye.x;
  camera.translation[1] = -eye.y;
  camera.translation[2] = -eye.z;
  return turned(camera, {0, 0.8, 0}, 1);
}

// The mean of 2 n + 1 neighbours along rows (stride 1) or columns (stride map_side).
void blur(std::vector<float> &map, int n, size_t stride) {
  const size_t across = stride == 1 ? map_side : 1;
  std::vector<float> line(map_side);
  for (size_t k = 0; k < map_side; k++) {
    float *first = &map[k * across];
    for (size_t i = 0; i < map_side; i++) line[i] = first[i * stride];
    const int end = int(map_side);
    float sum = 0; // of values that are multiples of a power of two at first, and no more than a few ulp off
    for (int i = -n; i < end; i++) {
      if (i + n < end) sum += line[size_t(i + n)];
      if (i - n - 1 >= 0) sum -= line[size_t(i - n - 1)];
      if (i >= 0) first[size_t(i) * stride] = std::max(0.0f, sum) / float(2 * n + 1);
    }
  }
}

} // namespace

Shadow::Shadow(const render::Mesh &mesh, const Lamp &lamp, double map_cell, float least)
    : light(lamp), cell(map_cell), view(at_lamp(lamp.towards, map_cell)) {
  render::SampleBuffer buffer(map_side, map_side, 1);
  render::rasterise(view, mesh, buffer);
  blocked.reserve(buffer.face.size());
  for (const uint32_t face : buffer.face) blocked.push_back(face == render::no_face ? 0 : 1);
  // Two boxes make a tent, twice as wide.
  const int n = std::max(1, int(lamp.softness / cell / 2));
  for (int pass = 0; pass < 2; pass++) {
    blur(blocked, n, 1);
    blur(blocked, n, map_side);
  }
  const double rim = 2 * n + 1;
  left = double(buffer.drawn.left) - rim;
  top = double(buffer.drawn.top) - rim;
  right = double(buffer.drawn.right) + rim;
  bottom = double(buffer.drawn.bottom) + rim;
  any.resize(size_t(map_side / coarse_side) * (map_side / coarse_side));
  for (size_t y = 0; y < map_side; y++)
    for (size_t x = 0; x < map_side; x++)
      if (blocked[y * map_side + x] > least)
        any[y / coarse_side * (map_side / coarse_side) + x / coarse_side] = 1;
}

double Shadow::covered(Vec3 on_floor) const {
  const Vec3 pixel = view.to_pixel(view.to_camera(on_floor));
  const double u = pixel.x / pixel.z - 0.5, v = pixel.y / pixel.z - 0.5;
  if (!(u >= 0 && v >= 0 && u < map_side - 1 && v < map_side - 1)) return 0;
  const uint32_t x = uint32_t(u), y = uint32_t(v);
  const float *p = &blocked[y * map_side + x];
  const double fu = u - double(x), fv = v - double(y);
  const double upper = double(p[0]) + double(p[1] - p[0]) * fu;
  const double lower = double(p[map_side]) + double(p[map_side + 1] - p[map_side]) * fu;
  return upper + (lower - upper) * fv;
}

// The part of a picture that shows the floor below this, as far as the map's margins allow to say; all where
// part of it is not seen.
Shadow::Rectangle Shadow::shown(const render::Projection &camera) const {
  const Vec3 lamp = view.centre();
  double low[2] = {1e9, 1e9}, high[2] = {-1e9, -1e9};
  constexpr int parts = 8; // lenses bend its sides
  for (int j = 0; j <= parts; j++)
    for (int i = 0; i <= parts; i++) {
      const Vec3 ray = view.to_world_direction(
          view.ray(left + (right - left) * i / parts, top + (bottom - top) * j / parts));
      const Vec3 pixel = camera.to_pixel(camera.to_camera(lamp + ray * (-lamp.y / ray.y)));
      const double at[2] = {pixel.x / pixel.z, pixel.y / pixel.z};
      if (!(pixel.z > 0 && std::isfinite(at[0]) && std::isfinite(at[1])))
        return {0, 0, camera.width(), camera.height()};
      for (int axis = 0; axis < 2; axis++) {
        low[axis] = std::min(low[axis], at[axis] - 4);
        high[axis] = std::max(high[axis], at[axis] + 4);
      }
    }
  const double width = camera.width(), height = camera.height();
  const auto bound = [&](double value, double side) { return uint32_t(std::clamp(value, 0.0, side)); };
  return {bound(low[0], width), bound(low[1], height), bound(high[0], width), bound(high[1], height)};
}

// Whether any light may be blocked between four places of the floor.
bool Shadow::reaches(const std::array<Vec3, 4> &corners) const {
  double low[2] = {1e9, 1e9}, high[2] = {-1e9, -1e9};
  for (const Vec3 corner : corners) {
    const Vec3 pixel = view.to_pixel(view.to_camera(corner));
    const double at[2] = {pixel.x / pixel.z, pixel.y / pixel.z};
    for (int axis = 0; axis < 2; axis++) {
      low[axis] = std::min(low[axis], at[axis]);
      high[axis] = std::max(high[axis], at[axis]);
    }
  }
  // A lens bends the sides between the corners, and covered() takes neighbours.
  const auto cell_of = [](double at) {
    return uint32_t(std::clamp(at, 0.0, double(map_side - 1))) / coarse_side;
  };
  constexpr double room = 4;
  for (uint32_t y = cell_of(low[1] - room); y <= cell_of(high[1] + room); y++)
    for (uint32_t x = cell_of(low[0] - room); x <= cell_of(high[0] + room); x++)
      if (any[y * (map_side / coarse_side) + x]) return true;
  return false;
}

void Shadow::cast(const std::vector<Shadow> &shadows, const render::Projection &camera,
                  render::LightField &picture) {
  std::vector<Rectangle> rectangles;
  for (const Shadow &shadow : shadows) rectangles.push_back(shadow.shown(camera));
  const Vec3 eye = camera.centre();
  const auto floor_at = [&](double u, double v) {
    const Vec3 way = camera.to_world_direction(camera.ray(u, v));
    return way.y < 0 ? eye + way * (-eye.y / way.y) : Vec3{0, std::numeric_limits<double>::infinity(), 0};
  };
  constexpr uint32_t tile = 16;
  std::vector<std::pair<const Shadow *, Rectangle>> near; // what may reach a tile, and the part of it
  for (uint32_t top = 0; top < camera.height(); top += tile)
    for (uint32_t left = 0; left < camera.width(); left += tile) {
      const uint32_t right = std::min(left + tile, camera.width()),
                     bottom = std::min(top + tile, camera.height());
      near.clear();
      std::optional<std::array<Vec3, 4>> corners;
      for (size_t i = 0; i < shadows.size(); i++) {
        const Rectangle &all = rectangles[i];
        const Rectangle here = {std::max(left, all.left), std::max(top, all.top), std::min(right, all.right),
                                std::min(bottom, all.bottom)};
        if (here.left >= here.right || here.top >= here.bottom) continue;
        if (!corners)
          corners = {floor_at(left, top), floor_at(right, top), floor_at(left, bottom),
                     floor_at(right, bottom)};
        const bool whole = std::all_of(corners->begin(), corners->end(), [](Vec3 p) { return p.y < 1; });
        if (!whole || shadows[i].reaches(*corners)) near.emplace_back(&shadows[i], here);
      }
      if (near.empty()) continue;
      for (uint32_t y = top; y < bottom; y++)
        for (uint32_t x = left; x < right; x++) {
          const Vec3 place = floor_at(x + 0.5, y + 0.5);
          if (!(place.y < 1)) continue;
          float *colour = &picture[3 * (size_t(y) * camera.width() + x)];
          for (const auto &[shadow, part] : near) {
            if (x < part.left || x >= part.right || y < part.top || y >= part.bottom) continue;
            const float kept = float(1 - shadow->light.share * shadow->covered(place));
            for (int i = 0; i < 3; i++) colour[i] *= kept;
          }
        }
    }
}

namespace {

constexpr double turn = 6.283185307179586;
constexpr Rgb black{0.012, 0.012, 0.014}, steel{0.20, 0.20, 0.21}, white{0.80, 0.80, 0.78};

// Two directions across a given one.
struct Frame {
  Vec3 u, v;
  explicit Frame(Vec3 along) {
    u = normalised(cross(along, std::abs(along.y) < 0.9 ? Vec3{0, 1, 0} : Vec3{1, 0, 0}));
    v = cross(along, u);
  }
};

} // namespace

Props::Props(bool ceiling) {
  hoop();
  truss();
  for (const double x : {-7.7, 7.7})
    for (const double z : {-6.2, 6.2}) stand({x, 0, z});
  bench({-2.2, 0, -6.7});
  bench({2.4, 0, -6.7});
  bench({0.3, 0, 6.8});
  const Rgb orange = render::to_linear({0.85, 0.43, 0.14}) * 0.9;
  for (const Vec3 at : {Vec3{4.4, 0.12, -6.5},
                        {4.68, 0.12, -6.62},
                        {4.52, 0.12, -6.85},
                        {-8.2, 0.12, 1.9},
                        {-4.4, 0.12, 6.7}}) {
    ball(at, 0.12, orange);
    stains.push_back({at.x, at.z, 0.13, 0.7});
  }
  if (ceiling)
    for (const CeilingPart &part : ceiling_parts()) block(part.centre, part.half, part.colour);
  still_end = faces.size();
}

std::vector<CeilingPart> ceiling_parts() {
  const Rgb beam{0.24, 0.235, 0.23}, purlin{0.17, 0.17, 0.17}, glowing{5.6, 5.4, 5.0},
      housing{0.05, 0.05, 0.055};
  std::vector<CeilingPart> parts;
  for (int i = -2; i <= 2; i++) {
    const double x = 3.4 * i;
    parts.push_back({{x, ceiling_height - 0.20, 0}, {0.03, 0.20, room_width / 2}, beam});
    for (const double y : {0.02, 0.38})
      parts.push_back({{x, ceiling_height - y, 0}, {0.14, 0.02, room_width / 2}, beam});
  }
  for (int i = -2; i <= 2; i++)
    parts.push_back({{0, ceiling_height - 0.08, 2.8 * i}, {room_length / 2, 0.08, 0.06}, purlin});
  // Lamps hang between the beams.
  for (int i = -2; i < 2; i++)
    for (int j = -1; j <= 1; j++) {
      const Vec3 at{3.4 * i + 1.7, ceiling_height - 0.20, 4.2 * j};
      parts.push_back({at, {0.20, 0.06, 0.80}, housing});
      parts.push_back({at - Vec3{0, 0.07, 0}, {0.17, 0.01, 0.77}, glowing});
    }
  return parts;
}

uint32_t Props::vertex(Vec3 at, Vec3 normal, Rgb colour) {
  const auto append = [](std::vector<float> &out, Vec3 v) {
    out.insert(out.end(), {float(v.x), float(v.y), float(v.z)});
  };
  append(positions, at);
  append(normals, normal);
  append(colours, colour);
  return uint32_t(positions.size() / 3 - 1);
}

void Props::quad(uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
  faces.insert(faces.end(), {a, b, c, a, c, d});
}

void Props::box(Vec3 centre, Vec3 x, Vec3 y, Vec3 z, Rgb colour) {
  const Vec3 axes[3] = {x, y, z};
  for (int i = 0; i < 3; i++)
    for (const double side : {-1.0, 1.0}) {
      const Vec3 out = axes[i] * side, u = axes[(i + 1) % 3], v = axes[(i + 2) % 3];
      const Vec3 normal = normalised(out), at = centre + out;
      quad(vertex(at - u - v, normal, colour), vertex(at + u - v, normal, colour),
           vertex(at + u + v, normal, colour), vertex(at - u + v, normal, colour));
    }
}

void Props::tube(Vec3 a, Vec3 b, double radius_a, double radius_b, Rgb colour, Rgb end) {
  constexpr int sides = 10;
  const Vec3 along = normalised(b - a);
  const Frame across(along);
  const uint32_t cap_a = vertex(a, -along, colour), cap_b = vertex(b, along, end);
  uint32_t last[4] = {};
  for (int i = 0; i <= sides; i++) {
    const double angle = turn * i / sides;
    const Vec3 out = across.u * std::cos(angle) + across.v * std::sin(angle);
    const Vec3 at = a + out * radius_a, to = b + out * radius_b;
    const uint32_t now[4] = {vertex(at, out, colour), vertex(to, out, colour), vertex(at, -along, colour),
                             vertex(to, along, end)};
    if (i > 0) {
      quad(last[0], now[0], now[1], last[1]);
      faces.insert(faces.end(), {cap_a, now[2], last[2], cap_b, last[3], now[3]});
    }
    std::copy(now, now + 4, last);
  }
}

void Props::ball(Vec3 centre, double radius, Rgb colour) {
  const Surface sphere = make_ball(4);
  const uint32_t first = uint32_t(positions.size() / 3);
  for (const Vec3 p : sphere.vertices) {
    const bool seam = std::min(std::abs(p.x), std::abs(p.z)) < 0.05;
    vertex(centre + p * radius, p, seam ? colour * 0.3 : colour);
  }
  for (const uint32_t v : sphere.faces) faces.push_back(first + v);
}

// Behind the lane: a padded pole, an arm, the board with its square, the ring and its net.
void Props::hoop() {
  constexpr double board_x = 7.05, ring_y = 3.05, ring_radius = 0.23;
  const Rgb red{0.55, 0.06, 0.03}, blue{0.03, 0.07, 0.26};
  tube({8.3, 0, 0}, {8.3, 3.3, 0}, 0.10, steel);
  block({8.25, 0.95, 0}, {0.20, 0.95, 0.22}, blue);
  tube({8.3, 3.2, 0}, {board_x, 3.45, 0}, 0.07, steel);
  tube({8.3, 2.2, 0}, {board_x, 3.15, 0}, 0.04, steel);
  block({board_x, 3.42, 0}, {0.025, 0.525, 0.9}, Rgb{0.62, 0.66, 0.68});
  const double front = board_x - 0.03;
  for (const double side : {-1.0, 1.0}) {
    block({front, 3.42, side * 0.87}, {0.012, 0.525, 0.03}, red);
    block({front, 3.42 + side * 0.495, 0}, {0.012, 0.03, 0.9}, red);
    block({front, 3.35, side * 0.28}, {0.012, 0.225, 0.025}, red);
    block({front, 3.35 + side * 0.2, 0}, {0.012, 0.025, 0.3}, red);
  }
  const auto on_ring = [&](double angle, double y, double radius) {
    return Vec3{board_x - 0.40 + radius * std::cos(angle), y, radius * std::sin(angle)};
  };
  tube({board_x, ring_y, 0}, {board_x - 0.17, ring_y, 0}, 0.03, red);
  for (int i = 0; i < 20; i++) {
    const double a = turn * i / 20, b = turn * (i + 1) / 20;
    tube(on_ring(a, ring_y, ring_radius), on_ring(b, ring_y, ring_radius), 0.011, red);
    if (i % 2) continue;
    for (const double way : {-1.0, 1.0}) {
      const Vec3 knot = on_ring(a + way * turn / 20, ring_y - 0.2, 0.17);
      tube(on_ring(a, ring_y, ring_radius), knot, 0.005, white);
      tube(knot, on_ring(a, ring_y - 0.42, 0.12), 0.005, white);
    }
  }
  stains.push_back({8.25, 0, 0.45, 0.7});
}

// A rectangle of lattice girders with spotlights.
void Props::truss() {
  constexpr double y = 4.9, x = 6.6, z = 5.6;
  const Vec3 corner[4] = {{x, y, z}, {-x, y, z}, {-x, y, -z}, {x, y, -z}};
  for (int side = 0; side < 4; side++) {
    const Vec3 a = corner[side], b = corner[(side + 1) % 4], above{0, 0.3, 0};
    tube(a, b, 0.035, steel);
    tube(a + above, b + above, 0.035, steel);
    const int parts = int(length(b - a) / 0.6);
    for (int i = 0; i < parts; i++) {
      const Vec3 p = mix(a, b, double(i) / parts), q = mix(a, b, double(i + 1) / parts);
      tube(i % 2 ? p : p + above, i % 2 ? q + above : q, 0.018, steel);
    }
    for (const double at : {0.14, 0.38, 0.62, 0.86}) {
      const Vec3 hang = mix(a, b, at) - Vec3{0, 0.22, 0}, aim = normalised(Vec3{0, 0.5, 0} - hang);
      tube(hang + Vec3{0, 0.22, 0}, hang, 0.02, black);
      tube(hang - aim * 0.18, hang + aim * 0.16, 0.09, 0.14, black, Rgb{6.0, 5.5, 4.6});
    }
  }
}

// A soft box on a stand with three feet.
void Props::stand(Vec3 foot) {
  const Vec3 head = foot + Vec3{0, 2.9, 0}, aim = normalised(Vec3{0, 1.2, 0} - head);
  const Frame across(aim);
  tube(foot + Vec3{0, 0.3, 0}, head, 0.025, black);
  for (int i = 0; i < 3; i++) {
    const double angle = turn * (i + 0.2) / 3;
    const Vec3 end = foot + Vec3{0.5 * std::cos(angle), 0.02, 0.5 * std::sin(angle)};
    tube(foot + Vec3{0, 0.55, 0}, end, 0.018, black);
    stains.push_back({end.x, end.z, 0.10, 0.5});
  }
  box(head, across.u * 0.55, across.v * 0.55, aim * 0.12, black);
  box(head + aim * 0.125, across.u * 0.51, across.v * 0.51, aim * 0.01, Rgb{6.0, 5.8, 5.4});
}

void Props::bench(Vec3 middle) {
  const Rgb plank{0.34, 0.19, 0.08};
  for (const double z : {-0.11, 0.11}) block(middle + Vec3{0, 0.45, z}, {0.9, 0.02, 0.095}, plank);
  for (const double x : {-0.7, 0.7}) {
    block(middle + Vec3{x, 0.215, 0}, {0.03, 0.215, 0.19}, steel);
    stains.push_back({middle.x + x, middle.z, 0.3, 0.5});
  }
  const Rgb towel[3] = {{0.75, 0.73, 0.70}, {0.05, 0.14, 0.42}, {0.50, 0.06, 0.05}};
  for (int i = 0; i < 3; i++) {
    const Vec3 at = middle + Vec3{-0.55 + 0.5 * i, 0.47, 0};
    if (i == 1)
      block(at + Vec3{0, 0.035, 0.02}, {0.16, 0.035, 0.12}, towel[0]);
    else
      tube(at, at + Vec3{0, 0.2, 0}, 0.035, towel[i]);
  }
  block(middle + Vec3{0.62, 0.12, 0.42}, {0.28, 0.12, 0.14}, towel[1]); // a bag
  stains.push_back({middle.x + 0.62, middle.z + 0.42, 0.4, 0.6});
  stains.push_back({middle.x, middle.z, 0.55, 0.45});
}

void Props::add_camera(Vec3 centre, Vec3 forward) {
  const Frame across(forward);
  const Vec3 body = centre - forward * 0.32;
  box(body, across.u * 0.07, across.v * 0.10, forward * 0.17, Rgb{0.045, 0.047, 0.05});
  box(body + across.v * -0.13, across.u * 0.02, across.v * 0.02, forward * 0.12, black); // the handle
  tube(body + forward * 0.17, centre - forward * 0.02, 0.05, 0.065, black, Rgb{0.03, 0.035, 0.06});
  box(body + across.v * -0.11 + forward * 0.15, across.u * 0.012, across.v * 0.012, forward * 0.012,
      Rgb{1.2, 0.03, 0.02}); // the lamp that says "on air"
  const Vec3 head = body - Vec3{0, 0.20, 0};
  tube(body - Vec3{0, 0.08, 0}, head, 0.05, steel);
  for (int i = 0; i < 3; i++) {
    const double angle = turn * (i + 0.5) / 3 + std::atan2(forward.z, forward.x);
    const Vec3 foot{head.x + 0.3 * head.y * std::cos(angle), 0, head.z + 0.3 * head.y * std::sin(angle)};
    tube(head, mix(head, foot, 0.5), 0.028, 0.024, black, black);
    tube(mix(head, foot, 0.48), foot, 0.018, 0.015, steel, black);
    stains.push_back({foot.x, foot.z, 0.10, 0.5});
  }
  camera_ends.push_back(faces.size());
}

render::LightField Props::draw(const render::Projection &camera, size_t own, const render::Light &light,
                               render::LightField background, render::SampleBuffer &buffer,
                               std::optional<uint32_t> part) const {
  std::vector<uint32_t> shown(faces);
  if (own < camera_ends.size()) {
    const size_t begin = own == 0 ? still_end : camera_ends[own - 1];
    shown.erase(shown.begin() + std::ptrdiff_t(begin), shown.begin() + std::ptrdiff_t(camera_ends[own]));
  }
  const std::vector<float> open(positions.size() / 3, 0.8f);
  const render::Mesh mesh = {positions.data(), positions.size() / 3, shown.data(), shown.size() / 3};
  const auto material = [](uint32_t, Vec3 colour) { return render::Reflectance{colour, 0.08}; };
  return std::move(render::illuminate(camera, mesh, {normals.data(), colours.data(), open.data()}, material,
                                      light, std::move(background), buffer, part)
                       .light);
}

namespace {

constexpr double overhead_height = 4; // cameras above hang from the ceiling

Props furnished(const std::vector<fvv_camera> &cameras, bool ceiling, std::vector<size_t> &tripods) {
  Props props(ceiling);
  size_t number = 0;
  for (const fvv_camera &camera : cameras) {
    double centre[3];
    fvv_camera_centre(&camera, centre);
    const bool stands = centre[1] < overhead_height;
    tripods.push_back(stands ? number++ : SIZE_MAX);
    if (stands)
      props.add_camera({centre[0], centre[1], centre[2]},
                       {camera.rotation[6], camera.rotation[7], camera.rotation[8]});
  }
  return props;
}

Texture make_ground(uint32_t key, double texel, const std::vector<Spot> &spots, uint32_t threads) {
  const auto row = [&](double t) {
    const double z = t - room_width / 2;
    std::vector<Spot> near;
    for (const Spot &spot : spots)
      if (std::abs(spot.z - z) < 2 * spot.radius) near.push_back(spot);
    return [=](double s) {
      const double x = s - room_length / 2;
      double shade = 1;
      for (const Spot &spot : near) {
        const double distance = std::sqrt((x - spot.x) * (x - spot.x) + (z - spot.z) * (z - spot.z));
        shade *= 1 - spot.depth * (1 - smoothstep(0, 2 * spot.radius, distance));
      }
      return floor_colour(x, z, key) * shade;
    };
  };
  return {room_length, room_width, texel, row, threads};
}

Texture make_wall(int wall, uint32_t key, double texel, uint32_t threads) {
  const auto row = [=](double t) { return [=](double s) { return wall_colour(wall, s, t, key); }; };
  return {wall < 2 ? room_width : room_length, room_height, texel, row, threads};
}

} // namespace

Studio::Studio(uint32_t key, double texel, const std::vector<fvv_camera> &cameras, const render::Light &lamps,
               bool with_ceiling, uint32_t threads)
    : light(lamps), props(furnished(cameras, with_ceiling, tripods)),
      ground(make_ground(key, texel, props.spots(), threads)), walls{make_wall(0, key, 2 * texel, threads),
                                                                     make_wall(1, key, 2 * texel, threads),
                                                                     make_wall(2, key, 2 * texel, threads),
                                                                     make_wall(3, key, 2 * texel, threads)} {
  if (!with_ceiling) return;
  const auto row = [=](double t) {
    return [=](double s) { return ceiling_colour(s - room_length / 2, t - room_width / 2, key); };
  };
  ceiling.emplace(room_length, room_width, 4 * texel, row, threads);
}

// The ceiling that a ray upwards meets.
Rgb Studio::above(Vec3 from, Vec3 direction, double footprint_per_metre, double blur) const {
  if (!ceiling) return {0.012, 0.012, 0.014};
  const double t = (ceiling_height - from.y) / direction.y, size = length(direction);
  const Vec3 at = from + direction * t;
  const double across = t * size * footprint_per_metre, along = across * size / direction.y;
  return ceiling->at(at.x + room_length / 2, at.z + room_width / 2,
                     std::max(blur, std::max(across, along / 3)));
}

// The wall or ceiling that a ray meets. Its footprint grows with the distance by footprint_per_metre and is
// at least blur.
Rgb Studio::wall(Vec3 from, Vec3 direction, double footprint_per_metre, double blur) const {
  const auto reach = [](double at, double way, double side) {
    return way == 0 ? std::numeric_limits<double>::infinity() : ((way > 0 ? side : -side) - at) / way;
  };
  const double to_x = reach(from.x, direction.x, room_length / 2),
               to_z = reach(from.z, direction.z, room_width / 2);
  const double t = std::min(to_x, to_z);
  const Vec3 at = from + direction * t;
  if (at.y > (ceiling ? ceiling_height : room_height))
    return above(from, direction, footprint_per_metre, blur);
  const double footprint = std::max(blur, t * length(direction) * footprint_per_metre);
  if (to_x < to_z) {
    const bool positive = direction.x > 0; // written as seen from inside, left to right
    return walls[positive ? 0 : 1].at(room_width / 2 + (positive ? at.z : -at.z), at.y, footprint);
  }
  const bool positive = direction.z > 0;
  return walls[positive ? 2 : 3].at(room_length / 2 + (positive ? -at.x : at.x), at.y, footprint);
}

// pixel: metres that a sample covers at 1 m. reflection: in the varnish; found where it is not known.
Rgb Studio::at(Vec3 eye, Vec3 direction, double pixel, std::optional<Rgb> &reflection) const {
  const double t = direction.y < 0 ? -eye.y / direction.y : std::numeric_limits<double>::infinity();
  const Vec3 at = eye + direction * t;
  if (!(std::abs(at.x) < room_length / 2 && std::abs(at.z) < room_width / 2))
    return wall(eye, direction, pixel, 0);
  const double size = length(direction), slope = -direction.y / size;
  // A pixel covers much of the floor along the view and little across: between the two, as far as 2 x 2
  // samples keep the rest from aliasing.
  const double across = t * size * pixel, along = across / slope;
  const Rgb boards = ground.at(at.x + room_length / 2, at.z + room_width / 2, std::max(across, along / 3));
  // Varnish mirrors the walls, blurred, the more the flatter the view (Schlick, "An inexpensive BRDF model
  // for physically-based rendering", 1994).
  const double flat = 1 - slope, mirrored = 0.03 + 0.55 * flat * flat * flat * flat * flat;
  if (!reflection) reflection = wall(at, {direction.x, -direction.y, direction.z}, 0.06, 0.10);
  return mix(boards, *reflection, mirrored);
}

render::LightField Studio::seen(const render::Projection &camera, size_t own, render::SampleBuffer &buffer,
                                std::optional<uint32_t> part) const {
  constexpr uint32_t samples = 2;
  const Vec3 eye = camera.centre();
  render::LightField picture;
  picture.reserve(size_t(camera.width()) * camera.height() * 3);
  const double middle_x = camera.width() / 2.0, middle_y = camera.height() / 2.0;
  const double pixel =
      length(camera.ray(middle_x + 0.5, middle_y) - camera.ray(middle_x - 0.5, middle_y)) / samples;
  // Of a pixel. It is so blurred that in the game, whose moving camera sees other places in each frame,
  // one place decides for all.
  std::optional<Rgb> reflection;
  const auto from = [&](uint32_t x, uint32_t y, uint32_t place) {
    if (place == 0 || !ceiling) reflection.reset();
    const double u = x + (place % samples + 0.5) / samples, v = y + (place / samples + 0.5) / samples;
    return at(eye, camera.to_world_direction(camera.ray(u, v)), pixel, reflection);
  };
  for (uint32_t y = 0; y < camera.height(); y++)
    for (uint32_t x = 0; x < camera.width(); x++) {
      Rgb colour;
      for (uint32_t place = 0; place < samples * samples; place++)
        colour += from(x, y, place) * (1.0 / (samples * samples));
      picture.insert(picture.end(), {float(colour.x), float(colour.y), float(colour.z)});
    }
  return props.draw(camera, own < tripods.size() ? tripods[own] : SIZE_MAX, light, std::move(picture), buffer,
                    part);
}

} // namespace fvv::synth
