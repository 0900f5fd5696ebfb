#include "fvvsynth/truth.h"

#include "fvv_media/exr.h"
#include "fvv_render/ray_visibility.h"

#include <string>

namespace fvv::synth {

namespace {

// The head of a .npy file, version 1.0, whose Booleans follow row by row:
// https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
std::vector<uint8_t> npy_head(size_t rows, size_t columns) {
  std::string text = "{'descr': '|b1', 'fortran_order': False, 'shape': (" + std::to_string(rows) + ", " +
                     std::to_string(columns) + "), }";
  constexpr size_t before = 10, alignment = 64;
  text.append(alignment - 1 - (before + text.size()) % alignment, ' ');
  text += '\n';
  const std::string magic("\x93NUMPY\x01\x00", 8);
  std::vector<uint8_t> bytes(magic.begin(), magic.end());
  bytes.push_back(uint8_t(text.size()));
  bytes.push_back(uint8_t(text.size() >> 8));
  bytes.insert(bytes.end(), text.begin(), text.end());
  return bytes;
}

} // namespace

std::vector<uint8_t> depth_exr(const render::Picture &picture) {
  media::FloatImage image;
  image.width = picture.width;
  image.height = picture.height;
  image.channels = {"Z"};
  image.samples = picture.depth;
  return media::encode_exr(image);
}

VisibilityFiles visibility_files(const std::vector<fvv_camera> &cameras, const std::vector<float> &positions,
                                 const std::vector<uint32_t> &faces, const std::vector<uint32_t> *copies) {
  const render::Mesh mesh = {positions.data(), positions.size() / 3, faces.data(), faces.size() / 3};
  const render::RayCaster rays(mesh);
  VisibilityFiles files = {npy_head(cameras.size(), mesh.face_count),
                           npy_head(cameras.size(), copies ? copies->size() : mesh.vertex_count)};
  const auto append = [](std::vector<uint8_t> &to, const std::vector<uint8_t> &row) {
    to.insert(to.end(), row.begin(), row.end());
  };
  for (const fvv_camera &camera : cameras) {
    append(files.faces, render::visible_faces(camera, mesh, rays));
    const std::vector<uint8_t> seen = render::visible_vertices(camera, mesh, rays);
    if (copies)
      for (const uint32_t vertex : *copies) files.vertices.push_back(seen[vertex]);
    else
      append(files.vertices, seen);
  }
  return files;
}

} // namespace fvv::synth
