// Decimation of frames that share their faces.
#include "decimate_fixture.h"

using namespace shapes;
using decimate::Frames;
using decimate::TopologyRun;

namespace {

// A ball that is pulled out into an ellipsoid.
Mesh stretched(size_t frame) {
  Mesh mesh = sphere(0.5, 5);
  for (size_t v = 0; v < mesh.vertex_count(); v++) mesh.positions[3 * v] *= 1 + 0.05 * double(frame);
  return mesh;
}

Frames frames_of(size_t count, const std::function<Mesh(size_t)> &mesh) {
  return {count, mesh, [](size_t) { return millimetre_pixels(); }};
}

} // namespace

TEST_CASE("a run has the same faces and source vertices in every frame, each within the budget") {
  const TopologyRun run(frames_of(5, stretched), budget(2), 0.02);
  const decimate::Decimated first = run.apply(stretched(0), 0);
  CHECK(first.report.faces_after < 3000);
  for (size_t i = 0; i < 5; i++) {
    const Mesh source = stretched(i);
    const decimate::Decimated out = run.apply(source, i);
    CHECK(out.mesh.faces == first.mesh.faces);
    CHECK(out.vertices == first.vertices);
    CHECK(out.report.error.rms_pixels <= 2);
    CHECK(out.report.error.max_pixels <= 12);
    for (size_t v = 0; v < out.vertices.size(); v++)
      for (size_t k = 0; k < 3; k++)
        REQUIRE(out.mesh.positions[3 * v + k] == source.positions[3 * size_t(out.vertices[v]) + k]);
  }
}

TEST_CASE("a part that needs all its triangles leaves the savings of the others") {
  // In later frames a third of the sheet has a needle at every fourth vertex, of which the first frame shows
  // nothing: far more faces than are locked at first.
  const auto prickly = [](size_t frame) {
    return sheet(60, false, [&](double x, double y) {
      const auto grid = [](double at) { return std::lround(60 * at) % 4 == 2; };
      return frame && x < 0.3 && grid(x) && grid(y) ? 0.1 : 0.01 * std::sin(5 * x) * y;
    });
  };
  const TopologyRun run(frames_of(3, prickly), budget(1), 0.005);
  for (size_t i = 0; i < 3; i++) {
    const decimate::Decimated out = run.apply(prickly(i), i);
    CHECK_FALSE(out.report.kept);
    CHECK(double(out.report.faces_after) < 0.95 * double(prickly(i).face_count()));
    CHECK(out.report.error.rms_pixels <= 1);
    CHECK(out.report.error.max_pixels <= 6);
  }
}

TEST_CASE("a later frame decides when it needs more triangles") {
  // Flat in the first frame, and bent later.
  const auto bent = [](size_t frame) {
    return sheet(30, false, [&](double x, double y) {
      return 0.04 * double(frame) * std::sin(6 * x) * std::cos(5 * y);
    });
  };
  const TopologyRun still(frames_of(2, [&](size_t) { return bent(0); }), budget(1), 0.01);
  const size_t flat = still.apply(bent(0), 0).report.faces_after;
  const TopologyRun moving(frames_of(4, bent), budget(1), 0.01);
  for (size_t i = 0; i < 4; i++) {
    const decimate::Decimated out = moving.apply(bent(i), i);
    CHECK((out.report.kept || out.report.error.rms_pixels <= 1));
    CHECK(out.report.faces_after > flat);
    CHECK(out.mesh.faces == moving.apply(bent(0), 0).mesh.faces);
  }
}

TEST_CASE("vertices that touch in the first frame only are not joined") {
  // Two sheets, face to face in frame 0, 20 mm apart in frame 1.
  const auto pair = [](size_t frame) {
    Mesh lower = sheet(12, false, [](double, double) { return 0.0; });
    const Mesh upper = sheet(12, false, [&](double, double) { return 0.02 * double(frame); });
    return together(lower, upper);
  };
  const TopologyRun run(frames_of(2, pair), budget(1), 0.005);
  const decimate::Decimated out = run.apply(pair(1), 1);
  for (size_t f = 0; f < out.mesh.face_count(); f++) {
    double z[3];
    for (size_t k = 0; k < 3; k++) z[k] = out.mesh.positions[3 * size_t(out.mesh.faces[3 * f + k]) + 2];
    CHECK((z[0] == z[1] && z[1] == z[2]));
  }
}

TEST_CASE("with a number of triangles, what a frame loses is counted for that frame alone") {
  // Far more is asked than the budget in pixels allows: all frames have places beyond it.
  decimate::Budget wanted = budget(2);
  wanted.triangles = 20;
  const TopologyRun run(frames_of(4, [](size_t) { return stretched(0); }), wanted, 0);
  const double lost = run.apply(stretched(0), 0).report.thin_area;
  CHECK(lost > 0);
  for (size_t i = 1; i < 4; i++) CHECK(run.apply(stretched(0), i).report.thin_area == Approx(lost));
}
