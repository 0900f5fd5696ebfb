// Wavefront OBJ, as far as polygon meshes go (Wavefront's "Advanced Visualizer" manual, appendix B1). Strict:
// a line that is not understood is an error, never a guess.

#include "fvv_cxx/untrusted.h"
#include "fvv_scene/file_io.h"
#include "scene/src/mesh_build.h"
#include "scene/src/mtl.h"
#include "scene/src/polygon.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <map>

namespace fvv::scene {

namespace {

// Keywords that do not change the surface: attributes of vertices, grouping, display.
constexpr std::string_view passed_over[] = {"g",      "o",          "s",         "usemap",
                                            "maplib", "mg",         "bevel",     "c_interp",
                                            "lod",    "shadow_obj", "trace_obj", "d_interp"};
// Keywords that shape the surface or bring in other files: to skip them would lose geometry silently.
constexpr std::string_view refused[] = {"vp",   "cstype", "deg",   "bmat", "step", "curv", "curv2", "surf",
                                        "parm", "trim",   "hole",  "scrv", "sp",   "end",  "con",   "call",
                                        "csh",  "ctech",  "stech", "bzp",  "bsp",  "cdc",  "cdp",   "res"};

template <size_t N> bool contains(const std::string_view (&list)[N], std::string_view word) {
  return std::find(std::begin(list), std::end(list), word) != std::end(list);
}

class ObjReader {
public:
  ObjReader(std::string_view bytes, const std::string &file, const fvv_limits &bounds, MeshReport &notes,
            bool with_texture, bool with_normals, bool with_colours = false, bool with_pictures = false)
      : cursor(bytes.data()), end(bytes.data() + bytes.size()), name(file), limits(bounds), report(notes),
        wants_texture(with_texture), wants_colours(with_colours), allows_bare(with_pictures),
        has_normals(with_normals), vertices{"vertex", bounds.max_vertices, 0, {}} {}

  Mesh read() {
    std::string_view keyword;
    while (cursor < end) {
      if (word(keyword)) statement(keyword);
      end_line();
    }
    check_forwards(vertices);
    check_forwards(pairs);
    if (has_normals) check_forwards(normals);
    if (mesh.faces.empty()) throw Error(name + ": expected at least one face (f), found none");
    settle_places();
    const ConcavePolygons concave(mesh, polygons, report, name);
    for (std::vector<uint32_t> *faces : {&mesh.faces, &chart.faces, &shading.faces}) concave.apply(*faces, 1);
    settle_pairs();
    if (wants_texture || has_normals)
      split_seams(mesh, of_corners(chart.faces, texture, 2),
                  has_normals ? of_corners(shading.faces, directions, 3) : std::vector<double>(), limits,
                  name);
    return std::move(mesh);
  }

  // After read(). R G B of each vertex, or empty.
  std::vector<uint8_t> vertex_colours() {
    // x y z w r g b, or x y z r g b a as some programs have it: weights are 1.
    if (colours.empty()) return {};
    colours.resize(4 * vertices.count, NAN);
    const bool weight_first =
        std::all_of(colours.begin(), colours.end(),
                    [&, i = size_t(0)](double w) mutable { return i++ % 4 != 0 || std::isnan(w) || w == 1; });
    std::vector<double> out;
    for (size_t v = 0; v < colours.size(); v += 4)
      out.insert(out.end(), &colours[v + weight_first], &colours[v + weight_first] + 3);
    return display_colours(out, white_of(out, false));
  }

  // After read(), of its mesh, if it has no colours of vertices: those of its materials. A vertex has the
  // mean of the faces around it. Empty: a material shows a picture, or none has a colour.
  std::vector<uint8_t> colours_of_materials(const Mesh &read) const {
    if (libraries.empty()) return {};
    std::vector<FacePicture> shown;
    try {
      shown = material_pictures(name, libraries, {materials_in_order.begin(), materials_in_order.end()});
    } catch (const Error &) {
      return {}; // those who read the pictures report it
    }
    bool has_colour = false;
    for (const FacePicture &one : shown) {
      if (!one.is_colour()) return {};
      has_colour = has_colour || one.has_colour;
    }
    if (!has_colour) return {};
    std::vector<double> sums(4 * read.vertex_count()), out;
    for (size_t i = 0; i < read.faces.size(); i++) {
      double *sum = &sums[4 * size_t(read.faces[i])];
      for (size_t k = 0; k < 3; k++) sum[k] += shown[face_materials[i / 3]].colour[k];
      sum[3]++;
    }
    for (size_t v = 0; v < sums.size(); v += 4)
      for (size_t k = 0; k < 3; k++) out.push_back(sums[v + 3] > 0 ? sums[v + k] / sums[v + 3] : NAN);
    return display_colours(out, 255);
  }

