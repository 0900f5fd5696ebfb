// tools/capture: Draco files, those of other writers and hostile ones included, and files by name.
#include "fvv_catch.h"
#include "fvv_scene/file_io.h"

#include "fvv_scene/mesh_file.h"

#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <random>
#include <unistd.h>

using namespace fvv::scene;

namespace {

const Lattice millimetres = {{0, 0, 0}, 0.001};

std::string complaint(const std::string &bytes, const fvv_limits *limits = nullptr) {
  const std::vector<char> exact(bytes.begin(), bytes.end());
  try {
    const Mesh mesh = parse_drc(std::string_view(exact.data(), exact.size()), "m.drc", limits);
    for (const uint32_t index : mesh.faces) REQUIRE(index < mesh.vertex_count());
    return "";
  } catch (const fvv::Error &error) {
    return error.what();
  }
}

std::string refusal(const Mesh &mesh, const Lattice &lattice) {
  try {
    format_drc(mesh, lattice, "m.drc");
    return "";
  } catch (const fvv::Error &error) {
    return error.what();
  }
}

// A closed octahedron as another program would write it: 8 faces, normals that differ per face, and metadata
// with children. Number: type of the positions.
template <class Number> std::string foreign(draco::DataType type, int quantisation, bool metadata) {
  const Number corners[6][3] = {{64, 0, 0}, {-64, 0, 0}, {0, 64, 0}, {0, -64, 0}, {0, 0, 64}, {0, 0, -64}};
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(8);
  const int positions = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, type);
  const int normals = builder.AddAttribute(draco::GeometryAttribute::NORMAL, 3, draco::DT_FLOAT32);
  for (int face = 0; face < 8; face++) {
    const int x = face & 1, y = 2 + (face >> 1 & 1), z = 4 + (face >> 2 & 1);
    // Every reflection turns the winding round: swap two corners to keep it outward.
    const bool odd = (face ^ face >> 1 ^ face >> 2) & 1;
    builder.SetAttributeValuesForFace(positions, draco::FaceIndex(face), corners[x], corners[odd ? z : y],
                                      corners[odd ? y : z]);
    const std::array<float, 3> normal = {x ? -.6f : .6f, y & 1 ? -.6f : .6f, z & 1 ? -.52f : .52f};
    builder.SetPerFaceAttributeValueForFace(normals, draco::FaceIndex(face), normal.data());
  }
  std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
  if (metadata) {
    auto top = std::make_unique<draco::GeometryMetadata>();
    auto child = std::make_unique<draco::Metadata>(), grandchild = std::make_unique<draco::Metadata>();
    grandchild->AddEntryString("written", "by hand");
    child->AddEntryInt("age", 7);
    child->AddSubMetadata("inner", std::move(grandchild));
    top->AddEntryDouble("scale", 2);
    top->AddSubMetadata("outer", std::move(child));
    top->AddSubMetadata("empty", std::make_unique<draco::Metadata>());
    mesh->AddMetadata(std::move(top));
    auto of_positions = std::make_unique<draco::AttributeMetadata>();
    of_positions->AddEntryString("name", "P");
    mesh->AddAttributeMetadata(positions, std::move(of_positions));
  }
  draco::Encoder encoder;
  if (quantisation) encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, quantisation);
  draco::EncoderBuffer buffer;
  REQUIRE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
  return std::string(buffer.data(), buffer.size());
}

// Six corners, for any seams of the normals, each at 64 on one axis.
void check_octahedron(const Mesh &mesh, double tolerance) {
  REQUIRE(mesh.vertex_count() == 6);
  REQUIRE(mesh.face_count() == 8);
  double sum = 0, positive = 0;
  for (const double coordinate : mesh.positions) {
    sum += std::abs(coordinate);
    positive += coordinate > 32;
  }
  CHECK(std::abs(sum - 6 * 64) < tolerance);
  CHECK(positive == 3);
  std::vector<int> uses(6);
  for (const uint32_t index : mesh.faces) uses[index]++;
  CHECK(uses == std::vector<int>(6, 4));
}

} // namespace

