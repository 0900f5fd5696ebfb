#include "fast_plain.h"

#include <algorithm>

namespace {

void put_u32(std::vector<uint8_t> &out, uint32_t value) {
  for (int i = 0; i < 4; i++) out.push_back(uint8_t(value >> (8 * i)));
}

} // namespace

FastPlain::FastPlain(const fvv_mesh &mesh) {
  header = {4, uint8_t((mesh.texture ? 1 : 0) + (mesh.normals ? 2 : 0)), mesh.texture_bits, mesh.normal_bits};
  put_u32(header, mesh.vertex_count);
  put_u32(header, mesh.face_count);
  put_u32(header, 0);
  put_vertices(mesh);
  put_faces(mesh);
}

void FastPlain::put_vertices(const fvv_mesh &mesh) {
  const size_t stride = size_t(12) + (mesh.texture ? 8 : 0) + (mesh.normals ? 8 : 0);
  std::vector<uint8_t> elements;
  for (size_t v = 0; v < mesh.vertex_count; v++) {
    for (size_t a = 0; a < 3; a++) put_u32(elements, uint32_t(mesh.lattice[3 * v + a]));
    for (size_t a = 0; mesh.texture && a < 2; a++) put_u32(elements, mesh.texture[2 * v + a]);
    for (size_t a = 0; mesh.normals && a < 2; a++) put_u32(elements, mesh.normals[2 * v + a]);
  }
  const std::vector<uint8_t> base(elements.begin(), elements.begin() + ptrdiff_t(stride));
  for (size_t block = 0; block < mesh.vertex_count; block += 256) {
    const size_t count = std::min<size_t>(256, mesh.vertex_count - block), groups = (count + 15) / 16;
    for (size_t k = 0; k < stride; k++) {
      vertices.insert(vertices.end(), (groups + 3) / 4, 0xff);
      for (size_t i = 0; i < 16 * groups; i++) {
        const size_t v = block + i;
        const int before =
            v ? elements[std::min<size_t>(v - 1, mesh.vertex_count - 1) * stride + k] : base[k];
        const int now = i < count ? elements[v * stride + k] : before;
        const auto delta = int8_t(uint8_t(now - before));
        vertices.push_back(uint8_t(delta < 0 ? -2 * delta - 1 : 2 * delta));
      }
    }
  }
  vertices.insert(vertices.end(), 32 - stride, 0);
  vertices.insert(vertices.end(), base.begin(), base.end());
}

uint32_t FastPlain::difference(uint32_t last, uint32_t index) {
  const uint32_t d = index - last;
  return d << 1 ^ (d >> 31 ? 0xffffffff : 0);
}

void FastPlain::put_number(std::vector<uint8_t> &out, uint32_t value) {
  for (; value > 127; value >>= 7) out.push_back(uint8_t(value | 128));
  out.push_back(uint8_t(value));
}

void FastPlain::put_faces(const fvv_mesh &mesh) {
  uint32_t last = 0;
  for (size_t f = 0; f < mesh.face_count; f++) {
    codes.push_back(0xff);
    numbers.push_back(0xff);
    for (size_t c = 0; c < 3; c++) {
      put_number(numbers, difference(last, mesh.faces[3 * f + c]));
      last = mesh.faces[3 * f + c];
    }
  }
}

std::vector<uint8_t> FastPlain::payload() const {
  std::vector<uint8_t> out = header;
  put_u32(out, uint32_t(1 + vertices.size()));
  out.push_back(vertex_codec);
  out.insert(out.end(), vertices.begin(), vertices.end());
  out.push_back(index_codec);
  for (const auto *part : {&codes, &numbers, &table}) out.insert(out.end(), part->begin(), part->end());
  return out;
}
