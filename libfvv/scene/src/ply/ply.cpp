// PLY 1.0. The header is checked completely before a body is read.

#include "fvv_cxx/input_file.h"
#include "fvv_cxx/untrusted.h"
#include "fvv_scene/file_io.h"
#include "fvv_scene/mesh_file.h"
#include "scene/src/atlas/atlas.h"
#include "scene/src/mesh_build.h"
#include "scene/src/mtl.h"
#include "scene/src/ply/header.h"
#include "scene/src/polygon.h"

#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace fvv::scene {

namespace {

std::string numbered(const PlyElement &element, uint64_t index) {
  return element.name + " " + std::to_string(index);
}

// Values of an ASCII body: an element begins and ends with a line, so that a missing value is found where it
// is missing.
class AsciiBody {
public:
  AsciiBody(std::string_view bytes, const PlyHeader &header, const std::string &file)
      : rest(bytes), name(file), line(header.lines) {}

  void begin(const PlyElement &declared, uint64_t number) {
    element = &declared;
    index = number;
    broken.clear();
    std::string_view words, word;
    do {
      line++;
      if (!next_line(rest, text))
        fail("the file ends before " + numbered(declared, number) + " of " + std::to_string(declared.count));
      words = text;
    } while (!next_word(words, word)); // an empty line is no element
  }
  // any: a number may also be NaN or infinite.
  double real(const PlyProperty &property, bool any = false) {
    const std::string_view word = take(property.name);
    double value;
    if (any && is_no_number(word)) return NAN;
    if (!parse_double(word, value))
      fail(numbered(*element, index) + ": expected a finite number for " + property.name + ", found " +
           quote(word));
    return value;
  }
  int64_t integer(const PlyProperty &property, const PlyType &) {
    const std::string_view word = take(property.name);
    int64_t value;
    if (!parse_integer(word, value))
      fail(numbered(*element, index) + ": expected an integer in " + property.name + ", found " +
           quote(word));
    return value;
  }
  void skip(const PlyProperty &property, uint64_t count) {
    for (uint64_t i = 0; i < count; i++) take(property.name);
  }
  bool holds(uint64_t values, const PlyType &) const {
    return values <= (text.size() + rest.size() + (rest.empty() ? 1 : 2)) / 2; // with a line end between both
  }
  void finish() {
    std::string_view word;
    if (!next_word(text, word)) return;
    if (!broken.empty()) throw Error(broken); // the next element begins there
    fail(numbered(*element, index) + ": expected the end of the line, found " + quote(word));
  }
  void finish_file() {
    std::string_view word;
    while (next_line(rest, text)) {
      line++;
      if (next_word(text, word)) fail("expected the end of the file, found " + quote(word));
    }
  }
  [[noreturn]] void fail(const std::string &what) const {
    throw Error(name + ":" + std::to_string(line) + ": " + what);
  }

private:
  static bool is_no_number(std::string_view text) {
    if (!text.empty() && (text[0] == '-' || text[0] == '+')) text.remove_prefix(1);
    const std::string small = lower(text);
    return small.substr(0, 3) == "nan" || small == "inf" || small == "infinity";
  }

  std::string_view take(const std::string &property) {
    std::string_view word;
    while (!next_word(text, word)) {
      if (broken.empty())
        broken = name + ":" + std::to_string(line) + ": " + numbered(*element, index) +
                 ": the line ends before " + property + " is complete";
      if (!next_line(rest, text)) throw Error(broken);
      line++;
    }
    return word;
  }

  std::string_view rest, text;
  const std::string &name;
  std::string broken; // what is wrong with an element that goes on in the next line, unless it ends with that
  uint64_t line, index = 0;
  const PlyElement *element = nullptr;
};

class BinaryBody {
public:
  BinaryBody(std::string_view bytes, const PlyHeader &header, const std::string &file)
      : start(bytes.data()), cursor(start), end(start + bytes.size()), body(header.size), name(file),
        big(header.format == PlyFormat::big_endian) {}

