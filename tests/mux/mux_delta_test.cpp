// Runs of frames with the same connectivity: fvvmux finds them, codes key and delta frames, and --verify
// detects wrong ones.
#include "mux_fixture.h"

#include "mux/src/meshes/meshes.h"

#include <algorithm>
#include <numeric>
#include <random>

namespace {

geometry::Mesh shuffled(const geometry::Mesh &mesh, uint32_t seed) {
  std::vector<uint32_t> order(mesh.vertex_count());
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), std::mt19937(seed));
  geometry::Mesh out = mesh;
  for (size_t v = 0; v < order.size(); v++)
    std::copy_n(&mesh.positions[3 * v], 3, &out.positions[3 * size_t(order[v])]);
  for (uint32_t &corner : out.faces) corner = order[corner];
  return out;
}

// 'k' or 'd' for each mesh, in order; the stream has nothing wrong.
std::string keys_of(const std::string &path) {
  std::string out;
  fvv_check_options options;
  fvv_check_options_default(&options);
  options.decode = 1;
  options.user = &out;
  options.event = [](void *user, const fvv_event *event) {
    if (event->kind == FVV_EVENT_CHUNK && event->chunk.type == FVV_CHUNK_MESH)
      *static_cast<std::string *>(user) += event->chunk.flags & FVV_FLAG_KEY ? 'k' : 'd';
  };
  fvv_checker *checker = nullptr;
  REQUIRE(fvv_checker_create(&options, nullptr, nullptr, &checker) == FVV_OK);
  const std::string bytes = read_bytes(path);
  CHECK(fvv_checker_push(checker, bytes.data(), bytes.size()) == FVV_OK);
  CHECK(fvv_checker_finish(checker) == FVV_OK);
  CHECK(fvv_checker_summary(checker)->problems == 0);
  fvv_checker_destroy(checker);
  return out;
}

} // namespace

TEST_CASE("frames with the same faces become key and delta frames") {
  const Folder folder;
  FileOptions options = frames_on_disk(folder, balls(13));
  const mux::Report summary = mux_file(options); // verifies
  CHECK(keys_of(options.output) == "kdddddkdddddk");
  CHECK((summary.mesh.chunks == 13 && summary.delta.chunks == 10));
  CHECK(summary.verdict->meshes == 13);
  options.delta = false;
  const mux::Report keys = mux_file(options);
  CHECK(keys_of(options.output) == std::string(13, 'k'));
  CHECK(summary.mesh.payload < keys.mesh.payload / 2);
}

TEST_CASE("the bytes of delta frames do not depend on threads") {
  const Folder folder;
  FileOptions options = frames_on_disk(folder, balls(13));
  options.threads = 1;
  mux_file(options);
  const std::string one = read_bytes(options.output);
  options.threads = 5;
  mux_file(options);
  CHECK(read_bytes(options.output) == one);
}

TEST_CASE("frames that differ in the order of their vertices are a run") {
  const Folder folder;
  Frames frames = balls(6);
  for (uint32_t i = 1; i < 6; i++) frames[i] = shuffled(frames[i], i);
  const FileOptions options = frames_on_disk(folder, frames);
  CHECK(mux_file(options).verdict->meshes == 6);
  CHECK(keys_of(options.output) == "kddddd");
}

TEST_CASE("a run that is decimated stays one, for any order of its vertices") {
  const Folder folder;
  Frames frames = balls(12);
  for (uint32_t i = 1; i < 12; i += 2) frames[i] = shuffled(frames[i], i);
  FileOptions options = frames_on_disk(folder, frames);
  options.keep_geometry = false;
  options.triangles = 150;
  const mux::Report summary = mux_file(options); // verifies
  CHECK(keys_of(options.output) == "kdddddkddddd");
  Stream stream(options.output);
  fvv_mesh mesh;
  stream.mesh(7, mesh);
  CHECK(mesh.face_count < 170);
  CHECK(summary.verdict->mesh.max_vertex_error <= summary.lattice.error() * (1 + 1e-9));
  fvv_mesh_free(&mesh);
}

TEST_CASE("a run ends where the faces change, and another begins") {
  const Folder folder;
  Frames frames = balls(6);
  for (size_t i = 2; i < 5; i++)
    std::swap(frames[i].faces[0], frames[i].faces[1]), std::swap(frames[i].faces[1], frames[i].faces[2]);
  for (size_t i = 0; i < 3; i++)
    std::rotate(frames[5].faces.begin(), frames[5].faces.begin() + 3, frames[5].faces.end());
  const FileOptions options = frames_on_disk(folder, frames);
  mux_file(options);
  CHECK(keys_of(options.output) == "kdkddk");
}