TEST_CASE("DRC: files of other writers: float and integer, quantised, metadata, normals with seams") {
  check_octahedron(parse_drc(foreign<float>(draco::DT_FLOAT32, 0, false), "m.drc"), 1e-9);
  check_octahedron(parse_drc(foreign<float>(draco::DT_FLOAT32, 12, true), "m.drc"), 0.3);
  check_octahedron(parse_drc(foreign<int32_t>(draco::DT_INT32, 0, true), "m.drc"), 1e-9);
  CHECK(complaint(foreign<int16_t>(draco::DT_INT16, 0, false)) ==
        "m.drc: expected positions as float32 or int32, found Draco data type 3");
}

TEST_CASE("DRC: a faulty file is refused in one sentence") {
  const Mesh triangle = {{0, 0, 0, 1, 0, 0, 0, 1, -0.25}, {0, 1, 2}};
  const std::string good = format_drc(triangle, millimetres, "m.drc");
  const auto changed = [&](size_t at, char value) {
    std::string bytes = good;
    bytes[at] = value;
    return complaint(bytes);
  };
  CHECK(complaint(good).empty());
  CHECK(complaint("") == "m.drc: 0x0: expected a Draco file, which begins with DRACO");
  CHECK(changed(0, 'd') == "m.drc: 0x0: expected a Draco file, which begins with DRACO");
  CHECK(changed(6, 1) == "m.drc: 0x5: expected Draco bitstream 2.2, found 2.1: 'draco_decoder -i old.drc -o "
                         "new.ply' converts it ('draco_transcoder' in a glTF file)");
  CHECK(changed(6, 3) == "m.drc: 0x5: expected Draco bitstream 2.2, found 2.3");
  CHECK(changed(7, 0) == "m.drc: 0x7: expected a triangular mesh, found a point cloud");
  CHECK(changed(7, 2) == "m.drc: 0x7: expected a triangular mesh, found another geometry");
  CHECK(changed(8, 2) == "m.drc: 0x8: expected encoding method 0 or 1, found 2");
  CHECK(complaint(good.substr(0, 12)) == "m.drc: 0xc: the file ends within the Draco header");
  CHECK(complaint(std::string("DRACO\2\2\1\1\0\x80\0\xff\xff\xff\xff", 16)) ==
        "m.drc: 0x10: the file ends within the Draco header");
  const std::string head("DRACO\2\2\1\0\0\0", 11);
  CHECK(complaint(head + "\xff\xff\xff\x7f\3") == "m.drc: 268435455 faces, at most 8388608 are allowed");
  CHECK(complaint(head + "\1\xff\xff\xff\x7f") == "m.drc: 268435455 vertices, at most 4194304 are allowed");
  CHECK(complaint(head + "\xff\xff\x7f\3") ==
        "m.drc: 2097151 faces in so small a file, at most 15360 are allowed");
  const std::string cut = complaint(good.substr(0, good.size() - 5));
  CHECK(cut.substr(0, 36) == "m.drc: Draco cannot decode the file:");
  fvv_limits limits;
  fvv_limits_default(&limits);
  limits.max_payload = 20;
  CHECK(complaint(good, &limits) ==
        "m.drc: has " + std::to_string(good.size()) + " bytes, at most 20 are allowed");
}

