#include "fvvsynth/props.h"

#include "fvvsynth/body.h"
#include "fvvsynth/paint.h"

#include <cmath>

namespace fvv::synth {

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

Props::Props() {
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
  still_end = faces.size();
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

} // namespace fvv::synth
