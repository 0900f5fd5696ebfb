// tools/capture: meshes from and to OBJ, PLY and Draco files.
#include "fvv_catch.h"

#include "fvv_scene/mesh_file.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

using namespace fvv::scene;

namespace {

using Parser = Mesh (*)(std::string_view, const std::string &, const fvv_limits *, MeshReport *, bool, bool,
                        MeshExtras *);

// The message of a reader for bytes; empty without an error. The bytes are in a heap block of exactly their
// size, so that a sanitizer detects a read beyond them.
std::string complaint(Parser parse, const std::string &bytes, const char *name,
                      const fvv_limits *limits = nullptr) {
  const std::vector<char> exact(bytes.begin(), bytes.end());
  try {
    const Mesh mesh =
        parse(std::string_view(exact.data(), exact.size()), name, limits, nullptr, false, true, nullptr);
    for (const uint32_t index : mesh.faces) REQUIRE(index < mesh.vertex_count());
    for (const double coordinate : mesh.positions) REQUIRE(std::isfinite(coordinate));
    REQUIRE(mesh.face_count() > 0);
    return "";
  } catch (const fvv::Error &error) {
    return error.what();
  }
}
std::string obj(const std::string &bytes) {
  return complaint(parse_obj, bytes, "m.obj");
}
std::string ply(const std::string &bytes) {
  return complaint(parse_ply, bytes, "m.ply");
}

void check_same(const Mesh &a, const Mesh &b) {
  CHECK(a.positions == b.positions);
  CHECK(a.faces == b.faces);
}

// A bumpy grid of n x n vertices, as many triangles as a captured person for n = 133.
Mesh grid(uint32_t n, double step) {
  Mesh mesh;
  for (uint32_t y = 0; y < n; y++)
    for (uint32_t x = 0; x < n; x++) {
      const uint32_t bump = (x * 7919 + y * 104729) % 500;
      for (const uint32_t index : {x * 10, y * 10, bump}) mesh.positions.push_back(step * index - 1.5);
    }
  for (uint32_t y = 0; y + 1 < n; y++)
    for (uint32_t x = 0; x + 1 < n; x++) {
      const uint32_t i = y * n + x;
      for (const uint32_t corner : {i, i + 1, i + n, i + 1, i + n + 1, i + n}) mesh.faces.push_back(corner);
    }
  return mesh;
}

const Mesh triangle = {{0, 0, 0, 1, 0, 0, 0, 1, -0.25}, {0, 1, 2}};

const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 -0.25\n";

// PLY headers, to which bodies are appended.
std::string header(const std::string &format, const std::string &elements) {
  return "ply\nformat " + format + " 1.0\n" + elements + "end_header\n";
}
const std::string plain = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
                          "element face 1\nproperty list uchar int vertex_indices\n";
std::string ascii(const std::string &body) {
  return header("ascii", plain) + body;
}

template <class Number> void put(std::string &out, Number value, bool big) {
  char bytes[sizeof value];
  memcpy(bytes, &value, sizeof value);
  const uint16_t one = 1;
  char first;
  memcpy(&first, &one, 1);
  if (big == (first == 1)) std::reverse(bytes, bytes + sizeof value);
  out.append(bytes, sizeof value);
}

// A triangle with everything that has to be skipped, in either byte order.
std::string binary(bool big) {
  std::string out = header(big ? "binary_big_endian" : "binary_little_endian",
                           "comment made by hand\nelement camera 1\nproperty list ushort double pose\n"
                           "element vertex 3\nproperty short z\nproperty uchar red\nproperty double x\n"
                           "property float32 y\nelement face 1\nproperty int8 label\n"
                           "property list int32 uint16 vertex_index\nproperty list uint8 float weights\n");
  put(out, uint16_t(2), big);
  put(out, 1.0, big);
  put(out, 2.0, big);
  for (int i = 0; i < 3; i++) {
    put(out, int16_t(-i), big);
    put(out, uint8_t(200), big);
    put(out, i == 1 ? 0.1 : 0.0, big);
    put(out, i == 2 ? 0.5f : 0.0f, big);
  }
  put(out, int8_t(-1), big);
  put(out, int32_t(3), big);
  for (const uint16_t index : {0, 1, 2}) put(out, index, big);
  put(out, uint8_t(1), big);
  put(out, 1.0f, big);
  return out;
}

void mutate(Parser parse, const std::string &bytes, const char *name, int rounds) {
  std::mt19937 random(20260101);
  int refused = 0;
  for (int round = 0; round < rounds; round++) {
    std::string bad = bytes;
    for (uint32_t changes = 1 + random() % 4; changes; changes--) {
      const size_t at = random() % bad.size();
      switch (random() % 4) {
      case 0:
        bad[at] = static_cast<char>(random());
        break;
      case 1:
        bad[at] = static_cast<char>(bad[at] ^ 1 << random() % 8);
        break;
      case 2:
        bad.erase(at, 1 + random() % 3);
        break;
      default:
        bad.insert(at, 1 + random() % 3, bad[random() % bad.size()]);
      }
      if (bad.empty()) bad = bytes;
    }
    const std::string what = complaint(parse, bad, name);
    if (!what.empty()) CHECK(what.compare(0, strlen(name) + 1, std::string(name) + ":") == 0);
    refused += !what.empty();
  }
  CHECK(refused > rounds / 4);
  CHECK(complaint(parse, bytes, name).empty());
}

} // namespace

