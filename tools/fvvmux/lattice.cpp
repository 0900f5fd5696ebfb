// The lattice step: as fine as the cameras can see, and no finer.
#include "cli/cli.h"
#include "fvvmux/plan.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace fvv::mux {

namespace {

struct Box {
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};

  // Coordinates that are not finite are for the canonicaliser to refuse, with the vertex named.
  explicit Box(const capture::Mesh &mesh) {
    for (size_t i = 0; i < mesh.positions.size(); i++) {
      const double x = mesh.positions[i];
      if (!std::isfinite(x)) continue;
      low[i % 3] = std::min(low[i % 3], x);
      high[i % 3] = std::max(high[i % 3], x);
    }
  }
  double diagonal() const { return std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]); }
  // To the nearest point of the box, from inside to its centre.
  double distance(const double point[3]) const {
    double outside[3], inward[3];
    for (int k = 0; k < 3; k++) {
      outside[k] = std::max({low[k] - point[k], point[k] - high[k], 0.0});
      inward[k] = (low[k] + high[k]) / 2 - point[k];
    }
    const double d = std::hypot(outside[0], outside[1], outside[2]);
    return d > 0 ? d : std::hypot(inward[0], inward[1], inward[2]);
  }
};

std::string text(const char *format, double a, double b = 0, double c = 0) {
  char buffer[160];
  std::snprintf(buffer, sizeof buffer, format, a, b, c);
  return buffer;
}

// Steps of error that leave room for rounding to the lattice within an error; metres.
uint32_t steps_within(double error, double step) {
  return uint32_t(std::clamp(error / step - 0.5 + 1e-9, 0.0, 32767.0)); // libfvv takes no more
}

// The camera in which a step covers most pixels: metres per pixel at its distance.
struct Nearest {
  double metres_per_pixel = INFINITY, distance = 0;
  uint16_t camera = 0;
};

void look(Nearest &nearest, const Box &box, const fvv_camera &camera, double scale_x, double scale_y) {
  double centre[3];
  fvv_camera_centre(&camera, centre);
  const double distance = box.distance(centre);
  const double pixel = distance / std::max(camera.fx * scale_x, camera.fy * scale_y);
  if (pixel < nearest.metres_per_pixel) nearest = {pixel, distance, camera.id};
}

// Cameras whose pictures are transmitted, at the size in which they are; without any, all cameras.
Nearest nearest_camera(const capture::Capture &capture, const Tiling &tiling, const Box &box) {
  Nearest nearest;
  for (size_t i = 0; i < tiling.tiles.size(); i++) {
    const fvv_tile &tile = tiling.tiles[i];
    look(nearest, box, capture.cameras[tiling.cameras[i]].calibration,
         double(tile.destination.width) / tile.source.width,
         double(tile.destination.height) / tile.source.height);
  }
  if (tiling.tiles.empty())
    for (const capture::Camera &camera : capture.cameras) look(nearest, box, camera.calibration, 1, 1);
  return nearest;
}

} // namespace

double round_down_125(double value) {
  // 10^|k| is exact up to 22, and so the quotient is the double nearest to the decimal.
  const auto candidate = [](int mantissa, int k) {
    return k < 0 ? mantissa / std::pow(10.0, -k) : mantissa * std::pow(10.0, k);
  };
  const int guess = int(std::floor(std::log10(value)));
  double best = 0;
  for (int k = guess - 1; k <= guess + 1; k++)
    for (const int mantissa : {1, 2, 5})
      if (candidate(mantissa, k) <= value) best = candidate(mantissa, k);
  return best;
}

LatticeChoice choose_lattice(const Options &options, const capture::Capture &capture, const Tiling &tiling,
                             bool tracked) {
  LatticeChoice choice;
  if (capture.lattice) choice.lattice = *capture.lattice;
  const char *unit = capture.scale_unknown ? "units" : "m";
  const bool chosen = options.lattice_step || capture.lattice;
  if (options.lattice_step) {
    if (options.lattice_step->metric && capture.scale_unknown)
      throw cli::Failure(
          "--lattice-step: expected a plain number of the capture's units, because its scale is "
          "unknown",
          cli::usage);
    choice.lattice.step = options.lattice_step->value;
    choice.reason = "as --lattice-step says";
  } else if (capture.lattice) {
    choice.reason = "as the capture says";
  }
  if (!capture.meshes) {
    if (!chosen) choice.reason = "there are no meshes";
    return choice;
  }
  const std::string first = capture.mesh_path(capture.frames.first);
  const Box box(capture::load_mesh(capture, capture.frames.first));
  const Nearest nearest = nearest_camera(capture, tiling, box);
  const bool seen = std::isfinite(nearest.metres_per_pixel) && nearest.metres_per_pixel > 0;
  if (!chosen) {
    const double wanted = seen ? 2 * pixel_budget * nearest.metres_per_pixel : box.diagonal() / 8192;
    if (!std::isfinite(wanted) || !(wanted > 1e-20) || wanted > 1e20)
      throw cli::Failure(first + ": expected a mesh with some extent to choose the lattice by; give "
                                 "--lattice-step");
    // A third: room for rounding and one step of error in delta frames.
    choice.lattice.step = round_down_125(tracked ? wanted / 3 : wanted);
    if (tracked) choice.delta_error = steps_within(wanted / 2, choice.lattice.step);
    choice.reason =
        seen ? text("for %g px at camera %g, %.3g ", pixel_budget, nearest.camera, nearest.distance) + unit +
                   " from the first mesh"
             : text("1/8192 of the first mesh's diagonal of %.4g ", box.diagonal()) + unit;
  }
  if (chosen && tracked && seen)
    choice.delta_error = steps_within(pixel_budget * nearest.metres_per_pixel, choice.lattice.step);
  if (seen) choice.pixels = choice.error() / nearest.metres_per_pixel;
  return choice;
}

} // namespace fvv::mux