  void begin(const PlyElement &declared, uint64_t number) {
    element = &declared;
    index = number;
  }
  double real(const PlyProperty &property, bool any = false) {
    const PlyType &type = property.type;
    if (!type.is_float) return static_cast<double>(integer(property, type));
    const uint64_t bits = take(type);
    double value;
    if (type.size == 4) {
      const uint32_t low = static_cast<uint32_t>(bits);
      float narrow;
      memcpy(&narrow, &low, sizeof narrow);
      value = narrow;
    } else {
      memcpy(&value, &bits, sizeof value);
    }
    if (!any && !std::isfinite(value)) {
      cursor -= type.size;
      fail(numbered(*element, index) + ": expected a finite number for " + property.name + ", found " +
           (std::isnan(value) ? "nan"
            : value < 0       ? "-inf"
                              : "inf"));
    }
    return value;
  }
  int64_t integer(const PlyProperty &, const PlyType &type) {
    const uint64_t bits = take(type), sign = uint64_t(1) << (8 * type.size - 1);
    return static_cast<int64_t>(bits) - (type.is_signed && bits & sign ? int64_t(sign) * 2 : 0);
  }
  void skip(const PlyProperty &property, uint64_t count) { advance(count * property.type.size); }
  bool holds(uint64_t values, const PlyType &type) const {
    return values <= static_cast<uint64_t>(end - cursor) / type.size;
  }
  void finish() {}
  void finish_file() {
    // Some programs end a binary file with a line end too.
    if (!std::all_of(cursor, end, [](char c) { return c == '\n' || c == '\r'; }))
      fail("expected the end of the file, found " + std::to_string(end - cursor) + " more bytes");
  }
  [[noreturn]] void fail(const std::string &what) const {
    char offset[32];
    snprintf(offset, sizeof offset, ": 0x%" PRIx64 ": ", body + static_cast<uint64_t>(cursor - start));
    throw Error(name + offset + what);
  }

private:
  const char *advance(uint64_t size) {
    if (size > static_cast<uint64_t>(end - cursor))
      fail("the file ends within " + numbered(*element, index) + " of " + std::to_string(element->count));
    const char *at = cursor;
    cursor += size;
    return at;
  }
  uint64_t take(const PlyType &type) {
    const auto *at = reinterpret_cast<const uint8_t *>(advance(type.size));
    uint64_t bits = 0;
    for (unsigned i = 0; i < type.size; i++) bits |= uint64_t(at[i]) << 8 * (big ? type.size - 1 - i : i);
    return bits;
  }

