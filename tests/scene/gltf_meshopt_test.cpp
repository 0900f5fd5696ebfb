// tools/capture: glTF whose bufferViews are compressed by meshoptimizer gives what the same file gives
// without.
#include "fvv_catch.h"

#include "gltf_fixture.h"
#include "scene/src/gltf/pose.h"

#include <algorithm>
#include <functional>
#include <meshoptimizer.h>

extern "C" {
#include "base/memory.h"
}

using namespace fvv::scene;
using namespace gltf_fixture;

namespace {

using Bytes = std::vector<unsigned char>;

// In a block of exactly that size, so that a sanitizer sees every byte too many.
Mesh posed(const File &file, double time) {
  const std::string glb = file.glb();
  const std::vector<char> exact(glb.begin(), glb.end());
  return gltf::pose(gltf::read_scene(std::string_view(exact.data(), exact.size()), "m.glb",
                                     gltf::OnlyAnimation{}, fvv_limits_or_default(nullptr)),
                    time);
}

std::string fault(const std::function<void(File &)> &change, File file) {
  change(file);
  try {
    posed(file, 0);
    return "";
  } catch (const fvv::Error &error) {
    return std::string(error.what()).substr(7);
  }
}

// The bytes of a view of the fixture, without the gaps of its stride between elements of that size.
std::vector<unsigned char> packed(const File &file, const json &view, size_t count, size_t size) {
  const size_t stride = view.value("byteStride", size), from = view["byteOffset"];
  Bytes out;
  for (size_t i = 0; i < count; i++)
    out.insert(out.end(), file.binary.begin() + ptrdiff_t(from + i * stride),
               file.binary.begin() + ptrdiff_t(from + i * stride + size));
  return out;
}

Bytes encode(const std::string &mode, const Bytes &bytes, size_t count, size_t stride) {
  if (mode == "ATTRIBUTES") {
    meshopt_encodeVertexVersion(0);
    Bytes out(meshopt_encodeVertexBufferBound(count, stride));
    out.resize(meshopt_encodeVertexBuffer(out.data(), out.size(), bytes.data(), count, stride));
    return out;
  }
  std::vector<unsigned> indices(count);
  for (size_t i = 0; i < count; i++)
    for (size_t k = 0; k < stride; k++) indices[i] |= unsigned(bytes[stride * i + k]) << (8 * k);
  meshopt_encodeIndexVersion(1);
  const bool triangles = mode == "TRIANGLES";
  Bytes out(triangles ? meshopt_encodeIndexBufferBound(count, 1 << 16)
                      : meshopt_encodeIndexSequenceBound(count, 1 << 16));
  out.resize(triangles ? meshopt_encodeIndexBuffer(out.data(), out.size(), indices.data(), count)
                       : meshopt_encodeIndexSequence(out.data(), out.size(), indices.data(), count));
  return out;
}

// Compresses the view with such elements; the bytes there become noise, as a fallback that is not used.
json &compress(File &file, size_t index, const char *mode, size_t count, size_t stride,
               const char *name = "EXT_meshopt_compression") {
  json &view = file.document["bufferViews"][index];
  const Bytes coded = encode(mode, packed(file, view, count, stride), count, stride);
  std::fill_n(file.binary.begin() + ptrdiff_t(view["byteOffset"].get<size_t>()),
              view["byteLength"].get<size_t>(), '\x55');
  view["byteLength"] = count * stride;
  if (view.contains("byteStride")) view["byteStride"] = stride;
  view["extensions"][name] = {{"buffer", 0},
                              {"byteOffset", file.binary.size()},
                              {"byteLength", coded.size()},
                              {"byteStride", stride},
                              {"count", count},
                              {"mode", mode}};
  file.binary.append(coded.begin(), coded.end());
  while (file.binary.size() % 4) file.binary += '\0';
  return view["extensions"][name];
}

// The tube with indices of 16 bits, everything in it but matrices and times compressed.
File small_tube(bool compressed, const char *indices, const char *name) {
  File file = tube();
  const size_t accessor = file.document["meshes"][0]["primitives"][0]["indices"];
  std::vector<double> corners;
  const size_t from = file.document["bufferViews"][accessor]["byteOffset"];
  const size_t count = file.document["accessors"][accessor]["count"];
  for (size_t i = 0; i < count; i++) corners.push_back(uint8_t(file.binary[from + i]));
  const size_t wide = file.add("SCALAR", uint16, corners);
  file.document["meshes"][0]["primitives"][0]["indices"] = wide;
  if (!compressed) return file;
  file.document["extensionsRequired"] = {name};
  compress(file, 0, "ATTRIBUTES", 20, 12, name); // positions
  compress(file, wide, indices, count, 2, name);
  compress(file, 2, "ATTRIBUTES", 20, 4, name);  // joints
  compress(file, 3, "ATTRIBUTES", 20, 16, name); // weights
  return file;
}

// Of the file with one view of that accessor replaced by filtered floats.
std::vector<double> filtered(const char *filter, const std::vector<double> &given, unsigned components) {
  File file = triangle();
  const size_t count = given.size() / components;
  std::vector<float> values(given.begin(), given.end());
  Bytes bytes(4 * given.size());
  meshopt_encodeFilterExp(bytes.data(), count, 4 * components, 24, values.data());
  file.document["bufferViews"][0]["byteOffset"] = file.binary.size();
  file.binary.append(bytes.begin(), bytes.end());
  compress(file, 0, "ATTRIBUTES", count, 4 * components)["filter"] = filter;
  return parse_gltf(file.glb(), "m.glb", nullptr).positions;
}

} // namespace

