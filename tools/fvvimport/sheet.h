// A picture that shows whether calibration, meshes and pictures agree: a panel for each camera with its
// picture and, over it, the projected geometry.
#pragma once

#include "fvvimport/sheet_input.h"

#include <nlohmann/json.hpp>

namespace fvv::fvvimport {

constexpr uint32_t largest_sheet = 8192; // pixels, width and height

struct SheetCamera {
  uint16_t id = 0;
  std::string name;
  uint32_t width = 0, height = 0;     // of its picture
  bool picture = false, mask = false; // were read
  double covered = 0;                 // fraction of the picture that the outlined body covers
  geometry::SilhouetteMatch match;    // of body and mask; empty without either
};

struct SheetReport {
  std::string path;
  int64_t frame = 0;
  Outlined outlined = Outlined::nothing;
  uint32_t width = 0, height = 0; // of the sheet, pixels
  uint32_t panel = 0;             // longest side of a panel's picture, pixels
  std::vector<SheetCamera> cameras;
  std::optional<double> median_iou, median_distance;
  std::vector<size_t> outliers;   // indices of cameras
  std::optional<size_t> excluded; // likewise, of the hull: see RigHull
  geometry::Suspicion suspicion = geometry::Suspicion::nothing;
  std::vector<std::string> warnings;
};

// Writes options.output, a PNG. Panels are options.width long, or less so that the sheet stays within
// largest_sheet. Files that are missing or invalid leave a panel without a picture or numbers, and a warning,
// which is printed; when no picture can be read at all, or the mesh cannot, nothing is written. Throws Error.
SheetReport check_calibration(const SheetOptions &options);

// sheet_report.cpp: for people and for programs.
std::string sheet_text(const SheetReport &report);
nlohmann::ordered_json sheet_json(const SheetReport &report);

} // namespace fvv::fvvimport
