// Draco without libfvv, as its command line encodes a mesh.
#include "fvvcodecs.h"

#include <cmath>
#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <stdexcept>

namespace fvv::codecs {

namespace {

std::unique_ptr<draco::Mesh> built(const Mesh &mesh) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(int(mesh.face_count()));
  const int id = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  for (size_t f = 0; f < mesh.face_count(); f++) {
    float corners[3][3];
    for (size_t c = 0; c < 3; c++)
      for (size_t k = 0; k < 3; k++)
        corners[c][k] = float(mesh.positions[3 * size_t(mesh.faces[3 * f + c]) + k]);
    builder.SetAttributeValuesForFace(id, draco::FaceIndex(uint32_t(f)), corners[0], corners[1], corners[2]);
  }
  auto out = builder.Finalize();
  if (!out) throw std::runtime_error("Draco takes no such mesh");
  return out;
}

std::string run(draco::Encoder &encoder, const Mesh &mesh, int level) {
  encoder.SetSpeedOptions(10 - level, 10 - level);
  draco::EncoderBuffer buffer;
  const draco::Status status = encoder.EncodeMeshToBuffer(*built(mesh), &buffer);
  if (!status.ok()) throw std::runtime_error(std::string("Draco: ") + status.error_msg());
  return {buffer.data(), buffer.size()};
}

} // namespace

PlainDraco::PlainDraco(const Mesh &mesh) {
  extent = 0;
  for (size_t k = 0; k < 3; k++) {
    double high = low[k] = mesh.positions[3 * size_t(mesh.faces[0]) + k];
    for (const uint32_t v : mesh.faces) {
      low[k] = std::min(low[k], mesh.positions[3 * size_t(v) + k]);
      high = std::max(high, mesh.positions[3 * size_t(v) + k]);
    }
    extent = std::max(extent, high - low[k]);
  }
}

int PlainDraco::bits_for(double step, double *coarser) const {
  const int bits = std::max(1, int(std::floor(std::log2(extent / step + 1))));
  *coarser = extent / (std::pow(2.0, bits) - 1);
  return bits;
}

std::string PlainDraco::encode(const Mesh &mesh, int bits, int level) const {
  draco::Encoder encoder;
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, bits);
  return run(encoder, mesh, level);
}

std::string PlainDraco::encode_on_lattice(const Mesh &mesh, double step, int level) const {
  const int bits = int(std::ceil(std::log2(extent / step + 3)));
  float origin[3];
  for (size_t k = 0; k < 3; k++) origin[k] = float(step * std::floor(low[k] / step));
  draco::Encoder encoder;
  encoder.SetAttributeExplicitQuantization(draco::GeometryAttribute::POSITION, bits, 3, origin,
                                           float(step * (std::pow(2.0, bits) - 1)));
  return run(encoder, mesh, level);
}

void PlainDraco::decode(const std::string &bytes) {
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  if (!decoder.DecodeMeshFromBuffer(&buffer).ok())
    throw std::runtime_error("Draco does not decode what it encoded");
}

} // namespace fvv::codecs
