// Codecs of others on the same meshes: Draco as its command line drives it, and meshoptimizer alone and after
// zstd. Each mesh is quantised over its own box, as these codecs are used without a lattice.
#include "fvvcodecs.h"

#include <algorithm>
#include <cmath>
#include <meshoptimizer.h>
#include <stdexcept>
#include <zstd.h>

namespace fvv::codecs {

namespace {

constexpr int draco_levels[] = {1, 7, 10};
constexpr int zstd_level = 19;

// Four 16-bit numbers a vertex, the last of them 0: meshoptimizer takes strides that are multiples of 4.
using Position = uint16_t[4];

struct Quantised {
  std::vector<uint16_t> positions; // of Position
  std::vector<uint32_t> faces;
  double step;
};

Quantised quantise(const Mesh &mesh, const PlainDraco &box, int bits) {
  Quantised out;
  out.step = box.extent / (std::pow(2.0, bits) - 1);
  out.positions.resize(4 * size_t(mesh.vertex_count()));
  for (size_t v = 0; v < mesh.vertex_count(); v++)
    for (size_t k = 0; k < 3; k++)
      out.positions[4 * v + k] = uint16_t(std::lround((mesh.positions[3 * v + k] - box.low[k]) / out.step));
  out.faces = mesh.faces;
  return out;
}

struct Streams {
  std::vector<unsigned char> vertices, faces;
  size_t size() const { return vertices.size() + faces.size(); }
};

// In the order of strips, which costs the fewest bytes for faces.
Streams encode(const Quantised &mesh) {
  const size_t vertex_count = mesh.positions.size() / 4;
  std::vector<uint32_t> faces(mesh.faces.size());
  meshopt_optimizeVertexCacheStrip(faces.data(), mesh.faces.data(), mesh.faces.size(), vertex_count);
  std::vector<uint16_t> vertices(mesh.positions.size());
  const size_t used = meshopt_optimizeVertexFetch(vertices.data(), faces.data(), faces.size(),
                                                  mesh.positions.data(), vertex_count, sizeof(Position));
  Streams out;
  out.vertices.resize(meshopt_encodeVertexBufferBound(used, sizeof(Position)));
  out.vertices.resize(meshopt_encodeVertexBuffer(out.vertices.data(), out.vertices.size(), vertices.data(),
                                                 used, sizeof(Position)));
  out.faces.resize(meshopt_encodeIndexBufferBound(faces.size(), used));
  out.faces.resize(meshopt_encodeIndexBuffer(out.faces.data(), out.faces.size(), faces.data(), faces.size()));
  if (out.vertices.empty() || out.faces.empty()) throw std::runtime_error("meshoptimizer encodes nothing");
  return out;
}

Quantised decode(const Streams &streams, size_t vertex_count, size_t index_count) {
  Quantised out;
  out.positions.resize(4 * vertex_count);
  out.faces.resize(index_count);
  if (meshopt_decodeVertexBuffer(out.positions.data(), vertex_count, sizeof(Position),
                                 streams.vertices.data(), streams.vertices.size()) ||
      meshopt_decodeIndexBuffer(out.faces.data(), index_count, sizeof(uint32_t), streams.faces.data(),
                                streams.faces.size()))
    throw std::runtime_error("meshoptimizer does not decode what it encoded");
  return out;
}

std::vector<unsigned char> compressed(const std::vector<unsigned char> &bytes) {
  std::vector<unsigned char> out(ZSTD_compressBound(bytes.size()));
  const size_t size = ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), zstd_level);
  if (ZSTD_isError(size)) throw std::runtime_error(ZSTD_getErrorName(size));
  out.resize(size);
  return out;
}

std::vector<unsigned char> expanded(const std::vector<unsigned char> &bytes, size_t to) {
  std::vector<unsigned char> out(to);
  const size_t size = ZSTD_decompress(out.data(), out.size(), bytes.data(), bytes.size());
  if (ZSTD_isError(size) || size != to) throw std::runtime_error("zstd does not decode what it encoded");
  return out;
}

Mesh in_metres(const Quantised &mesh, const PlainDraco &box, double step) {
  Mesh out;
  out.positions.resize(mesh.positions.size() / 4 * 3);
  for (size_t i = 0; i < out.positions.size(); i++)
    out.positions[i] = box.low[i % 3] + step * mesh.positions[i / 3 * 4 + i % 3];
  out.faces = mesh.faces;
  return out;
}

// The vertices that faces use, which is what optimizeVertexFetch keeps.
size_t used_vertices(const Mesh &mesh) {
  std::vector<char> used(mesh.vertex_count());
  for (const uint32_t v : mesh.faces) used[v] = 1;
  return size_t(std::count(used.begin(), used.end(), 1));
}

} // namespace

std::vector<Row> peer_rows(const std::vector<Mesh> &frames, int bits) {
  std::vector<Row> rows;
  const std::string precision = std::to_string(bits) + " bits";
  for (const int level : draco_levels)
    rows.emplace_back("libdraco", "level " + std::to_string(level) + ", " + precision, 0);
  rows.emplace_back("meshoptimizer", precision, 0);
  rows.emplace_back("meshoptimizer", precision + ", zstd " + std::to_string(zstd_level), 0);
  Row &plain = rows[std::size(draco_levels)], &packed = rows.back();
  for (const Mesh &source : frames) {
    const PlainDraco box(source);
    for (size_t i = 0; i < std::size(draco_levels); i++) {
      std::string bytes;
      const double encode_time = faster([&] { bytes = box.encode(source, bits, draco_levels[i]); });
      const double decode_time = faster([&] { PlainDraco::decode(bytes); });
      if (i == 0) rows[0].measure(source, scene::parse_drc(bytes, "libdraco"));
      rows[i].count(source, bytes.size(), encode_time, decode_time);
    }
    const Quantised mesh = quantise(source, box, bits);
    const size_t vertices = used_vertices(source);
    Streams streams;
    Quantised decoded;
    const double encode_time = faster([&] { streams = encode(mesh); });
    const double decode_time = faster([&] { decoded = decode(streams, vertices, source.faces.size()); });
    plain.measure(source, in_metres(decoded, box, mesh.step));
    plain.count(source, streams.size(), encode_time, decode_time);
    Streams small;
    const double pack_time = faster([&] {
      small = {compressed(streams.vertices), compressed(streams.faces)};
    });
    const double unpack_time = faster([&] {
      const Streams again = {expanded(small.vertices, streams.vertices.size()),
                             expanded(small.faces, streams.faces.size())};
      decoded = decode(again, vertices, source.faces.size());
    });
    packed.count(source, small.size(), encode_time + pack_time, unpack_time);
    for (Row &row : rows) row.step += mesh.step / double(frames.size());
  }
  for (size_t i = 1; i < std::size(draco_levels); i++) rows[i].take_errors(rows[0]);
  packed.take_errors(plain);
  return rows;
}

} // namespace fvv::codecs
