#include "fvvsynth/game/hoop.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace fvv::synth {

namespace {

constexpr double pi = 3.14159265358979323846;
constexpr double board_front = ring_centre.x + ring_radius + 0.15, board_thickness = 0.03;
constexpr double board_bottom = 2.45, board_top = 3.20, board_half_width = 0.56;
constexpr double ring_thickness = 0.011, cord = 0.0065;
constexpr double pole_x = 2.42, pole_radius = 0.05;

void face(Surface &out, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
  out.faces.insert(out.faces.end(), {a, b, c, a, c, d});
}

// A box whose edges are a strip wide, so that normals of vertices are those of its sides.
void add_box(Surface &out, Vec3 middle, Vec3 half) {
  constexpr double edge = 0.006;
  std::map<std::array<int, 3>, uint32_t> known;
  const auto at = [&](int i, double h) { return i == 0 ? -h : i == 1 ? edge - h : i == 2 ? h - edge : h; };
  const auto vertex = [&](std::array<int, 3> p) {
    const auto [entry, added] = known.try_emplace(p, uint32_t(out.vertices.size()));
    if (added) out.vertices.push_back(middle + Vec3{at(p[0], half.x), at(p[1], half.y), at(p[2], half.z)});
    return entry->second;
  };
  for (size_t axis = 0; axis < 3; axis++)
    for (const int end : {0, 3})
      for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
          const auto corner = [&](int u, int v) {
            std::array<int, 3> p{};
            p[axis] = end;
            p[(axis + 1) % 3] = end == 3 ? u : v;
            p[(axis + 2) % 3] = end == 3 ? v : u;
            return vertex(p);
          };
          face(out, corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
        }
}

// A closed tube along points.
void add_tube(Surface &out, const std::vector<Vec3> &line, double radius, int sides) {
  const uint32_t first = uint32_t(out.vertices.size()), around = uint32_t(sides);
  for (size_t i = 0; i < line.size(); i++) {
    const Vec3 along = normalised(line[std::min(i + 1, line.size() - 1)] - line[i == 0 ? 0 : i - 1]);
    const Vec3 u = normalised(cross(along, std::abs(along.y) < 0.9 ? Vec3{0, 1, 0} : Vec3{1, 0, 0})),
               v = cross(along, u);
    for (int k = 0; k < sides; k++) {
      const double angle = 2 * pi * k / sides;
      out.vertices.push_back(line[i] + (u * std::cos(angle) + v * std::sin(angle)) * radius);
    }
  }
  const uint32_t rings = uint32_t(line.size());
  for (uint32_t i = 0; i + 1 < rings; i++)
    for (uint32_t k = 0; k < around; k++) {
      const uint32_t a = first + i * around + k, b = first + i * around + (k + 1) % around;
      face(out, a, b, b + around, a + around);
    }
  for (const uint32_t end : {0u, rings - 1}) {
    const uint32_t centre = uint32_t(out.vertices.size());
    out.vertices.push_back(line[end]);
    for (uint32_t k = 0; k < around; k++) {
      const uint32_t a = first + end * around + k, b = first + end * around + (k + 1) % around;
      if (end == 0)
        out.faces.insert(out.faces.end(), {centre, b, a});
      else
        out.faces.insert(out.faces.end(), {centre, a, b});
    }
  }
}

void add_ring(Surface &out) {
  constexpr uint32_t around = 40, sides = 8;
  const uint32_t first = uint32_t(out.vertices.size());
  for (uint32_t i = 0; i < around; i++)
    for (uint32_t k = 0; k < sides; k++) {
      const double a = 2 * pi * i / around, b = 2 * pi * k / sides;
      const double r = ring_radius + ring_thickness * std::cos(b);
      out.vertices.push_back(ring_centre +
                             Vec3{r * std::cos(a), ring_thickness * std::sin(b), r * std::sin(a)});
    }
  const auto at = [&](uint32_t i, uint32_t k) { return first + i % around * sides + k % sides; };
  for (uint32_t i = 0; i < around; i++)
    for (uint32_t k = 0; k < sides; k++) face(out, at(i, k), at(i, k + 1), at(i + 1, k + 1), at(i + 1, k));
}

// Two families of cords that wind down in opposite directions.
void add_net(Surface &out) {
  constexpr int cords = 10, parts = 6;
  for (const double way : {-1.0, 1.0})
    for (int i = 0; i < cords; i++) {
      std::vector<Vec3> line;
      for (int k = 0; k <= parts; k++) {
        const double t = double(k) / parts;
        const double angle = 2 * pi * (i + way * 1.5 * t) / cords;
        const double radius = ring_radius - 0.085 * std::sqrt(t) - 0.015 * t + way * cord * 0.8;
        line.push_back(ring_centre +
                       Vec3{radius * std::cos(angle), -net_length * t, radius * std::sin(angle)});
      }
      add_tube(out, line, cord, 5);
    }
}

} // namespace

