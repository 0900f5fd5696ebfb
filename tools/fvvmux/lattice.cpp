// The lattice step: as fine as the cameras can see, and no finer.
#include "cli/cli.h"
#include "cli/format.h"
#include "fvvmux/plan.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace fvv::mux {

namespace {

// Coordinates that are not finite are for the canonicaliser to refuse, with the vertex named.
double diagonal_of(const capture::Mesh &mesh) {
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (size_t i = 0; i < mesh.positions.size(); i++) {
    const double x = mesh.positions[i];
    if (!std::isfinite(x)) continue;
    low[i % 3] = std::min(low[i % 3], x);
    high[i % 3] = std::max(high[i % 3], x);
  }
  return std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
}

// Steps of error that leave room for rounding to the lattice within an error; metres.
uint32_t steps_within(double error, double step) {
  return uint32_t(std::clamp(error / step - 0.5 + 1e-9, 0.0, 32767.0)); // libfvv takes no more
}

// The sharpest look at any of some vertices, enough of them to find it.
decimate::Sight sharpest(const capture::Mesh &mesh, const decimate::Footprint &cameras) {
  constexpr size_t enough = 20000;
  const size_t stride = 1 + mesh.vertex_count() / enough;
  decimate::Sight best;
  for (size_t v = 0; v < mesh.vertex_count(); v += stride) {
    const decimate::Sight sight = cameras.look(&mesh.positions[3 * v]);
    if (sight.metres_per_pixel < best.metres_per_pixel) best = sight;
  }
  return best;
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

decimate::Footprint footprint(const capture::Capture &capture, const Tiling &tiling, int64_t frame) {
  decimate::Footprint cameras;
  // Nobody sees the mesh through a camera that is lost; where all are, what they saw at another time counts.
  bool empty = true;
  for (const bool lost : {false, true}) {
    const auto add = [&](const capture::Camera &camera, double across, double down) {
      if (camera.is_calibrated(frame) == lost) return;
      cameras.add(lost ? camera.calibration : camera.calibration_at(frame), across, down);
      empty = false;
    };
    for (size_t i = 0; i < tiling.tiles.size(); i++) {
      const fvv_tile &tile = tiling.tiles[i];
      add(capture.cameras[tiling.cameras[i]], double(tile.destination.width) / tile.source.width,
          double(tile.destination.height) / tile.source.height);
    }
    if (tiling.tiles.empty())
      for (const capture::Camera &camera : capture.cameras) add(camera, 1, 1);
    if (!empty) break;
  }
  return cameras;
}

LatticeChoice choose_lattice(const Options &options, const capture::Capture &capture, const Tiling &tiling,
                             size_t delta_frames) {
  constexpr size_t many = 6; // they pay for two steps of error, fewer for one
  const bool tracked = delta_frames > 0;
  LatticeChoice choice;
  if (capture.lattice) choice.lattice = *capture.lattice;
  const char *unit = capture.scale_unknown ? "units" : "m";
  const bool chosen = options.step || capture.lattice;
  if (options.step) {
    if (options.step->metric && capture.scale_unknown)
      throw cli::Failure("--step: expected a plain number of the capture's units, because its scale is "
                         "unknown",
                         cli::usage);
    choice.lattice.step = options.step->value;
    choice.reason = "as --step says";
  } else if (capture.lattice) {
    choice.reason = "as the capture says";
  }
  if (!capture.meshes) {
    if (!chosen) choice.reason = "there are no meshes";
    return choice;
  }
  const std::string first = capture.mesh_path(capture.frames.first);
  const capture::Mesh mesh = capture::load_mesh(capture, capture.frames.first);
  const decimate::Sight nearest = sharpest(mesh, footprint(capture, tiling, capture.frames.first));
  const bool seen = std::isfinite(nearest.metres_per_pixel);
  const double pixels = options.max_error.value_or(default_max_error);
  if (!chosen) {
    const double wanted = seen ? 2 * pixels * nearest.metres_per_pixel : diagonal_of(mesh) / 8192;
    if (!std::isfinite(wanted) || !(wanted > 1e-20) || wanted > 1e20)
      throw cli::Failure(first + ": expected a mesh with some extent to choose the lattice by; give "
                                 "--step");
    choice.lattice.step = round_down_125(wanted / (delta_frames >= many ? 5 : tracked ? 3 : 1));
    if (tracked) choice.delta_error = steps_within(wanted / 2, choice.lattice.step);
    choice.reason =
        seen ? cli::format("for %g px at camera %u, %.3g ", pixels, nearest.camera, nearest.distance) + unit +
                   " from the first mesh"
             : cli::format("1/8192 of the first mesh's diagonal of %.4g ", diagonal_of(mesh)) + unit;
  }
  if (chosen && tracked && seen)
    choice.delta_error = steps_within(pixels * nearest.metres_per_pixel, choice.lattice.step);
  if (seen) choice.pixels = choice.error() / nearest.metres_per_pixel;
  return choice;
}

DecimationChoice choose_decimation(const Options &options, const capture::Capture &capture,
                                   const Tiling &tiling, const LatticeChoice &lattice,
                                   const NormalChoice &normals) {
  DecimationChoice choice;
  choice.budget.pixels = options.max_error.value_or(default_max_error);
  choice.budget.triangles = options.triangles;
  choice.budget.min_piece = options.min_component;
  // Delta frames leave errors like those of a coarser lattice.
  choice.budget.lattice = lattice.lattice;
  choice.budget.lattice.step = 2 * lattice.error();
  const capture::Frames &frames = capture.frames;
  std::vector<capture::Mesh> samples;
  std::vector<decimate::Footprint> cameras;
  for (const int64_t i : std::set<int64_t>{0, frames.count / 2, frames.count - 1}) {
    const int64_t number = frames.number(i);
    samples.push_back(capture::load_mesh(capture, number));
    cameras.push_back(footprint(capture, tiling, number));
    choice.pixel = std::min(choice.pixel, sharpest(samples.back(), cameras.back()).metres_per_pixel);
  }
  if (options.keep_geometry) {
    choice.reason = "as --keep-geometry says";
  } else if (options.triangles) {
    choice.on = true;
    choice.reason = "as --triangles says";
  } else if (!std::isfinite(choice.pixel)) {
    choice.reason = "no camera tells how large a pixel is";
  } else if (capture.lattice && !options.max_error) {
    choice.reason = "the capture brings its lattice, as meshes do that have been in a stream";
  } else if (capture.atlas && !options.max_error) {
    choice.reason = "there is an atlas, and how far texture slides is not measured";
  } else if (normals.bits && !options.max_error) {
    choice.reason = "normals are sent, and how far they turn is not measured";
  } else {
    choice.reach = INFINITY;
    for (size_t i = 0; i < samples.size() && choice.reach > 0; i++)
      choice.reach = decimate::find_reach(samples[i], cameras[i], choice.budget, choice.reach);
    choice.on = choice.reach > 0;
    choice.reason = choice.on ? "for the budget" : "no decimation keeps the budget, the lattice included";
  }
  return choice;
}

} // namespace fvv::mux
