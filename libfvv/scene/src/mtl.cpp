// Material libraries of Wavefront OBJ (Wavefront's "Advanced Visualizer" manual, "MTL material format"), and
// where the author of a file may lead the reader with them.

#include "scene/src/mtl.h"
#include "fvv_cxx/input_file.h"
#include "fvv_scene/file_io.h"

#include <algorithm>
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
  if (text.size() > 1 && text.front() == '"' && text.back() == '"')
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
      Named &best = named[material];
      if (!best.line || rank < best.rank) best = {rank, rest, line};
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
  std::string picture(std::string_view rest) {
    for (std::string_view after = rest, option; next_word(after, option) && option[0] == '-'; after = rest) {
      const auto numbers = std::find_if(std::begin(numeric), std::end(numeric),
                                        [&](const Numbers &one) { return one.option == option; });
      if (numbers != std::end(numeric))
        skip_neutral(*numbers, after);
      else if (std::find(std::begin(skipped), std::end(skipped), option) == std::end(skipped))
        fail("expected the name of a picture after map_Kd, found the unknown option " + quote(option));
      else if (std::string_view argument; !next_word(after, argument))
        fail("expected an argument of " + std::string(option) + ", found none");
      rest = after;
    }
    std::string file = as_name(trimmed(rest));
    if (file.empty()) fail("expected the name of a picture after map_Kd, found none");
    if (file.find('\0') != file.npos)
      fail("expected a picture below the folder of the OBJ file or in one beside it, found " + quote(file));
    return file;
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

ObjMaterials read_materials(const std::string &obj, const std::vector<std::string_view> &libraries,
                            const std::vector<std::string_view> &used) {
  ObjMaterials out;
  // The author of a file must not choose what else is read.
  const fs::path folder = fs::path(obj).parent_path();
  std::map<std::string, std::string, std::less<>> pictures; // paths
  for (const std::string_view text : libraries) {
    if (text.empty()) continue;
    for (const std::string &name : names_of(folder, text)) {
      const fs::path library = find_file(folder, name);
      if (name.find('\0') != name.npos || !is_below(folder, library))
        throw Error(obj + ": expected the library of mtllib below the folder of the file, found " +
                    quote(name));
      if (const std::string why = why_unreadable(library.string()); !why.empty()) {
        out.missing.push_back("the library " + quote(name) + " of mtllib " + why);
        continue;
      }
      const std::string file = library.string();
      out.libraries.push_back(file);
      for (auto &[material, picture] : parse_mtl(read_file(file, max_library), file)) {
        const fs::path path = find_file(library.parent_path(), picture).lexically_normal();
        if (!is_below(folder, path) && !is_beside(folder, path))
          throw Error(file + ": expected a picture below the folder of " + obj +
                      " or in one beside it, found " + quote(picture));
        pictures.emplace(material, path.string());
      }
    }
  }
  const auto picture_of = [&](std::string_view material) {
    const auto found = pictures.find(material);
    return found == pictures.end() ? std::nullopt : std::optional<std::string>(found->second);
  };
  std::set<std::string> shown, all;
  for (const auto &[material, picture] : pictures) all.insert(picture);
  bool without = false;
  for (const std::string_view material : used)
    if (const auto picture = picture_of(material))
      shown.insert(*picture);
    else
      without = true;
  if (shown.size() > 1 || (without && !shown.empty()))
    throw Error(obj + ": expected one picture (map_Kd) for all faces, found " + *shown.begin() + " and " +
                (without ? "none" : *shown.rbegin()) + ": bake one atlas of them");
  // Faces without a material, or with one that no library has: the picture is that of all materials, if there
  // is but one.
  if (shown.empty() && all.size() == 1) shown = all;
  if (shown.empty() && all.size() > 1)
    out.missing.push_back("its faces have no material of its libraries, which name " +
                          std::to_string(all.size()) + " pictures");
  if (!shown.empty()) out.picture = *shown.begin();
  return out;
}

} // namespace fvv::scene