  const char *start, *cursor, *end;
  uint64_t body; // offset of start in the file
  const std::string &name;
  bool big;
  uint64_t index = 0;
  const PlyElement *element = nullptr;
};

template <class Body> class BodyReader {
public:
  BodyReader(Body &input, const PlyHeader &declared, const std::string &file, const fvv_limits &bounds,
             MeshReport &notes, MeshExtras *more, std::vector<int64_t> *numbers_of)
      : body(input), header(declared), name(file), limits(bounds), report(notes), extras(more),
        numbers_of_faces(numbers_of) {}

  Mesh read() {
    // Both fit: the header was checked against limits and against the size of the file.
    mesh.positions.reserve(static_cast<size_t>(header.vertex_count) * 3);
    mesh.faces.reserve(static_cast<size_t>(header.face_count) * 3);
    for (const PlyElement &element : header.elements)
      for (uint64_t i = 0; i < element.count; i++) read_element(element, i);
    body.finish_file();
    if (mesh.faces.empty()) throw Error(name + ": expected at least one face, found lines and points alone");
    settle_unused(mesh, name);
    if (extras) extras->colours = colours();
    const ConcavePolygons concave(mesh, polygons, report, name);
    concave.apply(mesh.faces, 1);
    concave.apply(of_corners, 2);
    settle_bare();
    if (of_corners.empty())
      mesh.normals = std::move(of_vertices);
    else
      split_seams(mesh, of_corners, normals_of_corners(), limits, name);
    return std::move(mesh);
  }

private:
  void read_element(const PlyElement &element, uint64_t index) {
    double numbers[11]; // x y z u v nx ny nz red green blue
    bool has_texture = false, has_normal = false, has_colour = false;
    std::optional<int64_t> picture;
    pairs.clear();
    body.begin(element, index);
    for (const PlyProperty &property : element.properties) {
      switch (property.role) {
      case PlyRole::corners:
        read_face(property, index);
        break;
      case PlyRole::strips:
        read_strips(property, index);
        break;
      case PlyRole::corner_texture:
        for (uint64_t i = list_size(property); i; i--) pairs.push_back(body.real(property, true));
        has_texture = true;
        break;
      case PlyRole::texture_number:
        picture = body.integer(property, property.type);
        break;
      case PlyRole::unused:
        body.skip(property, property.is_list() ? list_size(property) : 1);
        break;
      default:
        numbers[static_cast<int>(property.role) - static_cast<int>(PlyRole::x)] =
            body.real(property, (element.name == "vertex" && property.role <= PlyRole::v) ||
                                    property.role >= PlyRole::red);
        has_texture = has_texture || property.role == PlyRole::u;
        has_normal = has_normal || property.role == PlyRole::nx;
        if (property.role == PlyRole::red) {
          has_colour = true;
          colour_type = property.type;
        }
      }
    }
    if (element.name == "vertex") {
      mesh.positions.insert(mesh.positions.end(), numbers, numbers + 3);
      if (has_normal) of_vertices.insert(of_vertices.end(), numbers + 5, numbers + 8);
      if (has_texture) mesh.texture.insert(mesh.texture.end(), {numbers[3], 1 - numbers[4]});
      if (has_colour) of_points.insert(of_points.end(), numbers + 8, numbers + 11);
    } else {
      if (picture) check_picture(*picture, index);
      if (has_texture) append_pairs(index);
      if (has_colour) add_to_corners(numbers + 8);
    }
    body.finish();
  }

  // The fan of append_fan again, u v for each of its corners. PLY counts v from the bottom of the picture.
  // Of a face that has none they are not numbers.
  void append_pairs(uint64_t index) {
    if (pairs.empty()) pairs.assign(corners.size() * 2, NAN);
    if (pairs.size() != corners.size() * 2)
      body.fail("face " + std::to_string(index) + ": expected " + std::to_string(corners.size() * 2) +
                " numbers in texcoord, found " + std::to_string(pairs.size()));
    for (size_t i = 1; i + 1 < corners.size(); i++)
      for (const size_t corner : {size_t(0), i, i + 1})
        of_corners.insert(of_corners.end(), {pairs[corner * 2], 1 - pairs[corner * 2 + 1]});
  }

  // Faces without texture coordinates beside others have no picture.
  void settle_bare() {
    std::vector<double> &values = of_corners.empty() ? mesh.texture : of_corners;
    const auto has_numbers = [&](size_t corner) {
      const double *pair = &values[2 * (of_corners.empty() ? mesh.faces[corner] : corner)];
      return std::isfinite(pair[0]) && std::isfinite(pair[1]);
    };
    std::vector<size_t> bare;
    for (size_t i = 0; !values.empty() && i < mesh.faces.size(); i += 3)
      if (!has_numbers(i) || !has_numbers(i + 1) || !has_numbers(i + 2)) bare.push_back(i / 3);
    if (!bare.empty() && (bare.size() == mesh.face_count() || !numbers_of_faces))
      throw Error(name + ": expected texture coordinates of all faces, found none of " +
                  std::to_string(bare.size()) + " of " + std::to_string(mesh.face_count()) +
                  " triangles: give them a place of the atlas, or read the mesh without one (" +
                  option_name("atlas", "none") + ")");
    for (double &value : values)
      if (!std::isfinite(value)) value = 0.5; // of what is not shown
    if (bare.empty()) return;
    numbers_of_faces->resize(mesh.face_count(), 0);
    for (const size_t face : bare) {
      int64_t &picture = (*numbers_of_faces)[face];
      report.untextured += picture >= 0; // the others are said to have none
      picture = -1;
    }
  }

  // Of a face, whose elements may precede those of the vertices.
  void add_to_corners(const double *colour) {
    sums.resize(4 * static_cast<size_t>(header.vertex_count));
    for (const uint32_t corner : corners) {
      for (size_t k = 0; k < 3; k++) sums[4 * size_t(corner) + k] += colour[k];
      sums[4 * size_t(corner) + 3]++;
    }
  }

  std::vector<uint8_t> colours() {
    for (size_t v = 0; v < sums.size(); v += 4)
      for (size_t k = 0; k < 3; k++) of_points.push_back(sums[v + 3] > 0 ? sums[v + k] / sums[v + 3] : NAN);
    return display_colours(of_points, white_of(of_points, !colour_type.is_float));
  }

  std::vector<double> normals_of_corners() const {
    std::vector<double> out;
    for (size_t i = 0; !of_vertices.empty() && i < mesh.faces.size(); i++) {
      const double *normal = &of_vertices[mesh.faces[i] * size_t(3)];
      out.insert(out.end(), normal, normal + 3);
    }
    return out;
  }

  void check_picture(int64_t picture, uint64_t index) {
    if (numbers_of_faces) { // -1: none, as MeshLab has it
      numbers_of_faces->resize(mesh.face_count(), picture);
      return;
    }
    if (index == 0) first_picture = picture;
    if (picture == first_picture) return; // also where all have -1: they address the atlas that is named
    if (picture < 0 || first_picture < 0)
      body.fail("face " + std::to_string(picture < 0 ? index : 0) + ": has no picture (texnumber " +
                std::to_string(std::min(picture, first_picture)) +
                "), others have: give it a place of the atlas, or read the mesh without one (" +
                option_name("atlas", "none") + ")");
    else
      body.fail("face " + std::to_string(index) + ": has texture " + std::to_string(picture) +
                ", others have " + std::to_string(first_picture) + ": expected one atlas for all faces");
  }

  uint64_t list_size(const PlyProperty &property) {
    const int64_t size = body.integer(property, property.count_type);
    if (size < 0 || !body.holds(static_cast<uint64_t>(size), property.type))
      body.fail("a list " + property.name + " of " + std::to_string(size) +
                " items does not fit into the file");
    return static_cast<uint64_t>(size);
  }

  void read_face(const PlyProperty &property, uint64_t index) {
    const auto face = [&] { return "face " + std::to_string(index); };
    const uint64_t size = list_size(property);
    if (size > 2 && size - 2 > limits.max_faces - mesh.face_count())
      body.fail(face() + ": more than the allowed " + std::to_string(limits.max_faces) + " triangles");
    corners.clear();
    for (uint64_t i = 0; i < size; i++)
      corners.push_back(vertex_of(body.integer(property, property.type), face()));
    if (size < 3) {
      report.lines_and_points++;
      return;
    }
    if (size > 3) polygons.push_back({mesh.face_count(), static_cast<uint32_t>(size)});
    append_fan(mesh, corners, report);
  }

  // Each vertex after the first two of a strip makes a triangle with the two before it; every second one is
  // turned round.
  void read_strips(const PlyProperty &property, uint64_t index) {
    const std::string strip = "strip " + std::to_string(index);
    uint32_t before[2] = {0, 0};
    size_t length = 0;
    for (uint64_t left = list_size(property); left; left--) {
      const int64_t corner = body.integer(property, property.type);
      if (corner == -1) {
        length = 0;
        continue;
      }
      const uint32_t vertex = vertex_of(corner, strip);
      if (length >= 2) {
        if (mesh.face_count() >= limits.max_faces)
          body.fail(strip + ": more than the allowed " + std::to_string(limits.max_faces) + " triangles");
        const bool turned = length % 2;
        mesh.faces.insert(mesh.faces.end(), {before[turned], before[!turned], vertex});
      }
      before[0] = before[1];
      before[1] = vertex;
      length++;
    }
  }

  uint32_t vertex_of(int64_t corner, const std::string &of) {
    if (corner < 0 || static_cast<uint64_t>(corner) >= header.vertex_count)
      body.fail(of + ": index " + std::to_string(corner) + " of " + std::to_string(header.vertex_count) +
                " vertices");
    return static_cast<uint32_t>(corner);
  }

  Body &body;
  const PlyHeader &header;
  const std::string &name;
  const fvv_limits &limits;
  MeshReport &report;
  MeshExtras *extras;
  std::vector<int64_t> *numbers_of_faces; // texnumber of each, or NULL
  PlyType colour_type = {};
  std::vector<double> of_points, sums; // R G B of each vertex; R G B and number of the faces around it
  Mesh mesh;
  std::vector<Polygon> polygons;
  std::vector<uint32_t> corners;   // of the last face
  std::vector<double> pairs;       // of that
  std::vector<double> of_corners;  // u v for each corner of mesh.faces, or empty; NaN: it has none
  std::vector<double> of_vertices; // normals, or empty
  int64_t first_picture = 0;
};

template <class Body>
Mesh read_body(std::string_view bytes, const PlyHeader &header, const std::string &name,
               const fvv_limits &limits, MeshReport &report, MeshExtras *extras,
               std::vector<int64_t> *numbers) {
  Body body(bytes.substr(header.size), header, name);
  return BodyReader<Body>(body, header, name, limits, report, extras, numbers).read();
}

// Without a byte order mark, and with LF where a file of old programs has CR alone: in the header, and in a
// body of text. kept: where the bytes are then.
std::string_view with_line_feeds(std::string_view bytes, std::string &kept) {
  if (bytes.substr(0, 3) == "\xef\xbb\xbf") bytes.remove_prefix(3);
  if (bytes.substr(0, 4) != "ply\r" || bytes.substr(4, 1) == "\n") return bytes;
  const size_t end = bytes.find("end_header\r");
  if (end == bytes.npos) return bytes;
  kept = bytes;
  const bool is_text = bytes.substr(0, end).find("format ascii") != bytes.npos;
  const auto last = is_text ? kept.end() : kept.begin() + std::ptrdiff_t(end + 11);
  std::replace(kept.begin(), last, '\r', '\n');
  return kept;
}

} // namespace

