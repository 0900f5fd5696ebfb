// Key meshes of one profile each: the guard before Draco with Draco itself, meshoptimizer's codec, and plain
// integers. What decodes is valid, and encoding it again gives the same mesh.
#include "meshes.h"

namespace {

void decode(const uint8_t *data, size_t size, uint8_t profile) {
  if (!size) return;
  fuzz::Bytes payload(data, data + size);
  payload[0] = profile;
  fvv_mesh_header header;
  const fvv_status peeked = fvv_mesh_peek(payload.data(), payload.size(), nullptr, &header, nullptr);
  fuzz::expect_status(peeked);
  const fuzz::Mesh decoded(payload);
  if (!decoded.there) return;
  fuzz::expect(peeked == FVV_OK && header.vertex_count == decoded.mesh.vertex_count &&
                   header.face_count == decoded.mesh.face_count,
               "a mesh has what its header declares");
  fuzz::expect_valid(decoded.mesh);
  std::vector<float> normals(3 * size_t(decoded.mesh.vertex_count));
  fuzz::expect(fvv_mesh_normals(&decoded.mesh, nullptr, normals.data(), nullptr) == FVV_OK,
               "a decoded mesh has normals");
  fuzz::Payload raw;
  fuzz::expect(fvv_mesh_encode(&decoded.mesh, FVV_MESH_RAW, 0, nullptr, &raw.bytes, nullptr) == FVV_OK,
               "a decoded mesh can be encoded");
  const fuzz::Mesh again(fuzz::Bytes(raw.bytes.data, raw.bytes.data + raw.bytes.size));
  fuzz::expect(again.there && fuzz::equal(again.mesh, decoded.mesh), "raw meshes come back as they were");
}

} // namespace

FVV_FUZZ_TARGET(draco, fuzz::Form::bytes) {
  decode(data, size, FVV_MESH_DRACO);
}

FVV_FUZZ_TARGET(fast, fuzz::Form::bytes) {
  decode(data, size, FVV_MESH_FAST);
}

FVV_FUZZ_TARGET(raw, fuzz::Form::bytes) {
  decode(data, size, FVV_MESH_RAW);
}
