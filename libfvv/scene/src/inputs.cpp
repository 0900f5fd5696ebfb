// From options and folders of other programs to the text of a capture.json, which is then read as any other.
#include "fvv_scene/inputs.h"
#include "fvv_cxx/format.h"
#include "fvv_scene/capture_keywords.h"
#include "fvv_scene/file_io.h"
#include "fvv_scene/import.h"
#include "scene/src/atlas/atlas.h"
#include "scene/src/capture_fields.h"
#include "scene/src/gltf/scene.h"
#include "scene/src/mtl.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <set>

namespace fvv::scene {

namespace fs = std::filesystem;

namespace {

constexpr const char *embedded = "embedded", *no_atlas = "none";

bool is_pattern_of_atlas(const std::string &text) {
  return !text.empty() && text != embedded && text != no_atlas;
}

[[noreturn]] void refuse(const char *option, const std::string &expected, const std::string &found) {
  refuse_option(option, "expected " + expected + ", found " + quote(found));
}

std::string extension_of(const std::string &name) {
  std::string extension = fs::path(name).extension().string();
  for (char &c : extension)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return extension;
}

bool is_one_of(const std::string &name, std::initializer_list<const char *> extensions) {
  const std::string extension = extension_of(name);
  return std::any_of(extensions.begin(), extensions.end(), [&](const char *one) { return extension == one; });
}

// transforms.json, or a part of a Blender set.
bool is_transforms(const std::string &name) {
  std::error_code ignored;
  return fs::path(name).filename().string().substr(0, 10) == "transforms" && is_one_of(name, {".json"}) &&
         fs::is_regular_file(name, ignored);
}

bool is_video(const std::string &name) {
  return is_one_of(name, {".mp4", ".mov", ".mkv", ".webm", ".avi"});
}

Pattern parse_pattern(const char *option, const std::string &text) {
  std::string what;
  const std::optional<Pattern> pattern = Pattern::parse(text, &what);
  if (!pattern) refuse_option(option, what);
  return *pattern;
}

// A pattern that means just this name.
std::string as_pattern(const std::string &name) {
  std::string out;
  for (const char c : name) out.append(c == '%' ? 2 : 1, c);
  return out;
}

// A pattern or, by its extension, a video.
PictureSource source_of(const char *option, const std::string &text) {
  if (is_video(text)) return VideoSource{text, std::nullopt, {}, 0};
  return parse_pattern(option, text);
}

// ---- frame numbers -------------------------------------------------------------------------------------

// The place of the number in a pattern's text.
size_t number_at(const std::string &text) {
  for (size_t i = 0; i + 1 < text.size(); i++)
    if (text[i] == '%') {
      if (text[i + 1] != '%') return i;
      i++;
    }
  return text.npos;
}

// The part of a numbered pattern up to the end of the folder or file with the number.
Pattern numbered_part(const Pattern &pattern) {
  const std::string &text = pattern.text();
  return *Pattern::parse(text.substr(0, text.find('/', number_at(text))), nullptr);
}

fs::path folder_of(const Pattern &part) {
  const fs::path parent = fs::path(part.file(0)).parent_path();
  return parent.empty() ? fs::path(".") : parent;
}

// Those of the files that a numbered pattern names, rising.
std::vector<int64_t> numbers_of(const Pattern &pattern) {
  const Pattern part = numbered_part(pattern);
  const fs::path parent = fs::path(part.file(0)).parent_path();
  std::vector<int64_t> numbers;
  std::error_code error;
  fs::directory_iterator entry(folder_of(part), error), end;
  for (; !error && entry != end; entry.increment(error)) {
    const auto number = part.frame((parent / entry->path().filename()).string());
    std::error_code ignored;
    if (number && *number <= INT32_MAX && fs::is_regular_file(pattern.file(*number), ignored))
      numbers.push_back(*number);
  }
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

// What is there in place of the files that were expected.
std::string found_instead(const Pattern &pattern) {
  const fs::path folder = folder_of(numbered_part(pattern));
  std::error_code error;
  std::string first;
  fs::directory_iterator entry(folder, error), end;
  if (error) return "found no folder " + folder.string();
  for (; !error && entry != end; entry.increment(error))
    if (const std::string name = entry->path().filename().string(); first.empty() || name < first)
      first = name;
  return first.empty() ? "found an empty folder" : "found " + quote(first);
}

struct Sequence {
  std::string subject; // for messages
  Pattern pattern;
};

// More than 1 if at least three numbers go in such steps without a gap: of two, one between them may be
// missing.
int64_t step_of(const std::set<int64_t> &numbers) {
  if (numbers.size() < 3) return 1;
  const int64_t step = *std::next(numbers.begin()) - *numbers.begin();
  for (auto here = numbers.begin(), next = std::next(here); next != numbers.end(); here = next++)
    if (*next - *here != step) return 1;
  return step;
}

// From the lowest to the highest number that any of these has, in the steps in which all of them go. Files
// that are missing between them are found when all files of the capture are checked.
Frames frames_of(const std::vector<Sequence> &sequences) {
  int64_t first = INT64_MAX, last = -1;
  std::set<int64_t> all;
  for (const Sequence &sequence : sequences) {
    const std::vector<int64_t> numbers = numbers_of(sequence.pattern);
    if (numbers.empty())
      throw Error(sequence.subject + ": expected files such as " + sequence.pattern.file(0) + ", " +
                  found_instead(sequence.pattern));
    first = std::min(first, numbers.front());
    last = std::max(last, numbers.back());
    all.insert(numbers.begin(), numbers.end());
  }
  Frames frames;
  frames.first = first;
  frames.step = step_of(all);
  frames.count = (last - first) / frames.step + 1;
  return frames;
}

// ---- folders of other programs -------------------------------------------------------------------------

struct Folder {
  std::vector<Camera> cameras; // with pictures, relative to the working folder
  std::string kind;            // for messages
  std::vector<std::string> notes;
};

// The pattern of the pictures beside one with a number in its name that differ from it in the number alone;
// none, if there are no others.
std::optional<std::string> sequence_of(const fs::path &picture) {
  const std::string stem = picture.stem().string();
  const size_t last = stem.find_last_of("0123456789");
  if (last == stem.npos) return std::nullopt;
  const size_t before = stem.find_last_not_of("0123456789", last);
  const size_t first = before == stem.npos ? 0 : before + 1, digits = last + 1 - first;
  if (digits > 9) return std::nullopt;
  std::optional<std::string> best;
  size_t most = 1;
  for (const std::string &number : {std::string("%d"), "%0" + std::to_string(digits) + "d"}) {
    const std::string name = as_pattern(stem.substr(0, first)) + number + as_pattern(stem.substr(last + 1)) +
                             as_pattern(picture.extension().string());
    const fs::path parent = as_pattern(picture.parent_path().string());
    const std::string text = (parent / name).string();
    const size_t count = numbers_of(*Pattern::parse(text, nullptr)).size();
    if (count <= most) continue;
    most = count;
    best = text;
  }
  return best;
}

// The pattern of exactly these files, if there is one; of a single file its name.
std::optional<std::string> pattern_of(const std::set<fs::path> &files) {
  if (files.size() == 1) return as_pattern(files.begin()->string());
  const std::optional<std::string> found = sequence_of(*files.begin());
  if (!found) return std::nullopt;
  const Pattern pattern = *Pattern::parse(*found, nullptr);
  std::set<fs::path> all;
  for (const int64_t number : numbers_of(pattern)) all.insert(pattern.file(number));
  return all == files ? found : std::nullopt;
}

// The files of m*.obj.
std::set<fs::path> matching(const fs::path &path, size_t star) {
  const std::string name = path.filename().string();
  const fs::path parent = path.parent_path();
  std::set<fs::path> out;
  std::error_code ignored;
  fs::directory_iterator entry(parent.empty() ? fs::path(".") : parent, ignored), end;
  for (; !ignored && entry != end; entry.increment(ignored)) {
    const std::string file = entry->path().filename().string();
    if (file.size() + 1 >= name.size() && file.compare(0, star, name, 0, star) == 0 &&
        file.compare(file.size() - (name.size() - star - 1), file.npos, name, star + 1, name.npos) == 0)
      out.insert(parent / file);
  }
  return out;
}

// The pattern that other programs mean by m####.obj, m@@@@.obj, m$F4.obj (Houdini) or m*.obj; a name that
// exists means itself.
std::string usual_pattern(const char *option, const std::string &text) {
  std::error_code ignored;
  if (fs::exists(text, ignored)) return text;
  std::string out;
  bool is_known = text.find('%') != text.npos;
  for (size_t i = 0; i < text.size(); i++) {
    const size_t end = text[i] == '#' || text[i] == '@' ? text.find_first_not_of(text[i], i) : i;
    const size_t marks = std::min(end, text.size()) - i;
    const bool is_frame = text.compare(i, 2, "$F") == 0;
    if (is_known || (!marks && !is_frame)) {
      out += text[i];
      continue;
    }
    const size_t digit = i + 2;
    const bool has_width = is_frame && digit < text.size() && text[digit] >= '1' && text[digit] <= '9';
    const size_t width = is_frame ? (has_width ? size_t(text[digit] - '0') : 1) : marks;
    out += width == 1 ? "%d" : "%0" + std::to_string(width) + "d";
    i += is_frame ? (has_width ? 2 : 1) : marks - 1;
    is_known = true;
  }
  const fs::path path = out;
  const std::string name = path.filename().string();
  const size_t star = name.find('*');
  if (is_known || out.find('*') == out.npos) return out;
  if (star == name.npos || name.find('*', star + 1) != name.npos || out.find('*') != out.rfind('*'))
    refuse(option, "%d or %04d for the number of the frame", text);
  const std::set<fs::path> files = matching(path, star);
  if (files.empty()) return out;
  const std::optional<std::string> found = pattern_of(files);
  if (!found)
    refuse_option(option, "expected files that differ in one number alone, found " +
                              quote(files.begin()->string()) + " and " +
                              quote(std::next(files.begin())->string()) +
                              ": write %d or %04d for the number of the frame");
  return *found;
}

// The first file of a folder, by name.
std::optional<fs::path> first_file(const fs::path &folder) {
  std::optional<fs::path> first;
  std::error_code error;
  fs::directory_iterator entry(folder, error), end;
  for (; !error && entry != end; entry.increment(error)) {
    std::error_code ignored;
    if (entry->is_regular_file(ignored) && (!first || entry->path() < *first)) first = entry->path();
  }
  return first;
}

// Frames follow the numbers of their files, which must go with the times that a calibration gives.
void check_order(const Camera &camera, const Pattern &pattern, const std::vector<std::string> &in_time) {
  std::map<std::string, int64_t> numbers;
  for (const int64_t number : numbers_of(pattern))
    numbers[fs::path(pattern.file(number)).lexically_normal().string()] = number;
  std::optional<int64_t> before;
  for (const std::string &file : in_time) {
    const auto found = numbers.find(fs::path(file).lexically_normal().string());
    if (found == numbers.end() || (before && found->second <= *before))
      throw Error(describe(camera) + ": expected pictures " + pattern.text() +
                  " whose numbers are in the order of their times, found " + quote(file) +
                  (before ? " after " + quote(pattern.file(*before)) : std::string()));
    before = found->second;
  }
}

// files: of the calibration, each camera's picture. A camera that has a folder of its own has a sequence of
// pictures there: the folder of its picture, unless other cameras have pictures in it, or one with the name
// of the picture. All others have the one picture.
// moments: empty, or of each camera its pictures in the order of time, which is a sequence wherever it is.
void add_pictures(std::vector<Camera> &cameras, const std::vector<std::string> &files,
                  const std::vector<std::vector<std::string>> &moments = {}) {
  const bool has_moments = !moments.empty();
  std::map<fs::path, size_t> used;
  for (const std::string &file : files) used[fs::path(file).parent_path()]++;
  for (size_t i = 0; i < cameras.size(); i++) {
    const fs::path picture = files[i];
    std::error_code ignored;
    std::optional<std::string> pattern;
    if (has_moments || (files.size() > 1 && used[picture.parent_path()] == 1)) pattern = sequence_of(picture);
    if (has_moments && !pattern)
      throw Error(describe(cameras[i]) +
                  ": expected pictures of several moments whose names differ by a number, "
                  "found " +
                  picture.string());
    const fs::path own = picture.parent_path() / picture.stem();
    if (!pattern && !fs::exists(picture, ignored) && fs::is_directory(own, ignored))
      if (const auto first = first_file(own)) {
        pattern = sequence_of(*first);
        if (!pattern) pattern = as_pattern(first->string());
      }
    cameras[i].pictures = parse_pattern("pictures", pattern.value_or(as_pattern(picture.string())));
    if (has_moments) check_order(cameras[i], *cameras[i].pictures->pattern, moments[i]);
  }
}

// The pictures of a model: in the folder that was given, or beside sparse, in which the model is.
fs::path images_of(const fs::path &folder, const fs::path &model) {
  fs::path sparse = fs::absolute(model).lexically_normal();
  if (sparse.parent_path().filename() == "sparse") sparse = sparse.parent_path();
  const fs::path beside = sparse.parent_path() / "images";
  std::error_code ignored;
  return sparse.filename() == "sparse" && !fs::is_directory(folder / "images", ignored) ? beside
                                                                                        : folder / "images";
}

Folder read_colmap(const fs::path &folder, const fs::path &model) {
  auto calibration = import::read_colmap(model.string());
  const fs::path images = images_of(folder, model);
  std::vector<std::string> files;
  for (const std::string &name : calibration.pictures) files.push_back((images / name).string());
  add_pictures(calibration.cameras, files);
  return {std::move(calibration.cameras), "a COLMAP model", {}};
}

Folder read_nerfstudio(const fs::path &file) {
  auto calibration = import::read_nerfstudio(file.string());
  std::vector<std::string> files;
  for (const std::string &name : calibration.pictures)
    files.push_back(import::nerfstudio_picture(file.parent_path().string(), name));
  for (std::vector<std::string> &of_camera : calibration.moments)
    for (std::string &name : of_camera) name = import::nerfstudio_picture(file.parent_path().string(), name);
  add_pictures(calibration.cameras, files, calibration.moments);
  std::vector<std::string> notes;
  for (const std::string &note : calibration.notes) notes.push_back(file.string() + ": " + note);
  return {std::move(calibration.cameras), file.filename().string(), std::move(notes)};
}

Folder read_folder(const std::string &given) {
  if (given.empty()) return {};
  std::error_code ignored;
  const fs::path path = given;
  if (is_transforms(given)) return read_nerfstudio(path);
  for (const char *name : {"transforms.json", "transforms_train.json"})
    if (fs::is_regular_file(path / name, ignored)) return read_nerfstudio(path / name);
  if (const auto model = import::find_colmap(given)) return read_colmap(path, *model);
  throw Error(given +
              ": expected capture.json, a COLMAP model (cameras.bin or cameras.txt, also in sparse/0) "
              "or transforms.json in the folder, found none");
}

// ---- to capture.json -----------------------------------------------------------------------------------

// Names relative to the working folder, as names relative to that of a capture.json.
class Names {
public:
  explicit Names(const std::string &file)
      : folder(fs::weakly_canonical(fs::absolute(file).parent_path()).string()) {}

  // literal: a name, else a pattern.
  std::string operator()(const std::string &name, bool literal) const {
    const auto written = [&](const fs::path &path) {
      return fs::path(literal ? path.string() : as_pattern(path.string()));
    };
    const bool absolute = fs::path(name).is_absolute();
    const fs::path whole =
        (absolute ? fs::path(name) : written(fs::current_path()) / name).lexically_normal();
    const std::string relative = whole.lexically_relative(written(folder)).string();
    return relative.empty() || (absolute && relative.substr(0, 2) == "..") ? whole.string() : relative;
  }
  PictureSource operator()(PictureSource source, const Frames &frames) const {
    if (source.pattern) {
      source.pattern = parse_pattern("pictures", (*this)(source.text(), false));
    } else {
      source.video->file = (*this)(source.video->file, true);
      source.video->first = frames.first;
    }
    return source;
  }

private:
  fs::path folder;
};

// Those of pictures and masks, where options name them.
void add_named(const Inputs &inputs, std::vector<Camera> &cameras) {
  for (Camera &camera : cameras) {
    const auto named = [&](const char *option, const std::string &text) {
      return source_of(option, fill_in(option, text, camera, is_video(text) ? "%" : "%%"));
    };
    if (!inputs.pictures.empty()) camera.pictures = named("pictures", inputs.pictures);
    if (!inputs.masks.empty()) camera.masks = named("masks", inputs.masks);
  }
}

// What a glTF file has, without reading its meshes.
struct GltfFacts {
  size_t animations = 0;
  bool base_colour = false; // some material has a picture of it
};

GltfFacts facts_of(const std::string &path) {
  const std::string bytes = read_file(path, max_mesh_file);
  const gltf::Container container(bytes, path);
  GltfFacts facts;
  if (const auto animations = container.root().find("animations")) facts.animations = animations->size();
  if (const auto materials = container.root().find("materials"))
    for (size_t i = 0; i < materials->size(); i++)
      facts.base_colour = facts.base_colour || gltf::colour_texture(materials->item(i));
  if (facts.animations > 1)
    throw Error(path + ": expected one animation, found " + std::to_string(facts.animations) +
                "; a capture.json names one of them (spec/capture.md)");
  return facts;
}

// By the meshes, else by the atlas, else by the pictures, whichever has numbers; else by an animation.
Frames find_frames(const Pattern &meshes, const std::optional<PictureSource> &atlas, const Capture &capture) {
  std::vector<Sequence> sequences;
  bool videos = atlas && atlas->video;
  if (meshes.is_numbered()) {
    Frames frames = frames_of({{option_name("meshes"), meshes}});
    // Pictures between the steps are of frames whose meshes are missing.
    if (frames.step > 1 && atlas && atlas->pattern && atlas->pattern->is_numbered())
      for (const int64_t number : numbers_of(*atlas->pattern))
        if (number > frames.first && (number - frames.first) % frames.step != 0) {
          frames.count = (frames.count - 1) * frames.step + 1;
          frames.step = 1;
          break;
        }
    return frames;
  }
  if (atlas && atlas->pattern && atlas->pattern->is_numbered())
    return frames_of({{option_name("atlas"), *atlas->pattern}});
  for (const Camera &camera : capture.cameras) {
    if (camera.pictures->pattern && camera.pictures->pattern->is_numbered())
      sequences.push_back({describe(camera) + ": pictures", *camera.pictures->pattern});
    videos = videos || camera.pictures->video;
  }
  if (!sequences.empty()) return frames_of(sequences);
  if (capture.animation) {
    constexpr double most = 10'000'000; // of a capture.json
    const double end = capture.animation->end(meshes.file(0), false);
    const double frames = end * capture.frame_duration.denominator / capture.frame_duration.numerator;
    Frames out;
    out.count = int64_t(std::min(std::floor(frames + 1e-6) + 1, most));
    return out;
  }
  if (videos)
    throw Error(option_name("meshes") +
                    ": expected a pattern with %d, because a video does not give the number of frames",
                Error::usage);
  return {};
}

void check_pictures(const Capture &capture) {
  for (const Camera &camera : capture.cameras)
    for (const auto &[source, option, folder] :
         {std::tuple(&camera.pictures, "pictures", "images"), std::tuple(&camera.masks, "masks", "masks")})
      if (*source && (*source)->is_constant() && capture.frames.count > 1)
        throw Error(describe(camera) + ": expected a picture for each of " +
                    std::to_string(capture.frames.count) + " frames, found one, " + (*source)->text() +
                    "; name them with " + option_name(option) + " '" + folder + "/{name}/%04d.png'");
}

// Of a PLY file that names pictures; empty: the first one is there.
std::string why_no_picture(const std::string &path, const PlyPictures &pictures) {
  if (!pictures.has_coordinates)
    return "it names " + quote(pictures.names[0]) + " (TextureFile) and has no texture coordinates";
  try {
    const std::string picture =
        picture_path(path, fs::path(path).parent_path().string(), pictures.names[0], path);
    std::error_code ignored;
    if (fs::is_regular_file(picture, ignored)) return "";
  } catch (const Error &error) {
    return error.line();
  }
  return "that of its comment TextureFile, " + quote(pictures.names[0]) + ", is missing";
}

// Whether the meshes bring a picture: the first that is not empty, or, so that one without does not decide
// for all, any other. notes: why there may be none.
bool brings_picture(const Pattern &meshes, const Frames &frames, const media::MemoryLimit &limit,
                    std::vector<std::string> &notes) {
  if (!may_bring_picture(meshes.text())) return false;
  bool is_first = true;
  for (const int64_t number : frames.numbers()) {
    const std::string path = meshes.file(number);
    std::error_code ignored;
    if (!fs::is_regular_file(path, ignored)) continue; // is said when all files are checked
    check_mesh_memory(path, limit);
    if (is_gltf(path)) {
      if (facts_of(path).base_colour) return true;
    } else if (is_one_of(path, {".ply"})) {
      const PlyPictures pictures = ply_pictures(read_file(path, max_mesh_file), path);
      if (!pictures.names.empty()) {
        const std::string why = why_no_picture(path, pictures);
        if (why.empty()) return true;
        notes.push_back(path + ": has no picture: " + why + "; the atlas option names one");
        return false;
      }
    } else if (!is_empty_mesh(path)) {
      const std::string bytes = read_file(path, max_mesh_file);
      if (is_first || bytes.find("mtllib") != bytes.npos) {
        const ObjMaterials materials = parse_obj_materials(bytes, path);
        if (materials.picture) return true;
        if (is_first)
          for (const std::string &missing : materials.missing)
            notes.push_back(path + ": has no picture: " + missing + "; the atlas option names one");
      }
      is_first = false;
    }
    if (!meshes.is_numbered()) break;
  }
  return false;
}

void set_meshes(Capture &capture, const Inputs &inputs, const Names &names) {
  const Pattern meshes = parse_pattern("meshes", inputs.meshes);
  std::optional<PictureSource> atlas;
  if (is_pattern_of_atlas(inputs.atlas)) atlas = source_of("atlas", inputs.atlas);
  const auto animation = [](int64_t first) {
    return std::make_shared<const MeshAnimation>(std::nullopt, fvv_rational{0, 1}, first);
  };
  const bool gltf = is_gltf(inputs.meshes);
  if (gltf && !meshes.is_numbered() && facts_of(meshes.file(0)).animations) capture.animation = animation(0);
  capture.frames = find_frames(meshes, atlas, capture);
  if (capture.animation) capture.animation = animation(capture.frames.first);
  capture.meshes = parse_pattern("meshes", names(inputs.meshes, false));
  if (atlas) capture.atlas = Atlas{names(*atlas, capture.frames), std::nullopt};
  if (inputs.atlas == embedded ||
      (inputs.atlas.empty() && capture.cameras.empty() &&
       brings_picture(meshes, capture.frames, capture.memory_limit, capture.notes)))
    capture.atlas = Atlas{};
  if (capture.atlas) capture.atlas->bake_repeats = inputs.bake_repeats;
}

// As JSON. by_gltf: what glTF defines is the default.
std::string units_text(const Inputs &inputs, bool by_gltf) {
  const std::string units = !inputs.units.empty() ? inputs.units : by_gltf ? "metres" : unknown_units;
  double number;
  if (!parse_double(units, number)) return "\"" + units + "\"";
  std::string text;
  append_double(text, number);
  return text;
}

} // namespace

bool Inputs::is_given() const {
  return !meshes.empty() || !atlas.empty() || !pictures.empty() || !masks.empty() || frame_duration ||
         !units.empty() || !up.empty() || bake_repeats;
}

fvv_rational parse_frame_rate(const char *option, const std::string &text) {
  const std::optional<fvv_rational> rate = parse_rational(text);
  if (!rate || !rate->numerator) refuse(option, "frames per second like 25 or 30000/1001", text);
  return {rate->denominator, rate->numerator};
}

std::optional<double> parse_units(const std::string &text) {
  if (text == unknown_units) return std::nullopt;
  for (const NamedUnit &unit : named_units)
    if (text == unit.name) return unit.metres;
  double metres;
  if (!parse_double(text, metres) || !(metres > 0))
    refuse("units", "metres, centimetres, millimetres, inches, feet, unknown or metres per unit > 0", text);
  return metres;
}

uint8_t parse_up(const std::string &text) {
  for (const NamedAxis &axis : named_axes)
    if (text == axis.name) return axis.up;
  refuse("up", "+x, -x, +y, -y, +z, -z or unknown", text);
}

std::string fill_in(const char *option, const std::string &text, const Camera &camera,
                    const std::string &percent) {
  std::string out;
  for (size_t i = 0; i < text.size(); i++) {
    if (text.compare(i, 6, "{name}") == 0) {
      for (const char c : *camera.name) out += c == '%' ? percent : std::string(1, c);
      i += 5;
    } else if (text.compare(i, 4, "{id}") == 0) {
      out += std::to_string(camera.calibration.id);
      i += 3;
    } else if (text[i] == '{' || text[i] == '}') {
      refuse(option, "{name} or {id} where there are braces", text);
    } else {
      out += text[i];
    }
  }
  return out;
}

void check_inputs(const Inputs &inputs) {
  if (!inputs.meshes.empty()) {
    parse_pattern("meshes", inputs.meshes);
    if (!is_one_of(inputs.meshes, {".obj", ".ply", ".drc", ".draco", ".glb", ".gltf"}))
      refuse("meshes", "files .obj, .ply, .drc, .draco, .glb or .gltf", inputs.meshes);
  }
  if (!inputs.atlas.empty()) {
    if (inputs.meshes.empty()) refuse("atlas", option_name("meshes") + " too", inputs.atlas);
    if (inputs.atlas == embedded && !may_bring_picture(inputs.meshes))
      refuse("atlas", "embedded for .glb, .gltf, .obj and .ply files only", inputs.meshes);
    if (is_pattern_of_atlas(inputs.atlas)) source_of("atlas", inputs.atlas);
  }
  for (const auto &[option, text] :
       {std::pair("pictures", &inputs.pictures), std::pair("masks", &inputs.masks)}) {
    if (text->empty()) continue;
    if (text->find("{name}") == text->npos && text->find("{id}") == text->npos)
      refuse(option, "{name} or {id} to tell the cameras apart", *text);
    if (!is_video(*text)) parse_pattern(option, *text);
  }
  if (inputs.bake_repeats && (inputs.meshes.empty() || inputs.atlas == no_atlas))
    refuse_option("bake-repeats", inputs.meshes.empty()
                                      ? "expected " + option_name("meshes") + " too, found none"
                                      : "expected an atlas, found " + quote(inputs.atlas));
  if (!inputs.units.empty()) parse_units(inputs.units);
  if (!inputs.up.empty()) parse_up(inputs.up);
}

std::string describe_inputs(const std::string &given, const Inputs &as_given, const std::string &file,
                            std::vector<std::string> *notes, const media::MemoryLimit &limit) {
  Inputs inputs = as_given;
  for (const auto &[option, text] :
       {std::pair("meshes", &inputs.meshes), std::pair("atlas", &inputs.atlas),
        std::pair("pictures", &inputs.pictures), std::pair("masks", &inputs.masks)})
    *text = usual_pattern(option, *text);
  check_inputs(inputs);
  std::error_code ignored;
  if (fs::is_regular_file(description_file(given), ignored) && !is_transforms(given))
    throw Error(description_file(given) + ": expected a folder without capture.json, found one",
                Error::usage);
  Folder folder = read_folder(given);
  if (inputs.meshes.empty())
    throw Error(given.empty() ? option_name("meshes") + ": expected a pattern of files, found none"
                              : given + ": expected " + option_name("meshes") + " too, because " +
                                    folder.kind + " has none",
                Error::usage);
  if (folder.cameras.empty() && (!inputs.pictures.empty() || !inputs.masks.empty()))
    refuse_option(inputs.pictures.empty() ? "masks" : "pictures",
                  "expected a folder with a calibration too, found none");
  Capture capture;
  capture.path = file;
  capture.memory_limit = limit;
  if (inputs.frame_duration) capture.frame_duration = *inputs.frame_duration;
  capture.cameras = std::move(folder.cameras);
  if (inputs.masks.empty()) capture.notes = std::move(folder.notes);
  add_named(inputs, capture.cameras);
  const Names names(file);
  set_meshes(capture, inputs, names);
  check_pictures(capture);
  for (Camera &camera : capture.cameras)
    for (auto *source : {&camera.pictures, &camera.masks})
      if (*source) *source = names(**source, capture.frames);
  const bool by_gltf = is_gltf(inputs.meshes) && capture.cameras.empty();
  capture.up = !inputs.up.empty() ? parse_up(inputs.up)
               : by_gltf          ? uint8_t(FVV_UP_Y)
                                  : uint8_t(FVV_UP_UNKNOWN);
  if (notes) *notes = capture.notes;
  return format_capture(capture, units_text(inputs, by_gltf));
}

std::string pattern_of_files(const char *option, const std::vector<std::string> &files) {
  std::set<fs::path> all;
  for (const std::string &file : files) all.insert(fs::path(file).lexically_normal());
  const std::optional<std::string> found = pattern_of(all);
  if (!found)
    refuse_option(option,
                  "expected one pattern in quotes, such as 'm%04d.obj', or all files of a sequence, found " +
                      std::to_string(files.size()) + " files from " + quote(files.front()) + " to " +
                      quote(files.back()));
  return *found;
}

Capture load_capture(const std::string &given, const Inputs &inputs, const media::MemoryLimit &limit) {
  std::error_code ignored;
  const std::string file = description_file(given);
  const bool is_folder = fs::is_directory(given, ignored) && !fs::exists(file, ignored);
  if (!given.empty() && !is_folder && !is_transforms(given)) {
    if (inputs.is_given())
      throw Error(option_name("meshes") + ", " + option_name("atlas") + ", " + option_name("pictures") +
                      ", " + option_name("masks") + ", " + option_name("fps") + ", " + option_name("units") +
                      ", " + option_name("up") + ", " + option_name("bake-repeats") +
                      ": expected without a "
                      "capture.json, found " +
                      file,
                  Error::usage);
    Capture capture = load_capture(file);
    capture.memory_limit = limit;
    return capture;
  }
  // Patterns are relative to the folder of this name, of which there is no file.
  std::string name = given.empty() ? option_name("meshes") : given;
  while (name.size() > 1 && name.back() == '/') name.pop_back();
  std::vector<std::string> notes;
  Capture capture = parse_capture(describe_inputs(given, inputs, name, &notes, limit), name);
  capture.memory_limit = limit;
  capture.notes = std::move(notes);
  return capture;
}

} // namespace fvv::scene
