// capture/ply_header.cpp: the header of a PLY file (Greg Turk, "The PLY polygon file format", 1994).
#include "capture/ply_header.h"
#include "capture/text_scan.h"

extern "C" {
#include "base/checked.h"
}

#include <algorithm>

namespace fvv::capture {

namespace {

struct NamedType {
  std::string_view name, alias;
  PlyType type;
};
constexpr NamedType types[] = {
    {"char", "int8", {1, false, true}},    {"uchar", "uint8", {1, false, false}},
    {"short", "int16", {2, false, true}},  {"ushort", "uint16", {2, false, false}},
    {"int", "int32", {4, false, true}},    {"uint", "uint32", {4, false, false}},
    {"float", "float32", {4, true, true}}, {"double", "float64", {8, true, true}},
};

class HeaderReader {
public:
  HeaderReader(std::string_view bytes, const std::string &file, const fvv_limits &bounds, bool with_texture,
               bool with_normals)
      : whole(bytes), rest(bytes), name(file), limits(bounds), wants_texture(with_texture),
        wants_normals(with_normals) {}

  PlyHeader read() {
    next();
    if (text != "ply") fail("expected ply in the first line, found " + quote(text));
    read_format();
    for (;;) {
      next();
      std::string_view words = text, keyword;
      if (!next_word(words, keyword))
        fail("expected element, property, comment or end_header, found nothing");
      if (keyword == "comment" || keyword == "obj_info") continue;
      if (keyword == "end_header") break;
      if (keyword == "element")
        read_element(words);
      else if (keyword == "property")
        read_property(words);
      else
        fail("expected element, property, comment or end_header, found " + quote(keyword));
    }
    header.size = whole.size() - rest.size();
    header.lines = line;
    check_mesh();
    if (wants_texture) find_texture();
    if (wants_normals) find_normals();
    check_counts();
    return std::move(header);
  }

private:
  [[noreturn]] void fail(const std::string &what) const {
    throw FileError(name + ":" + std::to_string(line) + ": " + what);
  }

  // A header line always ends in LF: a file cut inside end_header must not pass for a whole header.
  void next() {
    line++;
    if (rest.find('\n') == std::string_view::npos)
      fail(line == 1 ? "expected ply in the first line, found " + quote(rest)
                     : "the file ends within the header");
    next_line(rest, text);
  }

  std::string_view take(std::string_view &words, const char *what) const {
    std::string_view word;
    if (!next_word(words, word)) fail(std::string("expected ") + what + ", found the end of the line");
    return word;
  }

  void end(std::string_view words) const {
    std::string_view word;
    if (next_word(words, word)) fail("expected the end of the line, found " + quote(word));
  }

  void read_format() {
    next();
    std::string_view words = text;
    if (take(words, "format") != "format") fail("expected format in the second line, found " + quote(text));
    const std::string_view format = take(words, "ascii, binary_little_endian or binary_big_endian");
    if (format == "ascii")
      header.format = PlyFormat::ascii;
    else if (format == "binary_little_endian")
      header.format = PlyFormat::little_endian;
    else if (format == "binary_big_endian")
      header.format = PlyFormat::big_endian;
    else
      fail("expected ascii, binary_little_endian or binary_big_endian, found " + quote(format));
    const std::string_view version = take(words, "version 1.0");
    if (version != "1.0") fail("expected version 1.0, found " + quote(version));
    end(words);
  }

  void read_element(std::string_view words) {
    const std::string element(take(words, "the name of an element"));
    const std::string_view digits = take(words, "a count");
    int64_t count;
    if (!parse_integer(digits, count) || count < 0)
      fail("expected the number of elements " + quote(element) + ", found " + quote(digits));
    end(words);
    for (const PlyElement &other : header.elements)
      if (other.name == element) fail("element " + quote(element) + " is declared twice");
    header.elements.push_back({element, static_cast<uint64_t>(count), line, {}});
  }

  PlyType read_type(std::string_view &words) const {
    const std::string_view word = take(words, "a type");
    for (const NamedType &type : types)
      if (word == type.name || word == type.alias) return type.type;
    fail("expected a type such as float or uchar, found " + quote(word));
  }

  void read_property(std::string_view words) {
    if (header.elements.empty()) fail("expected an element before its properties");
    PlyElement &element = header.elements.back();
    PlyProperty property = {"", {}, {}, PlyRole::unused};
    std::string_view peek = words;
    if (take(peek, "a type") == "list") {
      words = peek;
      property.count_type = read_type(words);
      if (property.count_type.is_float) fail("expected an integer type for the length of a list");
    }
    property.type = read_type(words);
    property.name = take(words, "the name of a property");
    end(words);
    for (const PlyProperty &other : element.properties)
      if (other.name == property.name) fail("property " + quote(property.name) + " is declared twice");
    property.role = role_of(element, property);
    element.properties.push_back(property);
  }