  // After read(): what the faces show. Throws Error where a face shows a picture and lacks coordinates.
  FacePictures face_pictures() {
    const std::vector<std::string_view> used(materials_in_order.begin(), materials_in_order.end());
    FacePictures out;
    std::vector<uint32_t> index;
    const std::vector<FacePicture> shown = material_pictures(name, libraries, used);
    for (const FacePicture &one : shown) {
      std::string key = one.name + (one.wrap[0] == Wrap::clamp ? " clamped" : "");
      if (one.is_colour()) key.assign(one.colour.begin(), one.colour.end());
      index.push_back(uint32_t(out.add(one, key)));
    }
    for (const uint32_t material_of_face : face_materials) out.of_face.push_back(index[material_of_face]);
    for (const auto &[first, last] : bare_faces) {
      if (!out.has_picture())
        throw Error(name +
                    ": expected faces with a picture, found none and corners without texture coordinates");
      const FacePicture &picture = shown[face_materials[first]];
      if (picture.is_colour()) continue;
      FacePicture plain;
      plain.name = "faces without texture coordinates";
      plain.colour = picture.colour;
      const auto of_faces = uint32_t(out.add(plain, std::string(plain.colour.begin(), plain.colour.end())));
      for (size_t face = first; face < last; face++) out.of_face[face] = of_faces;
      report.untextured += last - first;
    }
    return out;
  }

  // After read().
  ObjMaterials materials() const {
    std::vector<std::string_view> used = materials_in_order;
    std::sort(used.begin(), used.end());
    ObjMaterials out = read_materials(name, libraries, used);
    if (out.picture && !has_pairs) {
      out.missing.push_back("its faces have no texture coordinates");
      out.picture.reset();
    }
    return out;
  }

private:
  static std::vector<double> of_corners(const std::vector<uint32_t> &corners,
                                        const std::vector<double> &values, size_t width) {
    std::vector<double> out;
    out.reserve(corners.size() * width);
    for (const uint32_t i : corners)
      if (i == no_pair)
        out.insert(out.end(), width, 0.5);
      else
        out.insert(out.end(), &values[i * width], &values[i * width] + width);
    return out;
  }

  [[noreturn]] void fail(const std::string &what) const {
    throw Error(name + ":" + std::to_string(line) + ": " + what);
  }

  // A backslash before a line's end continues the line. Returns the bytes of both.
  size_t continuation() const {
    if (end - cursor >= 2 && cursor[1] == '\n') return 2;
    return end - cursor >= 3 && cursor[1] == '\r' && cursor[2] == '\n' ? 3 : 0;
  }

  // The next word of this line; false at its end or at a comment.
  bool word(std::string_view &text) {
    for (; cursor < end; cursor++) {
      if (*cursor == ' ' || *cursor == '\t' || *cursor == '\r') continue;
      const size_t joined = *cursor == '\\' ? continuation() : 0;
      if (!joined) break;
      line++;
      cursor += joined - 1;
    }
    const char *start = cursor;
    const auto ends_word = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '#'; };
    while (cursor < end && !ends_word(*cursor) && !(*cursor == '\\' && continuation())) cursor++;
    text = std::string_view(start, static_cast<size_t>(cursor - start));
    return !text.empty();
  }

  // Skips the rest of the line, including continued lines unless they are in a comment.
  void end_line() {
    bool comment = false;
    for (; cursor < end; cursor++) {
      if (*cursor == '#') comment = true;
      const size_t joined = *cursor == '\\' && !comment ? continuation() : 0;
      if (joined) {
        line++;
        cursor += joined - 1;
      } else if (*cursor == '\n') {
        line++;
        cursor++;
        return;
      }
    }
  }

  // The rest of the line as it is written, because names may have blanks.
  std::string_view rest_of_line() {
    std::string_view first, next;
    if (!word(first)) return {};
    const char *last = first.data() + first.size();
    while (word(next)) last = next.data() + next.size();
    return {first.data(), static_cast<size_t>(last - first.data())};
  }

  void use_material() {
    material = rest_of_line();
    is_used = false;
  }

