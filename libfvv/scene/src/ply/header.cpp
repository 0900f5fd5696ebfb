// The header of a PLY file, checked completely, counts against the size of the file included.

#include "scene/src/ply/header.h"

#include "fvv_cxx/untrusted.h"
#include "fvv_scene/file_io.h"
#include "fvv_scene/mesh_file.h"
#include "scene/src/mesh_build.h"
#include "scene/src/mtl.h"

#include <algorithm>
#include <cinttypes>
#include <set>

namespace fvv::scene {

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
               bool with_normals, bool with_colours)
      : whole(bytes), rest(bytes), name(file), limits(bounds), wants_texture(with_texture),
        wants_normals(with_normals), wants_colours(with_colours) {}

  PlyHeader read() {
    next();
    if (trimmed_name(text) != "ply" && trimmed_name(text) != "PLY")
      fail("expected ply in the first line, found " + quote(text));
    while (next_is_remark()) {}
    read_format();
    for (;;) {
      if (next_is_remark()) continue;
      std::string_view words = text, keyword;
      next_word(words, keyword);
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
    if (wants_colours && !find_colours(find("vertex")) && has("face")) (void)find_colours(find("face"));
    check_counts();
    return std::move(header);
  }

private:
  [[noreturn]] void fail(const std::string &what) const {
    throw Error(name + ":" + std::to_string(line) + ": " + what);
  }

  // A header line always ends in LF: a file cut inside end_header must not pass for a whole header.
  void next() {
    line++;
    if (rest.find('\n') == std::string_view::npos)
      fail(line == 1 ? "expected ply in the first line, found " + quote(rest)
                     : "the file ends within the header");
    next_line(rest, text);
  }

  // Takes the next line. Some programs write comments before the format, and empty lines.
  bool next_is_remark() {
    next();
    std::string_view words = text, keyword, first;
    if (!next_word(words, keyword)) return true;
    if (keyword != "comment" && keyword != "obj_info") return false;
    std::string_view file = words;
    if (next_word(file, first) && (lower(first) == "texturefile" || lower(first) == "texturefile:"))
      header.pictures.push_back(trimmed_name(file));
    return true;
  }

  static std::string trimmed_name(std::string_view text) {
    const size_t first = text.find_first_not_of(" \t\r"), last = text.find_last_not_of(" \t\r");
    return first == text.npos ? std::string() : std::string(text.substr(first, last + 1 - first));
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
    std::string_view words = text;
    if (take(words, "format") != "format") fail("expected format after ply, found " + quote(text));
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
    if (!elements.insert(element).second) fail("element " + quote(element) + " is declared twice");
    properties.clear();
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
    if (!properties.insert(property.name).second)
      fail("property " + quote(property.name) + " is declared twice");
    property.role = role_of(element, property);
    element.properties.push_back(property);
  }

  static bool is_list_of_vertices(const PlyProperty &property) {
    return property.name == "vertex_indices" || property.name == "vertex_index";
  }

  PlyRole role_of(const PlyElement &element, const PlyProperty &property) const {
    PlyRole role = PlyRole::unused;
    if (element.name == "vertex") {
      if (property.name == "x") role = PlyRole::x;
      if (property.name == "y") role = PlyRole::y;
      if (property.name == "z") role = PlyRole::z;
      if (role != PlyRole::unused && property.is_list())
        fail("expected a number for " + property.name + ", found a list");
    } else if (element.name == "tristrips" && is_list_of_vertices(property)) {
      role = PlyRole::strips;
      if (!property.is_list() || property.type.is_float)
        fail("expected a list of integers for " + property.name);
    } else if (element.name == "face" && is_list_of_vertices(property)) {
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
    throw Error(name + ": expected an element " + element + ", found none");
  }

  void check_role(const PlyElement &element, PlyRole role, const char *what) const {
    for (const PlyProperty &property : element.properties)
      if (property.role == role) return;
    throw Error(name + ":" + std::to_string(element.line) + ": expected element " + element.name +
                " to have " + what);
  }

  void check_limit(const PlyElement &element, uint64_t limit) {
    line = element.line;
    if (element.count > limit)
      fail(std::to_string(element.count) + " elements " + quote(element.name) + ", at most " +
           std::to_string(limit) + " are allowed");
  }

  bool has(const char *element) const {
    return std::any_of(header.elements.begin(), header.elements.end(),
                       [&](const PlyElement &one) { return one.name == element && one.count; });
  }

  void check_mesh() {
    const PlyElement &vertex = find("vertex");
    check_role(vertex, PlyRole::x, "property x");
    check_role(vertex, PlyRole::y, "property y");
    check_role(vertex, PlyRole::z, "property z");
    check_limit(vertex, limits.max_vertices);
    header.vertex_count = vertex.count;
    if (has("tristrips")) {
      check_role(find("tristrips"), PlyRole::strips, "a list vertex_indices");
      if (!has("face")) return;
    }
    const PlyElement &face = find("face");
    check_role(face, PlyRole::corners, "a list vertex_indices");
    check_limit(face, limits.max_faces);
    header.face_count = face.count;
    if (!face.count) fail("expected at least one face, found none");
  }

  static PlyProperty *property_of(PlyElement &element, const char *property) {
    for (PlyProperty &candidate : element.properties)
      if (lower(candidate.name) == property) return &candidate; // programs disagree about capitals
    return nullptr;
  }

  // Pairs of the corners distinguish seams, which those of the vertices cannot.
  void find_texture() {
    PlyElement &vertex = find("vertex");
    const bool has_faces = has("face");
    if (PlyProperty *list = has_faces ? property_of(find("face"), "texcoord") : nullptr) {
      PlyElement &face = find("face");
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

  static bool find_colours(PlyElement &element) {
    constexpr const char *triples[][3] = {{"red", "green", "blue"},
                                          {"diffuse_red", "diffuse_green", "diffuse_blue"},
                                          {"r", "g", "b"},
                                          {"ambient_red", "ambient_green", "ambient_blue"}};
    for (const auto &names : triples) {
      PlyProperty *found[3];
      bool is_colour = true;
      for (size_t k = 0; k < 3; k++) {
        found[k] = property_of(element, names[k]);
        is_colour = is_colour && found[k] && !found[k]->is_list();
      }
      for (size_t k = 0; is_colour && k < 3; k++)
        found[k]->role = static_cast<PlyRole>(static_cast<int>(PlyRole::red) + static_cast<int>(k));
      if (is_colour) return true;
    }
    return false;
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
          checked_multiply(element.count, smallest(element), &bytes) && checked_add(needed, bytes, &needed);
      // The last separator of an ASCII file may be missing.
      const uint64_t spare = header.format == PlyFormat::ascii ? 1 : 0;
      if (!fits || needed > rest.size() + spare)
        fail(std::to_string(element.count) + " elements " + quote(element.name) + " do not fit into the " +
             std::to_string(rest.size()) + " bytes after the header");
    }
  }

  std::string_view whole, rest, text;
  const std::string &name;
  const fvv_limits &limits;
  const bool wants_texture, wants_normals, wants_colours;
  std::set<std::string> elements, properties; // names: of all elements, of the properties of the last one
  uint64_t line = 0;
  PlyHeader header = {};
};

} // namespace

PlyHeader parse_ply_header(std::string_view bytes, const std::string &name, const fvv_limits &limits,
                           bool texture, bool normals, bool colours) {
  return HeaderReader(bytes, name, limits, texture, normals, colours).read();
}

} // namespace fvv::scene
