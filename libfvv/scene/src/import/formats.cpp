// The formats by name: what each takes.

#include "fvv_cxx/error.h"
#include "fvv_scene/import.h"

#include <algorithm>

namespace fvv::import {

const std::vector<Format> &formats() {
  using Size = Format::Size;
  static const std::vector<Format> all = {
      {"colmap", {}, Size::stated},     {"opencv", {".yml", ".yaml", ".xml", ".json"}, Size::stated},
      {"nerfstudio", {}, Size::stated}, {"qualisys", {}, Size::stated},
      {"middlebury", {}, Size::given},  {"krt", {".txt", ".krt"}, Size::given},
      {"panoptic", {}, Size::stated},   {"easymocap", {}, Size::either},
      {"toml", {}, Size::stated},       {"kalibr", {}, Size::stated},
      {"metashape", {}, Size::stated},  {"realitycapture", {".xmp"}, Size::given},
  };
  return all;
}

const Format *find_format(const std::string &name) {
  for (const Format &format : formats())
    if (name == format.name) return &format;
  return nullptr;
}

Calibration read(const Format &format, const std::vector<std::string> &files, uint32_t width,
                 uint32_t height) {
  const std::string name = format.name;
  if (name == "opencv") return read_opencv(files);
  if (name == "krt") return read_krt(files, width, height);
  if (name == "realitycapture") return read_realitycapture(files, width, height);
  const std::string &file = files.at(0);
  if (name == "colmap") return read_colmap(file);
  if (name == "nerfstudio") return read_nerfstudio(file);
  if (name == "qualisys") return read_qualisys(file);
  if (name == "middlebury") return read_middlebury(file, width, height);
  if (name == "panoptic") return read_panoptic(file);
  if (name == "easymocap") return read_easymocap(file, width, height);
  if (name == "toml") return read_toml(file);
  if (name == "kalibr") return read_kalibr(file);
  return read_metashape(file);
}

} // namespace fvv::import