TEST_CASE("OBJ: every way to write a triangle gives the same mesh") {
  for (const char *face :
       {"f 1 2 3", "f 1/1 2/2 3/3", "f 1//1 2//2 3//3", "f 1/1/1 2/2/2 3/3/3\n", "f -3 -2 -1",
        "f 1/-1 2/-1 3/-1", "\tf\t1  2\t3 \r\n", "f 1 \\\n2\\\r\n 3 # done", "f 1 2 3#x\\"}) {
    INFO(face);
    check_same(parse_obj("# made by hand\\\r\nmtllib a.mtl\n\no body\n" + vertices +
                             "vt 0 0\nvn 0 0 \\\n1\ng a b\ns off\nusemtl skin\n" + face,
                         "m.obj"),
               triangle);
  }
  check_same(parse_obj("f 1 2 3\nv 0 0 0 1\nv +1e0 0 0 .5 .5 .5\nv 0 1 -25e-2 1 0.1 0.2 0.3", "m.obj"),
             triangle);
}

TEST_CASE("OBJ: polygons become fans, lines and points are counted") {
  MeshReport report;
  const Mesh mesh =
      parse_obj(vertices + "v 2 2 2\nv 3 3 3\nf 1 2 3 4 5\nf 1 2 3\nl 1 2\np 1\n", "m.obj", nullptr, &report);
  CHECK(mesh.faces == std::vector<uint32_t>{0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 1, 2});
  CHECK(report.polygons == 1);
  CHECK(report.lines_and_points == 2);
}

TEST_CASE("OBJ: errors name the line, what was expected and what was found") {
  CHECK(obj("") == "m.obj: expected at least one face (f), found none");
  CHECK(obj(vertices) == "m.obj: expected at least one face (f), found none");
  CHECK(obj("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n") ==
        R"(m.obj:1: expected a finite number after v, found "nan")");
  CHECK(obj("v 0 0 -inf\nv 1 0 0\nv 0 1 0\nf 1 2 3\n") ==
        R"(m.obj:1: expected a finite number after v, found "-inf")");
  CHECK(obj("v 0 0 1e999\n") == R"(m.obj:1: expected a finite number after v, found "1e999")");
  CHECK(obj("\n\nv 0 0 1,5\n") == R"(m.obj:3: expected a finite number after v, found "1,5")");
  CHECK(obj("v 0 0 0x1\n") == R"(m.obj:1: expected a finite number after v, found "0x1")");
  CHECK(obj("v 0 0 +-1\n") == R"(m.obj:1: expected a finite number after v, found "+-1")");
  CHECK(obj("v 0 \\\n\\\n 0\n") == "m.obj:3: expected 3, 4, 6 or 7 numbers after v, found 2");
  CHECK(obj("v 0 0 0 0 0") == "m.obj:1: expected 3, 4, 6 or 7 numbers after v, found 5");
  CHECK(obj("v 0 0 0 0 0 0 0 0 0") == "m.obj:1: expected 3, 4, 6 or 7 numbers after v, found 9");
  CHECK(obj(vertices + "f\n") == "m.obj:4: expected at least 1 corner after f, found none");
  CHECK(obj(vertices + "f 1 9\n") == "m.obj:4: vertex 9 is used, the file has 3");
  CHECK(obj(vertices + "f 1 2 0\n") == R"(m.obj:4: expected indices that count from 1, found "0")");
  CHECK(obj(vertices + "f 1 2 0/1\n") == R"(m.obj:4: expected indices that count from 1, found "0/1")");
  CHECK(obj(vertices + "f 1 2/0 3/0/0\n").empty());
  CHECK(obj(vertices + "f 1 2 4\n") == "m.obj:4: vertex 4 is used, the file has 3");
  CHECK(obj("f 1 2 3\nf 4 5 6\nf 1 9 1\n" + vertices) == "m.obj:2: vertex 4 is used, the file has 3");
  CHECK(obj(vertices + "f 1 2 -4\n") == "m.obj:4: vertex -4 is used, 3 precede it");
  CHECK(obj(vertices + "f 1 2 5000000\n") == "m.obj:4: vertex 5000000 is used, at most 4194304 are allowed");
  for (const char *corner : {"x", "/", "//", "1/2/3/4", "1.5", "/1", "99999999999999999999", "1/x"})
    CHECK(obj(vertices + "f 1 2 " + corner + "\n") ==
          std::string("m.obj:4: expected v, v/vt, v//vn or v/vt/vn after f, found \"") + corner + "\"");
  CHECK(obj("vertex 1 2 3\n") == R"(m.obj:1: expected an OBJ keyword such as v or f, found "vertex")");
  CHECK(obj(std::string("\x89PNG\r\n\0\n", 8)) ==
        R"(m.obj:1: expected an OBJ keyword such as v or f, found "?PNG")");
  CHECK(obj(std::string(100, 'x')) ==
        "m.obj:1: expected an OBJ keyword such as v or f, found \"" + std::string(40, 'x') + "...\"");
  CHECK(
      obj(vertices + "call other.obj\n") ==
      R"(m.obj:4: expected polygons, found "call": free-form geometry and included files are not supported)");
  fvv_limits limits;
  fvv_limits_default(&limits);
  limits.max_vertices = 2;
  CHECK(complaint(parse_obj, vertices, "m.obj", &limits) == "m.obj:3: more than the allowed 2 vertices");
  limits.max_vertices = 3;
  limits.max_faces = 1;
  CHECK(complaint(parse_obj, vertices + "f 1 2 3\nf 1 2 3", "m.obj", &limits) ==
        "m.obj:5: more than the allowed 1 triangles");
}

