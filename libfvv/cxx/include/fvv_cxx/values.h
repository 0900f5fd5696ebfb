// Plain values that the installed headers share: meshes and pictures in memory, ranges of frames, where a
// capture's files are.
#pragma once

#include "fvv/types.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace fvv {

// Numbers of frames. Both ends included; 0 <= first <= last <= 2147483647.
struct Range {
  int64_t first, last;
};

} // namespace fvv

namespace fvv::geometry {

// positions: x y z of each vertex, in metres, or in the unit of the file that they come from. faces: 3 vertex
// indices per triangle, each below the number of vertices, counter-clockwise seen from outside. texture:
// empty, or u v of each vertex on the axes of fvv.md clause 8.6: (0, 0) is the top left corner of the atlas
// picture, v points down. normals: empty, or x y z of each vertex, of any length; at hard edges there is a
// vertex for each side.
struct Mesh {
  std::vector<double> positions;
  std::vector<uint32_t> faces;
  std::vector<double> texture = {};
  std::vector<double> normals = {};

  size_t vertex_count() const { return positions.size() / 3; }
  size_t face_count() const { return faces.size() / 3; }
};

} // namespace fvv::geometry

namespace fvv::media {

// Rows from top to bottom, channels interleaved, no padding: pixels.size() is width * height * channels.
// White is the largest number of SampleType, so that 8 bits become 16 by times 257; of float it is 1.
template <class SampleType> struct BasicImage {
  using Value = SampleType;
  uint32_t width = 0, height = 0;
  int channels = 0; // 1: grey, 3: RGB
  std::vector<SampleType> pixels;
};
using Image = BasicImage<uint8_t>;
// For pictures of more than 8 bits.
using DeepImage = BasicImage<uint16_t>;
// For light beyond white: linear, any finite value. Scaled, cropped and compared as such.
using LinearImage = BasicImage<float>;

// Empty: there is none.
using AnyImage = std::variant<Image, DeepImage, LinearImage>;

} // namespace fvv::media

namespace fvv::scene {

// What options say in place of a capture.json; empty: nothing.
struct Inputs {
  // Patterns of spec/capture.md, relative to the working folder; of pictures and masks with {name} or {id} of
  // the camera. A name of the atlas, of pictures or masks that ends in .mp4, .mov, .mkv, .webm or .avi is a
  // video, which begins with the first frame. atlas: also "embedded", the pictures that glTF and OBJ files
  // bring, or "none"; absent: embedded, where there are such pictures and no cameras.
  std::string meshes, atlas, pictures, masks;
  std::optional<fvv_rational> frame_duration; // seconds; else 1/25
  // As in capture.json. Default: those of glTF where meshes are glTF and there is no calibration, else
  // unknown.
  std::string units, up;
  bool bake_repeats = false; // as Atlas has it

  bool is_given() const;
};

} // namespace fvv::scene