TEST_CASE("glTF: compressed views give what the same file gives without") {
  for (const char *indices : {"TRIANGLES", "INDICES"})
    for (const char *name : {"EXT_meshopt_compression", "KHR_meshopt_compression"})
      for (const double time : {0.0, 0.4}) {
        const Mesh wanted = posed(small_tube(false, indices, name), time);
        const Mesh found = posed(small_tube(true, indices, name), time);
        CHECK(found.positions == wanted.positions);
        REQUIRE(found.faces.size() == wanted.faces.size());
        // Triangles may be turned, but not over.
        for (size_t f = 0; f < wanted.faces.size(); f += 3) {
          std::vector<uint32_t> a(wanted.faces.begin() + ptrdiff_t(f),
                                  wanted.faces.begin() + ptrdiff_t(f + 3));
          std::vector<uint32_t> b(found.faces.begin() + ptrdiff_t(f), found.faces.begin() + ptrdiff_t(f + 3));
          std::rotate(a.begin(), std::min_element(a.begin(), a.end()), a.end());
          std::rotate(b.begin(), std::min_element(b.begin(), b.end()), b.end());
          CHECK(a == b);
        }
      }
}

TEST_CASE("glTF: the exponential filter is exact for floats of 24 bits") {
  const std::vector<double> corners = {0, 0, 0, 1.5, 0, 0, 0, -2.25, 1024};
  CHECK(filtered("EXPONENTIAL", corners, 3) == corners);
}

TEST_CASE("glTF: the quaternion filter turns a joint as far as numbers of 16 bits say") {
  File plain = tube(), file = tube();
  const size_t accessor = file.document["animations"][0]["samplers"][0]["output"];
  const float turns[8] = {0, 0, 0, 1, 0, 0, float(std::sin(0.6)), float(std::cos(0.6))};
  plain.document["animations"][0]["samplers"][0]["output"] =
      plain.add("VEC4", float32, std::vector<double>(turns, turns + 8));
  Bytes bytes(16);
  meshopt_encodeFilterQuat(bytes.data(), 2, 8, 16, turns);
  json &view = file.document["bufferViews"][accessor];
  view["byteOffset"] = file.binary.size();
  view["byteLength"] = 16;
  file.binary.append(bytes.begin(), bytes.end());
  file.document["accessors"][accessor]["componentType"] = int16;
  file.document["accessors"][accessor]["normalized"] = true;
  compress(file, accessor, "ATTRIBUTES", 2, 8)["filter"] = "QUATERNION";
  const Mesh wanted = posed(plain, 0.7), found = posed(file, 0.7);
  REQUIRE(found.positions.size() == wanted.positions.size());
  double worst = 0;
  for (size_t i = 0; i < wanted.positions.size(); i++)
    worst = std::max(worst, std::fabs(wanted.positions[i] - found.positions[i]));
  CHECK(worst < 5e-4);
  CHECK(worst > 0);
}

