#include "fvvmux/winding.h"

#include "cli/cli.h"
#include "cli/format.h"
#include "cli/parallel.h"
#include "fvv_render/vector.h"
#include "fvvmux/body.h"

#include <algorithm>
#include <set>
#include <stdexcept>

namespace fvv::mux {

namespace {

using render::Vec3;

constexpr uint32_t picture_side = 480; // pixels; which side a face shows needs no more
constexpr double inside_out = 0.5;     // share from which on it is more likely than not

struct Pixels {
  uint64_t covered = 0, turned_away = 0;
};

// Of the surface nearest to a camera: holes of an open mesh let it see backs, but few.
Pixels look(const Body &body, const capture::Mesh &mesh, const fvv_camera &camera) {
  const double scale = std::min(1.0, double(picture_side) / std::max(camera.width, camera.height));
  const auto side = [&](uint32_t size) { return std::max<uint32_t>(1, uint32_t(size * scale)); };
  double centre[3];
  fvv_camera_centre(&camera, centre);
  Pixels out;
  for (const uint32_t face : body.nearest(resized(camera, side(camera.width), side(camera.height)))) {
    if (face == render::no_face) continue;
    const auto corner = [&](size_t c) {
      const double *p = &mesh.positions[3 * size_t(mesh.faces[3 * size_t(face) + c])];
      return Vec3{p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]};
    };
    const Vec3 a = corner(0);
    out.covered++;
    out.turned_away += dot(a, cross(corner(1) - a, corner(2) - a)) > 0;
  }
  return out;
}

std::vector<fvv_camera> cameras_at(const capture::Capture &capture, int64_t frame) {
  std::vector<fvv_camera> out;
  for (const capture::Camera &camera : capture.cameras)
    if (camera.is_calibrated(frame)) out.push_back(camera.calibration_at(frame));
  return out;
}

} // namespace

WindingChoice choose_winding(const Options &options, const capture::Capture &capture) {
  WindingChoice choice;
  const int64_t count = capture.frames.count;
  Pixels all;
  size_t meshes = 0, negative = 0;
  for (const int64_t i : std::set<int64_t>{0, count / 2, count - 1}) {
    const int64_t number = capture.frames.number(i);
    const capture::Mesh mesh = capture::load_mesh(capture, number);
    std::optional<Body> body;
    try {
      body.emplace(mesh.positions, mesh.faces);
    } catch (const std::invalid_argument &) {
      continue; // the canonicaliser says what is wrong
    }
    const std::vector<fvv_camera> cameras = cameras_at(capture, number);
    std::vector<Pixels> seen(cameras.size());
    cli::parallel(options.threads, cameras.size(),
                  [&](size_t k) { seen[k] = look(*body, mesh, cameras[k]); });
    for (const Pixels &pixels : seen) {
      all.covered += pixels.covered;
      all.turned_away += pixels.turned_away;
    }
    meshes++;
    negative += body->inside_out();
  }
  choice.by_cameras = all.covered > 0;
  if (choice.by_cameras)
    choice.turned_away = double(all.turned_away) / double(all.covered);
  else if (meshes)
    choice.turned_away = double(negative) / double(meshes);
  choice.flip = options.winding == Winding::flip ||
                (options.winding == Winding::automatic && choice.turned_away > inside_out);
  return choice;
}

bool warn_of_winding(const Plan &plan) {
  const WindingChoice &choice = plan.winding;
  if (choice.in_stream() <= inside_out || plan.options.winding == Winding::keep) return false;
  cli::warn(plan.capture.path + ": " + (choice.flip ? "with --winding flip " : "") + winding_text(choice) +
            ": the faces are inside out" +
            (choice.by_cameras ? ", and players find no colours for them" : "") +
            (choice.flip ? "" : " (--winding flip turns them round, keep says that they are meant so)"));
  return true;
}

std::string winding_text(const WindingChoice &choice) {
  const double percent = 100 * choice.in_stream();
  return choice.by_cameras
             ? cli::format("%.3g %% of the surface nearest to the cameras has its back to them", percent)
             : cli::format("%.3g %% of the sampled meshes enclose a negative volume", percent);
}

} // namespace fvv::mux
