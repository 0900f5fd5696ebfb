// import/import.h: cameras out of the calibration files of other programs, in the conventions of fvv. Knows
// their formats and what their numbers mean (docs/calibration.md); knows nothing of pictures, frames or
// streams.
#pragma once

#include "capture/capture.h"

#include <string>
#include <vector>

namespace fvv::import {

// cameras: world -> camera with x right, y down, z forward, pixel centres at +0.5, r_max filled in, each
// validated, ids unique; at least one. Lengths are units of the file.
struct Calibration {
  std::vector<capture::Camera> cameras;
  double metres_per_unit = 0; // 0: the format does not say
};

// Every reader is strict and throws capture::FileError: "path:LINE: expected ..., found ..." for text and
// XML, "path: /JSON/POINTER: ..." for JSON. A lens or a convention that fvv cannot hold exactly is an error
// that names it, never an approximation.

// A COLMAP text model: the folder with cameras.txt and images.txt. A camera for each image, with the image's
// identifier; named after the picture.
Calibration read_colmap(const std::string &folder);

// cv::FileStorage, a camera in each file, YAML or XML by its first characters; ids by position, named after
// the file.
Calibration read_opencv(const std::vector<std::string> &files);

// transforms.json of nerfstudio or instant-ngp; ids by position, named after file_path.
Calibration read_nerfstudio(const std::string &file);

// Calibration exported by Qualisys Track Manager (XML, often *.qca.txt); ids by position among the active
// cameras, named after the serial number.
Calibration read_qualisys(const std::string &file);

// *_par.txt of the Middlebury multi-view data sets, whose pictures are all width by height (the file does not
// say); ids by position, named after the picture.
Calibration read_middlebury(const std::string &file, uint32_t width, uint32_t height);

} // namespace fvv::import
