// fvvmux/picture_file.h: picture files of an environment made fit for a stream: without what their cameras
// and editors wrote into them, and no larger than every reader takes.
#pragma once

#include <cstdint>
#include <string>

namespace fvv::mux {

// Longest side in pixels that every reader supports (fvv.md clause 13).
constexpr uint32_t max_picture_side = 4096;

// Bytes of a PNG or JPEG file as they are, but for metadata: segments APPn other than JFIF's and Adobe's and
// comments of JPEG, ancillary chunks of PNG (clause 14, private data). What is no such file stays as it is.
std::string without_metadata(const std::string &file);

struct FittedPicture {
  std::string file;
  uint32_t width = 0, height = 0;
  bool scaled = false; // larger than max_picture_side: made smaller, and JPEG at quality 92
};
// name: what messages call it. media::Error for what is no picture.
FittedPicture fit_picture(const std::string &file, const std::string &name);

} // namespace fvv::mux