TEST_CASE("glTF: a faulty compressed view is refused at its place") {
  const File good = small_tube(true, "TRIANGLES", "EXT_meshopt_compression");
  const size_t last = good.document["bufferViews"].size() - 1;
  const std::string at = "/bufferViews/0/extensions/EXT_meshopt_compression";
  const auto changed = [&](const std::string &key, const json &value, size_t view = 0) {
    return fault(
        [&](File &file) {
          file.document["bufferViews"][view]["extensions"]["EXT_meshopt_compression"][key] = value;
        },
        good);
  };
  REQUIRE(fault([](File &) {}, good).empty());
  CHECK(changed("mode", "POINTS") ==
        at + "/mode: expected ATTRIBUTES, TRIANGLES or INDICES, found \"POINTS\"");
  CHECK(changed("filter", "COLOR") ==
        at + "/filter: expected NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL, found \"COLOR\"");
  CHECK(changed("filter", "OCTAHEDRAL") == at + "/byteStride: expected 4 or 8 for OCTAHEDRAL, found 12");
  CHECK(changed("filter", "QUATERNION") == at + "/byteStride: expected 8 for QUATERNION, found 12");
  CHECK(changed("byteStride", 10) == at + "/byteStride: expected a multiple of 4, found 10");
  CHECK(changed("byteStride", 260).substr(0, at.size()) == at);
  CHECK(changed("mode", "INDICES") == at + "/byteStride: expected 2 or 4 bytes an index, found 12");
  CHECK(changed("count", 21) ==
        "/bufferViews/0/byteLength: expected the 252 bytes that are compressed, found 240");
  CHECK(changed("byteLength", 44) == at + ": expected at least 45 bytes for 20 elements, found 44");
  CHECK(changed("byteLength", 1000000).find("in a buffer of") != std::string::npos);
  CHECK(changed("byteOffset", 0).find("expected ATTRIBUTES that meshoptimizer decodes, found ") !=
        std::string::npos);
  CHECK(changed("count", 97, last).find("expected a multiple of 3") != std::string::npos);
  CHECK(changed("filter", "EXPONENTIAL", last).find("expected NONE for indices") != std::string::npos);
  CHECK(fault(
            [](File &file) {
              file.document["bufferViews"][0]["extensions"]["KHR_meshopt_compression"] = json::object();
            },
            good) == "/bufferViews/0: expected one of EXT_ and KHR_meshopt_compression, found both");
  // A count that the bytes cannot hold allocates nothing.
  CHECK(fault(
            [](File &file) {
              json &view = file.document["bufferViews"][0];
              view["byteLength"] = uint64_t(12) * 80000000u;
              view["extensions"]["EXT_meshopt_compression"]["count"] = 80000000u;
            },
            good)
            .find("expected at least 15000033 bytes") != std::string::npos);
}

TEST_CASE("glTF: damaged compressed views do no harm") {
  const File good = small_tube(true, "TRIANGLES", "EXT_meshopt_compression");
  const size_t from = tube().binary.size();
  int refused = 0;
  for (size_t i = from; i < good.binary.size(); i++)
    for (const int flip : {1, 0x10, 0x80, 0xff}) {
      const std::string what = fault([&](File &file) { file.binary[i] = char(file.binary[i] ^ flip); }, good);
      refused += !what.empty();
    }
  CHECK(refused > 100);
}
