// OpenEXR files of one part, with scan lines or tiles, as float samples. Colours are not converted (image.h
// does that, for pictures). A FloatImage takes any float, NaN and infinities among them.
#pragma once

#include "fvv_media/image.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace fvv::media {

// Rows from top to bottom, channels interleaved, no padding: samples.size() is width * height *
// channels.size().
struct FloatImage {
  uint32_t width = 0, height = 0;
  std::vector<std::string> channels; // "R" "G" "B", "Y", "Z", ... in the order of the samples
  std::vector<float> samples;
};

// Reads R G B, with A if there is one; without them Y, with A if there is one; else Z. Further channels are
// left out. half or float, any line order, the finest level of a tiled file; a pixel aspect ratio is ignored.
//
// Errors: several parts, deep data, channels that are subsampled, of 32-bit integers, or luminance with
// chroma (RY, BY); a data window unlike the display window; sides above max_dimension; the lossy compressions
// DWAA and DWAB, whose decoders do not give the same samples on every machine; a file that is cut,
// incomplete, or cannot hold what its header announces. OpenEXR has no checksum but that of zlib (ZIP, ZIPS,
// PXR24): other damage may go unseen. name begins messages.
FloatImage decode_exr(const uint8_t *bytes, size_t size, const std::string &name);
FloatImage read_exr(const std::string &path);

// A whole file: float channels, scan lines, ZIP, the same bytes for the same image and zlib. Error unless
// channels have different names of 1 to 31 bytes and samples the size that follows.
std::vector<uint8_t> encode_exr(const FloatImage &image);

// Error, naming channel and pixel, unless all values are finite as half floats: -65504 to 65504.
void check_halves(const LinearImage &image, const std::string &name);

// An RGB picture as a sample of video (clause 10.12 of the format): half floats, scan lines, PIZ, rounded to
// the nearest. Error as check_halves.
std::vector<uint8_t> encode_half_exr(const LinearImage &image);

} // namespace fvv::media