TEST_CASE("PLY: ASCII and both byte orders, properties in any order, the rest skipped") {
  check_same(parse_ply(ascii("0 0 0\n1 0 0\r\n0 1 -.25\n3 0 1 2\n\n"), "m.ply"), triangle);
  std::string crlf = ascii("0 0 0\n1 0 0\n0 1 -.25\n3 0 1 2");
  for (size_t at = 0; (at = crlf.find('\n', at)) != crlf.npos; at += 2) crlf.insert(at, "\r");
  check_same(parse_ply(crlf, "m.ply"), triangle);
  const Mesh expected = {{0, 0, 0, 0.1, 0, -1, 0, 0.5, -2}, {0, 1, 2}};
  check_same(parse_ply(binary(false), "m.ply"), expected);
  check_same(parse_ply(binary(true), "m.ply"), expected);
  MeshReport report;
  const Mesh quad = parse_ply(
      header("ascii", "element face 1\nproperty list uchar uint vertex_indices\nelement vertex 4\n"
                      "property uchar x\nproperty int y\nproperty list int int tags\nproperty double z\n") +
          "4 0 1 2 3\n0 0 0 0\n1 0 2 7 7 0\n1 1 0 0\n0 -1 0 1e-3\n",
      "m.ply", nullptr, &report);
  check_same(quad, {{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, -1, 1e-3}, {0, 1, 2, 0, 2, 3}});
  CHECK(report.polygons == 1);
}