  void statement(std::string_view keyword) {
    if (keyword == "v")
      vertex();
    else if (keyword == "vt")
      texture_pair();
    else if (keyword == "vn")
      normal();
    else if (keyword == "f" || keyword == "fo") // as old programs have it
      face();
    else if (keyword == "usemtl")
      use_material();
    else if (keyword == "mtllib")
      libraries.push_back(rest_of_line());
    else if (keyword == "l" || keyword == "p")
      report.lines_and_points++;
    else if (contains(refused, keyword))
      fail("expected polygons, found " + quote(keyword) +
           ": free-form geometry and included files are not supported");
    else if (!contains(passed_over, keyword))
      fail("expected an OBJ keyword such as v or f, found " + quote(keyword));
  }

  static bool is_no_number(std::string_view text) {
    if (!text.empty() && (text[0] == '-' || text[0] == '+')) text.remove_prefix(1);
    const std::string small = lower(text);
    return small.substr(0, 3) == "nan" || small == "inf" || small == "infinity" ||
           small.substr(0, 3) == "1.#";
  }

  // The numbers of the line, of which the first ones are stored; returns their number. any: a number may also
  // be NaN or infinite, which is noted of v.
  template <size_t kept>
  size_t numbers_of_line(const char *keyword, double (&numbers)[kept], bool any = false) {
    size_t count = 0;
    for (std::string_view text; word(text); count++) {
      double value;
      if (any && is_no_number(text)) {
        value = NAN;
        if (count < 3 && keyword[1] == '\0' &&
            (no_numbers.empty() || no_numbers.back().vertex != mesh.vertex_count()))
          no_numbers.push_back({mesh.vertex_count(), line, text});
      } else if (!parse_double(text, value))
        fail("expected a finite number after " + std::string(keyword) + ", found " + quote(text));
      if (count < kept) numbers[count] = value;
    }
    return count;
  }

  // What is no number matters where a face uses it, and is reported where it is.
  void settle_places() {
    if (no_numbers.empty()) return;
    std::vector<bool> used(mesh.vertex_count());
    for (const uint32_t vertex : mesh.faces) used[vertex] = true;
    for (const NoNumber &one : no_numbers) {
      if (!used[one.vertex]) continue;
      line = one.line;
      fail("expected a finite number after v, found " + quote(one.text));
    }
    settle_unused(mesh, name);
  }

  // A corner whose texture coordinates are no numbers has none.
  void settle_pairs() {
    const auto is_pair = [&](uint32_t i) {
      return i == no_pair ||
             (std::isfinite(texture[2 * size_t(i)]) && std::isfinite(texture[2 * size_t(i) + 1]));
    };
    for (size_t i = 0; i < chart.faces.size(); i += 3) {
      uint32_t *face = &chart.faces[i];
      if (std::all_of(face, face + 3, is_pair)) continue;
      if (!allows_bare)
        throw Error(name + ": expected texture coordinates that are numbers, found others (vt) in triangle " +
                    std::to_string(i / 3));
      if (std::find(face, face + 3, no_pair) == face + 3) bare_faces.push_back({i / 3, i / 3 + 1});
      std::fill_n(face, 3, no_pair);
    }
  }

  void vertex() {
    double numbers[7];
    // Only places of vertices that faces use must be numbers.
    const size_t count = numbers_of_line("v", numbers, true);
    if (count < 3 || count == 5 || count > 7)
      fail("expected 3, 4, 6 or 7 numbers after v, found " + std::to_string(count));
    if (mesh.vertex_count() == limits.max_vertices)
      fail("more than the allowed " + std::to_string(limits.max_vertices) + " vertices");
    if (wants_colours && count >= 6) {
      colours.resize(4 * mesh.vertex_count(), NAN);
      if (count == 6) colours.push_back(1);
      colours.insert(colours.end(), numbers + 3, numbers + count);
    }
    mesh.positions.insert(mesh.positions.end(), numbers, numbers + 3);
    vertices.count++;
  }

  // OBJ counts v from the bottom of the picture; a third number is for solid textures.
  void texture_pair() {
    if (!wants_texture) return;
    double numbers[3] = {0, 0, 0};
    const size_t count = numbers_of_line("vt", numbers, true);
    if (count < 1 || count > 3) fail("expected 1 to 3 numbers after vt, found " + std::to_string(count));
    texture.insert(texture.end(), {numbers[0], 1 - numbers[1]});
    pairs.count++;
  }

  void normal() {
    if (!has_normals) return;
    double numbers[3];
    const size_t count = numbers_of_line("vn", numbers);
    if (count != 3) fail("expected 3 numbers after vn, found " + std::to_string(count));
    directions.insert(directions.end(), numbers, numbers + 3);
    normals.count++;
  }

