// The only file that knows Draco. Plain arrays come in and go out; what is allowed to come in from a stream
// is draco_check.c's business, what the result must look like is payload.c's.
#include "mesh/draco_bridge.h"

#include <algorithm>
#include <cstring>
#include <new>

#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

#include "base/diagnostic.h"
#include "base/layout.h"
#include "base/memory.h"
#include "fvv/format.h"

namespace {

// Draco's encoder holds a histogram with an entry for each value that a prediction error could have, so that
// far-apart positions would cost gigabytes. From this extent on, 1 km at 1 mm, errors are stored as they are.
constexpr int64_t wide_extent = int64_t(1) << 20;

fvv_status out_of_memory(fvv_diagnostic *diagnostic) {
  return fvv_fail(diagnostic, FVV_ERROR_MEMORY, 0, 0, 0, "no memory for Draco");
}

fvv_status broken(fvv_diagnostic *diagnostic, uint32_t issue, const char *text) {
  return fvv_fail(diagnostic, FVV_ERROR_INVALID, issue, FVV_CHUNK_MESH, FVV_MESH_SIZE, "%s", text);
}

bool is_wide(const fvv_mesh &mesh) {
  int32_t low = mesh.lattice[0], high = low;
  for (size_t i = 0; i < 3 * size_t(mesh.vertex_count); i++) {
    low = std::min(low, mesh.lattice[i]);
    high = std::max(high, mesh.lattice[i]);
  }
  return int64_t(high) - low >= wide_extent;
}

// values: vertices x components.
void add_attribute(draco::GeometryAttribute::Type type, int8_t components, const void *values,
                   uint32_t vertices, draco::Mesh *out) {
  draco::GeometryAttribute attribute;
  const int64_t stride = components * int64_t(sizeof(int32_t));
  attribute.Init(type, nullptr, components, draco::DT_INT32, false, stride, 0);
  const int id = out->AddAttribute(attribute, true, vertices);
  out->attribute(id)->buffer()->Write(0, values, size_t(vertices) * size_t(stride));
}

// The vertices are split at seams already, so that one connectivity serves all attributes. Left to itself
// Draco predicts texture coordinates and normals from positions with arithmetic that clause 8.4 does not
// admit; these are the levels at which it takes the same methods for positions. For normals its encoder
// offers no other but the difference.
draco::Status choose_pair_coding(const fvv_mesh &mesh, int level, draco::ExpertEncoder *encoder) {
  encoder->options().SetGlobalBool("split_mesh_on_seams", true);
  draco::Status status;
  if (mesh.texture)
    status = encoder->SetAttributePredictionScheme(
        1, level > 8   ? draco::MESH_PREDICTION_CONSTRAINED_MULTI_PARALLELOGRAM
           : level > 2 ? draco::MESH_PREDICTION_PARALLELOGRAM
                       : draco::PREDICTION_DIFFERENCE);
  if (mesh.normals && status.ok())
    status = encoder->SetAttributePredictionScheme(mesh.texture ? 2 : 1, draco::PREDICTION_DIFFERENCE);
  return status;
}

// One attribute value a vertex, in the given order: vertices at one place stay apart, so that the faces alone
// say what is connected.
void fill(const fvv_mesh &mesh, draco::Mesh *out) {
  out->SetNumFaces(mesh.face_count);
  for (uint32_t f = 0; f < mesh.face_count; f++) {
    draco::Mesh::Face face;
    for (int c = 0; c < 3; c++) face[c] = mesh.faces[3 * size_t(f) + c];
    out->SetFace(draco::FaceIndex(f), face);
  }
  out->set_num_points(mesh.vertex_count);
  add_attribute(draco::GeometryAttribute::POSITION, 3, mesh.lattice, mesh.vertex_count, out);
  if (mesh.texture)
    add_attribute(draco::GeometryAttribute::TEX_COORD, 2, mesh.texture, mesh.vertex_count, out);
  if (mesh.normals) add_attribute(draco::GeometryAttribute::NORMAL, 2, mesh.normals, mesh.vertex_count, out);
}

fvv_status encode(const fvv_mesh &mesh, int level, fvv_draco_coding coding, fvv_bytes *bytes,
                  fvv_diagnostic *diagnostic) {
  draco::Mesh source;
  fill(mesh, &source);
  draco::ExpertEncoder encoder(source);
  encoder.SetSpeedOptions(10 - level, 10 - level);
  encoder.SetEncodingMethod(coding == FVV_DRACO_SEQUENTIAL ? draco::MESH_SEQUENTIAL_ENCODING
                                                           : draco::MESH_EDGEBREAKER_ENCODING);
  // SetEncodingSubmethod sets an option that the encoder of Draco 1.5 does not read.
  if (coding == FVV_DRACO_STANDARD)
    encoder.options().SetGlobalInt("edgebreaker_method", draco::MESH_EDGEBREAKER_STANDARD_ENCODING);
  draco::Status accepted;
  if (mesh.texture || mesh.normals) accepted = choose_pair_coding(mesh, level, &encoder);
  if (is_wide(mesh)) {
    encoder.SetUseBuiltInAttributeCompression(false);
    if (accepted.ok())
      accepted = encoder.SetAttributePredictionScheme(0, draco::MESH_PREDICTION_PARALLELOGRAM);
  }
  if (!accepted.ok())
    return fvv_fail(diagnostic, FVV_ERROR_BUG, 0, 0, 0, "Draco refuses its option: %s", accepted.error_msg());
  draco::EncoderBuffer buffer;
  const draco::Status status = encoder.EncodeToBuffer(&buffer);
  if (!status.ok())
    return fvv_fail(diagnostic, FVV_ERROR_BUG, 0, 0, 0, "Draco does not encode the mesh: %s",
                    status.error_msg());
  return fvv_bytes_append(bytes, buffer.data(), buffer.size()) == FVV_OK ? FVV_OK : out_of_memory(diagnostic);
}

// Values lie in coding order; the mapping says which vertex has which. values: vertices x components. Not
// part of a larger function, which engines of wasm would compile again for this loop.
template <int components, typename T>
__attribute__((noinline)) fvv_status copy_attribute(const draco::Mesh &decoded,
                                                    draco::GeometryAttribute::Type type, uint32_t vertices,
                                                    T *values, fvv_diagnostic *diagnostic) {
  constexpr size_t size = components * sizeof(T);
  const draco::PointAttribute *attribute = decoded.GetNamedAttribute(type);
  if (!attribute || attribute->data_type() != draco::DT_INT32 || attribute->num_components() != components ||
      attribute->byte_stride() != int64_t(size))
    return broken(diagnostic, FVV_ISSUE_DRACO_ATTRIBUTE, "Draco yields other attributes than were declared");
  const uint8_t *const coded = attribute->GetAddress(draco::AttributeValueIndex(0));
  const size_t count = attribute->size();
  for (uint32_t v = 0; v < vertices; v++) {
    const size_t value = attribute->mapped_index(draco::PointIndex(v)).value();
    if (value >= count)
      return broken(diagnostic, FVV_ISSUE_DRACO_STREAM, "a vertex of the Draco bitstream lacks an attribute");
    std::memcpy(values + components * size_t(v), coded + size * value, size);
  }
  return FVV_OK;
}

fvv_status copy_attributes(const draco::Mesh &decoded, fvv_mesh *mesh, fvv_diagnostic *diagnostic) {
  if (decoded.num_attributes() != 1 + (mesh->texture ? 1 : 0) + (mesh->normals ? 1 : 0))
    return broken(diagnostic, FVV_ISSUE_DRACO_ATTRIBUTE, "Draco yields other attributes than were declared");
  const uint32_t count = mesh->vertex_count;
  fvv_status status =
      copy_attribute<3>(decoded, draco::GeometryAttribute::POSITION, count, mesh->lattice, diagnostic);
  if (status == FVV_OK && mesh->texture)
    status =
        copy_attribute<2>(decoded, draco::GeometryAttribute::TEX_COORD, count, mesh->texture, diagnostic);
  if (status == FVV_OK && mesh->normals)
    status = copy_attribute<2>(decoded, draco::GeometryAttribute::NORMAL, count, mesh->normals, diagnostic);
  return status;
}

fvv_status decode(const uint8_t *data, size_t size, fvv_mesh *mesh, fvv_diagnostic *diagnostic) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char *>(data), size);
  draco::Mesh decoded;
  draco::Decoder decoder;
  if (!decoder.DecodeBufferToGeometry(&buffer, &decoded).ok())
    return broken(diagnostic, FVV_ISSUE_DRACO_STREAM, "Draco does not decode the bitstream");
  if (buffer.remaining_size() != 0)
    return broken(diagnostic, FVV_ISSUE_DRACO_STREAM, "Draco does not read the bitstream to its end");
  if (decoded.num_points() != mesh->vertex_count || decoded.num_faces() != mesh->face_count)
    return fvv_fail(
        diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_DRACO_COUNTS, FVV_CHUNK_MESH, FVV_MESH_SIZE,
        "Draco yields %lu vertices and %lu faces, the MESH header declares %lu and %lu",
        static_cast<unsigned long>(decoded.num_points()), static_cast<unsigned long>(decoded.num_faces()),
        static_cast<unsigned long>(mesh->vertex_count), static_cast<unsigned long>(mesh->face_count));
  static_assert(sizeof(draco::Mesh::Face) == 3 * sizeof *mesh->faces, "faces have three indices in a row");
  std::memcpy(mesh->faces, &decoded.face(draco::FaceIndex(0)), mesh->face_count * sizeof(draco::Mesh::Face));
  return copy_attributes(decoded, mesh, diagnostic);
}

} // namespace

fvv_status fvv_draco_encode(const fvv_mesh *mesh, int level, fvv_draco_coding coding, fvv_bytes *bytes,
                            fvv_diagnostic *diagnostic) {
  try {
    return encode(*mesh, level, coding, bytes, diagnostic);
  } catch (const std::bad_alloc &) {
    return out_of_memory(diagnostic);
  } catch (...) {
    return fvv_fail(diagnostic, FVV_ERROR_BUG, 0, 0, 0, "Draco's encoder threw an exception");
  }
}

fvv_status fvv_draco_decode(const uint8_t *data, size_t size, fvv_mesh *mesh, fvv_diagnostic *diagnostic) {
  try {
    return decode(data, size, mesh, diagnostic);
  } catch (const std::bad_alloc &) {
    return out_of_memory(diagnostic);
  } catch (...) {
    // std::length_error and its kind: a size that no valid stream leads to.
    return broken(diagnostic, FVV_ISSUE_DRACO_STREAM, "Draco does not decode the bitstream");
  }
}
