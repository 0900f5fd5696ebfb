// Poses, lenses, names and checks.

#include "scene/src/import/camera.h"
#include "fvv_scene/file_io.h"

#include <algorithm>

namespace fvv::import {

void set_pose_opengl(fvv_camera &camera, const double axes[9], const double centre[3]) {
  for (int row = 0; row < 3; row++)
    for (int column = 0; column < 3; column++)
      camera.rotation[3 * row + column] = row == 0 ? axes[column] : -axes[3 * row + column];
  set_centre(camera, centre);
}

void set_centre(fvv_camera &camera, const double centre[3]) {
  for (int row = 0; row < 3; row++) {
    camera.translation[row] = 0;
    for (int column = 0; column < 3; column++)
      camera.translation[row] -= camera.rotation[3 * row + column] * centre[column];
  }
}

namespace {

void set_lens(fvv_camera &camera, uint8_t lens, const double *coefficients, size_t count) {
  std::copy(coefficients, coefficients + count, camera.distortion);
  camera.lens = lens;
}

std::vector<std::string> parts_of(const std::string &path) {
  std::vector<std::string> parts(1);
  for (const char c :
       path.substr(0, path.find_last_of('.') > path.find_last_of("/\\") + 1 ? path.find_last_of('.')
                                                                            : std::string::npos)) {
    if (c != '/' && c != '\\')
      parts.back() += c;
    else if (!parts.back().empty())
      parts.emplace_back();
  }
  return parts;
}

} // namespace

void set_radtan(fvv_camera &camera, const double coefficients[8]) {
  if (std::any_of(coefficients, coefficients + 8, [](double k) { return k != 0; }))
    set_lens(camera, FVV_LENS_RADTAN, coefficients, 8);
}

void set_fisheye(fvv_camera &camera, const double coefficients[4]) {
  set_lens(camera, FVV_LENS_FISHEYE, coefficients, 4);
}

std::vector<std::string> names_of_pictures(const std::vector<std::string> &paths) {
  std::vector<std::vector<std::string>> all;
  size_t shortest = SIZE_MAX;
  for (const std::string &path : paths) {
    all.push_back(parts_of(path));
    shortest = std::min(shortest, all.back().size());
  }
  const auto shared = [&](auto part) {
    return std::all_of(all.begin(), all.end(),
                       [&](const auto &parts) { return part(parts) == part(all[0]); });
  };
  // At least one part stays of every path.
  size_t head = 0, tail = 0;
  while (paths.size() > 1 && head + 1 < shortest &&
         shared([&](const auto &parts) -> const std::string & { return parts[head]; }))
    head++;
  while (paths.size() > 1 && head + tail + 1 < shortest &&
         shared([&](const auto &parts) -> const std::string & { return parts[parts.size() - 1 - tail]; }))
    tail++;
  std::vector<std::string> names;
  for (const auto &parts : all) {
    std::string name;
    for (size_t i = paths.size() > 1 ? head : parts.size() - 1; i + tail < parts.size(); i++)
      name += (name.empty() ? "" : "/") + parts[i];
    names.push_back(name);
  }
  return names;
}

void append(Calibration &calibration, scene::Camera camera, const std::string &where) {
  fvv_limits limits;
  fvv_limits_default(&limits);
  if (calibration.cameras.size() == limits.max_cameras)
    throw Error(where + ": expected at most " + std::to_string(limits.max_cameras) + " cameras");
  fvv_camera &model = camera.calibration;
  for (const scene::Camera &other : calibration.cameras)
    if (other.calibration.id == model.id)
      throw Error(where + ": expected an identifier of its own for every camera, found " +
                  std::to_string(model.id) + " again");
  model.r_max = fvv_camera_r_max(&model);
  fvv_diagnostic diagnostic = {};
  if (fvv_camera_validate(&model, &diagnostic) != FVV_OK) throw Error(where + ": " + diagnostic.message);
  calibration.cameras.push_back(std::move(camera));
}

void require_cameras(const Calibration &calibration, const std::string &path) {
  if (calibration.cameras.empty()) throw Error(path + ": expected at least one camera, found none");
}

void fail_at(const std::string &path, uint64_t line, const std::string &what) {
  throw Error(path + ":" + std::to_string(line) + ": " + what);
}

double number_at(const std::string &path, uint64_t line, std::string_view word, const char *name) {
  double value;
  if (!scene::parse_double(word, value))
    fail_at(path, line,
            std::string("expected a finite number for ") + name + ", found " + scene::quote(word));
  return value;
}

int64_t integer_at(const std::string &path, uint64_t line, std::string_view word, const char *name,
                   int64_t least, int64_t most) {
  int64_t value;
  if (!scene::parse_integer(word, value) || value < least || value > most)
    fail_at(path, line,
            std::string("expected an integer from ") + std::to_string(least) + " to " + std::to_string(most) +
                " for " + name + ", found " + scene::quote(word));
  return value;
}

std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  std::string_view line, word;
  while (words.size() < max_words && scene::next_line(text, line))
    while (words.size() < max_words && scene::next_word(line, word)) words.push_back(word);
  return words;
}

bool Lines::next(std::string_view &line) {
  if (!scene::next_line(rest, line)) return false;
  count++;
  return true;
}

bool Lines::next_content(std::string_view &line) {
  while (next(line)) {
    const size_t first = line.find_first_not_of(" \t");
    if (first != line.npos && line[first] != '#') return true;
  }
  return false;
}

} // namespace fvv::import
