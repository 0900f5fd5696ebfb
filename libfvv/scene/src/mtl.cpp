// Material libraries of Wavefront OBJ (Wavefront's "Advanced Visualizer" manual, "MTL material format"), and
// where the author of a file may lead the reader with them.

#include "scene/src/mtl.h"
#include "fvv_cxx/input_file.h"
#include "fvv_scene/file_io.h"
#include "scene/src/mesh_build.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <optional>
#include <set>

namespace fvv::scene {

namespace fs = std::filesystem;

namespace {

constexpr uint64_t max_library = uint64_t(1) << 24; // 100,000 materials

// Options of a map with one argument that changes nothing in a picture that is neither repeated nor filtered.
constexpr std::string_view skipped[] = {"-blendu", "-blendv", "-bm",      "-boost",
                                        "-cc",     "-clamp",  "-imfchan", "-texres"};
constexpr std::string_view clamp = "-clamp"; // of these; says what is beyond the picture

struct Numbers {
  std::string_view option;
  size_t most;
  double neutral[3];
};
constexpr Numbers numeric[] = {
    {"-mm", 2, {0, 1}}, {"-o", 3, {0, 0, 0}}, {"-s", 3, {1, 1, 1}}, {"-t", 3, {0, 0, 0}}};

std::string_view trimmed(std::string_view text) {
  const size_t first = text.find_first_not_of(" \t"), last = text.find_last_not_of(" \t");
  return first == text.npos ? std::string_view() : text.substr(first, last + 1 - first);
}

// A name as it is meant: without the quotes of some programs, with / where those on Windows write a
// backslash. Of a path on the machine that wrote it the name alone, because the file lies beside the others
// here.
std::string as_name(std::string_view text) {
  if (text.size() > 1 && (text.front() == '"' || text.front() == '\'') && text.back() == text.front())
    text = trimmed(text.substr(1, text.size() - 2));
  std::string name(text);
  std::replace(name.begin(), name.end(), '\\', '/');
  const bool is_absolute = !name.empty() && (name[0] == '/' || name.find(':') != name.npos);
  return is_absolute ? name.substr(name.find_last_of("/:") + 1) : name;
}

class MtlReader {
public:
  explicit MtlReader(const std::string &file) : name(file) {}

  MaterialPictures read(std::string_view bytes) {
    std::map<std::string_view, Named> named;
    for (std::string_view rest; next_line(bytes, rest); line++) {
      std::string_view word;
      if (!next_word(rest, word)) continue;
      // Programs disagree about capitals. What is none of these does not name the picture.
      const std::string keyword = lower(word);
      if (keyword == "newmtl") {
        material = trimmed(rest);
        if (material.empty()) fail("expected a name after newmtl, found none");
        continue;
      }
      const auto map = std::find(std::begin(colours), std::end(colours), keyword);
      if (map == std::end(colours)) continue;
      if (material.empty()) fail("expected newmtl before map_Kd");
      const auto rank = size_t(map - std::begin(colours));
      if (trimmed(rest).empty()) continue; // some programs write it of materials without a picture
      Named &best = named[material];       // of two lines the last one counts
      if (!best.line || rank <= best.rank) best = {rank, rest, line};
    }
    MaterialPictures pictures;
    for (const auto &[name_of_material, best] : named) {
      line = best.line;
      pictures.emplace(name_of_material, picture(best.rest));
    }
    return pictures;
  }

private:
  [[noreturn]] void fail(const std::string &what) const {
    throw Error(name + ":" + std::to_string(line) + ": " + what);
  }

  // What a material shows, best first: diffuse, then what some programs write in its place, ambient or
  // emitted.
  static constexpr std::string_view colours[] = {"map_kd", "map_ka", "map_ke"};
  struct Named {
    size_t rank = 0;
    std::string_view rest;
    uint64_t line = 0;
  };

  // Options, then a name, which may have blanks.
  MaterialPicture picture(std::string_view rest) {
    bool is_clamped = false;
    for (std::string_view after = rest, option; next_word(after, option) && option[0] == '-'; after = rest) {
      const auto numbers = std::find_if(std::begin(numeric), std::end(numeric),
                                        [&](const Numbers &one) { return one.option == option; });
      if (numbers != std::end(numeric))
        skip_neutral(*numbers, after);
      else if (std::find(std::begin(skipped), std::end(skipped), option) == std::end(skipped))
        fail("expected the name of a picture after map_Kd, found the unknown option " + quote(option));
      else if (std::string_view argument; !next_word(after, argument))
        fail("expected an argument of " + std::string(option) + ", found none");
      else if (option == clamp)
        is_clamped = lower(argument) == "on";
      rest = after;
    }
    std::string file = as_name(trimmed(rest));
    if (file.empty()) fail("expected the name of a picture after map_Kd, found none");
    if (file.find('\0') != file.npos)
      fail("expected a picture below the folder of the OBJ file or in one beside it, found " + quote(file));
    return {file, is_clamped};
  }

