// fvvmux: an animated glTF file on the whole way into a stream.
#include "gltf_fixture.h"
#include "mux_fixture.h"

#include <set>

namespace {

// The corner of the mesh that is nearest to a lattice point, by the largest difference of a coordinate.
double nearest(const double (&point)[3], const geometry::Mesh &mesh) {
  double best = INFINITY;
  for (size_t i = 0; i < mesh.positions.size(); i += 3) {
    double off = 0;
    for (size_t k = 0; k < 3; k++) off = std::max(off, std::fabs(point[k] - mesh.positions[i + k]));
    best = std::min(best, off);
  }
  return best;
}

std::string describe(const Folder &folder, int first, int count) {
  const std::string text =
      R"({"fvv_capture": 1, "frame_rate": 9, "units": "metres", "up": "+y", "frames": {"first": )" +
      std::to_string(first) + R"(, "count": )" + std::to_string(count) +
      R"(}, "meshes": {"file": "tube.glb", "animation": 0}})";
  write_bytes(folder.path("in/capture.json"), text.data(), text.size());
  return folder.path("in/capture.json");
}

} // namespace

TEST_CASE("ten frames of an animated glTF file become ten meshes of one topology") {
  const Folder folder;
  fs::create_directories(folder.path("in"));
  const std::string glb = gltf_fixture::tube().glb();
  write_bytes(folder.path("in/tube.glb"), glb.data(), glb.size());
  const scene::Capture capture = scene::load_capture(describe(folder, 3, 10));
  std::set<std::string> results;
  double error = 0;
  for (const uint32_t threads : {1, 4}) {
    FileOptions options = options_for(folder);
    options.threads = threads;
    options.verify = true;
    const mux::Report summary = mux_file(options);
    CHECK(!summary.warned);
    error = summary.lattice.error();
    results.insert(read_bytes(options.output));
  }
  CHECK(results.size() == 1);
  Stream stream(folder.path("out.fvv"));
  REQUIRE(stream.frames() == 10);
  const fvv_scene &scene = stream.configuration().scene;
  std::vector<std::vector<int32_t>> positions;
  for (size_t i = 0; i < 10; i++) {
    const geometry::Mesh source = scene::load_mesh(capture, 3 + int64_t(i));
    fvv_mesh mesh = {};
    stream.mesh(i, mesh);
    CHECK(mesh.vertex_count == 20);
    CHECK(mesh.face_count == 32);
    for (uint32_t v = 0; v < mesh.vertex_count; v++) {
      double metres[3];
      fvv_lattice_to_metres(scene.lattice_origin, scene.lattice_step, mesh.lattice + 3 * size_t(v), metres);
      CHECK(nearest(metres, source) <= error * (1 + 1e-9));
    }
    positions.emplace_back(mesh.lattice, mesh.lattice + 3 * size_t(mesh.vertex_count));
    fvv_mesh_free(&mesh);
    for (size_t j = 0; j < i; j++) CHECK(positions[j] != positions[i]);
  }
}

TEST_CASE("frames after the end of an animation are written with a warning") {
  const Folder folder;
  fs::create_directories(folder.path("in"));
  const std::string glb = gltf_fixture::tube().glb();
  write_bytes(folder.path("in/tube.glb"), glb.data(), glb.size());
  const std::string description = describe(folder, 0, 12);
  const ToolResult run = run_tool({folder.path("in"), "-o", folder.path("out.fvv")});
  CHECK(run.exit == cli::loss);
  CHECK(run.err.find(
            "fvvmux: warning: " + description +
            ": meshes: the animation ends at 1.000 s, the last 2 of 12 frames, from 10, repeat its end\n") !=
        run.err.npos);
  CHECK(run_tool({folder.path("in"), "-o", folder.path("part.fvv"), "--frames", "2-9"}).exit == cli::done);
  // Frames left out by an option give no warning, missing ones do.
  CHECK(run_tool({folder.path("in"), "-o", folder.path("part.fvv"), "--force", "--frames", "9-11"}).exit ==
        cli::loss);
  fs::remove(folder.path("in/tube.glb"));
  CHECK(run_tool({folder.path("in"), "-o", folder.path("no.fvv")}).err ==
        "fvvmux: " + description + ": meshes: " + folder.path("in/tube.glb") +
            ": cannot be opened: No such file or directory\n");
}
