// What masks say: those that a camera's frames all have empty, or full, are mostly a mistake; others show
// whether the meshes are their hulls.
#include "fvv_cxx/format.h"
#include "fvv_cxx/parallel.h"
#include "mux/src/choose/choices.h"
#include "mux/src/crop.h"
#include "mux/src/meshes/meshes.h"
#include "mux/src/pictures.h"
#include "mux/src/terms.h"

#include <algorithm>
#include <cmath>

namespace fvv::mux {

namespace {

constexpr double least_of_vertices = 0.01; // of a mesh's vertices, that are in the picture
constexpr double most_covered = 0.9;       // of a picture that is not filled by the mesh

// What the masks of a camera have in some frame.
struct MaskContent {
  bool foreground = false, background = false;

  bool says_something() const { return foreground && background; }
};

MaskContent content_of(const Plan &plan, size_t camera) {
  const scene::PictureSource &masks = *plan.capture.cameras[camera].masks;
  MaskContent out;
  const size_t count = masks.is_constant() ? 1 : plan.frame_count();
  for (size_t i = 0; i < count && !out.says_something(); i++) {
    plan.observer.check_cancelled();
    const int64_t number = plan.capture.frames.number(int64_t(i));
    for (const uint8_t value : load_view<uint8_t>(plan, camera, masks, number, 1).pixels)
      (value > 127 ? out.foreground : out.background) = true;
  }
  return out;
}

// How a mesh is in a camera's picture.
struct MeshInPicture {
  bool within = false, fills = false;
};

MeshInPicture look(const geometry::Mesh &mesh, const fvv_camera &camera) {
  MeshInPicture out;
  size_t within = 0;
  for (size_t v = 0; v < mesh.vertex_count(); v++) {
    double pixel[2];
    within += fvv_camera_project(&camera, &mesh.positions[3 * v], pixel, nullptr) == 1 && pixel[0] >= 0 &&
              pixel[1] >= 0 && pixel[0] < camera.width && pixel[1] < camera.height;
  }
  out.within = within && double(within) >= least_of_vertices * double(mesh.vertex_count());
  const Silhouette box = box_of_mesh(mesh, camera);
  const double covered = double(box.right - box.left) * double(box.bottom - box.top);
  out.fills = covered >= most_covered * camera.width * camera.height;
  return out;
}

} // namespace

bool warn_of_masks(const Plan &plan, const std::vector<SampledMesh> &meshes) {
  const scene::Capture &capture = plan.capture;
  if (capture.memory || meshes.empty()) return false;
  std::vector<std::string> warnings(capture.cameras.size());
  fvv::parallel(plan.options.threads, warnings.size(), [&](size_t i) {
    const scene::Camera &camera = capture.cameras[i];
    if (!camera.masks) return;
    bool within = true, fills = false;
    for (const auto &[number, mesh] : meshes) {
      const MeshInPicture found =
          camera.is_calibrated(number) ? look(mesh, camera.calibration_at(number)) : MeshInPicture{};
      within = within && found.within;
      fills = fills || found.fills;
    }
    if (!within) return;
    const MaskContent content = content_of(plan, i);
    const std::string where = capture.path + ": " + scene::describe(camera) + ": its masks are ";
    if (!content.foreground)
      warnings[i] = where + "empty in all frames, though the mesh is in its picture: expected foreground, "
                            "values above 127";
    else if (!content.background && !fills)
      warnings[i] = where + "full in all frames, though the mesh does not fill its picture: expected "
                            "background, values of 127 or less";
  });
  bool warned = false;
  for (const std::string &warning : warnings)
    if (!warning.empty()) {
      plan.observer.warn(warning);
      warned = true;
    }
  return warned;
}

std::shared_ptr<const std::vector<scene::Camera>> outline_cameras(std::vector<scene::Camera> cameras,
                                                                  const std::vector<media::MaskRule> &rules) {
  for (size_t i = 0; i < std::min(cameras.size(), rules.size()); i++)
    if (cameras[i].masks) cameras[i].masks->mask_rule = rules[i];
  return std::make_shared<const std::vector<scene::Camera>>(std::move(cameras));
}

std::vector<track::MaskView> mask_views(const scene::Capture &capture,
                                        const std::vector<scene::Camera> &cameras, scene::Videos &videos,
                                        const Tiling &tiling, int64_t frame) {
  const auto scale_of = [](const fvv_tile &tile) {
    return std::sqrt(double(tile.destination.width) / tile.source.width * double(tile.destination.height) /
                     tile.source.height);
  };
  double typical = 0; // of cameras whose pictures are not sent
  for (const fvv_tile &tile : tiling.tiles) typical += scale_of(tile) / double(tiling.tiles.size());
  std::vector<track::MaskView> out;
  for (const scene::Camera &camera : cameras) {
    if (!camera.masks || !camera.is_calibrated(frame)) continue;
    media::Image mask =
        about_frame(capture, frame, [&] { return videos.read<uint8_t>(capture, *camera.masks, frame, 1); });
    track::MaskView view = {camera.calibration_at(frame), std::move(mask.pixels)};
    if (view.camera.width != mask.width || view.camera.height != mask.height) continue; // refused elsewhere
    for (uint8_t &value : view.inside) value = value > 127;
    if (typical > 0) view.scale = typical;
    for (size_t k = 0; k < tiling.tiles.size(); k++)
      if (capture.cameras[tiling.cameras[k]].calibration.id == camera.calibration.id)
        view.scale = scale_of(tiling.tiles[k]);
    out.push_back(std::move(view));
  }
  return out;
}

void look_for_hulls(Plan &plan, const SampledScene &scene, const Tiling &tiling) {
  // Masks in memory lose their lens distortion with the pictures.
  if (!plan.tracking.on || plan.error.is_length || (!plan.outline_cameras && plan.undistortion)) return;
  const std::vector<scene::Camera> &cameras =
      plan.outline_cameras ? *plan.outline_cameras : plan.capture.cameras;
  std::vector<double> fractions;
  for (const SampledScene::Frame &frame : scene.frames()) {
    const std::vector<track::MaskView> masks =
        mask_views(plan.capture, cameras, *plan.videos, tiling, frame.number);
    if (masks.empty()) return;
    fractions.push_back(track::fraction_on_outlines(frame.mesh, masks));
  }
  const double fraction = *std::min_element(fractions.begin(), fractions.end());
  plan.tracking.by_outlines = fraction >= track::least_of_hull;
  if (!plan.tracking.by_outlines) return;
  plan.tracking.reason += fvv::format("; %.3g %% of the surface touch outlines of the masks, as hulls do: "
                                      "outlines decide, not the distance",
                                      100 * fraction);
  if (!plan.outline_cameras) return;
  for (const scene::Camera &camera : cameras)
    plan.outline_rules.push_back(camera.masks ? plan.videos->mask_rule(plan.capture, *camera.masks)
                                              : media::MaskRule::luma);
  plan.outline_cameras = outline_cameras(cameras, plan.outline_rules);
}

} // namespace fvv::mux