  PlyRole role_of(const PlyElement &element, const PlyProperty &property) const {
    PlyRole role = PlyRole::unused;
    if (element.name == "vertex") {
      if (property.name == "x") role = PlyRole::x;
      if (property.name == "y") role = PlyRole::y;
      if (property.name == "z") role = PlyRole::z;
      if (role != PlyRole::unused && property.is_list())
        fail("expected a number for " + property.name + ", found a list");
    } else if (element.name == "face" &&
               (property.name == "vertex_indices" || property.name == "vertex_index")) {
      role = PlyRole::corners;
      if (!property.is_list() || property.type.is_float)
        fail("expected a list of integers for " + property.name);
      for (const PlyProperty &other : element.properties)
        if (other.role == role) fail("expected one of vertex_indices and vertex_index, found both");
    }
    return role;
  }

  PlyElement &find(const char *element) {
    for (PlyElement &candidate : header.elements)
      if (candidate.name == element) return candidate;
    throw FileError(name + ": expected an element " + element + ", found none");
  }

  void check_role(const PlyElement &element, PlyRole role, const char *what) const {
    for (const PlyProperty &property : element.properties)
      if (property.role == role) return;
    throw FileError(name + ":" + std::to_string(element.line) + ": expected element " + element.name +
                    " to have " + what);
  }

  void check_limit(const PlyElement &element, uint64_t limit) {
    line = element.line;
    if (element.count > limit)
      fail(std::to_string(element.count) + " elements " + quote(element.name) + ", at most " +
           std::to_string(limit) + " are allowed");
  }

  void check_mesh() {
    const PlyElement &vertex = find("vertex"), &face = find("face");
    check_role(vertex, PlyRole::x, "property x");
    check_role(vertex, PlyRole::y, "property y");
    check_role(vertex, PlyRole::z, "property z");
    check_role(face, PlyRole::corners, "a list vertex_indices");
    check_limit(vertex, limits.max_vertices);
    check_limit(face, limits.max_faces);
    header.vertex_count = vertex.count;
    header.face_count = face.count;
    if (!face.count) fail("expected at least one face, found none");
    for (const PlyElement &element : header.elements)
      if (element.name == "tristrips" && element.count) {
        line = element.line;
        fail("expected polygons in element face, found triangle strips as well");
      }
  }

  static PlyProperty *property_of(PlyElement &element, const char *property) {
    for (PlyProperty &candidate : element.properties)
      if (candidate.name == property) return &candidate;
    return nullptr;
  }

  // Pairs of the corners tell seams apart, which those of the vertices cannot.
  void find_texture() {
    PlyElement &vertex = find("vertex"), &face = find("face");
    if (PlyProperty *list = property_of(face, "texcoord")) {
      line = face.line;
      if (!list->is_list() || !list->type.is_float) fail("expected a list of floats for texcoord");
      list->role = PlyRole::corner_texture;
      PlyProperty *picture = property_of(face, "texnumber");
      if (picture && !picture->is_list() && !picture->type.is_float) picture->role = PlyRole::texture_number;
      return;
    }
    constexpr const char *pairs[][2] = {{"texture_u", "texture_v"}, {"s", "t"}, {"u", "v"}};
    for (const auto &names : pairs) {
      PlyProperty *u = property_of(vertex, names[0]), *v = property_of(vertex, names[1]);
      if (!u || !v || u->is_list() || v->is_list()) continue;
      u->role = PlyRole::u;
      v->role = PlyRole::v;
      return;
    }
    line = vertex.line;
    fail("expected texture coordinates: properties s and t, u and v or texture_u and texture_v of the "
         "vertices, or a list texcoord of the faces; found none");
  }

  void find_normals() {
    PlyElement &vertex = find("vertex");
    PlyProperty *x = property_of(vertex, "nx"), *y = property_of(vertex, "ny"),
                *z = property_of(vertex, "nz");
    if (!x || !y || !z || x->is_list() || y->is_list() || z->is_list()) return;
    x->role = PlyRole::nx;
    y->role = PlyRole::ny;
    z->role = PlyRole::nz;
  }

  // The fewest bytes that one element can take. In ASCII every value takes a digit and a separator.
  uint64_t smallest(const PlyElement &element) const {
    uint64_t bytes = 0;
    for (const PlyProperty &property : element.properties)
      bytes += header.format == PlyFormat::ascii ? 2
               : property.is_list()              ? property.count_type.size
                                                 : property.type.size;
    return bytes;
  }

  void check_counts() {
    uint64_t needed = 0;
    for (const PlyElement &element : header.elements) {
      line = element.line;
      if (element.properties.empty() && element.count)
        fail("expected element " + quote(element.name) + " to have properties, found none");
      uint64_t bytes = 0;
      const bool fits =
          fvv_multiply_u64(element.count, smallest(element), &bytes) && fvv_add_u64(needed, bytes, &needed);
      // The last separator of an ASCII file may be missing.
      const uint64_t spare = header.format == PlyFormat::ascii ? 1 : 0;
      if (!fits || needed > rest.size() + spare)
        fail(std::to_string(element.count) + " elements " + quote(element.name) + " do not fit into the " +
             std::to_string(rest.size()) + " bytes behind the header");
    }
  }

  std::string_view whole, rest, text;
  const std::string &name;
  const fvv_limits &limits;
  const bool wants_texture, wants_normals;
  uint64_t line = 0;
  PlyHeader header = {};
};

} // namespace

PlyHeader parse_ply_header(std::string_view bytes, const std::string &name, const fvv_limits &limits,
                           bool texture, bool normals) {
  return HeaderReader(bytes, name, limits, texture, normals).read();
}

} // namespace fvv::capture
