// Frames that share their faces as one glTF file, read back.
#include "fvv_catch.h"

#include "fvv_cxx/error.h"
#include "fvv_cxx/untrusted.h"
#include "fvv_scene/mesh_run.h"
#include "scene/src/gltf/pose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

using namespace fvv::scene;

namespace {

const Lattice lattice = {{0.5, -2, 0.25}, 0.001};

// A tetrahedron that moves, with normals and texture coordinates; reach: of its positions, in steps.
MeshRun tetrahedron(size_t frames, int32_t reach = 1000) {
  MeshRun run;
  run.faces = {3, 2, 1, 0, 1, 2, 0, 2, 3, 0, 3, 1};
  run.texture = {0, 0, 4096, 0, 0, 4096, 1234, 4095};
  run.texture_bits = 12;
  for (size_t i = 0; i < frames; i++) {
    const auto by = int32_t(i * i) * (reach / 100);
    run.frames.push_back({{by, 0, 0, reach, 0, by, 0, reach, 0, -3, 5, reach - by},
                          {1, 0, 0, 0, 1, 0, 0, 0, 1, 0.6f, i % 2 ? 0.8f : 0, i % 2 ? 0 : 0.8f},
                          double(i) / 30,
                          "frame " + std::to_string(i)});
  }
  return run;
}

// A corner of a face: position and texture on their lattices, normal in thousandths.
using Corner = std::array<long, 8>;
using Face = std::vector<Corner>;

// Faces, each from its least corner on: compressors may begin with any.
std::multiset<Face> faces_of(const std::vector<Corner> &corners) {
  std::multiset<Face> out;
  for (size_t i = 0; i < corners.size(); i += 3) {
    const auto first = std::min_element(corners.begin() + long(i), corners.begin() + long(i) + 3);
    Face face(first, corners.begin() + long(i) + 3);
    face.insert(face.end(), corners.begin() + long(i), first);
    out.insert(face);
  }
  return out;
}

std::multiset<Face> expected(const MeshRun &run, size_t frame) {
  std::vector<Corner> corners;
  for (const uint32_t v : run.faces) {
    Corner corner;
    for (size_t k = 0; k < 3; k++) corner[k] = run.frames[frame].positions[3 * v + k];
    for (size_t k = 0; k < 2; k++) corner[3 + k] = run.texture[2 * v + k];
    for (size_t k = 0; k < 3; k++) corner[5 + k] = std::lround(run.frames[frame].normals[3 * v + k] * 1000);
    corners.push_back(corner);
  }
  return faces_of(corners);
}

std::multiset<Face> found(const std::string &glb, std::optional<double> time) {
  const fvv_limits limits = fvv::limits_or_default(nullptr);
  const gltf::AnimationChoice choice =
      time ? gltf::AnimationChoice(gltf::OnlyAnimation{}) : gltf::AnimationChoice(gltf::NoAnimation{});
  gltf::Scene scene = gltf::read_scene(glb, "run.glb", choice, limits, gltf::Texture::coordinates, true);
  const Mesh mesh = gltf::pose(scene, time);
  std::vector<Corner> corners;
  for (const uint32_t v : mesh.faces) {
    Corner corner;
    for (size_t k = 0; k < 3; k++) {
      const double steps = (mesh.positions[3 * v + k] - lattice.origin[k]) / lattice.step;
      corner[k] = std::lround(steps);
      CHECK(std::fabs(steps - double(corner[k])) < 0.4);
      const double *normal = &mesh.normals[3 * v];
      const double length = std::hypot(normal[0], normal[1], normal[2]); // its node is scaled
      corner[5 + k] = std::lround(normal[k] / length * 1000);
    }
    for (size_t k = 0; k < 2; k++) corner[3 + k] = std::lround(mesh.texture[2 * v + k] * 4096);
    corners.push_back(corner);
  }
  return faces_of(corners);
}

const std::string picture = "\x89PNG of the atlas";

std::string failure(const MeshRun &run, const Lattice &on, Compression compression) {
  try {
    format_run(run, on, "", compression, "run.glb");
  } catch (const fvv::Error &error) {
    return error.what();
  }
  return "";
}

} // namespace

