// Material libraries of Wavefront OBJ (Wavefront's "Advanced Visualizer" manual, "MTL material format"), and
// where the author of a file may lead the reader with them.

#include "scene/src/mtl.h"
#include "fvv_cxx/input_file.h"
#include "fvv_scene/file_io.h"

#include <algorithm>
#include <filesystem>
#include <iterator>

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

class MtlReader {
public:
  explicit MtlReader(const std::string &file) : name(file) {}

  MaterialPictures read(std::string_view bytes) {
    for (std::string_view rest; next_line(bytes, rest); line++) {
      std::string_view word;
      if (!next_word(rest, word)) continue;
      // Programs disagree about capitals. What is neither of these two does not name the picture.
      const std::string keyword = lower(word);
      if (keyword == "newmtl") {
        material = trimmed(rest);
        if (material.empty()) fail("expected a name after newmtl, found none");
      } else if (keyword == "map_kd") {
        if (material.empty()) fail("expected newmtl before map_Kd");
        pictures.emplace(material, picture(rest));
      }
    }
    return std::move(pictures);
  }

private:
  [[noreturn]] void fail(const std::string &what) const {
    throw Error(name + ":" + std::to_string(line) + ": " + what);
  }

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
    std::string file(trimmed(rest));
    std::replace(file.begin(), file.end(), '\\', '/'); // as programs on Windows write it
    if (file.empty()) fail("expected the name of a picture after map_Kd, found none");
    if (file[0] == '/' || file.find(':') != file.npos || file.find('\0') != file.npos)
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
  MaterialPictures pictures;
};

// ---- files ---------------------------------------------------------------------------------------------

// Directly in a folder beside this one: meshes/0000.obj and atlas/0000.png.
bool is_beside(const fs::path &folder, const fs::path &path) {
  const fs::path own = resolved(folder), other = resolved(path).parent_path();
  return own.has_relative_path() && other.has_relative_path() && other.parent_path() == own.parent_path();
}

// The names in what follows mtllib: one with blanks, if there is such a file, else each word.
std::vector<std::string> names_of(const fs::path &folder, std::string_view text) {
  std::error_code ignored;
  std::vector<std::string> names;
  if (text.find('\0') == text.npos && fs::is_regular_file(folder / fs::path(text), ignored))
    return {std::string(text)};
  for (std::string_view word; next_word(text, word);) names.emplace_back(word);
  return names;
}

} // namespace

MaterialPictures parse_mtl(std::string_view bytes, const std::string &name) {
  return MtlReader(name).read(bytes);
}

ObjMaterials read_materials(const std::string &obj, const std::vector<std::string_view> &libraries,
                            const std::vector<std::string_view> &used) {
  ObjMaterials out;
  if (std::all_of(used.begin(), used.end(), [](std::string_view material) { return material.empty(); }))
    return out;
  // The author of a file must not choose what else is read.
  const fs::path folder = fs::path(obj).parent_path();
  std::map<std::string, std::string, std::less<>> pictures; // paths
  for (const std::string_view text : libraries)
    for (const std::string &name : names_of(folder, text)) {
      const fs::path library = folder / name;
      if (name.find('\0') != name.npos || !is_below(folder, library))
        throw Error(obj + ": expected the library of mtllib below the folder of the file, found " +
                    quote(name));
      if (const std::string why = why_unreadable(library.string()); !why.empty())
        throw Error(obj + ": expected the library " + quote(name) + " of mtllib, which " + why);
      const std::string file = library.string();
      out.libraries.push_back(file);
      for (auto &[material, picture] : parse_mtl(read_file(file, max_library), file)) {
        const fs::path path = (library.parent_path() / picture).lexically_normal();
        if (!is_below(folder, path) && !is_beside(folder, path))
          throw Error(file + ": expected a picture below the folder of " + obj +
                      " or in one beside it, found " + quote(picture));
        pictures.emplace(material, path.string());
      }
    }
  const auto picture_of = [&](std::string_view material) {
    const auto found = pictures.find(material);
    return found == pictures.end() ? std::nullopt : std::optional<std::string>(found->second);
  };
  for (const std::string_view material : used) {
    const std::optional<std::string> picture = picture_of(material), first = picture_of(used.front());
    if (picture != first)
      throw Error(obj + ": expected one picture (map_Kd) for all faces, found " + first.value_or("none") +
                  " and " + picture.value_or("none") + ": bake one atlas of them");
    out.picture = picture;
  }
  return out;
}

} // namespace fvv::scene
