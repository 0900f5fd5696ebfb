// The only file of libfvv that knows meshoptimizer. What is allowed to come in from a stream is
// fast_streams.c's business, what the result must look like is check.c's.
#include "mesh/fast.h"

#include <new>
#include <vector>

#include <meshoptimizer.h>

extern "C" {
#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/memory.h"
}

namespace {

// Which versions the library writes is a setting of the whole process. A static local is set before the first
// mesh is encoded, once, whatever the number of threads.
void choose_versions() {
  static const bool chosen = [] {
    meshopt_encodeVertexVersion(FVV_FAST_VERTEX_CODEC & 15);
    meshopt_encodeIndexVersion(FVV_FAST_INDEX_CODEC & 15);
    return true;
  }();
  (void)chosen;
}

// Vertices of the mesh as the codec takes them, at the place that remap gives each.
std::vector<uint8_t> interleaved(const fvv_mesh &mesh, size_t stride, const std::vector<unsigned> &remap) {
  std::vector<uint8_t> out(mesh.vertex_count * stride);
  for (size_t v = 0; v < mesh.vertex_count; v++) {
    uint8_t *vertex = out.data() + remap[v] * stride;
    for (size_t a = 0; a < 3; a++) fvv_put_u32(vertex + 4 * a, uint32_t(mesh.lattice[3 * v + a]));
    uint8_t *pair = vertex + FVV_FAST_POSITION;
    for (size_t a = 0; mesh.texture && a < 2; a++, pair += 4) fvv_put_u32(pair, mesh.texture[2 * v + a]);
    for (size_t a = 0; mesh.normals && a < 2; a++, pair += 4) fvv_put_u32(pair, mesh.normals[2 * v + a]);
  }
  return out;
}

fvv_status append(const std::vector<uint8_t> &stream, fvv_bytes *bytes) {
  return fvv_bytes_append(bytes, stream.data(), stream.size());
}

fvv_status encode(const fvv_mesh &mesh, fvv_bytes *bytes, fvv_diagnostic *diagnostic) {
  choose_versions();
  const size_t vertices = mesh.vertex_count, corners = 3 * size_t(mesh.face_count);
  const size_t stride = fvv_fast_stride(mesh.texture != nullptr, mesh.normals != nullptr);
  std::vector<unsigned> faces(corners), remap(vertices);
  // The order for strips: 2 to 7 % smaller on captured meshes than that for vertex caches.
  meshopt_optimizeVertexCacheStrip(faces.data(), mesh.faces, corners, vertices);
  meshopt_optimizeVertexFetchRemap(remap.data(), faces.data(), corners, vertices);
  meshopt_remapIndexBuffer(faces.data(), faces.data(), corners, remap.data());
  const std::vector<uint8_t> values = interleaved(mesh, stride, remap);
  std::vector<uint8_t> stream(meshopt_encodeVertexBufferBound(vertices, stride));
  stream.resize(meshopt_encodeVertexBuffer(stream.data(), stream.size(), values.data(), vertices, stride));
  std::vector<uint8_t> indices(meshopt_encodeIndexBufferBound(corners, vertices));
  indices.resize(meshopt_encodeIndexBuffer(indices.data(), indices.size(), faces.data(), corners));
  if (stream.empty() || stream[0] != FVV_FAST_VERTEX_CODEC || indices.empty() ||
      indices[0] != FVV_FAST_INDEX_CODEC)
    return fvv_fail(diagnostic, FVV_ERROR_BUG, 0, 0, 0,
                    "meshoptimizer does not write version 0 of its vertex codec and 1 of its index codec");
  if (stream.size() > UINT32_MAX)
    return fvv_fail(diagnostic, FVV_ERROR_INPUT, 0, 0, 0,
                    "%zu vertices take more bytes than a fast mesh can have", vertices);
  uint8_t size[FVV_FAST_HEADER_SIZE];
  fvv_put_u32(size, uint32_t(stream.size()));
  fvv_status status = fvv_bytes_append(bytes, size, sizeof size);
  if (status == FVV_OK) status = append(stream, bytes);
  if (status == FVV_OK) status = append(indices, bytes);
  return status;
}

} // namespace

fvv_status fvv_fast_encode(const fvv_mesh *mesh, fvv_bytes *bytes, fvv_diagnostic *diagnostic) {
  try {
    return encode(*mesh, bytes, diagnostic);
  } catch (const std::bad_alloc &) {
    return FVV_ERROR_MEMORY;
  } catch (...) {
    return fvv_fail(diagnostic, FVV_ERROR_BUG, 0, 0, 0, "the encoder of fast meshes threw an exception");
  }
}

int fvv_fast_decode_vertices(const uint8_t *data, size_t size, size_t stride, uint32_t count,
                             void *vertices) {
  return meshopt_decodeVertexBuffer(vertices, count, stride, data, size) == 0;
}

int fvv_fast_decode_faces(const uint8_t *data, size_t size, uint32_t count, uint32_t *faces) {
  return meshopt_decodeIndexBuffer(faces, 3 * size_t(count), sizeof *faces, data, size) == 0;
}
