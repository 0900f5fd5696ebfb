// fvvmux/sheet_input.h: what a contact sheet shows, read: the frame, its cameras, the surface whose outline
// is drawn, pictures and masks. Knows files; draws nothing.
#pragma once

#include "capture/capture.h"
#include "fvvmux/body.h"
#include "fvvmux/options.h"
#include "fvvmux/videos.h"

namespace fvv::mux {

enum class Outlined { nothing, mesh, hull };

struct SheetInput {
  capture::Capture capture;          // its cameras by rising identifier, as Options::cameras wants them
  int64_t frame = 0;                 // frame number
  std::vector<fvv_camera> cameras;   // calibrations of that frame; names are borrowed from capture
  bool pictures = true;              // wanted at all
  std::shared_ptr<Videos> videos;    // what pictures and masks are read through
  std::vector<std::string> warnings; // what was left out
};

// The frame in the middle of the capture, or of Options::frames. Throws cli::Failure, capture::FileError.
SheetInput open_capture(const Options &options);

// A picture as it should be, or why there is none. Both empty: the capture names none.
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
  Body body;
  Outlined outlined = Outlined::nothing;
  std::optional<size_t> left_out; // camera that had no say in the hull, see RigHull
};
Subject subject_of(const SheetInput &input, const Options &options);

} // namespace fvv::mux
