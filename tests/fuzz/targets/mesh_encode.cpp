// From any source mesh to payloads and back: canonicalising, all profiles, delta frames, visibility, colours.
#include "meshes.h"

#include "fvv/colours.h"
#include "fvv/visibility.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace {

struct Source {
  std::vector<double> positions, texture, normals;
  std::vector<uint32_t> faces;
};

// Coordinates are small integers most of the time, so that points and faces coincide.
double coordinate(fuzz::Input &input, bool odd) {
  return odd && !input.below(32) ? input.f64() : double(input.number<int8_t>()) / 8;
}

Source source_of(fuzz::Input &input) {
  Source out;
  const uint8_t what = input.u8();
  const bool odd = what & 1;
  const uint32_t vertices = 3 + input.below(60), faces = 1 + input.below(90);
  for (uint32_t i = 0; i < 3 * vertices; i++) out.positions.push_back(coordinate(input, odd));
  for (uint32_t i = 0; what & 2 && i < 2 * vertices; i++)
    out.texture.push_back(std::abs(coordinate(input, odd)) / 16);
  for (uint32_t i = 0; what & 4 && i < 3 * vertices; i++) out.normals.push_back(coordinate(input, odd));
  for (uint32_t i = 0; i < 3 * faces; i++)
    out.faces.push_back(odd && !input.below(64) ? input.u32() : input.below(vertices));
  return out;
}

void encode_all(const fvv_mesh &mesh, fuzz::Input &input) {
  const uint8_t profiles[] = {FVV_MESH_RAW, FVV_MESH_DRACO, FVV_MESH_FAST};
  const uint8_t profile = profiles[input.below(3)];
  fuzz::Payload payload;
  fvv_mesh decoded = {};
  std::vector<uint32_t> vertices(3 * size_t(mesh.face_count));
  const fvv_status status = fvv_mesh_encode_mapped(&mesh, profile, int(input.below(11)), nullptr,
                                                   &payload.bytes, &decoded, vertices.data(), nullptr);
  fuzz::expect(status == FVV_OK, "a canonical mesh can be encoded");
  const fuzz::Mesh again(fuzz::Bytes(payload.bytes.data, payload.bytes.data + payload.bytes.size));
  fuzz::expect(again.there && fuzz::equal(again.mesh, decoded), "what is decoded is what the encoder says");
  for (size_t v = 0; v < decoded.vertex_count; v++)
    fuzz::expect(!std::memcmp(decoded.lattice + 3 * v, mesh.lattice + 3 * size_t(vertices[v]), 12),
                 "decoded vertices are those of the mesh");
  fvv_mesh_free(&decoded);
}

void encode_delta(const fvv_mesh &key, fuzz::Input &input) {
  fvv_mesh_sequence *encoder = nullptr, *decoder = nullptr;
  fuzz::expect(fvv_mesh_sequence_open(&key, nullptr, &encoder, nullptr) == FVV_OK &&
                   fvv_mesh_sequence_open(&key, nullptr, &decoder, nullptr) == FVV_OK,
               "a canonical mesh may be a key");
  std::vector<int32_t> positions(key.lattice, key.lattice + 3 * size_t(key.vertex_count));
  fvv_mesh_delta_options options;
  fvv_mesh_delta_options_default(&options);
  for (int frame = 0; frame < 3 && input.left(); frame++) {
    options.max_error = input.below(4);
    for (int32_t &value : positions)
      value = std::max(-FVV_LATTICE_MAX, std::min(FVV_LATTICE_MAX, value + input.number<int8_t>()));
    fuzz::Payload payload;
    fuzz::expect(fvv_mesh_sequence_encode(encoder, positions.data(), &options, &payload.bytes, nullptr) ==
                     FVV_OK,
                 "a frame can be encoded");
    fuzz::expect(fvv_mesh_sequence_decode(decoder, payload.bytes.data, payload.bytes.size, nullptr) ==
                         FVV_OK &&
                     fuzz::equal(*fvv_mesh_sequence_mesh(encoder), *fvv_mesh_sequence_mesh(decoder)),
                 "both sides have the same frame");
    const fvv_mesh *mesh = fvv_mesh_sequence_mesh(decoder);
    for (size_t i = 0; i < positions.size(); i++)
      fuzz::expect(std::abs(int64_t(mesh->lattice[i]) - positions[i]) <= 2 * int64_t(options.max_error),
                   "the error is bounded");
  }
  fvv_mesh_sequence_close(encoder);
  fvv_mesh_sequence_close(decoder);
}

