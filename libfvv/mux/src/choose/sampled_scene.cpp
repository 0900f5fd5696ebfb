#include "mux/src/choose/sampled_scene.h"
#include "fvv_media/packed_image.h"
#include "mux/src/choose/choices.h"
#include "mux/src/meshes/meshes.h"
#include "mux/src/pictures.h"

#include <algorithm>
#include <set>

namespace fvv::mux {

namespace {

constexpr size_t most_kept = size_t(256) << 20; // bytes of pictures

} // namespace

struct SampledScene::Kept {
  media::PackedImage<uint8_t> picture, mask; // without gains
};

std::vector<SampledMesh> sample_meshes(const scene::Capture &capture) {
  std::vector<SampledMesh> out;
  if (!capture.meshes) return out;
  const std::vector<int64_t> numbers = capture.mesh_frames();
  for (const int64_t number : std::set<int64_t>{numbers.front(), numbers[numbers.size() / 2], numbers.back()})
    out.push_back({number, frame_mesh(capture, number)});
  return out;
}

decimate::Sight sharpest(const geometry::Mesh &mesh, const decimate::Footprint &cameras) {
  constexpr size_t enough = 20000;
  const size_t stride = 1 + mesh.vertex_count() / enough;
  decimate::Sight best;
  for (size_t v = 0; v < mesh.vertex_count(); v += stride) {
    const decimate::Sight sight = cameras.look(&mesh.positions[3 * v]);
    if (sight.metres_per_pixel < best.metres_per_pixel) best = sight;
  }
  return best;
}

SampledScene::SampledScene(const scene::Capture &of_plan, std::vector<SampledMesh> meshes,
                           const Tiling &cameras)
    : capture(of_plan) {
  for (SampledMesh &sampled : meshes) {
    if (capture.flip_faces) geometry::flip_faces(sampled.mesh);
    decimate::Footprint seen = footprint(capture, cameras, sampled.number);
    const decimate::Sight nearest = mux::sharpest(sampled.mesh, seen);
    all.push_back({std::move(sampled), std::move(seen), nearest});
  }
}

const SampledScene::Frame &SampledScene::middle() const {
  const std::vector<int64_t> numbers = capture.mesh_frames();
  return *std::find_if(all.begin(), all.end(),
                       [&](const Frame &frame) { return frame.number == numbers[numbers.size() / 2]; });
}

geometry::Mesh SampledScene::first_with_normals() const {
  return frame_mesh(capture, first().number, nullptr, true);
}

geometry::Mesh SampledScene::mesh(int64_t number) const {
  const auto known =
      std::find_if(all.begin(), all.end(), [&](const Frame &frame) { return frame.number == number; });
  return known == all.end() ? frame_mesh(capture, number) : known->mesh;
}

double SampledScene::constant_topology_fraction() const {
  constexpr int64_t most = 8; // pairs
  const std::vector<int64_t> numbers = capture.mesh_frames();
  const int64_t pairs = int64_t(numbers.size()) - 1, looked_at = std::min(most, pairs);
  int64_t same = 0;
  const auto load_at = [&](int64_t i) { return mesh(numbers[size_t(i)]); };
  for (int64_t k = 0; k < looked_at; k++) {
    const int64_t i = looked_at > 1 ? k * (pairs - 1) / (looked_at - 1) : 0;
    same += same_connectivity(load_at(i), load_at(i + 1)).has_value();
  }
  return looked_at > 0 ? double(same) / double(looked_at) : 0;
}

SampledScene::View SampledScene::load(const Plan &plan, size_t camera, int64_t number) const {
  const scene::Camera &source = capture.cameras[camera];
  // Frames in memory are converted with their gains, before they lose bits.
  const bool keeps = !capture.memory && number == middle().number;
  if (keeps) {
    std::unique_lock<std::mutex> lock(mutex);
    if (const auto known = kept.find(camera); known != kept.end()) {
      const std::shared_ptr<const Kept> found = known->second;
      lock.unlock();
      View out = {found->picture.image(), found->mask.image()};
      apply_gains(plan, camera, out.picture);
      return out;
    }
  }
  View out = {load_display(plan, camera, number), {}};
  if (source.masks) out.mask = load_view<uint8_t>(plan, camera, *source.masks, number, 1);
  if (keeps && !plan.match.tables) {
    auto packed = std::make_shared<const Kept>(
        Kept{media::PackedImage<uint8_t>(out.picture), media::PackedImage<uint8_t>(out.mask)});
    const size_t bytes = packed->picture.bytes() + packed->mask.bytes();
    const std::lock_guard<std::mutex> lock(mutex);
    if (kept_bytes + bytes <= most_kept && kept.emplace(camera, std::move(packed)).second)
      kept_bytes += bytes;
  }
  return out;
}

std::optional<SampledScene::View> SampledScene::view(const Plan &plan, size_t camera, int64_t number,
                                                     const fvv_camera &calibration) const {
  View out = load(plan, camera, number);
  if (out.picture.width != calibration.width || out.picture.height != calibration.height) return {};
  return out;
}

} // namespace fvv::mux
