#include "delta_shapes.h"

#include "fvv_catch.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

extern "C" {
#include "base/bytes.h"
}

std::unique_ptr<Mesh> key_of(const Shape &shape, double step) {
  const auto source = canonical(shape, step);
  auto key = std::make_unique<Mesh>();
  REQUIRE(decode(encoded(*source, FVV_MESH_DRACO, 7), key.get(), nullptr) == FVV_OK);
  return key;
}

std::vector<int32_t> moved(const fvv_mesh &key, int t, int tremble) {
  std::vector<int32_t> out;
  std::mt19937 random(unsigned(t) + 1);
  for (size_t v = 0; v < key.vertex_count; v++) {
    const int32_t *p = key.positions + 3 * v;
    const double angle = 0.02 * t + 0.0003 * t * p[1] / 10.0;
    const double x = std::cos(angle) * p[0] + std::sin(angle) * p[2] + 15.0 * t;
    const double z = std::cos(angle) * p[2] - std::sin(angle) * p[0];
    const double y = p[1] + 20 * std::sin(0.3 * t + p[0] / 200.0);
    for (const double c : {x, y, z})
      out.push_back(int32_t(std::lround(c)) + int32_t(random() % unsigned(2 * tremble + 1)) - tremble);
  }
  return out;
}

Sequence::Sequence(const fvv_mesh &key, const fvv_allocator *allocator) {
  fvv_diagnostic diagnostic = {};
  const fvv_status status = fvv_mesh_sequence_open(&key, allocator, &handle, &diagnostic);
  INFO(diagnostic.message);
  REQUIRE(status == FVV_OK);
}

std::vector<uint8_t> Sequence::encode(const std::vector<int32_t> &positions, uint32_t max_error) {
  fvv_mesh_delta_options options;
  fvv_mesh_delta_options_default(&options);
  options.max_error = max_error;
  Bytes payload;
  fvv_diagnostic diagnostic = {};
  const fvv_status status =
      fvv_mesh_sequence_encode(handle, positions.data(), &options, &payload, &diagnostic);
  INFO(diagnostic.message);
  REQUIRE(status == FVV_OK);
  return payload.copy();
}

fvv_status Sequence::decode(const std::vector<uint8_t> &payload, uint32_t levels,
                            fvv_diagnostic *diagnostic) {
  const std::unique_ptr<uint8_t[]> block(new uint8_t[payload.size()]);
  if (!payload.empty()) std::memcpy(block.get(), payload.data(), payload.size());
  return fvv_mesh_sequence_decode(handle, block.get(), payload.size(), levels, diagnostic);
}

std::vector<int32_t> Sequence::positions() const {
  const fvv_mesh *mesh = fvv_mesh_sequence_mesh(handle);
  return {mesh->positions, mesh->positions + 3 * size_t(mesh->vertex_count)};
}

int32_t distance(const std::vector<int32_t> &a, const std::vector<int32_t> &b) {
  int32_t most = 0;
  for (size_t i = 0; i < a.size(); i++) most = std::max(most, std::abs(a[i] - b[i]));
  return a.size() == b.size() ? most : INT32_MAX;
}

DeltaHeader header_of(const std::vector<uint8_t> &payload) {
  fvv_cursor cursor = {payload.data(), payload.size(), 16, 0};
  DeltaHeader out;
  out.number = fvv_cursor_uleb(&cursor);
  out.levels.resize(size_t(fvv_cursor_uleb(&cursor)));
  for (auto &level : out.levels)
    for (uint64_t &number : level) number = fvv_cursor_uleb(&cursor);
  REQUIRE(!cursor.failed);
  out.data = cursor.position;
  return out;
}

std::vector<uint8_t> with_header(const std::vector<uint8_t> &payload, const DeltaHeader &header) {
  std::vector<uint8_t> out = payload;
  out.resize(16);
  const auto put = [&](uint64_t number) {
    uint8_t bytes[10];
    const size_t size = fvv_put_uleb(bytes, number);
    for (size_t i = 0; i < size; i++) out.push_back(bytes[i]);
  };
  put(header.number);
  put(header.levels.size());
  for (const auto &level : header.levels)
    for (const uint64_t number : level) put(number);
  for (size_t i = header.data; i < payload.size(); i++) out.push_back(payload[i]);
  return out;
}