  // What corners refer to by a number, and where they did so before it was defined. Only record indices
  // matter: the first that stays undefined is larger than all before it.
  struct Forward {
    uint64_t index, line;
  };
  struct Records {
    const char *what;
    uint64_t most, count;
    std::vector<Forward> forwards;
  };

  // given counts from 1, or backwards from the last one before it. Returns an index from 0.
  uint32_t resolve(int64_t given, Records &records) {
    const int64_t count = static_cast<int64_t>(records.count);
    const std::string what = records.what + std::string(" ");
    if (given < -count)
      fail(what + std::to_string(given) + " is used, " + std::to_string(count) + " precede it");
    const uint64_t index = static_cast<uint64_t>(given < 0 ? count + given + 1 : given);
    if (index > records.most)
      fail(what + std::to_string(index) + " is used, at most " + std::to_string(records.most) +
           " are allowed");
    std::vector<Forward> &forwards = records.forwards;
    if (index > records.count && (forwards.empty() || index > forwards.back().index))
      forwards.push_back({index, line});
    return static_cast<uint32_t>(index - 1);
  }

  void check_forwards(const Records &records) {
    for (const Forward &forward : records.forwards)
      if (forward.index > records.count) {
        line = forward.line;
        fail(records.what + std::string(" ") + std::to_string(forward.index) + " is used, the file has " +
             std::to_string(records.count));
      }
  }

  // One of v, v/vt, v//vn, v/vt/vn; all have to be integers other than 0, those that are used have to exist.
  void corner(std::string_view text) {
    const auto malformed = [&] { fail("expected v, v/vt, v//vn or v/vt/vn after f, found " + quote(text)); };
    int64_t indices[3] = {0, 0, 0};
    const char *at = text.data(), *stop = at + text.size();
    for (int part = 0;; part++) {
      // Some programs write v/, v// and v/0/0 where there are no texture coordinates and normals.
      const bool empty = part > 0 && (at == stop || (part == 1 && *at == '/'));
      if (!empty) {
        const auto [behind, error] = std::from_chars(at, stop, indices[part]);
        if (error != std::errc()) malformed();
        if (!part && !indices[part]) fail("expected indices that count from 1, found " + quote(text));
        at = behind;
      }
      if (at == stop) break;
      if (*at != '/' || part == 2) malformed();
      at++;
    }
    corners.push_back(resolve(indices[0], vertices));
    has_pairs = has_pairs || indices[1];
    has_normals = has_normals && indices[2];
    if (has_normals) corner_normals.push_back(resolve(indices[2], normals));
    if (!wants_texture) return;
    if (!indices[1] && !allows_bare)
      fail("expected v/vt or v/vt/vn, for every corner needs texture coordinates, found " + quote(text));
    is_bare = is_bare || !indices[1];
    corner_pairs.push_back(indices[1] ? resolve(indices[1], pairs) : no_pair);
  }

  void face() {
    corners.clear();
    corner_pairs.clear();
    corner_normals.clear();
    is_bare = false;
    for (std::string_view text; word(text);) corner(text);
    if (corners.empty()) fail("expected at least 1 corner after f, found none");
    if (corners.size() < 3) {
      report.lines_and_points++;
      return;
    }
    if (corners.size() - 2 > limits.max_faces - mesh.face_count())
      fail("more than the allowed " + std::to_string(limits.max_faces) + " triangles");
    if (corners.size() > 3) polygons.push_back({mesh.face_count(), uint32_t(corners.size())});
    append_fan(mesh, corners, report);
    if (!is_used) {
      const auto [place, is_new] = material_numbers.emplace(material, uint32_t(materials_in_order.size()));
      if (is_new) materials_in_order.push_back(material);
      material_index = place->second;
    }
    if (allows_bare || wants_colours) {
      if (is_bare) bare_faces.push_back({face_materials.size(), mesh.face_count()});
      face_materials.resize(mesh.face_count(), material_index);
    }
    is_used = true;
    MeshReport counted_already;
    if (wants_texture) append_fan(chart, corner_pairs, counted_already);
    if (has_normals) append_fan(shading, corner_normals, counted_already);
  }

