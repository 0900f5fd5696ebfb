// Whether masks say anything: those that a camera's frames all have empty, or full, are mostly a mistake.
#include "fvv_cxx/parallel.h"
#include "mux/src/choose/choices.h"
#include "mux/src/crop.h"
#include "mux/src/pictures.h"
#include "mux/src/terms.h"

#include <algorithm>

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

} // namespace fvv::mux