Hoop make_hoop() {
  Hoop hoop;
  Surface &out = hoop.rest;
  add_box(out, {2.58, 0.07, 0}, {0.36, 0.07, 0.28}); // base
  add_tube(out, {{pole_x, 0.10, 0}, {pole_x, 1.0, 0}, {pole_x, 2.2, 0}, {pole_x, 3.0, 0}}, pole_radius, 16);
  const double back = board_front + board_thickness;
  for (const double y : {board_bottom + 0.18, board_top - 0.26})
    add_tube(out, {{pole_x, y + 0.02, 0}, {back - 0.005, y, 0}}, 0.028, 10);
  add_box(out, {board_front + board_thickness / 2, (board_bottom + board_top) / 2, 0},
          {board_thickness / 2, (board_top - board_bottom) / 2, board_half_width});
  add_box(out, {ring_centre.x + ring_radius + 0.078, ring_centre.y - 0.01, 0}, {0.075, 0.02, 0.05});
  add_ring(out);
  hoop.net_vertices = out.vertices.size();
  add_net(out);
  return hoop;
}

void carry(const Hoop &hoop, const Game &game, double seconds, std::vector<float> &positions) {
  const Vec3 ball = game.ball_position(seconds);
  // After the ball the net swings up and settles.
  const double game_time = seconds - std::floor(seconds / game.duration()) * game.duration();
  const double after = game_time - game.net_time() - 0.16;
  const double swing = after > 0 ? std::exp(-3.5 * after) * std::sin(15 * after) : 0;
  for (size_t i = 0; i < hoop.rest.vertices.size(); i++) {
    Vec3 p = hoop.rest.vertices[i];
    if (i >= hoop.net_vertices) {
      const double down = (ring_centre.y - p.y) / net_length;
      p.y += 0.10 * swing * down * down;
      const Vec3 from{p.x - ring_centre.x, 0, p.z - ring_centre.z};
      const double radius = length(from), height = p.y - ball.y;
      const Vec3 aside{ball.x - ring_centre.x, 0, ball.z - ring_centre.z};
      constexpr double room = ball_radius + 0.018;
      if (length(aside) < 0.15 && std::abs(height) < room) {
        const double needed = std::sqrt(room * room - height * height);
        const Vec3 out = normalised(from) * std::max(radius, needed) + aside * smoothstep(0, 0.3, down);
        p = {ring_centre.x + out.x, p.y, ring_centre.z + out.z};
      } else {
        const Vec3 out = from * (1 + 0.35 * std::max(0.0, swing) * down);
        p = {ring_centre.x + out.x, p.y, ring_centre.z + out.z};
      }
    }
    for (const double value : {p.x, p.y, p.z}) positions.push_back(float(value));
  }
}

render::Reflectance hoop_reflectance(Vec3 p) {
  const render::Rgb red{0.62, 0.09, 0.02}, white{0.78, 0.78, 0.76}, steel{0.16, 0.17, 0.19},
      dark{0.03, 0.05, 0.12};
  if (p.x < board_front - 0.001) {
    if (p.y < ring_centre.y - 0.035) return {white, 0.02};
    return {red, 0.10};
  }
  if (p.x < board_front + board_thickness + 0.001 && p.y > board_bottom - 0.01) {
    const double y = p.y - (board_bottom + board_top) / 2, half = (board_top - board_bottom) / 2;
    const double rim = std::min(board_half_width - std::abs(p.z), half - std::abs(y));
    const double square = std::max(std::abs(p.z) / 0.24, std::abs(p.y - 2.84) / 0.18);
    if (rim < 0.035) return {red, 0.05};
    if (p.x < board_front + 0.002 && square < 1 && std::min((1 - square) * 0.18, 1.0) < 0.03)
      return {red, 0.05};
    return {white, 0.12};
  }
  if (p.y < 0.15) return {dark, 0.05};
  if (p.y < 1.9) return {render::Rgb{0.035, 0.07, 0.22}, 0.03}; // padding
  return {steel, 0.15};
}

} // namespace fvv::synth
