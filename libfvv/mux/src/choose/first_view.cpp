// Where a viewer begins: the side of a camera whose picture shows the action whole and large.
#include "fvv_cxx/parallel.h"
#include "fvv_render/projection.h"
#include "mux/src/choose/choices.h"
#include "mux/src/pictures.h"

#include <algorithm>
#include <cmath>

namespace fvv::mux {

namespace {

using render::Vec3;

constexpr size_t enough = 4000;   // vertices
constexpr double as_whole = 0.05; // what a camera may show less than the one that shows most
constexpr double most_tilt =
    0.64; // sine of the angle between the direction of a camera and the horizon: 40 degrees

// What the picture of a camera shows of the meshes.
struct Shown {
  double share = 0; // of the vertices, 0 to 1: those in front of which nothing is
  double size = 0;  // how large, of the picture
  bool is_steep = false;
};

// mask: empty where the camera has none; then what is in the picture is taken to be seen.
void look(const SampledScene::Frame &frame, const fvv_camera &camera, const media::Image &mask,
          Shown &shown) {
  const size_t stride = 1 + frame.mesh.vertex_count() / enough;
  size_t seen = 0, all = 0;
  double near = 0, far = 0, centre[3];
  fvv_camera_centre(&camera, centre);
  for (size_t v = 0; v < frame.mesh.vertex_count(); v += stride, all++) {
    const double *p = &frame.mesh.positions[3 * v];
    double pixel[2];
    if (fvv_camera_project(&camera, p, pixel, nullptr) != 1) continue;
    if (!(pixel[0] >= 0 && pixel[1] >= 0 && pixel[0] < camera.width && pixel[1] < camera.height)) continue;
    const size_t x = size_t(pixel[0]), y = size_t(pixel[1]);
    if (!mask.pixels.empty() && mask.pixels[y * mask.width + x] <= 127) continue;
    seen++;
    const Vec3 ray = Vec3{p[0], p[1], p[2]} - Vec3{centre[0], centre[1], centre[2]};
    // What a square metre there covers, and how many such pictures a square metre takes.
    const double covers = camera.fx * camera.fy / (dot(ray, ray) * camera.width * camera.height);
    near += covers;
    far += 1 / covers;
  }
  if (!seen) return;
  shown.share += double(seen) / double(all);
  // The harmonic mean: what is far away counts most, so that one who stands before the camera is not all that
  // is seen. With a mask times what the surface covers over what it would if it faced the camera and nothing
  // hid anything else.
  const double size = double(seen) / far;
  const double covered = double(std::count_if(mask.pixels.begin(), mask.pixels.end(),
                                              [](uint8_t value) { return value > 127; })) /
                         (double(camera.width) * camera.height);
  shown.size += mask.pixels.empty() ? size : size * covered * double(seen) / near;
}

} // namespace

std::optional<uint16_t> choose_first_view(const Plan &plan, const SampledScene &scene) {
  const scene::Capture &capture = plan.capture;
  const std::vector<size_t> &cameras = plan.whole.cameras;
  if (scene.frames().empty() || cameras.size() < 2) return {};
  std::vector<const SampledScene::Frame *> frames = {&scene.first()};
  if (&scene.middle() != frames[0]) frames.push_back(&scene.middle());
  // Areas by masks and without cannot be compared.
  const bool by_masks = std::all_of(cameras.begin(), cameras.end(),
                                    [&](size_t i) { return capture.cameras[i].masks.has_value(); });
  std::optional<Vec3> up;
  if (capture.up != FVV_UP_UNKNOWN) up = render::up_vector(capture.up);
  std::vector<Shown> all(cameras.size());
  fvv::parallel(plan.options.threads, cameras.size(), [&](size_t k) {
    plan.observer.check_cancelled();
    const scene::Camera &camera = capture.cameras[cameras[k]];
    for (const SampledScene::Frame *frame : frames) {
      if (!camera.is_calibrated(frame->number)) continue;
      const fvv_camera at = camera.calibration_at(frame->number);
      media::Image mask;
      if (by_masks) mask = load_view<uint8_t>(plan, cameras[k], *camera.masks, frame->number, 1);
      // Another size is refused later.
      if (by_masks && (mask.width != at.width || mask.height != at.height)) continue;
      look(*frame, at, mask, all[k]);
      const double *r = at.rotation;
      if (up && std::abs(dot(Vec3{r[6], r[7], r[8]}, *up)) > most_tilt) all[k].is_steep = true;
    }
  });
  const bool all_steep = std::all_of(all.begin(), all.end(), [](const Shown &s) { return s.is_steep; });
  const auto counts = [&](const Shown &s) { return s.share > 0 && (all_steep || !s.is_steep); };
  double most = 0;
  for (const Shown &s : all)
    if (counts(s)) most = std::max(most, s.share);
  std::optional<size_t> best;
  for (size_t k = 0; k < all.size(); k++)
    if (counts(all[k]) && all[k].share >= most - as_whole * double(frames.size()) &&
        (!best || all[k].size > all[*best].size))
      best = k;
  if (!best) return {};
  return capture.cameras[cameras[*best]].calibration.id;
}

} // namespace fvv::mux
