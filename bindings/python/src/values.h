// What a frame holds, as Python sees it: meshes, cameras, pictures and sound. Arrays are read-only views of
// memory that the object owns, and keep it alive.
#pragma once

#include "fvv/stream.h"
#include "fvv_cxx/owned.h"
#include "fvv_demux/picture_decoder.h"
#include "fvv_demux/sounds.h"

#include <memory>
#include <pybind11/numpy.h>
#include <string>
#include <vector>

namespace fvv::python {

namespace py = pybind11;

// A decoded mesh. Floats are computed when they are first needed.
struct Mesh {
  OwnedMesh mesh;
  uint16_t track = 0;
  double origin[3] = {};
  double step = 1;
  std::vector<float> positions, normals, uvs;
  std::vector<double> far_positions; // in place of positions, where float32 does not hold the lattice
  std::vector<uint8_t> colours;      // R, G, B of each vertex; empty: none
};

// A camera with a name of its own.
struct Camera {
  explicit Camera(const fvv_camera &source);
  fvv_camera calibration; // without name
  std::string name;
};

// A camera's picture, or the atlas, in a frame of video.
struct Picture {
  std::shared_ptr<const demux::VideoFrame> frame; // linear light has become half floats when it is an array
  fvv_tile tile, whole;                           // as of fvv_demux/views.h
  std::shared_ptr<const Camera> camera; // of the pixels of the tile; NULL: the atlas, or not calibrated
  py::object half;                      // the pixels as float16, once they were needed
};

struct Sound {
  demux::UnpackedSound sound;
  int64_t first = 0;      // sample from which on the sound is heard
  fvv_rational time_base; // seconds per tick of its places
};

void register_values(py::module_ &module);

} // namespace fvv::python
