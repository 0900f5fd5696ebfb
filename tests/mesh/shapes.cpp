#include "shapes.h"

#include "fvv_catch.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

extern "C" {
#include "base/bytes.h"
}

Shape tetrahedron(double size) {
  Shape s;
  s.point(0, 0, 0);
  s.point(size, 0, 0);
  s.point(0, size, 0);
  s.point(0, 0, size);
  s.face(0, 2, 1);
  s.face(0, 1, 3);
  s.face(0, 3, 2);
  s.face(1, 2, 3);
  return s;
}

Shape torus(uint32_t u, uint32_t v, double jitter) {
  Shape s;
  uint32_t state = 1;
  const auto noise = [&] { return jitter * ((state = state * 1664525 + 1013904223) / 4294967296.0 - 0.5); };
  const double turn = 2 * 3.14159265358979323846;
  for (uint32_t i = 0; i < u; i++)
    for (uint32_t j = 0; j < v; j++) {
      const double a = turn * (i + noise()) / u, b = turn * (j + noise()) / v;
      const double tube = 0.3 + 0.02 * std::sin(5 * a) * std::cos(3 * b), ring = 0.6 + tube * std::cos(b);
      s.point(ring * std::cos(a), ring * std::sin(a), tube * std::sin(b));
    }
  for (uint32_t i = 0; i < u; i++)
    for (uint32_t j = 0; j < v; j++) {
      const uint32_t i1 = (i + 1) % u, j1 = (j + 1) % v;
      s.face(i * v + j, i1 * v + j, i1 * v + j1);
      s.face(i * v + j, i1 * v + j1, i * v + j1);
    }
  return s;
}

Shape sphere(uint32_t u, uint32_t v) {
  Shape s;
  const double half = 3.14159265358979323846;
  s.point(0, 0, 1);
  for (uint32_t j = 1; j < v; j++)
    for (uint32_t i = 0; i < u; i++) {
      const double a = 2 * half * i / u, b = half * j / v;
      s.point(std::cos(a) * std::sin(b), std::sin(a) * std::sin(b), std::cos(b));
    }
  s.point(0, 0, -1);
  const uint32_t last = 1 + u * (v - 1);
  for (uint32_t i = 0; i < u; i++) {
    const uint32_t i1 = (i + 1) % u;
    s.face(0, 1 + i, 1 + i1);
    s.face(last, last - u + i1, last - u + i);
    for (uint32_t j = 0; j + 2 < v; j++) {
      const uint32_t a = 1 + j * u, b = a + u;
      s.face(a + i, b + i, b + i1);
      s.face(a + i, b + i1, a + i1);
    }
  }
  return s;
}

Shape grid(uint32_t n, double height) {
  Shape s;
  for (uint32_t i = 0; i < n; i++)
    for (uint32_t j = 0; j < n; j++)
      s.point(0.01 * i, 0.01 * j, height * std::sin(0.3 * i) * std::cos(0.2 * j));
  for (uint32_t i = 0; i + 1 < n; i++)
    for (uint32_t j = 0; j + 1 < n; j++) {
      const uint32_t a = i * n + j, b = a + n;
      s.face(a, b, b + 1);
      s.face(a, b + 1, a + 1);
    }
  return s;
}

static void append(Shape &s, const Shape &other, double shift) {
  const uint32_t first = uint32_t(s.positions.size() / 3);
  for (size_t i = 0; i < other.positions.size(); i++)
    s.positions.push_back(other.positions[i] + (i % 3 == 0 ? shift : 0));
  for (const uint32_t index : other.faces) s.faces.push_back(first + index);
}

Shape two_components() {
  Shape s = sphere(12, 8);
  append(s, torus(10, 8), 5);
  return s;
}

Shape ragged(uint32_t u, uint32_t v, uint32_t share) {
  Shape s = torus(u, v, 0.5);
  std::vector<uint32_t> kept;
  uint32_t state = 7;
  for (size_t f = 0; f < s.faces.size() / 3; f++) {
    state = state * 1664525 + 1013904223;
    if ((state >> 16) % share == 0) continue;
    for (size_t c = 0; c < 3; c++) kept.push_back(s.faces[3 * f + c]);
  }
  s.faces = kept;
  return s;
}

Shape holed_hubs(uint32_t faces) {
  Shape s = sphere(faces, 3);
  const uint32_t last = 1 + 2 * faces;
  std::vector<uint32_t> kept;
  for (size_t f = 0; f < s.faces.size() / 3; f++) {
    const uint32_t *face = &s.faces[3 * f];
    const bool at_hub = std::count(face, face + 3, 0u) || std::count(face, face + 3, last);
    if (at_hub || f % 5) kept.insert(kept.end(), face, face + 3);
  }
  s.faces = kept;
  return s;
}

Shape fin() {
  Shape s;
  s.point(0, 0, 0);
  s.point(0, 0, 1);
  s.point(1, 0, 0);
  s.point(0, 1, 0);
  s.point(-1, -1, 0);
  s.face(0, 1, 2);
  s.face(1, 0, 3);
  s.face(0, 1, 4);
  return s;
}