Mesh parse_ply(std::string_view bytes, const std::string &name, const fvv_limits *limits, MeshReport *report,
               bool texture, bool normals, MeshExtras *extras) {
  MeshReport ignored;
  const fvv_limits bounds = limits_or_default(limits);
  std::string kept;
  bytes = with_line_feeds(bytes, kept);
  const PlyHeader header = parse_ply_header(bytes, name, bounds, texture, normals, extras != nullptr);
  const auto read = header.format == PlyFormat::ascii ? read_body<AsciiBody> : read_body<BinaryBody>;
  return read(bytes, header, name, bounds, report ? *report : ignored, extras, nullptr);
}

PlyPictures ply_pictures(std::string_view bytes, const std::string &name) {
  std::string kept;
  bytes = with_line_feeds(bytes, kept);
  const fvv_limits bounds = limits_or_default(nullptr);
  PlyPictures out;
  try {
    out.names = parse_ply_header(bytes, name, bounds, false, false, false).pictures;
    (void)parse_ply_header(bytes, name, bounds, true, false, false);
    out.has_coordinates = true;
  } catch (const Error &) {} // those who read the mesh report what is wrong with it
  return out;
}

Mesh parse_ply_pictures(std::string_view bytes, const std::string &name, const fvv_limits *limits,
                        MeshReport *report, bool normals, FacePictures &faces) {
  MeshReport ignored;
  const fvv_limits bounds = limits_or_default(limits);
  std::string kept;
  bytes = with_line_feeds(bytes, kept);
  const PlyHeader header = parse_ply_header(bytes, name, bounds, true, normals, false);
  const auto read = header.format == PlyFormat::ascii ? read_body<AsciiBody> : read_body<BinaryBody>;
  std::vector<int64_t> numbers;
  Mesh mesh = read(bytes, header, name, bounds, report ? *report : ignored, nullptr, &numbers);
  numbers.resize(mesh.face_count(), 0);
  // Programs that know one picture alone write -1 of all faces.
  if (header.pictures.size() == 1 &&
      std::all_of(numbers.begin(), numbers.end(), [](int64_t number) { return number < 0; }))
    numbers.assign(numbers.size(), 0);
  for (const int64_t number : numbers) {
    FacePicture one;
    if (number >= int64_t(header.pictures.size()))
      throw Error(name + ": a face has texture " + std::to_string(number) + ", the file names " +
                  std::to_string(header.pictures.size()) + " (comment TextureFile)");
    std::string key;
    if (number < 0) {
      one.name = "faces without a picture";
      one.colour = {128, 128, 128};
    } else {
      key = one.name = picture_path(name, std::filesystem::path(name).parent_path().string(),
                                    header.pictures[size_t(number)], name);
      one.load = [path = one.name, name] {
        if (const std::string why = why_unreadable(path); !why.empty())
          throw Error(name + ": expected the picture " + quote(path) + " of TextureFile, which " + why +
                      "; " + option_name("atlas") + " names another, or none");
        return read_file(path, max_mesh_picture);
      };
    }
    faces.of_face.push_back(uint32_t(faces.add(std::move(one), key)));
  }
  return mesh;
}

