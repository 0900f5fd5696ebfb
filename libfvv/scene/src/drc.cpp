// Draco files (DRC). The header is read without libdraco first, because the decoder allocates by its counts
// before it checks anything else.
#include "fvv_cxx/untrusted.h"
#include "fvv_scene/file_io.h"
#include "fvv_scene/mesh_file.h"
#include "scene/src/drc_points.h"
#include "scene/src/mesh_build.h"

#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>

namespace fvv::scene {

namespace {

// Of messages about older bitstreams, which decoders of today still read.
constexpr const char *way_to_today =
    ": 'draco_decoder -i old.drc -o new.ply' converts it ('draco_transcoder' in a glTF file)";

struct DrcCounts {
  uint64_t faces, vertices;
};

class HeaderReader {
public:
  HeaderReader(std::string_view bytes, const std::string &file)
      : cursor{reinterpret_cast<const uint8_t *>(bytes.data()), bytes.size(), 0, 0}, name(file) {}

  DrcCounts read() {
    const uint8_t *head = cursor.take(11);
    if (!head || memcmp(head, "DRACO", 5)) fail(0, "expected a Draco file, which begins with DRACO");
    if (head[5] != 2 || head[6] != 2)
      fail(5, "expected Draco bitstream 2.2, found " + std::to_string(head[5]) + "." +
                  std::to_string(head[6]) +
                  (head[5] < 2 || (head[5] == 2 && head[6] < 2) ? way_to_today : ""));
    if (head[7] != 1)
      fail(7, head[7] ? "expected a triangular mesh, found another geometry"
                      : "expected a triangular mesh, found a point cloud");
    if (head[8] > 1) fail(8, "expected encoding method 0 or 1, found " + std::to_string(head[8]));
    const bool edgebreaker = head[8] == 1;
    constexpr uint16_t has_metadata = 0x8000;
    if (load_u16(head + 9) & has_metadata) skip_metadata();
    if (edgebreaker) take(1); // which traversal
    const uint64_t first = number(), second = number();
    return edgebreaker ? DrcCounts{second, first} : DrcCounts{first, second};
  }

private:
  [[noreturn]] void fail(size_t offset, const std::string &what) const {
    char text[32];
    snprintf(text, sizeof text, ": 0x%zx: ", offset);
    throw Error(name + text + what);
  }
  void check() const {
    if (cursor.failed) fail(cursor.position, "the file ends within the Draco header");
  }
  void take(uint64_t size) {
    cursor.take(size > SIZE_MAX ? SIZE_MAX : static_cast<size_t>(size));
    check();
  }
  uint64_t number() {
    const uint64_t value = cursor.uleb();
    check();
    return value;
  }
  void skip_name() {
    const uint8_t *size = cursor.take(1);
    check();
    take(*size);
  }
  // Metadata nests: entries, then children, each a name and metadata of its own. In this order a count of the
  // children still to come does instead of recursion.
  void skip_metadata() {
    for (uint64_t attributes = number(), i = 0; i <= attributes; i++) {
      if (i < attributes) number(); // of which attribute; the last one is of the whole mesh
      for (uint64_t pending = 1, visited = 0; pending; pending--, visited++) {
        if (visited) skip_name();
        for (uint64_t entries = number(); entries; entries--) {
          skip_name();
          take(number());
        }
        const uint64_t children = number();
        if (children > cursor.size) fail(cursor.position, "the file ends within the Draco header");
        pending += children;
      }
    }
  }

