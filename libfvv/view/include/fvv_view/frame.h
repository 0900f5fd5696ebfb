// One decoded frame of a stream: its mesh in metres, the pictures of its cameras, and their visibility of the
// mesh.
#pragma once

#include "fvv/stream.h"
#include "fvv_cxx/input_file.h"
#include "fvv_media/image.h"
#include "fvv_media/video.h"
#include "fvv_render/environment.h"
#include "fvv_render/rasteriser.h"
#include "fvv_render/vector.h"

#include <string>
#include <vector>

namespace fvv::view {

// The visibility of the vertices of the frame's mesh from one camera (fvv_visibility_weights).
struct CameraWeights {
  uint16_t camera;
  std::vector<uint8_t> weights;
};

struct Picture {
  fvv_camera camera; // of these pixels (fvv_camera_of_tile)
  media::DeepImage image;
  // In its place, of video in OpenEXR: display values, wide as render::SourceView::wide_pixels has them.
  media::BasicImage<float> wide;
};

struct Frame {
  std::string file; // as InputFile::path() names it
  int64_t number = 0;
  // What positions, cameras, pictures and environment count from, in the stream's coordinates: the lattice's
  // origin as far as that is beyond what float holds to a fraction of a step (coordinates of maps), else 0.
  render::Vec3 origin;
  std::vector<float> positions; // none: the stage is empty
  std::vector<uint32_t> faces;
  std::vector<fvv_camera> cameras;   // all of the stream, whole pictures; without names
  std::vector<Picture> pictures;     // in the order of the stream's tracks and tiles
  uint8_t up = 0;                    // FVV_UP_...
  fvv_texturing texturing = {};      // as the stream says, else the defaults
  std::vector<render::Vec3> normals; // of vertices, where the stream sends some or has seams; else none
  std::vector<CameraWeights> bits;
  std::vector<uint8_t> colours; // R, G, B of vertices; empty: the stream has none for this mesh
  std::vector<render::EnvironmentPart> environment; // empty: there is none
  std::vector<std::string>
      losses; // whole lines: pictures, visibility and colours of this frame that are lost or missing

  render::Mesh mesh() const {
    return {positions.data(), positions.size() / 3, faces.data(), faces.size() / 3};
  }
  const fvv_camera *camera(uint16_t id) const;         // NULL: there is none
  const CameraWeights *bits_of(uint16_t camera) const; // likewise
  std::string camera_ids() const;                      // "0, 1, 3"
};

struct LoadOptions {
  media::MemoryLimit memory;          // of decoding each track, and each picture of the environment
  bool pictures = true;               // of cameras
  size_t rung = 0;                    // of a ladder of quality (fvv_cxx/rung.h)
  const fvv_limits *limits = nullptr; // NULL: defaults
};

// Frame number of the stream, counted as fvvdemux does. Error when it is not there (usage), the stream has no
// meshes, or its mesh is damaged, or a picture takes more than memory. Nothing is read from file afterwards.
Frame load_frame(const InputFile &file, int64_t number, const LoadOptions &options = {});

} // namespace fvv::view