Shape bow_tie() {
  Shape s = tetrahedron();
  append(s, tetrahedron(-1), 0);
  // The reflected one is inside out, and its apex coincides with the first one's: welding joins them.
  for (size_t f = 4; f < 8; f++) std::swap(s.faces[3 * f + 1], s.faces[3 * f + 2]);
  return s;
}

Shape charts(uint32_t n) {
  Shape s;
  for (uint32_t chart = 0; chart < 6; chart++) {
    const size_t axis = chart / 2, side = chart % 2, first = (axis + (side ? 1 : 2)) % 3,
                 second = 3 - axis - first;
    const uint32_t base = uint32_t(s.positions.size() / 3);
    for (uint32_t i = 0; i <= n; i++)
      for (uint32_t j = 0; j <= n; j++) {
        double p[3] = {};
        p[axis] = double(side);
        p[first] = double(i) / n;
        p[second] = double(j) / n;
        s.point(p[0], p[1], p[2]);
        s.texture.push_back((chart + 0.05 + 0.9 * i / n) / 6);
        s.texture.push_back(double(j) / n);
      }
    for (uint32_t i = 0; i < n; i++)
      for (uint32_t j = 0; j < n; j++) {
        const uint32_t a = base + i * (n + 1) + j, b = a + n + 1;
        s.face(a, b, b + 1);
        s.face(a, b + 1, a + 1);
      }
  }
  return s;
}

Shape hard_cube(uint32_t n) {
  Shape shape = charts(n);
  shape.texture.clear();
  const size_t side = (n + 1) * (n + 1);
  shape.normals.resize(shape.positions.size());
  for (size_t f = 0; f < shape.faces.size(); f += 3) {
    const uint32_t *face = &shape.faces[f];
    REQUIRE(face[0] / side == face[2] / side);
    const double *a = &shape.positions[3 * face[0]], *b = &shape.positions[3 * face[1]],
                 *c = &shape.positions[3 * face[2]];
    for (size_t k = 0; k < 3; k++) {
      const size_t i = (k + 1) % 3, j = (k + 2) % 3;
      const double area = (b[i] - a[i]) * (c[j] - a[j]) - (b[j] - a[j]) * (c[i] - a[i]);
      for (size_t corner = 0; corner < 3; corner++) shape.normals[3 * face[corner] + k] = area;
    }
  }
  return shape;
}

std::unique_ptr<Mesh> canonical(const Shape &shape, double step, fvv_mesh_report *report,
                                uint32_t normal_bits) {
  fvv_mesh_options options;
  fvv_mesh_options_default(&options);
  options.lattice_step = step;
  options.normal_bits = normal_bits;
  const fvv_mesh_source source = shape.source();
  auto mesh = std::make_unique<Mesh>();
  fvv_diagnostic diagnostic = {};
  const fvv_status status =
      fvv_mesh_canonicalise(&source, &options, nullptr, mesh.get(), report, &diagnostic);
  INFO(diagnostic.message);
  REQUIRE(status == FVV_OK);
  return mesh;
}

uint8_t profile_of(int level) {
  return level < -1 ? FVV_MESH_FAST : level < 0 ? FVV_MESH_RAW : FVV_MESH_DRACO;
}

std::vector<uint8_t> encoded(const fvv_mesh &mesh, uint8_t profile, int level) {
  Bytes payload;
  fvv_diagnostic diagnostic = {};
  const fvv_status status = fvv_mesh_encode(&mesh, profile, level, nullptr, &payload, &diagnostic);
  INFO(diagnostic.message);
  REQUIRE(status == FVV_OK);
  return payload.copy();
}

fvv_status decode(const std::vector<uint8_t> &payload, fvv_mesh *mesh, fvv_diagnostic *diagnostic,
                  const fvv_allocator *allocator) {
  const std::unique_ptr<uint8_t[]> block(new uint8_t[payload.size()]);
  if (!payload.empty()) memcpy(block.get(), payload.data(), payload.size());
  return fvv_mesh_decode(block.get(), payload.size(), nullptr, allocator, mesh, diagnostic);
}

std::vector<Triangle> triangles(const fvv_mesh &mesh) {
  std::vector<Triangle> all;
  for (uint32_t f = 0; f < mesh.face_count; f++) {
    Triangle best = {};
    for (int first = 0; first < 3; first++) {
      Triangle t = {};
      for (uint32_t c = 0; c < 3; c++) {
        const size_t vertex = mesh.faces[3 * f + (uint32_t(first) + c) % 3];
        memcpy(&t[7 * c], mesh.lattice + 3 * vertex, 12);
        if (mesh.texture) memcpy(&t[7 * c + 3], mesh.texture + 2 * vertex, 8);
        if (mesh.normals) memcpy(&t[7 * c + 5], mesh.normals + 2 * vertex, 8);
      }
      if (first == 0 || t < best) best = t;
    }
    all.push_back(best);
  }
  std::sort(all.begin(), all.end());
  return all;
}