  Cursor cursor;
  const std::string &name;
};

// Error "name: 0xOFFSET: what" for anything but a triangular mesh of bitstream 2.2.
DrcCounts parse_drc_header(std::string_view bytes, const std::string &name) {
  return HeaderReader(bytes, name).read();
}

// The best that Draco does, a flat grid of two million triangles, is 89 faces per byte; a header that
// declares much more is wrong.
constexpr uint64_t max_faces_per_byte = 1024;

void check_counts(const DrcCounts &counts, size_t size, const fvv_limits &limits, const std::string &name) {
  const auto check = [&](uint64_t count, uint64_t limit, const char *what) {
    if (count > limit)
      throw Error(name + ": " + std::to_string(count) + " " + what + ", at most " + std::to_string(limit) +
                  " are allowed");
  };
  check(counts.faces, limits.max_faces, "faces");
  check(counts.vertices, limits.max_vertices, "vertices");
  check(counts.faces, size * max_faces_per_byte, "faces in so small a file");
  check(counts.vertices, size * max_faces_per_byte, "vertices in so small a file");
}

template <class Number>
void copy_positions(const draco::PointAttribute &attribute, Mesh &mesh, const std::string &name) {
  mesh.positions.resize(attribute.size() * 3);
  for (uint32_t i = 0; i < attribute.size(); i++) {
    Number value[3];
    attribute.GetValue(draco::AttributeValueIndex(i), value);
    for (size_t axis = 0; axis < 3; axis++) {
      const double coordinate = static_cast<double>(value[axis]);
      if (!std::isfinite(coordinate))
        throw Error(name + ": vertex " + std::to_string(i) +
                    ": expected finite coordinates, found nan or inf");
      mesh.positions[i * size_t(3) + axis] = coordinate;
    }
  }
}

const draco::PointAttribute *texture_of(const draco::Mesh &decoded, const std::string &name) {
  const draco::PointAttribute *pairs = decoded.GetNamedAttribute(draco::GeometryAttribute::TEX_COORD);
  if (!pairs) throw Error(name + ": expected an attribute of texture coordinates, found none");
  if (pairs->num_components() != 2 || pairs->data_type() != draco::DT_FLOAT32)
    throw Error(name + ": expected texture coordinates as 2 components of float32, found " +
                std::to_string(pairs->num_components()) + " of Draco data type " +
                std::to_string(pairs->data_type()));
  return pairs;
}

const draco::PointAttribute *normals_of(const draco::Mesh &decoded) {
  const draco::PointAttribute *normals = decoded.GetNamedAttribute(draco::GeometryAttribute::NORMAL);
  const bool usable = normals && normals->num_components() == 3 && normals->data_type() == draco::DT_FLOAT32;
  return usable ? normals : nullptr;
}

// R G B of each vertex, of the mesh whose vertices are the values of positions; grey where no face has one.
std::vector<uint8_t> colours_of(const draco::Mesh &decoded, const draco::PointAttribute &positions) {
  const draco::PointAttribute *colours = decoded.GetNamedAttribute(draco::GeometryAttribute::COLOR);
  if (!colours || colours->num_components() < 3) return {};
  const bool is_float = colours->data_type() == draco::DT_FLOAT32;
  if (!is_float && colours->data_type() != draco::DT_UINT8) return {};
  std::vector<double> values(3 * size_t(positions.size()), NAN);
  for (uint32_t i = 0; i < decoded.num_points(); i++) {
    const uint32_t vertex = positions.mapped_index(draco::PointIndex(i)).value();
    const draco::AttributeValueIndex index = colours->mapped_index(draco::PointIndex(i));
    float value[4] = {};
    if (vertex >= positions.size() || index.value() >= colours->size() || colours->num_components() > 4 ||
        !colours->ConvertValue<float>(index, int8_t(colours->num_components()), value))
      continue;
    std::copy_n(value, 3, &values[3 * size_t(vertex)]);
  }
  return display_colours(values, is_float || colours->normalized() ? 1 : 255);
}

Mesh from_draco(const draco::Mesh &decoded, const fvv_limits &limits, const std::string &name, bool texture,
                bool normals, MeshExtras *extras) {
  const draco::PointAttribute *attribute = decoded.GetNamedAttribute(draco::GeometryAttribute::POSITION);
  if (!attribute) throw Error(name + ": expected an attribute of positions, found none");
  if (attribute->num_components() != 3)
    throw Error(name + ": expected positions of 3 components, found " +
                std::to_string(attribute->num_components()));
  if (!decoded.num_faces()) throw Error(name + ": expected at least one face, found none");
  if (decoded.num_faces() > limits.max_faces || attribute->size() > limits.max_vertices)
    throw Error(name + ": decodes to " + std::to_string(decoded.num_faces()) + " faces and " +
                std::to_string(attribute->size()) + " vertices, at most " + std::to_string(limits.max_faces) +
                " and " + std::to_string(limits.max_vertices) + " are allowed");
  Mesh mesh;
  if (attribute->data_type() == draco::DT_FLOAT32)
    copy_positions<float>(*attribute, mesh, name);
  else if (attribute->data_type() == draco::DT_INT32)
    copy_positions<int32_t>(*attribute, mesh, name);
  else
    throw Error(name + ": expected positions as float32 or int32, found Draco data type " +
                std::to_string(attribute->data_type()));
  if (extras) extras->colours = colours_of(decoded, *attribute);
  const draco::PointAttribute *pairs = texture ? texture_of(decoded, name) : nullptr;
  const draco::PointAttribute *directions = normals ? normals_of(decoded) : nullptr;
  std::vector<double> of_corners, normals_of_corners;
  // Points of Draco are split at seams of texture and normals; the values of the positions are not.
  mesh.faces.reserve(size_t(decoded.num_faces()) * 3);
  for (uint32_t i = 0; i < decoded.num_faces(); i++)
    for (const draco::PointIndex &point : decoded.face(draco::FaceIndex(i))) {
      const auto value_of = [&](const draco::PointAttribute &values, const char *what) {
        const uint32_t value = values.mapped_index(point).value();
        if (point.value() >= decoded.num_points() || value >= values.size())
          throw Error(name + ": face " + std::to_string(i) + ": index " + std::to_string(value) + " of " +
                      std::to_string(values.size()) + " " + what);
        return value;
      };
      mesh.faces.push_back(value_of(*attribute, "vertices"));
      if (directions) {
        float normal[3];
        directions->GetValue(draco::AttributeValueIndex(value_of(*directions, "normals")), normal);
        normals_of_corners.insert(normals_of_corners.end(), normal, normal + 3);
      }
      if (!pairs) continue;
      float pair[2];
      pairs->GetValue(draco::AttributeValueIndex(value_of(*pairs, "texture coordinates")), pair);
      if (!std::isfinite(pair[0]) || !std::isfinite(pair[1]))
        throw Error(name + ": face " + std::to_string(i) +
                    ": expected finite texture coordinates, found nan or inf");
      // Draco files count v from the bottom of the picture, as the OBJ files that they mostly come from.
      of_corners.insert(of_corners.end(), {double(pair[0]), 1 - double(pair[1])});
    }
  if (texture || directions) split_seams(mesh, of_corners, normals_of_corners, limits, name);
  return mesh;
}

// The coordinate as written, verified to be the same lattice point.
float narrowed(double coordinate, size_t index, const Lattice &lattice, const std::string &name) {
  const size_t axis = index % 3;
  const auto lattice_index = [&](double x) { return std::round((x - lattice.origin[axis]) / lattice.step); };
  const float value = static_cast<float>(coordinate);
  if (std::isfinite(value) && lattice_index(double(value)) == lattice_index(coordinate)) return value;
  std::string text, step;
  append_double(text, coordinate);
  append_double(step, lattice.step);
  throw Error(name + ": vertex " + std::to_string(index / 3) + ": " + "xyz"[axis] + " = " + text +
              " as float32 falls onto another lattice point (step " + step + "): write PLY or OBJ");
}

// Attributes 0, 1, ...: positions, texture coordinates, normals, of which the mesh has some. v_up: as OBJ and
// Draco files count v, not as glTF does.
void to_draco(const Mesh &mesh, const Lattice &lattice, bool v_up, const std::string &name,
              draco::Mesh &out) {
  const auto vertices = static_cast<uint32_t>(mesh.vertex_count());
  out.set_num_points(vertices);
  const auto add = [&](draco::GeometryAttribute::Type type, size_t components, const auto &value_of) {
    draco::GeometryAttribute description;
    description.Init(type, nullptr, static_cast<uint8_t>(components), draco::DT_FLOAT32, false,
                     static_cast<int64_t>(components * sizeof(float)), 0);
    const int id = out.AddAttribute(description, true, vertices);
    for (uint32_t i = 0; i < vertices; i++) {
      float value[3];
      for (size_t k = 0; k < components; k++) value[k] = value_of(i * components + k);
      out.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(i), value);
    }
  };
  add(draco::GeometryAttribute::POSITION, 3,
      [&](size_t i) { return narrowed(mesh.positions[i], i, lattice, name); });
  if (!mesh.texture.empty())
    add(draco::GeometryAttribute::TEX_COORD, 2,
        [&](size_t i) { return float(v_up && i % 2 ? 1 - mesh.texture[i] : mesh.texture[i]); });
  if (!mesh.normals.empty())
    add(draco::GeometryAttribute::NORMAL, 3, [&](size_t i) { return float(mesh.normals[i]); });
  out.SetNumFaces(mesh.face_count());
  for (size_t i = 0; i < mesh.faces.size(); i += 3)
    out.SetFace(draco::FaceIndex(static_cast<uint32_t>(i / 3)),
                {{draco::PointIndex(mesh.faces[i]), draco::PointIndex(mesh.faces[i + 1]),
                  draco::PointIndex(mesh.faces[i + 2])}});
}

std::string encoded(draco::ExpertEncoder &encoder, const std::string &name) {
  draco::EncoderBuffer buffer;
  const draco::Status status = encoder.EncodeToBuffer(&buffer);
  if (!status.ok()) throw Error(name + ": Draco cannot encode the mesh: " + status.error_msg_string());
  return std::string(buffer.data(), buffer.size());
}

std::string encode(const Mesh &mesh, const Lattice &lattice, const std::string &name) {
  draco::Mesh source;
  to_draco(mesh, lattice, true, name, source);
  draco::ExpertEncoder encoder(source);
  encoder.SetEncodingMethod(draco::MESH_SEQUENTIAL_ENCODING);
  encoder.options().SetGlobalBool("compress_connectivity", true);
  return encoded(encoder, name);
}

// Beyond, dequantising in float32 could err by half a step.
constexpr int max_quantisation_bits = 22;

// Draco's grid of positions is that of the lattice, so that quantising changes none.
void quantise_positions(draco::ExpertEncoder &encoder, const Mesh &mesh, const Lattice &lattice,
                        const std::string &name) {
  double low[3], high[3];
  for (size_t k = 0; k < 3; k++) low[k] = high[k] = mesh.positions[k];
  for (size_t i = 0; i < mesh.positions.size(); i++) {
    low[i % 3] = std::min(low[i % 3], mesh.positions[i]);
    high[i % 3] = std::max(high[i % 3], mesh.positions[i]);
  }
  double steps = 1;
  for (size_t k = 0; k < 3; k++) steps = std::max(steps, std::round((high[k] - low[k]) / lattice.step));
  int bits = 1;
  while (std::ldexp(1, bits) - 1 < steps) bits++;
  if (bits > max_quantisation_bits) {
    std::string step;
    append_double(step, lattice.step);
    throw Error(name + ": the mesh is 2^" + std::to_string(max_quantisation_bits) +
                " steps of its lattice long or more (step " + step + "), which Draco cannot hold exactly");
  }
  const float origin[3] = {float(low[0]), float(low[1]), float(low[2])};
  encoder.SetAttributeExplicitQuantization(0, bits, 3, origin,
                                           float(lattice.step * (std::ldexp(1, bits) - 1)));
}

std::string encode_points(const Mesh &mesh, const Lattice &lattice, unsigned texture_bits,
                          const std::string &name) {
  draco::Mesh source;
  to_draco(mesh, lattice, false, name, source);
  draco::ExpertEncoder encoder(source);
  encoder.SetEncodingMethod(draco::MESH_EDGEBREAKER_ENCODING);
  encoder.SetSpeedOptions(0, 0); // the smallest
  quantise_positions(encoder, mesh, lattice, name);
  if (!mesh.texture.empty()) {
    const float origin[2] = {0, 0};
    const int bits = int(texture_bits) + 1; // 1 is a coordinate too
    encoder.SetAttributeExplicitQuantization(1, bits, 2, origin,
                                             float(std::ldexp(std::ldexp(1, bits) - 1, -int(texture_bits))));
  }
  return encoded(encoder, name);
}

// One sentence for all exceptions of libdraco (std::bad_alloc, std::length_error for hostile files).
template <class Function> auto guarded(const std::string &name, const Function &function) {
  try {
    return function();
  } catch (const Error &) {
    throw;
  } catch (const std::exception &error) {
    throw Error(name + ": Draco failed: " + error.what());
  }
}

// Checks everything that is declared before libdraco allocates by it.
std::unique_ptr<draco::Mesh> decode(std::string_view bytes, const std::string &name,
                                    const fvv_limits &limits) {
  if (bytes.size() > limits.max_payload)
    throw Error(name + ": has " + std::to_string(bytes.size()) + " bytes, at most " +
                std::to_string(limits.max_payload) + " are allowed");
  check_counts(parse_drc_header(bytes, name), bytes.size(), limits, name);
  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok())
    throw Error(name + ": Draco cannot decode the file: " + decoded.status().error_msg_string());
  return std::move(decoded).value();
}