  // The last word of a line is the name of the picture, even if it is a number.
  void skip_neutral(const Numbers &numbers, std::string_view &rest) const {
    for (size_t i = 0; i < numbers.most; i++) {
      std::string_view after = rest, word;
      double value;
      if (!next_word(after, word) || trimmed(after).empty() || !parse_double(word, value)) return;
      if (value != numbers.neutral[i])
        fail("expected a picture as it is, found " + std::string(numbers.option) + " with " + quote(word) +
             ": bake the option into the picture or the texture coordinates");
      rest = after;
    }
  }

  const std::string &name;
  uint64_t line = 1;
  std::string_view material;
};

// ---- files ---------------------------------------------------------------------------------------------

// Directly in a folder beside this one: meshes/0000.obj and atlas/0000.png.
bool is_beside(const fs::path &folder, const fs::path &path) {
  const fs::path own = resolved(folder), other = resolved(path).parent_path();
  return own.has_relative_path() && other.has_relative_path() && other.parent_path() == own.parent_path();
}

// The file of this name, or the only one that differs from it in capitals, as on Windows and macOS; the name
// itself if there is neither.
fs::path find_file(const fs::path &folder, const fs::path &name) {
  std::error_code ignored;
  if (fs::exists(folder / name, ignored)) return folder / name;
  fs::path here = folder;
  for (const fs::path &step : name) {
    if (fs::exists(here / step, ignored)) {
      here /= step;
      continue;
    }
    std::optional<fs::path> only;
    size_t found = 0;
    fs::directory_iterator entry(here.empty() ? fs::path(".") : here, ignored), end;
    for (; !ignored && entry != end; entry.increment(ignored))
      if (lower(entry->path().filename().string()) == lower(step.string())) {
        only = entry->path().filename();
        found++;
      }
    if (found != 1) return folder / name;
    here /= *only;
  }
  return here;
}

// find_file(), else the file of that name alone: folders of the machine that wrote it are often gone.
fs::path find_moved(const fs::path &folder, const fs::path &name) {
  std::error_code ignored;
  const fs::path path = find_file(folder, name);
  if (fs::exists(path, ignored) || !name.has_filename()) return path;
  const fs::path alone = find_file(folder, name.filename());
  return fs::exists(alone, ignored) ? alone : path;
}

// The names in what follows mtllib: one with blanks, if there is such a file or it is in quotes, else each
// word.
std::vector<std::string> names_of(const fs::path &folder, std::string_view text) {
  std::error_code ignored;
  std::vector<std::string> names;
  const std::string whole = as_name(text);
  if (text.find('\0') == text.npos &&
      (text.front() == '"' || fs::is_regular_file(find_file(folder, whole), ignored)))
    return {whole};
  for (std::string_view word; next_word(text, word);) names.push_back(as_name(word));
  return names;
}

} // namespace

MaterialPictures parse_mtl(std::string_view bytes, const std::string &name) {
  return MtlReader(name).read(bytes);
}

std::map<std::string, std::array<uint8_t, 3>, std::less<>> parse_mtl_colours(std::string_view bytes) {
  std::map<std::string, std::array<uint8_t, 3>, std::less<>> out;
  std::string material;
  for (std::string_view rest, word; next_line(bytes, rest);) {
    if (!next_word(rest, word)) continue;
    const std::string keyword = lower(word);
    if (keyword == "newmtl") material = trimmed(rest);
    if (keyword != "kd") continue;
    std::array<uint8_t, 3> colour = {};
    bool is_colour = true;
    for (uint8_t &value : colour) {
      double number = 0;
      is_colour = is_colour && next_word(rest, word) && parse_double(word, number);
      value = uint8_t(std::floor(std::clamp(number, 0.0, 1.0) * 255 + 0.5));
    }
    if (is_colour) out.emplace(material, colour);
  }
  return out;
}

std::string picture_path(const std::string &mesh, const std::string &folder, const std::string &name,
                         const std::string &where) {
  const fs::path own = fs::path(mesh).parent_path(),
                 path = find_moved(folder, as_name(name)).lexically_normal();
  // The author of a file must not choose what else is read.
  if (name.find('\0') != name.npos || (!is_below(own, path) && !is_beside(own, path)))
    throw Error(where + ": expected a picture below the folder of " + mesh + " or in one beside it, found " +
                quote(name));
  return path.string();
}

namespace {

// What the libraries of an OBJ file say, by material.
struct Materials {
  std::vector<std::string> libraries, missing; // as ObjMaterials has them
  MaterialPictures pictures;                   // with their paths
  std::map<std::string, std::array<uint8_t, 3>, std::less<>> colours;