TEST_CASE("DRC: a writer that would leave the lattice reports an error, and unusable meshes are refused") {
  const double nan = std::nan("");
  const Mesh far = {{0, 0, 0, 1, 0, 0, 0, 50000.001, 0}, {0, 1, 2}};
  CHECK(refusal(far, millimetres) ==
        "m.drc: vertex 2: y = 50000.001 as float32 falls onto another lattice point "
        "(step 0.001): write PLY or OBJ");
  CHECK(refusal(far, {{0, 0, 0}, 0.01}).empty());
  CHECK(refusal({{0, 0, 0, 1, 0, 0, 0, 1e39, 0}, {0, 1, 2}}, millimetres) ==
        "m.drc: vertex 2: y = 1e+39 as float32 falls onto another lattice point (step 0.001): write PLY or "
        "OBJ");
  CHECK(refusal({{0, 0, 0}, {}}, millimetres) == "m.drc: expected a mesh with faces");
  CHECK(refusal({{0, 0, nan}, {0, 0, 0}}, millimetres) == "m.drc: a coordinate of vertex 0 is not finite");
  CHECK(refusal({{0, 0, 0}, {0, 0, 1}}, millimetres) == "m.drc: face 0 has index 1 of 1 vertices");
  CHECK(refusal({{0, 0, 0, 0}, {0, 0, 0}}, millimetres) ==
        "m.drc: expected multiples of 3 and at most 2147483647 vertices, found 4 coordinates and 3 corners");
  CHECK(refusal({{0, 0, 0}, {0, 0, 0}}, {{0, 0, 0}, 0}) == "m.drc: expected a lattice step > 0");
  // Degenerate and repeated faces pass through as they are.
  const Mesh odd = {{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0}, {0, 1, 2, 0, 0, 1, 2, 1, 0, 0, 1, 2}};
  const Mesh again = parse_drc(format_drc(odd, millimetres, "m.drc"), "m.drc");
  CHECK(again.faces == odd.faces);
  CHECK(again.positions == odd.positions);
}

TEST_CASE("DRC: no prefix is taken for a whole file, no mutation does harm") {
  for (const std::string &bytes :
       {format_drc({{0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 1}, {0, 1, 2, 2, 1, 3}}, millimetres, "m.drc"),
        foreign<float>(draco::DT_FLOAT32, 11, true), foreign<int32_t>(draco::DT_INT32, 0, false)}) {
    for (size_t size = 0; size < bytes.size(); size++) {
      INFO(size);
      CHECK(complaint(bytes.substr(0, size)) != "");
    }
    std::mt19937 random(7);
    for (int round = 0; round < 500; round++) {
      std::string bad = bytes;
      for (uint32_t changes = 1 + random() % 3; changes; changes--)
        bad[random() % bad.size()] = static_cast<char>(random());
      const std::string what = complaint(bad);
      CHECK((what.empty() || what.compare(0, 7, "m.drc: ") == 0));
    }
  }
}

TEST_CASE("the extension decides how a mesh is read and written") {
  const auto folder =
      std::filesystem::temp_directory_path() / ("fvv_mesh_file_test_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const Mesh mesh = {{0, 0, 0, 1, 0, 0, 0, 1, -0.25}, {0, 1, 2}};
  for (const char *name : {"a.obj", "a.ply", "a.drc", "a.PLY"}) {
    const std::string path = (folder / name).string();
    write_mesh(mesh, millimetres, path);
    const Mesh again = read_mesh(path);
    CHECK(again.positions == mesh.positions);
    CHECK(again.faces == mesh.faces);
  }
  CHECK(read_file((folder / "a.drc").string(), 1000).substr(0, 5) == "DRACO");
  CHECK(read_file((folder / "a.PLY").string(), 1000).substr(0, 4) == "ply\n");
  const std::string unknown = (folder / "a.stl").string(), absent = (folder / "b.obj").string(),
                    odd = (folder / "a.obj").string();
  CHECK_THROWS_WITH(
      read_mesh(unknown),
      unknown +
          ": expected a mesh file with extension .obj, .ply, .drc, .draco, .glb or .gltf, found \".stl\"");
  CHECK_THROWS_WITH(write_mesh(mesh, millimetres, "mesh"),
                    "mesh: expected a mesh file with extension .obj, .ply or .drc, found no extension");
  CHECK_THROWS_WITH(read_mesh(absent), absent + ": cannot be opened: No such file or directory");
  CHECK_THROWS_WITH(read_file(folder.string(), 1), folder.string() + ": is a folder, expected a file");
  CHECK_THROWS_WITH(read_file(odd, 5), odd + ": has 36 bytes, at most 5 are allowed");
  CHECK_THROWS_WITH(write_mesh(mesh, millimetres, (folder / "no/a.obj").string()),
                    (folder / "no/a.obj").string() + ": cannot be created: No such file or directory");
  std::filesystem::remove_all(folder);
}