Shape sponge(uint32_t n, double filled, uint32_t seed) {
  std::vector<bool> cells(size_t(n) * n * n);
  for (size_t i = 0; i < cells.size(); i++) {
    seed = seed * 1664525 + 1013904223;
    cells[i] = (seed >> 8) < filled * (1 << 24);
  }
  const auto at = [&](const std::array<int, 3> &c) {
    for (const int x : c)
      if (x < 0 || x >= int(n)) return false;
    return bool(cells[(size_t(c[0]) * n + size_t(c[1])) * n + size_t(c[2])]);
  };
  Shape shape;
  const auto corner = [&](std::array<int, 3> c) {
    shape.point(0.01 * c[0], 0.01 * c[1], 0.01 * c[2]);
    return uint32_t(shape.positions.size() / 3 - 1);
  };
  for (int x = 0; x < int(n); x++)
    for (int y = 0; y < int(n); y++)
      for (int z = 0; z < int(n); z++)
        for (size_t axis = 0; axis < 3; axis++)
          for (const int side : {0, 1}) {
            const std::array<int, 3> here = {x, y, z};
            std::array<int, 3> beyond = here, a = here;
            beyond[axis] += side ? 1 : -1;
            if (!at(here) || at(beyond)) continue;
            // The quad on that side, counter-clockwise from outside; welding joins its corners to others'.
            a[axis] += side;
            std::array<int, 3> b = a, c = a, d = a;
            const size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
            b[side ? u : v]++;
            c[u]++;
            c[v]++;
            d[side ? v : u]++;
            const uint32_t i = corner(a), j = corner(b), k = corner(c), l = corner(d);
            shape.face(i, j, k);
            shape.face(i, k, l);
          }
  return shape;
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
    const int32_t *p = key.lattice + 3 * v;
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

std::vector<uint8_t> Sequence::encode(const std::vector<int32_t> &positions, const fvv_mesh_patch &patch,
                                      uint32_t max_error) {
  fvv_mesh_delta_options options;
  fvv_mesh_delta_options_default(&options);
  options.max_error = max_error;
  Bytes payload;
  fvv_diagnostic diagnostic = {};
  const fvv_status status =
      fvv_mesh_sequence_encode_patched(handle, positions.data(), &options, &patch, &payload, &diagnostic);
  INFO(diagnostic.message);
  REQUIRE(status == FVV_OK);
  return payload.copy();
}

fvv_status Sequence::decode(const std::vector<uint8_t> &payload, fvv_diagnostic *diagnostic) {
  const std::unique_ptr<uint8_t[]> block(new uint8_t[payload.size()]);
  if (!payload.empty()) std::memcpy(block.get(), payload.data(), payload.size());
  return fvv_mesh_sequence_decode(handle, block.get(), payload.size(), diagnostic);
}

std::vector<int32_t> Sequence::positions() const {
  const fvv_mesh *mesh = fvv_mesh_sequence_mesh(handle);
  return {mesh->lattice, mesh->lattice + 3 * size_t(mesh->vertex_count)};
}

CutOut cut_out(const fvv_mesh &key, const std::vector<int32_t> &positions, uint32_t first, uint32_t count) {
  CutOut out;
  out.texture_bits = key.texture_bits;
  out.normal_bits = key.normal_bits;
  out.absent.assign(key.face_count, 0);
  std::vector<uint32_t> number(key.vertex_count, UINT32_MAX);
  for (size_t i = 3 * size_t(first); i < 3 * (size_t(first) + count); i++) {
    const uint32_t v = key.faces[i];
    out.absent[i / 3] = 1;
    if (number[v] == UINT32_MAX) {
      number[v] = uint32_t(out.border.size());
      out.border.push_back(v);
      for (size_t a = 0; a < 3; a++) out.lattice.push_back(positions[3 * size_t(v) + a]);
      for (size_t a = 0; a < 2 && key.texture; a++) out.texture.push_back(key.texture[2 * size_t(v) + a]);
      for (size_t a = 0; a < 2 && key.normals; a++) out.normals.push_back(key.normals[2 * size_t(v) + a]);
    }
    out.faces.push_back(number[v]);
  }
  return out;
}

fvv_mesh CutOut::mesh() {
  fvv_mesh mesh = {};
  mesh.lattice = lattice.data();
  mesh.faces = faces.data();
  mesh.vertex_count = uint32_t(lattice.size() / 3);
  mesh.face_count = uint32_t(faces.size() / 3);
  mesh.texture = texture.empty() ? nullptr : texture.data();
  mesh.texture_bits = texture_bits;
  mesh.normals = normals.empty() ? nullptr : normals.data();
  mesh.normal_bits = normal_bits;
  return mesh;
}

fvv_mesh_patch CutOut::patch(const fvv_mesh &mesh, uint8_t profile) const {
  return {sizeof(fvv_mesh_patch), absent.data(), &mesh, border.data(), profile, 7, nullptr};
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