void encode_visibility(const fvv_mesh &mesh, fuzz::Input &input) {
  fvv_visibility_order *order = nullptr;
  fuzz::expect(fvv_visibility_order_open(&mesh, nullptr, &order, nullptr) == FVV_OK, "a mesh has an order");
  const size_t count = mesh.vertex_count;
  std::vector<uint8_t> seen(count), former(count), states(count), decoded(count);
  for (uint8_t &state : seen) state = uint8_t(1 + input.below(6));
  for (uint8_t &state : former) state = uint8_t(input.below(7));
  fvv_visibility_header header = {64, 1, 0, input.below(2), 0};
  fvv_visibility_view view = {
      1, {0, 0, 100000}, seen.data(), header.number ? former.data() : nullptr, states.data()};
  fuzz::Payload payload;
  fuzz::expect(fvv_visibility_encode(order, &mesh, &header, &view, 1, &payload.bytes, nullptr) == FVV_OK,
               "visibility can be encoded");
  fvv_visibility_stream stream;
  fuzz::expect(fvv_visibility_peek(payload.bytes.data, payload.bytes.size, nullptr, &header, &stream, 1,
                                   nullptr) == FVV_OK &&
                   fvv_visibility_decode(order, &mesh, &header, payload.bytes.data + stream.offset,
                                         stream.size, view.centre, view.former, decoded.data(),
                                         nullptr) == FVV_OK &&
                   decoded == states,
               "visibility is decoded as the encoder says");
  fvv_visibility_order_close(order);
}

void encode_colours(const fvv_mesh &mesh, fuzz::Input &input) {
  std::vector<uint8_t> colours(3 * size_t(mesh.vertex_count)), decoded(colours.size());
  for (uint8_t &value : colours) value = input.u8();
  fvv_colours_header header = {1, uint8_t(1 + input.below(64)), uint8_t(1 + input.below(64)),
                               0, 1 + input.below(300),         0};
  fuzz::Payload payload;
  const fvv_status status =
      fvv_colours_encode(&mesh, &header, colours.data(), nullptr, nullptr, &payload.bytes, nullptr);
  fuzz::expect_status(status);
  if (status != FVV_OK) return;
  fuzz::expect(fvv_colours_decode(payload.bytes.data, payload.bytes.size, &mesh, nullptr, nullptr,
                                  decoded.data(), nullptr) == FVV_OK,
               "colours that were encoded decode");
}

} // namespace

FVV_FUZZ_TARGET(mesh_encode, fuzz::Form::bytes) {
  fuzz::Input input(data, size);
  const Source from = source_of(input);
  const fvv_mesh_source source = {from.positions.data(),
                                  from.faces.data(),
                                  from.positions.size() / 3,
                                  from.faces.size() / 3,
                                  from.texture.empty() ? nullptr : from.texture.data(),
                                  from.normals.empty() ? nullptr : from.normals.data()};
  fvv_mesh_options options;
  fvv_mesh_options_default(&options);
  options.lattice_step = 1.0 / (1 + input.below(64));
  options.min_component_faces = input.below(4);
  options.keep_winding = int(input.below(2));
  options.normal_bits = input.below(2) ? 8 : 0;
  fvv_mesh mesh;
  fvv_mesh_report report = {};
  report.struct_size = sizeof report;
  const fvv_status status = fvv_mesh_canonicalise(&source, &options, nullptr, &mesh, &report, nullptr);
  fuzz::expect_status(status);
  if (status != FVV_OK) return;
  fuzz::expect_valid(mesh);
  encode_all(mesh, input);
  encode_delta(mesh, input);
  encode_visibility(mesh, input);
  encode_colours(mesh, input);
  fvv_mesh_free(&mesh);
}