std::string format_ply(const Mesh &mesh, const std::string &name, const std::vector<uint8_t> &colours) {
  geometry::check(mesh, name);
  const bool has_texture = !mesh.texture.empty(), has_normals = !mesh.normals.empty();
  const std::string header =
      "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(mesh.vertex_count()) +
      "\nproperty double x\nproperty double y\nproperty double z\n" +
      (has_normals ? "property double nx\nproperty double ny\nproperty double nz\n" : "") +
      (has_texture ? "property double s\nproperty double t\n" : "") +
      (colours.empty() ? "" : "property uchar red\nproperty uchar green\nproperty uchar blue\n") +
      "element face " + std::to_string(mesh.face_count()) +
      "\nproperty list uchar int vertex_indices\nend_header\n";
  std::string out = header;
  out.resize(header.size() + (mesh.positions.size() + mesh.normals.size() + mesh.texture.size()) * 8 +
             colours.size() + mesh.face_count() * 13);
  auto *at = reinterpret_cast<uint8_t *>(&out[header.size()]);
  const auto put = [&](double number) {
    store_f64(at, number);
    at += 8;
  };
  for (size_t vertex = 0; vertex < mesh.vertex_count(); vertex++) {
    for (size_t axis = 0; axis < 3; axis++) put(mesh.positions[vertex * 3 + axis]);
    for (size_t axis = 0; has_normals && axis < 3; axis++) put(mesh.normals[vertex * 3 + axis]);
    if (has_texture) {
      put(mesh.texture[vertex * 2]);
      put(1 - mesh.texture[vertex * 2 + 1]);
    }
    for (size_t channel = 0; !colours.empty() && channel < 3; channel++)
      *at++ = colours[vertex * 3 + channel];
  }
  for (size_t i = 0; i < mesh.faces.size(); i++) {
    if (i % 3 == 0) *at++ = 3;
    store_u32(at, mesh.faces[i]);
    at += 4;
  }
  return out;
}

} // namespace fvv::scene
