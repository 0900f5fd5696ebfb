// tests/tools/gltf_fixture.h: glTF files built by hand: JSON as a document that tests may change, and the
// bytes of one buffer. Independent of the reader.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace gltf_fixture {

using nlohmann::json;

constexpr int int8 = 5120, uint8 = 5121, int16 = 5122, uint16 = 5123, uint32 = 5125, float32 = 5126;

struct File {
  json document = {{"asset", {{"version", "2.0"}}}, {"scenes", {{{"nodes", {0}}}}},
                   {"nodes", {{{"mesh", 0}}}},      {"meshes", json::array()},
                   {"accessors", json::array()},    {"bufferViews", json::array()}};
  std::string binary;

  void put(double value, int type) {
    const auto append = [&](auto number) {
      char bytes[sizeof number];
      memcpy(bytes, &number, sizeof number); // little-endian machines, as all that build this
      binary.append(bytes, sizeof number);
    };
    switch (type) {
    case int8:
      append(static_cast<int8_t>(value));
      break;
    case uint8:
      append(static_cast<uint8_t>(value));
      break;
    case int16:
      append(static_cast<int16_t>(value));
      break;
    case uint16:
      append(static_cast<uint16_t>(value));
      break;
    case uint32:
      append(static_cast<uint32_t>(value));
      break;
    default:
      append(static_cast<float>(value));
    }
  }
  static size_t width(const std::string &type) {
    return type == "SCALAR" ? 1 : type == "VEC2" ? 2 : type == "VEC3" ? 3 : type == "VEC4" ? 4 : 16;
  }
  static size_t size_of(int type) {
    return type == int8 || type == uint8 ? 1 : type == int16 || type == uint16 ? 2 : 4;
  }

  size_t view(size_t from, size_t stride = 0) {
    json entry = {{"buffer", 0}, {"byteOffset", from}, {"byteLength", binary.size() - from}};
    if (stride) entry["byteStride"] = stride;
    while (binary.size() % 4) binary += '\0';
    document["bufferViews"].push_back(entry);
    return document["bufferViews"].size() - 1;
  }
  // The index of an accessor that holds these numbers in a separate view. stride: bytes, 0 for none between.
  size_t add(const std::string &type, int component, const std::vector<double> &numbers,
             bool normalised = false, size_t stride = 0) {
    const size_t from = binary.size(), size = size_of(component) * width(type);
    for (size_t i = 0; i < numbers.size(); i++) {
      put(numbers[i], component);
      if (stride && (i + 1) % width(type) == 0) binary.append(stride - size, '\x7f');
    }
    json entry = {{"bufferView", view(from, stride)},
                  {"componentType", component},
                  {"type", type},
                  {"count", numbers.size() / width(type)}};
    if (normalised) entry["normalized"] = true;
    document["accessors"].push_back(entry);
    return document["accessors"].size() - 1;
  }
  // Adds a mesh of one primitive, and returns that primitive.
  json &mesh(size_t positions, int indices = -1) {
    json primitive = {{"attributes", {{"POSITION", positions}}}};
    if (indices >= 0) primitive["indices"] = indices;
    document["meshes"].push_back({{"primitives", {primitive}}});
    return document["meshes"].back()["primitives"][0];
  }
  // Adds a channel and its sampler to animation 0.
  void channel(size_t node, const char *path, size_t input, size_t output,
               const char *interpolation = "LINEAR") {
    json &animation = document["animations"][0];
    const size_t sampler = animation["samplers"].is_array() ? animation["samplers"].size() : 0;
    animation["samplers"].push_back({{"input", input}, {"output", output}, {"interpolation", interpolation}});
    animation["channels"].push_back({{"sampler", sampler}, {"target", {{"node", node}, {"path", path}}}});
  }

