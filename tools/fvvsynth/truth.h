// What a capture's pictures and meshes truly show, as files for measurements: depth and visibility. Knows the
// formats of those files; knows no scene and no folder.
#pragma once

#include "fvv_render/picture.h"

#include <vector>

namespace fvv::synth {

// An OpenEXR file with the one channel Z, float32: the depth of the picture as it is.
std::vector<uint8_t> depth_exr(const render::Picture &picture);

// NumPy files (format 1.0) of Boolean arrays [cameras, faces] and [cameras, vertices].
struct VisibilityFiles {
  std::vector<uint8_t> faces, vertices;
};

// What the cameras see of a mesh, by fvv_render/ray_visibility.h. positions in metres, three indices a face.
// copies: what the columns of vertices are, each a vertex of this mesh (a seam gives one several); NULL: its
// vertices as they are.
VisibilityFiles visibility_files(const std::vector<fvv_camera> &cameras, const std::vector<float> &positions,
                                 const std::vector<uint32_t> &faces,
                                 const std::vector<uint32_t> *copies = nullptr);

} // namespace fvv::synth
