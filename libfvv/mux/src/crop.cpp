#include "mux/src/crop.h"
#include "fvv_cxx/parallel.h"
#include "mux/src/meshes/meshes.h"
#include "mux/src/pictures.h"

#include <algorithm>
#include <cmath>

namespace fvv::mux {

namespace {

Silhouette everything(const fvv_camera &camera) {
  return {0, 0, camera.width, camera.height};
}

Silhouette box_of(const media::Image &mask) {
  Silhouette box;
  for (uint32_t y = 0; y < mask.height; y++) {
    const auto begin = mask.pixels.begin() + std::ptrdiff_t(y) * mask.width, end = begin + mask.width;
    const auto set = [](uint8_t value) { return value > 127; };
    const auto first = std::find_if(begin, end, set);
    if (first == end) continue;
    const auto last = std::find_if(std::reverse_iterator(end), std::reverse_iterator(first), set);
    box.add({uint32_t(first - begin), y, uint32_t(last.base() - begin), y + 1});
  }
  return box;
}

std::vector<Silhouette> boxes_of_frame(const Plan &plan, const std::vector<size_t> &cameras, int64_t number) {
  const scene::Capture &capture = plan.capture;
  std::vector<Silhouette> boxes;
  std::optional<geometry::Mesh> mesh;
  for (const size_t index : cameras) {
    const scene::Camera &camera = capture.cameras[index];
    switch (crop_by(capture, camera)) {
    case CropBy::masks:
      boxes.push_back(box_of(load_view<uint8_t>(plan, index, *camera.masks, number, 1)));
      break;
    case CropBy::mesh:
      if (!mesh && capture.has_mesh(number)) mesh = frame_mesh(capture, number);
      boxes.push_back(mesh && camera.is_calibrated(number) ? box_of_mesh(*mesh, camera.calibration_at(number))
                                                           : Silhouette{});
      break;
    case CropBy::nothing:
      boxes.push_back(everything(camera.calibration));
    }
  }
  return boxes;
}

} // namespace

Silhouette box_of_mesh(const geometry::Mesh &mesh, const fvv_camera &camera) {
  double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
  for (size_t v = 0; v < mesh.vertex_count(); v++) {
    double pixel[2], depth;
    if (!fvv_camera_project(&camera, &mesh.positions[3 * v], pixel, &depth)) {
      if (!(depth > 0)) return everything(camera);
      continue;
    }
    for (int axis = 0; axis < 2; axis++) {
      low[axis] = std::min(low[axis], pixel[axis]);
      high[axis] = std::max(high[axis], pixel[axis]);
    }
  }
  if (!(low[0] < camera.width && low[1] < camera.height && high[0] >= 0 && high[1] >= 0)) return {};
  const auto within = [](double value, uint32_t most) {
    return uint32_t(std::clamp(std::floor(value), 0.0, double(most)));
  };
  return {within(low[0], camera.width - 1), within(low[1], camera.height - 1),
          within(high[0] + 1, camera.width), within(high[1] + 1, camera.height)};
}

CropBy crop_by(const scene::Capture &capture, const scene::Camera &camera) {
  return camera.masks ? CropBy::masks : capture.meshes ? CropBy::mesh : CropBy::nothing;
}

void Silhouette::add(const Silhouette &other) {
  if (other.empty()) return;
  if (empty()) {
    *this = other;
    return;
  }
  left = std::min(left, other.left);
  top = std::min(top, other.top);
  right = std::max(right, other.right);
  bottom = std::max(bottom, other.bottom);
}

std::vector<std::vector<Silhouette>> silhouettes(const Plan &plan, const std::vector<size_t> &cameras) {
  std::vector<std::vector<Silhouette>> frames(plan.frame_count());
  fvv::parallel(plan.options.threads, frames.size(), [&](size_t i) {
    frames[i] = boxes_of_frame(plan, cameras, plan.capture.frames.number(int64_t(i)));
  });
  std::vector<std::vector<Silhouette>> groups(plan.group_count(), std::vector<Silhouette>(cameras.size()));
  for (size_t i = 0; i < frames.size(); i++)
    for (size_t k = 0; k < cameras.size(); k++) groups[plan.group_of(i)][k].add(frames[i][k]);
  return groups;
}

std::vector<Silhouette> silhouettes(const Plan &plan, const std::vector<size_t> &cameras, size_t group) {
  std::vector<Silhouette> all(cameras.size());
  const size_t first = plan.first_of(group);
  for (size_t i = first; i < first + plan.frames_of(group); i++) {
    const std::vector<Silhouette> frame =
        boxes_of_frame(plan, cameras, plan.capture.frames.number(int64_t(i)));
    for (size_t k = 0; k < cameras.size(); k++) all[k].add(frame[k]);
  }
  return all;
}

} // namespace fvv::mux