TEST_CASE("where motion costs more than a key frame there is a key frame") {
  const Folder folder;
  Frames frames = balls(6);
  std::mt19937 random(1);
  for (size_t i = 3; i < 6; i++)
    for (size_t k = 0; k < frames[i].positions.size(); k++)
      frames[i].positions[k] += i == 3 ? std::uniform_real_distribution(-3.0, 3.0)(random)
                                       : frames[3].positions[k] - ball(3).positions[k];
  const FileOptions options = frames_on_disk(folder, frames);
  mux_file(options);
  CHECK(keys_of(options.output) == "kddkdd");
}

TEST_CASE("vertices and faces that meet in the key frame alone come apart again") {
  const Folder folder;
  Frames frames = balls(6);
  for (size_t v = 1; v <= 16; v++)
    std::copy_n(&frames[0].positions[0], 3, &frames[0].positions[3 * v]); // a ring at the pole
  FileOptions options = frames_on_disk(folder, frames);
  const mux::Report summary = mux_file(options); // verifies every face
  CHECK(keys_of(options.output) == "kddddd");
  CHECK(summary.changes.welded.count == 0);
  options.delta = false;
  CHECK(mux_file(options).changes.welded.count == 16);
}

TEST_CASE("verification finds a delta frame that is not the capture's") {
  const Folder folder;
  Frames frames = balls(6);
  const FileOptions options = frames_on_disk(folder, frames);
  const Encoded encoded = encode_file(options);
  const auto complaint = [&](const geometry::Mesh &other) {
    const std::string path = encoded.plan.capture.mesh_path(3), was = read_bytes(path);
    scene::write_mesh(other, {{0, 0, 0}, 1e-6}, path);
    std::string found;
    try {
      encoded.verify(options.output);
    } catch (const fvv::Error &failure) {
      found = failure.what();
    }
    write_bytes(path, was.data(), was.size());
    return found;
  };
  const std::string prefix = options.output + ": frame 3: ";
  geometry::Mesh moved = frames[3], turned = frames[3], more = frames[3], less = frames[3];
  moved.positions[3 * 20 + 1] += 2 * encoded.report.lattice.error();
  CHECK(complaint(moved).find(prefix + "decoded vertex ") == 0);
  std::swap(turned.faces[0], turned.faces[1]);
  CHECK(complaint(turned) == prefix + "1 decoded faces are turned round, the encoder turned 0");
  more.faces.insert(more.faces.end(), {5, 70, 140});
  CHECK(complaint(more) == prefix + "a face of the source is missing");
  less.faces.resize(less.faces.size() - 3);
  CHECK(complaint(less) == prefix + "a decoded face is none of the source's");
  CHECK(complaint(frames[3]).empty());
}

TEST_CASE("connectivity is the same or it is not") {
  const geometry::Mesh mesh = ball(0);
  geometry::Mesh other = shuffled(ball(3), 7);
  const auto there = mux::same_connectivity(mesh, other);
  REQUIRE(there);
  for (size_t i = 0; i < mesh.faces.size(); i++) CHECK(other.faces[i] == (*there)[mesh.faces[i]]);
  other.faces[0] = other.faces[1];
  CHECK(!mux::same_connectivity(mesh, other));
  other = mesh;
  other.positions.insert(other.positions.end(), {1, 2, 3});
  CHECK(!mux::same_connectivity(mesh, other));
  other = mesh;
  other.texture.assign(2 * mesh.vertex_count(), 0.5);
  CHECK(!mux::same_connectivity(mesh, other));
  geometry::Mesh first = other;
  CHECK(mux::same_connectivity(first, other));
  other.texture[5] = 0.25;
  CHECK(!mux::same_connectivity(first, other));
  // A vertex without a face goes with what is left.
  first = mesh;
  first.positions.insert(first.positions.end(), {1, 2, 3});
  other = shuffled(first, 3);
  CHECK(mux::same_connectivity(first, other)->size() == first.vertex_count());
}

TEST_CASE("a tracked capture gets a finer lattice, and the error that the budget leaves") {
  const Folder folder;
  const scene::Capture capture = make_capture(folder);
  FileOptions options = options_for(folder);
  const double budget = 0.15 * 2.5 / 70.5; // metres at the nearest camera, as in the test of the lattice
  const mux::LatticeChoice tracked = mux::make_plan(options, {}).lattice;
  CHECK(tracked.lattice.step == 0.002); // not above 2 * budget / 3 / 2 = 0.0035
  CHECK(tracked.delta_error == 2);      // 2.5 steps are 5 mm of 5.3
  CHECK(tracked.error() <= budget);
  CHECK(tracked.pixels == Approx(0.005 * 70.5 / 2.5).epsilon(1e-3));
  options.step = mux::Length{0.001, true};
  CHECK(mux::make_plan(options, {}).lattice.delta_error == 4);
  options.step = mux::Length{0.01, true};
  CHECK(mux::make_plan(options, {}).lattice.delta_error == 0);
}