  static std::string u32(size_t value) {
    std::string out;
    for (unsigned shift = 0; shift < 32; shift += 8) out += static_cast<char>(value >> shift & 0xff);
    return out;
  }
  // uri empty: none, as for the chunk BIN.
  std::string text(const std::string &uri = "") const {
    json out = document;
    if (!out.contains("buffers") && !binary.empty()) {
      out["buffers"] = {{{"byteLength", binary.size()}}};
      if (!uri.empty()) out["buffers"][0]["uri"] = uri;
    }
    return out.dump();
  }
  std::string glb() const {
    std::string body = text();
    while (body.size() % 4) body += ' ';
    std::string out = u32(body.size()) + "JSON" + body;
    if (!binary.empty()) out += u32(binary.size()) + std::string("BIN\0", 4) + binary;
    return "glTF" + u32(2) + u32(out.size() + 12) + out;
  }
  std::string data_uri() const {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out = "data:application/octet-stream;base64,";
    for (size_t i = 0; i < binary.size(); i += 3) {
      unsigned bits = 0;
      for (size_t k = 0; k < 3; k++)
        bits = bits << 8 | (i + k < binary.size() ? static_cast<uint8_t>(binary[i + k]) : 0u);
      for (size_t k = 0; k < 4; k++) out += i + k <= binary.size() ? digits[bits >> (18 - 6 * k) & 63] : '=';
    }
    return out;
  }
};

// A triangle with corners (0 0 0), (1 0 0), (0 2 0) and indices.
inline File triangle() {
  File file;
  const size_t positions = file.add("VEC3", float32, {0, 0, 0, 1, 0, 0, 0, 2, 0});
  file.mesh(positions, static_cast<int>(file.add("SCALAR", uint16, {0, 1, 2})));
  return file;
}

// A square tube along y from 0 to 2, five rings of four corners. Joint 0 is at the origin and joint 1 at y =
// 1, below an armature that is moved by (5, 0, 0) and doubled. Joint 1 turns from 0 to 90 degrees about z in
// the first second. The node that carries the mesh is moved by 100, which a skin is to ignore.
inline double tube_share(double y) {
  return y / 2;
} // of joint 1
inline File tube() {
  File file;
  std::vector<double> positions, joints, weights, indices;
  for (int ring = 0; ring < 5; ring++)
    for (int corner = 0; corner < 4; corner++) {
      const double y = ring * 0.5;
      positions.insert(positions.end(),
                       {corner == 0 || corner == 3 ? 0.25 : -0.25, y, corner < 2 ? 0.25 : -0.25});
      // Joint 1 in both sets, to be added up; weights that add up to 2, to be scaled.
      joints.insert(joints.end(), {0, 1, 1, 0});
      weights.insert(weights.end(), {2 - 2 * tube_share(y), tube_share(y), tube_share(y), 0});
      if (ring == 4) continue;
      const int next = (corner + 1) % 4, base = ring * 4;
      for (const int index : {corner, corner + 4, next, next, corner + 4, next + 4})
        indices.push_back(base + index);
    }
  const size_t corners = file.add("VEC3", float32, positions, false, 20);
  json &primitive = file.mesh(corners, static_cast<int>(file.add("SCALAR", uint8, indices)));
  primitive["attributes"]["JOINTS_0"] = file.add("VEC4", uint8, joints);
  primitive["attributes"]["WEIGHTS_0"] = file.add("VEC4", float32, weights);
  const std::vector<double> bind = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0,  0, 1,
                                    1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1};
  file.document["skins"] = {{{"joints", {2, 3}}, {"inverseBindMatrices", file.add("MAT4", float32, bind)}}};
  file.document["nodes"] = {
      {{"mesh", 0}, {"skin", 0}, {"translation", {100, 100, 100}}},
      {{"children", {2}}, {"translation", {5, 0, 0}}, {"scale", {2, 2, 2}}},
      {{"children", {3}}},
      {{"translation", {0, 1, 0}}},
  };
  file.document["scenes"][0]["nodes"] = {0, 1};
  const size_t times = file.add("SCALAR", float32, {0, 1});
  // The second quaternion with its sign turned round: the same rotation, to be reached along the shorter arc.
  const double half = std::sqrt(0.5);
  file.channel(3, "rotation", times, file.add("VEC4", float32, {0, 0, 0, 1, 0, 0, -half, -half}));
  return file;
}

// Where a corner of the tube at (x, y, z) is when joint 1 is turned by angle.
inline void bend(double angle, const double *from, double *to) {
  const double share = tube_share(from[1]), x = from[0], y = from[1] - 1;
  const double turned[3] = {std::cos(angle) * x - std::sin(angle) * y,
                            std::sin(angle) * x + std::cos(angle) * y + 1, from[2]};
  for (int k = 0; k < 3; k++) to[k] = 2 * ((1 - share) * from[k] + share * turned[k]) + (k == 0 ? 5 : 0);
}

} // namespace gltf_fixture
