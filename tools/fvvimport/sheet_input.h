// The input of a calibration sheet: the frame, its cameras, the surface whose outline is drawn, pictures and
// masks.
#pragma once

#include "fvv_geometry/outline.h"
#include "fvv_scene/capture.h"
#include "fvv_scene/pictures.h"

namespace fvv::fvvimport {

struct SheetOptions {
  std::string capture;              // capture.json or its folder
  std::string output;               // PNG to write; "-": standard output
  uint32_t width = 480;             // of a panel's picture, at most, in pixels
  std::optional<fvv::Range> frames; // the middle one of these is shown; numbers as in file names
  std::vector<std::string> cameras; // identifiers, ranges of them (2-5) or names; empty: all
  bool meshes = true;               // else the hull of the masks is outlined
  uint32_t threads = 1;
  media::MemoryLimit memory; // of decoding one file
  bool force = false;
};

// The source of the drawn outline.
enum class Outlined { nothing, mesh, hull };

struct SheetInput {
  scene::Capture capture;                // its cameras by rising identifier, as Options::cameras wants them
  int64_t frame = 0;                     // frame number
  std::vector<fvv_camera> cameras;       // calibrations of that frame; names are borrowed from capture
  std::shared_ptr<scene::Videos> videos; // what pictures and masks are read through
  std::vector<std::string> warnings;     // what was left out
};

// The frame in the middle of the capture, or of Options::frames. Throws Error, Error.
SheetInput open_capture(const SheetOptions &options);

// A picture, or why there is none. Both empty: the capture names none.
struct Loaded {
  media::Image image;
  std::string problem; // a sentence that names the file
};
// RGB.
Loaded picture_of(const SheetInput &input, size_t camera);
// Grey, 255 inside of the silhouette (above 127 in the file), else 0.
Loaded mask_of(const SheetInput &input, size_t camera);

// The mesh of the frame; without meshes the hull of the masks that can be read; else nothing.
struct Subject {
  geometry::ViewedSurface body;
  Outlined outlined = Outlined::nothing;
  std::optional<size_t> excluded; // camera that was ignored for the hull, see RigHull
};
Subject subject_of(const SheetInput &input, const SheetOptions &options);

} // namespace fvv::fvvimport
