#include "draco_direct.h"

#include <algorithm>
#include <memory>

#include <draco/compression/expert_encode.h>
#include <draco/mesh/mesh.h>

#include "fvv_catch.h"

static int add(draco::Mesh *mesh, draco::GeometryAttribute::Type type, draco::DataType data, uint32_t count,
               uint8_t components = 3) {
  draco::GeometryAttribute attribute;
  attribute.Init(type, nullptr, components, data, false, 4 * components, 0);
  return mesh->AddAttribute(attribute, true, count);
}

std::vector<uint8_t> draco_payload(const fvv_mesh &mesh, const DracoOptions &options) {
  draco::Mesh source;
  source.SetNumFaces(mesh.face_count);
  for (uint32_t f = 0; f < mesh.face_count; f++)
    source.SetFace(draco::FaceIndex(f),
                   {{draco::PointIndex(mesh.faces[3 * f]), draco::PointIndex(mesh.faces[3 * f + 1]),
                     draco::PointIndex(mesh.faces[3 * f + 2])}});
  source.set_num_points(mesh.vertex_count);
  const int id = add(&source, draco::GeometryAttribute::POSITION,
                     options.floats ? draco::DT_FLOAT32 : draco::DT_INT32, mesh.vertex_count);
  for (uint32_t v = 0; v < mesh.vertex_count; v++) {
    const int32_t *p = mesh.lattice + 3 * v;
    const float as_floats[3] = {float(p[0]), float(p[1]), float(p[2])};
    source.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(v),
                                            options.floats ? static_cast<const void *>(as_floats) : p);
  }
  int texture = -1;
  if (mesh.texture) {
    texture = add(&source, draco::GeometryAttribute::TEX_COORD, draco::DT_INT32, mesh.vertex_count, 2);
    for (uint32_t v = 0; v < mesh.vertex_count; v++)
      source.attribute(texture)->SetAttributeValue(draco::AttributeValueIndex(v), mesh.texture + 2 * v);
  }
  if (options.normals) {
    const int normal = add(&source, draco::GeometryAttribute::NORMAL, draco::DT_INT32, mesh.vertex_count);
    const int32_t up[3] = {0, 0, 1};
    for (uint32_t v = 0; v < mesh.vertex_count; v++)
      source.attribute(normal)->SetAttributeValue(draco::AttributeValueIndex(v), up);
  }
  if (options.metadata) {
    auto metadata = std::make_unique<draco::GeometryMetadata>();
    metadata->AddEntryInt("answer", 42);
    source.AddMetadata(std::move(metadata));
  }
  draco::ExpertEncoder encoder(source);
  encoder.SetSpeedOptions(options.speed, options.speed);
  encoder.SetEncodingMethod(options.sequential ? draco::MESH_SEQUENTIAL_ENCODING
                                               : draco::MESH_EDGEBREAKER_ENCODING);
  encoder.options().SetGlobalBool("compress_connectivity", options.compressed_indices);
  encoder.options().SetGlobalBool("split_mesh_on_seams", options.single_connectivity);
  if (mesh.texture)
    REQUIRE(encoder
                .SetAttributePredictionScheme(texture, options.portable_prediction
                                                           ? draco::MESH_PREDICTION_TEX_COORDS_PORTABLE
                                                           : draco::MESH_PREDICTION_PARALLELOGRAM)
                .ok());
  draco::EncoderBuffer buffer;
  REQUIRE(encoder.EncodeToBuffer(&buffer).ok());
  std::vector<uint8_t> payload(16 + buffer.size());
  payload[0] = FVV_MESH_DRACO;
  payload[1] = mesh.texture ? FVV_MESH_HAS_TEXTURE : 0;
  payload[2] = mesh.texture_bits;
  for (int i = 0; i < 4; i++) {
    payload[size_t(4 + i)] = uint8_t(mesh.vertex_count >> (8 * i));
    payload[size_t(8 + i)] = uint8_t(mesh.face_count >> (8 * i));
  }
  std::copy(buffer.data(), buffer.data() + buffer.size(), payload.begin() + 16);
  return payload;
}
