// fvvmux, then fvvdemux: when normals are sent, and that they arrive.
#include "mux_fixture.h"

#include "fvv_mux/report.h"
#include "fvvdemux/demux.h"

#include <algorithm>
#include <array>

namespace {

// A box whose six sides have n x n squares and vertices and a normal of their own, turned about y.
geometry::Mesh box(uint32_t n, double turn) {
  geometry::Mesh mesh;
  const auto rotated = [&](std::array<double, 3> p) {
    return std::array<double, 3>{std::cos(turn) * p[0] + std::sin(turn) * p[2], p[1],
                                 std::cos(turn) * p[2] - std::sin(turn) * p[0]};
  };
  for (size_t side = 0; side < 6; side++) {
    const size_t k = side / 2, i = (k + 1) % 3, j = (k + 2) % 3;
    const double sign = side % 2 ? 1 : -1;
    const auto base = uint32_t(mesh.vertex_count());
    for (uint32_t a = 0; a <= n; a++)
      for (uint32_t b = 0; b <= n; b++) {
        std::array<double, 3> p = {}, normal = {};
        p[k] = 0.5 * sign;
        p[i] = double(a) / n - 0.5;
        p[j] = double(b) / n - 0.5;
        normal[k] = sign;
        for (const double x : rotated(p)) mesh.positions.push_back(x);
        for (const double x : rotated(normal)) mesh.normals.push_back(x);
      }
    for (uint32_t a = 0; a < n; a++)
      for (uint32_t b = 0; b < n; b++) {
        const uint32_t v = base + a * (n + 1) + b, w = v + n + 1;
        for (const uint32_t corner : {v, w, w + 1, v, w + 1, v + 1}) mesh.faces.push_back(corner);
        if (sign < 0) { // the other way round
          std::swap(mesh.faces[mesh.faces.size() - 5], mesh.faces[mesh.faces.size() - 4]);
          std::swap(mesh.faces[mesh.faces.size() - 2], mesh.faces[mesh.faces.size() - 1]);
        }
      }
  }
  return mesh;
}

Frames boxes(size_t count) {
  Frames frames;
  for (size_t i = 0; i < count; i++) frames.push_back(box(6, 0.1 * double(i)));
  return frames;
}

// A ball with its analytic normals.
Frames smooth(size_t count) {
  Frames frames;
  for (size_t i = 0; i < count; i++) {
    frames.push_back(ball(int64_t(i)));
    for (size_t k = 0; k < frames[i].positions.size(); k++)
      frames[i].normals.push_back(frames[i].positions[k] - (k % 3 ? 0 : 0.05 * double(i)));
  }
  return frames;
}

fvv_check_summary checked(const std::string &path, fvv_track_summary &track) {
  fvv_check_options options;
  fvv_check_options_default(&options);
  options.decode = 1;
  fvv_checker *checker = nullptr;
  REQUIRE(fvv_checker_create(&options, nullptr, nullptr, &checker) == FVV_OK);
  const std::string bytes = read_bytes(path);
  CHECK(fvv_checker_push(checker, bytes.data(), bytes.size()) == FVV_OK);
  CHECK(fvv_checker_finish(checker) == FVV_OK);
  const fvv_check_summary summary = *fvv_checker_summary(checker);
  track = *fvv_checker_track(checker, 0);
  fvv_checker_destroy(checker);
  return summary;
}

} // namespace

TEST_CASE("normals are sent where edges are hard, and turn in delta frames") {
  const Folder folder;
  FileOptions options = frames_on_disk(folder, boxes(8));
  const mux::Report summary = mux_file(options); // verifies
  CHECK(summary.normals.bits == 8);
  CHECK(summary.delta.chunks == 6);
  CHECK(summary.verdict->mesh.max_normal_error < 4); // of 8 bits twice, and of rounded positions
  fvv_track_summary track;
  CHECK(checked(options.output, track).problems == 0);
  CHECK((track.with_normals == 8 && track.min_normal_bits == 8 && track.max_normal_bits == 8));
  CHECK(track.max_vertices == 6 * 49);
  const nlohmann::ordered_json json = json_of(summary);
  CHECK(json["mesh"]["normals"]["bits"] == 8);
  CHECK(json["verified"]["max_normal_error"] == summary.verdict->mesh.max_normal_error);
  CHECK(text_of(summary).find("normals   sent with 8 bits: ") != std::string::npos);

  options.normals = mux::Normals::never;
  const mux::Report without = mux_file(options);
  CHECK(without.normals.bits == 0);
  CHECK(without.mesh.payload < summary.mesh.payload);
  CHECK(checked(options.output, track).problems == 0);
  CHECK(track.with_normals == 0);
  CHECK(track.max_vertices == 6 * 36 + 2); // of a closed surface: welded at the edges
}