  std::optional<MaterialPicture> picture_of(std::string_view material) const {
    const auto found = pictures.find(material);
    return found == pictures.end() ? std::nullopt : std::optional<MaterialPicture>(found->second);
  }
  // Of faces without a material, or with one that no library has: the picture of all materials, if that is
  // but one.
  std::optional<MaterialPicture> only_picture() const {
    std::set<std::string> all;
    for (const auto &[material, picture] : pictures) all.insert(picture.file);
    return all.size() == 1 ? std::optional<MaterialPicture>(pictures.begin()->second) : std::nullopt;
  }
};

Materials load_libraries(const std::string &obj, const std::vector<std::string_view> &libraries) {
  Materials out;
  // The author of a file must not choose what else is read.
  const fs::path folder = fs::path(obj).parent_path();
  for (const std::string_view text : libraries) {
    if (text.empty()) continue;
    for (const std::string &name : names_of(folder, text)) {
      const fs::path library = find_moved(folder, name);
      if (name.find('\0') != name.npos || !is_below(folder, library))
        throw Error(obj + ": expected the library of mtllib below the folder of the file, found " +
                    quote(name));
      if (const std::string why = why_unreadable(library.string()); !why.empty()) {
        out.missing.push_back("the library " + quote(name) + " of mtllib " + why);
        continue;
      }
      std::string kept;
      const std::string file = library.string(), stored = read_file(file, max_library);
      const std::string_view bytes = as_usual(stored, kept);
      out.libraries.push_back(file);
      for (auto &[material, picture] : parse_mtl(bytes, file)) {
        picture.file = picture_path(obj, library.parent_path().string(), picture.file, file);
        out.pictures.emplace(material, std::move(picture));
      }
      out.colours.merge(parse_mtl_colours(bytes));
    }
  }
  return out;
}

constexpr std::array<uint8_t, 3> grey = {128, 128, 128};

} // namespace

std::vector<FacePicture> material_pictures(const std::string &obj,
                                           const std::vector<std::string_view> &libraries,
                                           const std::vector<std::string_view> &used) {
  const Materials materials = load_libraries(obj, libraries);
  const bool any = std::any_of(used.begin(), used.end(), [&](std::string_view material) {
    return materials.picture_of(material).has_value();
  });
  std::vector<FacePicture> out;
  for (const std::string_view material : used) {
    std::optional<MaterialPicture> picture = materials.picture_of(material);
    if (!any) picture = materials.only_picture();
    const auto colour = materials.colours.find(material);
    FacePicture one;
    one.name = picture ? picture->file : "material " + quote(material);
    if (picture && picture->is_clamped) one.wrap = {Wrap::clamp, Wrap::clamp};
    one.has_colour = colour != materials.colours.end();
    one.colour = one.has_colour ? colour->second : grey;
    if (picture)
      one.load = [path = picture->file, obj] {
        if (const std::string why = why_unreadable(path); !why.empty())
          throw Error(obj + ": expected the picture " + quote(path) + " of map_Kd, which " + why + "; " +
                      option_name("atlas") + " names another, or none");
        return read_file(path, max_mesh_picture);
      };
    out.push_back(one);
  }
  return out;
}

ObjMaterials read_materials(const std::string &obj, const std::vector<std::string_view> &libraries,
                            const std::vector<std::string_view> &used) {
  Materials materials = load_libraries(obj, libraries);
  ObjMaterials out;
  for (const std::string_view material : used)
    if (const auto picture = materials.picture_of(material); picture && !out.picture)
      out.picture = picture->file;
  if (const auto only = materials.only_picture(); only && !out.picture) out.picture = only->file;
  out.libraries = std::move(materials.libraries);
  out.missing = std::move(materials.missing);
  if (!out.picture && !materials.pictures.empty())
    out.missing.push_back("its faces have no material of its libraries, which name " +
                          std::to_string(materials.pictures.size()) + " pictures");
  return out;
}

} // namespace fvv::scene