TEST_CASE("PLY: a faulty header is refused at its line") {
  const auto with = [](const std::string &elements) { return ply(header("ascii", elements)); };
  CHECK(ply("") == R"(m.ply:1: expected ply in the first line, found "")");
  CHECK(ply("plyx\n") == R"(m.ply:1: expected ply in the first line, found "plyx")");
  CHECK(ply("ply\nformat ascii 1.0\nend_header") == "m.ply:3: the file ends within the header");
  CHECK(ply("ply\ncomment\n") == "m.ply:3: the file ends within the header");
  CHECK(ply("ply\ncomment\nend_header\n") == R"(m.ply:3: expected format after ply, found "end_header")");
  CHECK(ply("ply\nformat\n") ==
        "m.ply:2: expected ascii, binary_little_endian or binary_big_endian, found the end of the line");
  CHECK(ply("ply\nformat binary 1.0\n") ==
        R"(m.ply:2: expected ascii, binary_little_endian or binary_big_endian, found "binary")");
  CHECK(ply("ply\nformat ascii 1.1\n") == R"(m.ply:2: expected version 1.0, found "1.1")");
  CHECK(ply("ply\nformat ascii 1.0 x\n") == R"(m.ply:2: expected the end of the line, found "x")");
  CHECK(with("elephant\n") ==
        R"(m.ply:3: expected element, property, comment or end_header, found "elephant")");
  CHECK(with("\n\nelephant\n") ==
        R"(m.ply:5: expected element, property, comment or end_header, found "elephant")");
  CHECK(with("element vertex -1\n") == R"(m.ply:3: expected the number of elements "vertex", found "-1")");
  CHECK(with("element a 0\nelement a 0\n") == R"(m.ply:4: element "a" is declared twice)");
  CHECK(with("property float x\n") == "m.ply:3: expected an element before its properties");
  CHECK(with("element a 1\nproperty half x\n") ==
        R"(m.ply:4: expected a type such as float or uchar, found "half")");
  CHECK(with("element a 1\nproperty list float int x\n") ==
        "m.ply:4: expected an integer type for the length of a list");
  CHECK(with("element a 1\nproperty int x\nproperty int x\n") ==
        R"(m.ply:5: property "x" is declared twice)");
  CHECK(with("element vertex 1\nproperty list int int x\n") ==
        "m.ply:4: expected a number for x, found a list");
  CHECK(with("element face 1\nproperty int vertex_index\n") ==
        "m.ply:4: expected a list of integers for vertex_index");
  CHECK(
      with(
          "element face 1\nproperty list uchar int vertex_index\nproperty list uchar int vertex_indices\n") ==
      "m.ply:5: expected one of vertex_indices and vertex_index, found both");
  CHECK(with("") == "m.ply: expected an element vertex, found none");
  CHECK(with("element vertex 0\n") == "m.ply:3: expected element vertex to have property x");
  CHECK(with("element vertex 0\nproperty int x\nelement face 0\n") ==
        "m.ply:3: expected element vertex to have property y");
  const std::string xyz = "property int x\nproperty int y\nproperty int z\n";
  const std::string corners = "property list uchar int vertex_index\n";
  CHECK(with("element vertex 0\n" + xyz + "element face 1\n") ==
        "m.ply:7: expected element face to have a list vertex_indices");
  CHECK(with("element vertex 0\n" + xyz + "element face 0\n" + corners) ==
        "m.ply:7: expected at least one face, found none");
  CHECK(with("element vertex 0\n" + xyz + "element face 1\n" + corners + "element tristrips 1\n") ==
        "m.ply:9: expected element tristrips to have a list vertex_indices");
  CHECK(with("element vertex 0\n" + xyz + "element face 1\n" + corners + "element b 1\n") ==
        R"(m.ply:7: 1 elements "face" do not fit into the 0 bytes after the header)");
  CHECK(with("element b 5\nelement vertex 0\n" + xyz + "element face 1\n" + corners) ==
        R"(m.ply:3: expected element "b" to have properties, found none)");
  CHECK(with("element vertex 4194305\n" + xyz + "element face 1\n" + corners) ==
        R"(m.ply:3: 4194305 elements "vertex", at most 4194304 are allowed)");
  CHECK(with("element b 9223372036854775807\n" + xyz + "element vertex 1\n" + xyz + "element face 1\n" +
             corners) ==
        R"(m.ply:3: 9223372036854775807 elements "b" do not fit into the 0 bytes after the header)");
}

