// Following surfaces of which every frame has other faces.
#include "decimate_fixture.h"

#include "fvv_cxx/error.h"
#include "fvv_geometry/marching_cubes.h"
#include "fvv_geometry/outline.h"
#include "fvv_geometry/pieces.h"
#include "fvv_geometry/silhouette.h"
#include "fvv_geometry/track.h"

#include <algorithm>
#include <functional>
#include <map>

using namespace shapes;
using render::Vec3;

namespace {

// A distance field as a surface: the grid moves by a part of a cell with every frame, so that no two frames
// have the same faces.
Mesh meshed(size_t frame, const std::function<double(Vec3)> &field, double cell = 0.04) {
  const double shift = 0.37 * cell * double(frame);
  const hull::Grid grid = hull::grid_over({-1 - shift, -1, -1}, {1, 1, 1}, cell);
  std::vector<double> value;
  for (size_t i = 0; i < grid.points(); i++) {
    const std::array<size_t, 3> place = grid.place(i);
    value.push_back(field(grid.point(double(place[0]), double(place[1]), double(place[2]))));
  }
  const hull::Surface surface = hull::march(grid, value, [&](size_t point, int axis) {
    return hull::interpolated_crossing(grid, value, point, axis);
  });
  Mesh mesh;
  for (const Vec3 &p : surface.vertices) mesh.positions.insert(mesh.positions.end(), {p.x, p.y, p.z});
  mesh.faces = surface.faces;
  return mesh;
}

double capsule(Vec3 p, Vec3 from, Vec3 to, double radius) {
  const double along = std::clamp(dot(p - from, to - from) / dot(to - from, to - from), 0.0, 1.0);
  return length(p - from - (to - from) * along) - radius;
}

// A capsule that sways, and grows thicker.
Mesh swaying(size_t frame) {
  const double t = double(frame);
  return meshed(frame, [&](Vec3 p) {
    return capsule(p, {0, 0, -0.4}, {0.06 * t, 0.03 * t, 0.4}, 0.25 + 0.01 * t);
  });
}

decimate::Frames frames_of(size_t count, const std::function<Mesh(size_t)> &mesh) {
  return {count, mesh, [](size_t) { return decimate::Footprint::uniform(1); }};
}

track::Settings within(double rms) {
  track::Settings settings;
  settings.budget = budget(rms, rms / 4);
  settings.target_error = 4 * rms;
  return settings;
}

// Two balls that come near to each other; from frame 3 on a bar connects them.
Mesh joining(size_t frame) {
  const double t = double(frame);
  return meshed(frame, [&](Vec3 p) {
    const Vec3 a = {-0.5 + 0.02 * t, 0, 0}, b = {0.5 - 0.02 * t, 0, 0};
    const double balls =
        std::min(capsule(p, a, a + Vec3{0, 0, 0.01}, 0.3), capsule(p, b, b + Vec3{0, 0, 0.01}, 0.3));
    return frame < 3 ? balls : std::min(balls, capsule(p, a, b, 0.15));
  });
}

// Edges by places that faces do not have once in each direction.
size_t open_edges(const Mesh &mesh) {
  const std::vector<uint32_t> alike = decimate::first_alike(mesh, false);
  std::map<std::pair<uint32_t, uint32_t>, int> sum;
  for (size_t i = 0; i < mesh.faces.size(); i++) {
    const uint32_t a = alike[mesh.faces[i]], b = alike[mesh.faces[i % 3 == 2 ? i - 2 : i + 1]];
    sum[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
  }
  return size_t(std::count_if(sum.begin(), sum.end(), [](const auto &edge) { return edge.second != 0; }));
}

double area_of(const Mesh &mesh) {
  double area = 0;
  for (size_t f = 0; f < mesh.face_count(); f++) area += decimate::face_area(mesh, f);
  return area;
}

// Of frame 2 a part at the border is raised.
Mesh sheet_at(size_t frame) {
  Mesh mesh;
  for (size_t y = 0; y <= 30; y++)
    for (size_t x = 0; x <= 30; x++) {
      const double u = double(x) / 30, v = double(y) / 30;
      const bool raised = frame == 2 && x >= 27 && y >= 13 && y <= 15;
      const double wave = 0.03 * std::sin(9 * u) * std::cos(7 * v);
      mesh.positions.insert(mesh.positions.end(), {u, v, wave + (raised ? 0.1 : 0)});
    }
  for (uint32_t y = 0; y < 30; y++)
    for (uint32_t x = 0; x < 30; x++) {
      const uint32_t v = 31 * y + x;
      mesh.faces.insert(mesh.faces.end(), {v, v + 1, v + 31, v + 1, v + 32, v + 31});
    }
  return mesh;
}

} // namespace

TEST_CASE("a capsule whose faces change in every frame becomes one run within the budget") {
  const decimate::Frames frames = frames_of(6, swaying);
  CHECK(frames.mesh(0).faces != frames.mesh(1).faces);
  const track::Settings settings = within(0.004);
  const std::vector<track::Run> runs = track::track(frames, settings);
  REQUIRE(runs.size() == 1);
  CHECK(runs[0].first == 0);
  REQUIRE(runs[0].frames.size() == 6);
  for (size_t i = 0; i < 6; i++) {
    const track::Frame &frame = runs[0].frames[i];
    CHECK(frame.mesh.faces == runs[0].frames[0].mesh.faces);
    const Mesh source = frames.mesh(i);
    decimate::Outliers outliers;
    const decimate::Report report =
        decimate::measure_on_lattice(decimate::Reference(source, frames.footprint(i)), frame.mesh,
                                     settings.budget, outliers, decimate::Looks::within_faces);
    CHECK(report.error.rms_pixels == frame.report.error.rms_pixels);
    CHECK(report.error.rms_pixels <= settings.budget.pixels);
    CHECK(report.thin_area == 0);
  }
}

TEST_CASE("the result is the same each time, and scales with the scene") {
  const auto large = [](size_t i) {
    Mesh mesh = swaying(i);
    for (double &x : mesh.positions) x *= 1024;
    return mesh;
  };
  const std::vector<track::Run> runs = track::track(frames_of(3, swaying), within(0.004));
  const std::vector<track::Run> again = track::track(frames_of(3, swaying), within(0.004));
  const std::vector<track::Run> scaled = track::track(frames_of(3, large), within(0.004 * 1024));
  REQUIRE(runs.size() == 1);
  REQUIRE(again.size() == 1);
  REQUIRE(scaled.size() == 1);
  REQUIRE(scaled[0].frames.size() == runs[0].frames.size());
  for (size_t i = 0; i < runs[0].frames.size(); i++) {
    CHECK(runs[0].frames[i].mesh.positions == again[0].frames[i].mesh.positions);
    CHECK(scaled[0].frames[i].report.error.rms / 1024 ==
          Approx(runs[0].frames[i].report.error.rms).epsilon(0.1));
  }
}

TEST_CASE("two bodies that move apart are followed each on its own") {
  const auto two = [](size_t frame) {
    const double t = double(frame);
    return meshed(frame, [&](Vec3 p) {
      return std::min(capsule(p, {-0.4, 0, -0.4 - 0.03 * t}, {-0.4, 0, 0.3}, 0.2),
                      capsule(p, {0.4, 0, -0.3 + 0.05 * t}, {0.4, 0.05 * t, 0.4}, 0.2));
    });
  };
  const std::vector<track::Run> runs = track::track(frames_of(4, two), within(0.004));
  REQUIRE(runs.size() == 1);
  CHECK(runs[0].frames.size() == 4);
}

TEST_CASE("where two pieces become one the run ends, and another begins") {
  const std::vector<track::Run> runs = track::track(frames_of(6, joining), within(0.003));
  REQUIRE(runs.size() == 2);
  CHECK(runs[0].first == 0);
  CHECK(runs[0].frames.size() == 3);
  CHECK(runs[1].first == 3);
  CHECK(runs[1].frames.size() == 3);
}

namespace {

constexpr double metres_per_pixel = 4.0 / 300; // at the origin

// Three cameras around the origin, and the masks of a surface. The budget is in metres.
std::vector<track::MaskView> masks_of(const Mesh &mesh) {
  std::vector<track::MaskView> out;
  const geometry::ViewedSurface surface(mesh.positions, mesh.faces);
  for (int k = 0; k < 3; k++) {
    fvv_camera camera = {};
    camera.id = uint16_t(k);
    camera.width = camera.height = 200;
    camera.fx = camera.fy = 300;
    camera.cx = camera.cy = 100;
    camera.r_max = 4;
    const double turn = k * M_PI / 3, c = std::cos(turn), s = std::sin(turn);
    const double rotation[9] = {c, s, 0, 0, 0, -1, -s, c, 0};
    std::copy_n(rotation, 9, camera.rotation);
    camera.translation[2] = 4;
    out.push_back({camera, surface.cover(camera), metres_per_pixel});
  }
  return out;
}

// A capsule with bumps of nine tenths of a pixel that are elsewhere in each frame.
Mesh flickering(size_t frame) {
  const double t = double(frame), phase = 2.3 * t;
  return meshed(frame, [&](Vec3 p) {
    return capsule(p, {0, 0, -0.4}, {0.03 * t, 0, 0.4}, 0.25) +
           0.012 * std::sin(30 * p.z + phase) * std::sin(30 * (p.x + p.y) + 1.7 * phase);
  });
}

} // namespace

TEST_CASE("outlines judge frames whose hulls flicker") {
  track::Settings settings = within(0.002);
  const decimate::Frames frames = frames_of(4, flickering);
  const auto tracked = [&] {
    size_t count = 0;
    for (const track::Run &run : track::track(frames, settings)) count += run.frames.size();
    return count;
  };
  CHECK(tracked() < 4);
  settings.masks = [&](size_t i) { return masks_of(flickering(i)); };
  const std::vector<track::Run> runs = track::track(frames, settings);
  REQUIRE(runs.size() == 1);
  REQUIRE(runs[0].frames.size() == 4);
  size_t by_outlines = 0;
  for (const track::Frame &frame : runs[0].frames) by_outlines += frame.report.by_outlines;
  CHECK(by_outlines >= 1);
  // A budget of a fiftieth of that: outlines are too far off as well.
  settings.masks = [&](size_t i) {
    std::vector<track::MaskView> masks = masks_of(flickering(i));
    for (track::MaskView &mask : masks) mask.scale *= 50;
    return masks;
  };
  CHECK(tracked() < 4);
}

TEST_CASE("what outlines of a hull miss gets a patch") {
  track::Settings settings = within(0.004);
  settings.masks = [&](size_t i) { return masks_of(joining(i)); };
  const auto tracked = [&] { return track::track(frames_of(5, joining), settings); };
  const std::vector<track::Run> without = tracked();
  REQUIRE(!without.empty());
  CHECK(without[0].first + without[0].frames.size() == 3); // the bar comes
  settings.patches = true;
  const std::vector<track::Run> runs = tracked();
  REQUIRE(runs.size() == 1);
  REQUIRE(runs[0].frames.size() == 5);
  CHECK(runs[0].key < 3);
  for (size_t i = 0; i < 5; i++) CHECK(runs[0].frames[i].patch.has_value() == (i == 3));
  const track::Patch &patch = *runs[0].frames[3].patch;
  CHECK(open_edges(patch.next) == 0);
  CHECK(area_of(patch.next) == Approx(area_of(joining(3))).epsilon(0.02));
}

TEST_CASE("hulls lie on the outlines of their masks, other surfaces do not") {
  const Mesh ball = shapes::sphere(0.4, 4);
  const std::vector<track::MaskView> masks = masks_of(ball);
  CHECK(track::fraction_on_outlines(ball, masks) < track::least_of_hull);
  CHECK(track::fraction_on_outlines({}, masks) == 0);
  std::vector<hull::Silhouette> silhouettes;
  for (const track::MaskView &mask : masks) silhouettes.emplace_back(mask.camera, mask.inside);
  const Mesh carved = meshed(0, [&](Vec3 p) {
    const double point[3] = {p.x, p.y, p.z};
    double furthest = -1;
    for (const hull::Silhouette &silhouette : silhouettes)
      furthest = std::max(furthest, silhouette.view(point).metres);
    return furthest;
  });
  CHECK(track::fraction_on_outlines(carved, masks) > track::least_of_hull);
}

TEST_CASE("frames without a surface are left out, and a run may be cancelled") {
  const auto empty_at_two = [](size_t frame) { return frame == 2 ? Mesh{} : swaying(frame); };
  const std::vector<track::Run> runs = track::track(frames_of(5, empty_at_two), within(0.004));
  REQUIRE(runs.size() == 2);
  CHECK(runs[0].first == 0);
  CHECK(runs[0].frames.size() == 2);
  CHECK(runs[1].first == 3);
  CHECK(runs[1].frames.size() == 2);
  track::Settings settings = within(0.004);
  size_t calls = 0;
  settings.check_cancelled = [&] {
    if (++calls == 8) throw Error("cancelled", Error::cancelled);
  };
  CHECK_THROWS_AS(track::track(frames_of(4, swaying), settings), Error);
  CHECK(calls == 8);
}

TEST_CASE("where two pieces become one a patch stands, closed and within the budget") {
  track::Settings settings = within(0.003);
  settings.patches = true;
  const decimate::Frames frames = frames_of(6, joining);
  const std::vector<track::Run> runs = track::track(frames, settings);
  REQUIRE(runs.size() == 1);
  REQUIRE(runs[0].frames.size() == 6);
  const std::vector<uint32_t> *faces = &runs[0].frames[0].mesh.faces;
  for (size_t i = 0; i < 6; i++) {
    const track::Frame &frame = runs[0].frames[i];
    CHECK(frame.mesh.faces == *faces);
    if (i == 3) REQUIRE(frame.patch); // those that follow move the mesh that has it
    if (!frame.patch) continue;
    CHECK(i >= 3);
    const track::Patch &patch = *frame.patch;
    faces = &patch.next.faces;
    const Mesh whole = track::patched(frame.mesh, patch);
    CHECK(open_edges(whole) == 0);
    CHECK(open_edges(patch.next) == 0);
    CHECK(area_of(patch.next) == Approx(area_of(whole)));
    REQUIRE(patch.next_of.size() == whole.vertex_count());
    std::vector<bool> reached(patch.next.vertex_count());
    for (size_t v = 0; v < patch.next_of.size(); v++) {
      const uint32_t next = patch.next_of[v];
      if (next == UINT32_MAX) continue;
      reached[next] = true;
      for (size_t k = 0; k < 3; k++)
        CHECK(patch.next.positions[3 * size_t(next) + k] == whole.positions[3 * v + k]);
    }
    CHECK(std::find(reached.begin(), reached.end(), false) == reached.end());
    REQUIRE(patch.joins.size() == patch.mesh.vertex_count());
    for (size_t v = 0; v < patch.joins.size(); v++)
      for (size_t k = 0; k < 3 && patch.joins[v] != UINT32_MAX; k++)
        CHECK(patch.mesh.positions[3 * v + k] == frame.mesh.positions[3 * size_t(patch.joins[v]) + k]);
    const size_t absent = size_t(std::count(patch.absent.begin(), patch.absent.end(), 1));
    CHECK(absent > 0);
    CHECK(3 * absent < patch.absent.size());
    const Mesh source = frames.mesh(i);
    decimate::Outliers outliers;
    const decimate::Report report =
        decimate::measure_on_lattice(decimate::Reference(source, frames.footprint(i)), whole, settings.budget,
                                     outliers, decimate::Looks::within_faces);
    CHECK(report.error.rms_pixels == frame.report.error.rms_pixels);
    CHECK(report.error.rms_pixels <= settings.budget.pixels);
    CHECK(report.error.max_pixels <= decimate::max_over_rms * settings.budget.pixels);
    CHECK(std::abs(decimate::enclosed_volume(whole) / decimate::enclosed_volume(source) - 1) < 0.01);
  }
}

TEST_CASE("a patch may end at a border of the surface") {
  track::Settings settings = within(0.002);
  settings.patches = true;
  const std::vector<track::Run> runs = track::track(frames_of(4, sheet_at), settings);
  REQUIRE(runs.size() == 1);
  REQUIRE(runs[0].frames.size() == 4);
  CHECK(runs[0].key == 0); // frame 2 has more area, but those before it would have patches
  CHECK(!runs[0].frames[1].patch);
  CHECK(runs[0].frames[3].patch); // it is down again
  const track::Frame &raised = runs[0].frames[2];
  REQUIRE(raised.patch);
  CHECK(area_of(track::patched(raised.mesh, *raised.patch)) == Approx(area_of(sheet_at(2))).epsilon(0.01));
}