  const char *cursor, *end;
  const std::string &name;
  const fvv_limits &limits;
  MeshReport &report;
  const bool wants_texture, wants_colours, allows_bare;
  std::vector<double> colours; // weight and R G B of each vertex up to the last one that has them
  bool has_pairs = false;      // some corner has texture coordinates
  bool has_normals;            // they are requested, and every corner so far has one
  uint64_t line = 1;
  std::string_view material;
  bool is_used = false; // by a face
  std::vector<std::string_view> libraries;
  std::map<std::string_view, uint32_t> material_numbers; // in materials_in_order
  std::vector<std::string_view> materials_in_order;
  // With unlike pictures: of each face; faces, from and to, with a corner without texture coordinates.
  std::vector<uint32_t> face_materials;
  std::vector<std::pair<size_t, size_t>> bare_faces;
  uint32_t material_index = 0;
  bool is_bare = false;
  static constexpr uint32_t no_pair = UINT32_MAX;
  std::vector<Polygon> polygons;
  struct NoNumber {
    size_t vertex;
    uint64_t line;
    std::string_view text;
  };
  std::vector<NoNumber> no_numbers; // among coordinates
  Mesh mesh, chart, shading;        // the same faces with indices of vertices, pairs, normals
  std::vector<double> texture, directions;
  std::vector<uint32_t> corners, corner_pairs, corner_normals; // of one face
  Records vertices, normals = {"normal", UINT32_MAX, 0, {}},
                    pairs = {"texture coordinate", UINT32_MAX, 0, {}};
};

} // namespace

Mesh parse_obj(std::string_view bytes, const std::string &name, const fvv_limits *limits, MeshReport *report,
               bool texture, bool normals, MeshExtras *extras) {
  MeshReport ignored;
  const fvv_limits bounds = limits_or_default(limits);
  std::string kept;
  ObjReader reader(as_usual(bytes, kept), name, bounds, report ? *report : ignored, texture, normals,
                   extras != nullptr);
  Mesh mesh = reader.read();
  if (extras) extras->colours = reader.vertex_colours();
  if (extras && extras->colours.empty()) extras->colours = reader.colours_of_materials(mesh);
  return mesh;
}

Mesh parse_obj_pictures(std::string_view bytes, const std::string &name, const fvv_limits *limits,
                        MeshReport *report, bool normals, FacePictures &faces) {
  MeshReport ignored;
  const fvv_limits bounds = limits_or_default(limits);
  std::string kept;
  ObjReader reader(as_usual(bytes, kept), name, bounds, report ? *report : ignored, true, normals, false,
                   true);
  Mesh mesh = reader.read();
  faces.replace_pictures(reader.face_pictures());
  return mesh;
}

ObjMaterials parse_obj_materials(std::string_view bytes, const std::string &name) {
  MeshReport ignored;
  const fvv_limits bounds = limits_or_default(nullptr);
  std::string kept;
  ObjReader reader(as_usual(bytes, kept), name, bounds, ignored, false, false);
  (void)reader.read();
  try {
    return reader.materials();
  } catch (const Error &error) {
    // OBJ files often come without what they name.
    throw Error(error.line() + "; " + option_name("atlas") + " names other pictures, or none");
  }
}

std::string format_obj(const Mesh &mesh, const std::string &name, const std::vector<uint8_t> &colours) {
  geometry::check(mesh, name);
  std::string out;
  for (size_t i = 0; i < mesh.positions.size(); i += 3) {
    out += 'v';
    for (size_t axis = 0; axis < 3; axis++) {
      out += ' ';
      append_double(out, mesh.positions[i + axis]);
    }
    for (size_t channel = 0; !colours.empty() && channel < 3; channel++) {
      out += ' ';
      append_double(out, colours[i + channel] / 255.0);
    }
    out += '\n';
  }
  for (size_t i = 0; i < mesh.texture.size(); i += 2) {
    out += "vt ";
    append_double(out, mesh.texture[i]);
    out += ' ';
    append_double(out, 1 - mesh.texture[i + 1]);
    out += '\n';
  }
  for (size_t i = 0; i < mesh.normals.size(); i += 3) {
    out += "vn";
    for (size_t axis = 0; axis < 3; axis++) {
      out += ' ';
      append_double(out, mesh.normals[i + axis]);
    }
    out += '\n';
  }
  for (size_t i = 0; i < mesh.faces.size(); i += 3) {
    out += 'f';
    for (size_t corner = 0; corner < 3; corner++) {
      const std::string index = std::to_string(uint64_t(mesh.faces[i + corner]) + 1);
      out.append(" ").append(index);
      if (!mesh.texture.empty()) out.append("/").append(index);
      if (!mesh.normals.empty()) out.append(mesh.texture.empty() ? "//" : "/").append(index);
    }
    out += '\n';
  }
  return out;
}

} // namespace fvv::scene