TEST_CASE("PLY: a faulty body is refused at its line or byte") {
  const std::string good = "0 0 0\n1 0 0\n0 1 0\n";
  const auto face = [&](const std::string &text) { return ply(ascii(good + text)); };
  CHECK(ply(ascii("0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n")) ==
        "m.ply: face 0 uses vertex 1 (from 0), whose coordinates are not finite numbers");
  CHECK(ply(ascii("0 0 0\n1 0\n0 1 0\n3 0 1 2\n")) ==
        "m.ply:11: vertex 1: the line ends before z is complete");
  CHECK(ply(ascii("0 0 0\n1 0 0 5\n0 1 0\n3 0 1 2\n")) ==
        R"(m.ply:11: vertex 1: expected the end of the line, found "5")");
  CHECK(ply(ascii("0.000000 0 0\n1 0 0\n0 1 0")) == "m.ply:13: the file ends before face 0 of 1");
  CHECK(face("2 0 1\n") == "m.ply: expected at least one face, found lines and points alone");
  CHECK(face("3 0 1 3\n") == "m.ply:13: face 0: index 3 of 3 vertices");
  CHECK(face("3 0 1 -1\n") == "m.ply:13: face 0: index -1 of 3 vertices");
  CHECK(face("3 0 1 2.5\n") == R"(m.ply:13: face 0: expected an integer in vertex_indices, found "2.5")");
  CHECK(face("-3 0 1 2\n") == "m.ply:13: a list vertex_indices of -3 items does not fit into the file");
  CHECK(face("4 0 1 2\n") == "m.ply:13: a list vertex_indices of 4 items does not fit into the file");
  CHECK(face("3 0 1 2\n\n3 0 1 2\n") == R"(m.ply:15: expected the end of the file, found "3")");
  std::string bytes = header("binary_little_endian", plain);
  const size_t body = bytes.size();
  for (const float value : {0.f, 0.f, 0.f, 1.f, 0.f, std::nanf(""), 0.f, 1.f, 0.f}) put(bytes, value, false);
  const auto offset = [&](size_t at) {
    char text[32];
    snprintf(text, sizeof text, "m.ply: 0x%zx: ", body + at);
    return std::string(text);
  };
  bytes += std::string("\3\0\0\0\0\1\0\0\0\2\0\0\0", 13);
  const std::string not_finite =
      "m.ply: face 0 uses vertex 1 (from 0), whose coordinates are not finite numbers";
  CHECK(ply(bytes) == not_finite);
  bytes.replace(body + 20, 4, "\0\0\x80\xff", 4);
  CHECK(ply(bytes) == not_finite);
  bytes.replace(body + 20, 4, 4, '\0');
  CHECK(ply(bytes).empty());
  CHECK(ply(bytes + "\r\n").empty());
  CHECK(ply(bytes + "\nx") == offset(49) + "expected the end of the file, found 2 more bytes");
  CHECK(ply(bytes.substr(0, body + 48)) ==
        offset(37) + "a list vertex_indices of 3 items does not fit into the file");
  CHECK(ply(bytes.substr(0, body + 36)) ==
        R"(m.ply:7: 1 elements "face" do not fit into the 36 bytes after the header)");
  bytes[body + 45] = 9;
  CHECK(ply(bytes) == offset(49) + "face 0: index 9 of 3 vertices");
  fvv_limits limits;
  fvv_limits_default(&limits);
  limits.max_faces = 1;
  CHECK(complaint(parse_ply, ascii(good + "4 0 1 2 2\n"), "m.ply", &limits) ==
        "m.ply:13: face 0: more than the allowed 1 triangles");
}

TEST_CASE("no prefix and no mutation of a mesh file is taken for a whole one or does harm") {
  for (const bool big : {false, true}) {
    const std::string bytes = binary(big);
    for (size_t size = 0; size < bytes.size(); size++) {
      INFO(size);
      CHECK(ply(bytes.substr(0, size)) != "");
    }
    mutate(parse_ply, bytes, "m.ply", 3000);
  }
  const std::string text = ascii("0 0 0\n1 0 0\n0 1 -.25\n3 0 1 2");
  for (size_t size = 0; size < text.size(); size++) CHECK(ply(text.substr(0, size)) != "");
  mutate(parse_ply, text, "m.ply", 3000);
  const std::string faces = vertices + "vn 0 0 1\nf 1//1 \\\n2//1 -1//-1 # c\r\n";
  for (size_t size = 0; size < faces.size(); size++) {
    // Cut after "-1", "-1/" or "-1//" or within the comment, the text is a whole OBJ file.
    const size_t end = faces.find(" # c");
    const std::string what = obj(faces.substr(0, size));
    INFO(size);
    CHECK(what.empty() == (size >= end || (size >= end - strlen("//-1") && size <= end - strlen("-1"))));
  }
  mutate(parse_obj, faces, "m.obj", 3000);
}

TEST_CASE("meshes come back from OBJ and PLY bit for bit, from DRC on the same lattice points") {
  const Lattice lattice = {{-1.5, -1.5, -1.5}, 0.001};
  const Mesh mesh = grid(30, lattice.step);
  check_same(parse_obj(format_obj(mesh, "a"), "a"), mesh);
  check_same(parse_ply(format_ply(mesh, "a"), "a"), mesh);
  const Mesh drc = parse_drc(format_drc(mesh, lattice, "a"), "a");
  CHECK(drc.faces == mesh.faces);
  REQUIRE(drc.positions.size() == mesh.positions.size());
  for (size_t i = 0; i < mesh.positions.size(); i++)
    REQUIRE(std::round((drc.positions[i] + 1.5) / 0.001) == std::round((mesh.positions[i] + 1.5) / 0.001));
  const Mesh odd = {{-0.0, 0.1, 1e-300, 5e-324, 1.7976931348623157e308, 1. / 3, 1, 2, 3}, {2, 1, 0}};
  const Mesh again = parse_obj(format_obj(odd, "a"), "a");
  check_same(again, odd);
  CHECK(std::signbit(again.positions[0]));
  check_same(parse_ply(format_ply(odd, "a"), "a"), odd);
}