TEST_CASE("a run of frames comes back from its glTF file, compressed or not") {
  // 70,000 steps do not fit into 16 bits.
  for (const int32_t reach : {1000, 70000})
    for (const Compression compression : {Compression::none, Compression::meshopt}) {
      const MeshRun run = tetrahedron(4, reach);
      const std::string glb = format_run(run, lattice, picture, compression, "run.glb");
      const bool integers = compression == Compression::meshopt && reach < 65536;
      CHECK((glb.find("KHR_mesh_quantization") != std::string::npos) == integers);
      for (size_t i = 0; i < 4; i++) CHECK(found(glb, double(i) / 30) == expected(run, i));
      CHECK(glb == format_run(run, lattice, picture, compression, "run.glb"));
    }
}

TEST_CASE("a mesh that rests until later has a key at both ends") {
  for (const Compression compression : {Compression::none, Compression::meshopt}) {
    MeshRun run = tetrahedron(3);
    run.frames[1].time = 0.1;
    run.frames[1].held_until = 0.5;
    run.frames[2].time = 0.6;
    run.frames[2].held_until = 0.9;
    const std::string glb = format_run(run, lattice, picture, compression, "run.glb");
    CHECK(found(glb, 0.0) == expected(run, 0));
    for (const double time : {0.1, 0.3, 0.5}) CHECK(found(glb, time) == expected(run, 1));
    for (const double time : {0.6, 0.8, 0.9}) CHECK(found(glb, time) == expected(run, 2));
    CHECK(found(glb, 0.55) != expected(run, 1));
  }
}

TEST_CASE("displacements that 16 bits do not hold are float32") {
  MeshRun run = tetrahedron(2, 30000);
  run.frames[1].positions[0] = -32768;
  run.frames[1].positions[3] = 70000;
  const std::string glb = format_run(run, lattice, picture, Compression::meshopt, "run.glb");
  CHECK(glb.find("KHR_mesh_quantization") == std::string::npos);
  CHECK(found(glb, 1.0 / 30) == expected(run, 1));
}

TEST_CASE("a frame alone has no animation") {
  const MeshRun run = tetrahedron(1);
  for (const Compression compression : {Compression::none, Compression::draco, Compression::meshopt}) {
    const std::string glb = format_run(run, lattice, picture, compression, "run.glb");
    CHECK(glb.find("animations") == std::string::npos);
    CHECK(glb.find("targets") == std::string::npos);
    CHECK(found(glb, {}) == expected(run, 0));
  }
}

TEST_CASE("vertices of no face are left out by compression") {
  MeshRun run = tetrahedron(1);
  const std::multiset<Face> faces = expected(run, 0);
  run.frames[0].positions.insert(run.frames[0].positions.begin(), {9, 9, 9});
  run.frames[0].normals.insert(run.frames[0].normals.begin(), {0, 0, 1});
  run.texture.insert(run.texture.begin(), {7, 7});
  for (uint32_t &corner : run.faces) corner++;
  for (const Compression compression : {Compression::draco, Compression::meshopt})
    CHECK(found(format_run(run, lattice, picture, compression, "run.glb"), {}) == faces);
}

TEST_CASE("a lattice that float32 does not hold is refused") {
  // One that is as large as that itself.
  MeshRun late = tetrahedron(2);
  late.frames[1].positions[4] = 200000001;
  CHECK(failure(late, lattice, Compression::none).find("vertex 1 lies too far out") != std::string::npos);
  CHECK(failure(tetrahedron(1, 1 << 22), {{-2000, 0, 0}, 0.001}, Compression::draco)
            .find("2^22 steps of its lattice long or more") != std::string::npos);
  CHECK(failure(tetrahedron(2), lattice, Compression::draco) ==
        "run.glb: Draco cannot compress an animation");
}