unsigned type_code(draco::DataType type) {
  switch (type) {
  case draco::DT_INT8:
    return 5120;
  case draco::DT_UINT8:
    return 5121;
  case draco::DT_INT16:
    return 5122;
  case draco::DT_UINT16:
    return 5123;
  case draco::DT_UINT32:
    return 5125;
  case draco::DT_FLOAT32:
    return 5126;
  default:
    return 0;
  }
}

DrcPoints points_of(const draco::Mesh &decoded, const std::string &name, const fvv_limits &limits,
                    const std::vector<uint32_t> &attributes) {
  if (decoded.num_faces() > limits.max_faces || decoded.num_points() > limits.max_vertices)
    throw Error(name + ": decodes to " + std::to_string(decoded.num_faces()) + " faces and " +
                std::to_string(decoded.num_points()) + " points, at most " +
                std::to_string(limits.max_faces) + " and " + std::to_string(limits.max_vertices) +
                " are allowed");
  DrcPoints out = {decoded.num_points(), {}, {}};
  for (uint32_t i = 0; i < decoded.num_faces(); i++)
    for (const draco::PointIndex &point : decoded.face(draco::FaceIndex(i))) {
      if (point.value() >= out.count)
        throw Error(name + ": face " + std::to_string(i) + ": index " + std::to_string(point.value()) +
                    " of " + std::to_string(out.count) + " points");
      out.triangles.push_back(point.value());
    }
  for (const uint32_t id : attributes) {
    const draco::PointAttribute *attribute = decoded.GetAttributeByUniqueId(id);
    if (!attribute) throw Error(name + ": expected an attribute " + std::to_string(id) + ", found none");
    const size_t size = size_t(draco::DataTypeLength(attribute->data_type())) * attribute->num_components();
    DrcValues &values = out.attributes[id];
    values = {attribute->num_components(), type_code(attribute->data_type()),
              std::string(out.count * size, '\0')};
    for (uint32_t i = 0; i < out.count; i++) {
      const draco::AttributeValueIndex value = attribute->mapped_index(draco::PointIndex(i));
      if (value.value() >= attribute->size())
        throw Error(name + ": point " + std::to_string(i) + ": index " + std::to_string(value.value()) +
                    " of " + std::to_string(attribute->size()) + " values");
      attribute->GetValue(value, &values.bytes[i * size]);
    }
  }
  return out;
}

} // namespace

Mesh parse_drc(std::string_view bytes, const std::string &name, const fvv_limits *limits, MeshReport *,
               bool texture, bool normals, MeshExtras *extras) {
  const fvv_limits bounds = limits_or_default(limits);
  return guarded(
      name, [&] { return from_draco(*decode(bytes, name, bounds), bounds, name, texture, normals, extras); });
}

DrcPoints parse_drc_points(std::string_view bytes, const std::string &name, const fvv_limits &limits,
                           const std::vector<uint32_t> &attributes) {
  return guarded(name, [&] { return points_of(*decode(bytes, name, limits), name, limits, attributes); });
}

std::string format_drc(const Mesh &mesh, const Lattice &lattice, const std::string &name) {
  geometry::check(mesh, name);
  if (!(lattice.step > 0)) throw Error(name + ": expected a lattice step > 0");
  return guarded(name, [&] { return encode(mesh, lattice, name); });
}

std::string format_drc_points(const Mesh &mesh, const Lattice &lattice, unsigned texture_bits,
                              const std::string &name) {
  geometry::check(mesh, name);
  return guarded(name, [&] { return encode_points(mesh, lattice, texture_bits, name); });
}

} // namespace fvv::scene