TEST_CASE("smooth normals are left to players") {
  const Folder folder;
  FileOptions options = frames_on_disk(folder, smooth(3));
  const mux::Report summary = mux_file(options);
  CHECK(summary.normals.bits == 0);
  CHECK(summary.normals.reason == "0 % of the first mesh's vertices lie on hard edges");
  const std::string bytes = read_bytes(options.output);
  // What points inwards is as smooth; a normal of no length is no reason to fail.
  Frames inwards = smooth(3);
  for (double &x : inwards[0].normals) x = -x;
  frames_on_disk(folder, inwards);
  CHECK(mux_file(options).normals.bits == 0);
  CHECK(read_bytes(options.output) == bytes);
  for (size_t k = 0; k < 3; k++) inwards[0].normals[3 * 20 + k] = 0;
  frames_on_disk(folder, inwards);
  const mux::Report broken = mux_file(options);
  CHECK(broken.normals.bits == 0);
  CHECK(broken.normals.reason.find("vertex 20: its normal is (0, 0, 0)") != std::string::npos);
  CHECK(read_bytes(options.output) == bytes);

  // Normals of other vertices, as they come with some captures, are no hard edges.
  Frames mixed = smooth(3);
  std::rotate(mixed[0].normals.begin(), mixed[0].normals.begin() + 3 * 40, mixed[0].normals.end());
  frames_on_disk(folder, mixed);
  const mux::Report odd = mux_file(options);
  CHECK(odd.normals.bits == 0);
  CHECK(odd.normals.reason.find("off those of their own faces") != std::string::npos);

  frames_on_disk(folder, smooth(3));
  options.normals = mux::Normals::always;
  const mux::Report sent = mux_file(options);
  CHECK(sent.normals.bits == 8);
  CHECK(sent.verdict->mesh.max_normal_error <
        6); // a ball of 12 x 16 cells whose normals only the lattice turns
}

TEST_CASE("requested normals have to be there") {
  const Folder folder;
  FileOptions options = frames_on_disk(folder, balls(3));
  CHECK(mux_file(options).normals.reason == "the source has none");
  options.normals = mux::Normals::always;
  CHECK_THROWS_WITH(mux_file(options),
                    Catch::Matchers::Contains("normals=always: ") &&
                        Catch::Matchers::Contains("0000.ply: expected a normal for every"));
  Frames some = boxes(3);
  some[1].normals.clear();
  options = frames_on_disk(folder, some);
  CHECK_THROWS_WITH(mux_file(options), Catch::Matchers::Contains("0001.ply: frame 1: expected a normal"));
  CHECK(run_tool({folder.path("in"), "-o", folder.path("a.fvv"), "--normals", "some"}).exit == cli::usage);
}

TEST_CASE("a capture with hard edges comes back with its normals") {
  const Folder folder;
  FileOptions options = frames_on_disk(folder, {box(3, 0.3), box(4, 0.3)});
  mux_file(options);
  const std::string bytes = read_bytes(options.output);
  for (const demux::Meshes meshes : {demux::Meshes::ply, demux::Meshes::obj, demux::Meshes::drc}) {
    demux::Options how;
    how.meshes = meshes;
    how.force = true;
    demux::Result result;
    demux::demux(options.output, folder.path("back"), how, result);
    CHECK(result.meshes == 2);
    const scene::Capture back = scene::load_capture(folder.path("back/capture.json"));
    const geometry::Mesh mesh = scene::load_mesh(back, 0, nullptr, nullptr, true);
    CHECK(mesh.normals.size() == mesh.positions.size());
    FileOptions again = options_for(folder);
    again.capture = folder.path("back");
    again.output = folder.path("again.fvv");
    again.group = options.group;
    CHECK(mux_file(again).normals.bits == 8);
    Stream first(options.output), second(again.output);
    for (size_t f = 0; f < 2; f++) {
      fvv_mesh a = {}, b = {};
      first.mesh(f, a);
      second.mesh(f, b);
      REQUIRE(a.vertex_count == b.vertex_count);
      const auto sorted = [](const fvv_mesh &m) {
        std::vector<std::array<int64_t, 5>> all;
        for (size_t v = 0; v < m.vertex_count; v++)
          all.push_back({m.lattice[3 * v], m.lattice[3 * v + 1], m.lattice[3 * v + 2], m.normals[2 * v],
                         m.normals[2 * v + 1]});
        std::sort(all.begin(), all.end());
        return all;
      };
      CHECK(sorted(a) == sorted(b));
      fvv_mesh_free(&a);
      fvv_mesh_free(&b);
    }
  }
}
