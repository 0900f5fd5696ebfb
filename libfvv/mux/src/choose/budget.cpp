#include "fvv_cxx/error.h"
#include "fvv_cxx/format.h"
#include "fvv_geometry/pieces.h"
#include "mux/src/choose/choices.h"
#include "mux/src/meshes/meshes.h"
#include "mux/src/options/presets.h"
#include "mux/src/terms.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace fvv::mux {

namespace {

// Steps of error that leave room for rounding to the lattice within an error; metres.
uint32_t steps_within(double error, double step) {
  return uint32_t(std::clamp(error / step - 0.5 + 1e-9, 0.0, 32767.0)); // libfvv takes no more
}

} // namespace

decimate::Footprint footprint(const scene::Capture &capture, const Tiling &tiling, int64_t frame,
                              bool is_length) {
  return is_length ? decimate::Footprint::uniform(1) : footprint(capture, tiling, frame);
}

decimate::Footprint footprint(const scene::Capture &capture, const Tiling &tiling, int64_t frame) {
  decimate::Footprint cameras;
  // A camera without calibration in this frame is ignored; if all lack it, other frames are used.
  bool empty = true;
  for (const bool lost : {false, true}) {
    const auto add = [&](const scene::Camera &camera, double across, double down) {
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
      for (const scene::Camera &camera : capture.cameras) add(camera, 1, 1);
    if (!empty) break;
  }
  return cameras;
}

namespace {

// One frame that is far larger or smaller than the others does not decide.
double typical_diagonal(const SampledScene &scene) {
  std::vector<double> diagonals;
  for (const SampledScene::Frame &frame : scene.frames())
    diagonals.push_back(geometry::typical_box(frame.mesh).diagonal());
  std::sort(diagonals.begin(), diagonals.end());
  return diagonals[(diagonals.size() - 1) / 2];
}

const char *unit_of(const scene::Capture &capture) {
  return capture.scale_unknown ? "units" : "m";
}

// Beyond this number of steps a coordinate has no float of its own.
constexpr double far_from_origin = 1 << 24;

// Coordinates of maps lie hundreds of kilometres from 0, where a lattice from there does not reach, and where
// floats are coarse. The origin moves to whole units near the mesh then.
void place_origin(const geometry::Mesh &mesh, geometry::Lattice &lattice) {
  const geometry::TypicalBox box = geometry::typical_box(mesh);
  double furthest = 0;
  for (size_t k = 0; k < 3; k++) furthest = std::max({furthest, std::abs(box.low[k]), std::abs(box.high[k])});
  if (furthest <= far_from_origin * lattice.step || furthest <= box.diagonal()) return;
  for (size_t k = 0; k < 3; k++) lattice.origin[k] = std::round((box.low[k] + box.high[k]) / 2);
}

} // namespace

ErrorBudget choose_budget(const Options &options, const SampledScene &scene) {
  const scene::Capture &capture = scene.of();
  ErrorBudget error;
  if (!capture.meshes) return error;
  error.nearest = scene.first().sharpest;
  const bool seen = std::isfinite(error.nearest.metres_per_pixel);
  if (const std::optional<MaxError> &wanted = options.max_error) {
    error.value = wanted->value;
    if (wanted->unit == MaxError::metres && capture.scale_unknown)
      throw Error(option_name("max-error") +
                      ": expected pixels or, without cameras, a plain number of the capture's units, "
                      "because its scale is unknown",
                  Error::usage);
    error.is_length = wanted->unit == MaxError::metres ||
                      (wanted->unit == MaxError::plain && !seen && capture.scale_unknown);
    error.reason = "as " + option_name("max-error") + " says";
    if (!error.is_length && !seen)
      throw Error(
          option_name("max-error") +
              fvv::format(": expected a length such as 1mm, because %s, found %g pixels",
                          capture.cameras.empty() ? "there are no cameras" : "no camera sees the first mesh",
                          wanted->value),
          Error::usage);
    return error;
  }
  if (seen) return error;
  const double diagonal = typical_diagonal(scene);
  error.is_length = true;
  error.value = diagonal / default_max_error_parts;
  error.reason =
      fvv::format("1/%g of a typical mesh's diagonal of %.4g ", default_max_error_parts, diagonal) +
      unit_of(capture);
  return error;
}

void allow_error(LatticeChoice &choice, const ErrorBudget &error, bool has_constant_topology) {
  const double pixel = error.nearest.metres_per_pixel;
  const double allowed = error.is_length ? error.value : error.value * pixel;
  choice.delta_error = has_constant_topology ? steps_within(allowed, choice.lattice.step) : 0;
  choice.pixels = std::isfinite(pixel) ? choice.error() / pixel : 0;
}

LatticeChoice choose_lattice(const Options &options, const SampledScene &scene, const ErrorBudget &error,
                             bool has_constant_topology, double delta_frames) {
  const scene::Capture &capture = scene.of();
  // A lattice of a fifth of the step costs a key 7 bits a vertex, one of a third 5; each saves a delta frame
  // about 2.
  constexpr double many = 6, some = 1;
  LatticeChoice choice;
  if (capture.lattice) choice.lattice = *capture.lattice;
  const bool chosen = options.step || capture.lattice;
  if (options.step) {
    if (options.step->metric && capture.scale_unknown)
      throw Error(option_name("step") +
                      ": expected a plain number of the capture's units, because its scale is "
                      "unknown",
                  Error::usage);
    choice.lattice.step = options.step->value;
    choice.reason = "as " + option_name("step") + " says";
  } else if (capture.lattice) {
    choice.reason = "as the capture says";
  }
  if (!capture.meshes) {
    if (!chosen) choice.reason = "there are no meshes";
    return choice;
  }
  const decimate::Sight &nearest = error.nearest;
  if (!chosen) {
    const double wanted = 2 * (error.is_length ? error.value : error.value * nearest.metres_per_pixel);
    if (!std::isfinite(wanted) || !(wanted > 1e-20) || wanted > 1e20)
      throw Error(capture.mesh_path(scene.first().number) +
                  ": expected a mesh with some extent to choose the lattice by; give " + option_name("step"));
    choice.lattice.step = geometry::round_down_125(wanted / (delta_frames >= many   ? 5
                                                             : delta_frames >= some ? 3
                                                                                    : 1));
    choice.reason =
        error.is_length
            ? fvv::format("for an error of %.3g ", error.value * (capture.scale_unknown ? 1 : 1000)) +
                  (capture.scale_unknown ? "units, " : "mm, ") + error.reason
            : fvv::format("for %g px at camera %u, %.3g ", error.value, nearest.camera, nearest.distance) +
                  unit_of(capture) + " from the first mesh";
  }
  if (!capture.lattice) place_origin(scene.first().mesh, choice.lattice);
  allow_error(choice, error, has_constant_topology);
  return choice;
}

bool warn_of_lattice(const Plan &plan) {
  const LatticeChoice &lattice = plan.lattice;
  if (!plan.options.max_error || !plan.capture.meshes || plan.view.on()) return false;
  const bool over = plan.error.is_length ? 0.5 * lattice.lattice.step > plan.error.value * (1 + 1e-9)
                                         : lattice.pixels > plan.error.value * (1 + 1e-9);
  if (over)
    plan.observer.warn(plan.capture.path + ": the lattice step of " +
                       length_text(plan, lattice.lattice.step) + ", " + lattice.reason +
                       ", errs by more than " + option_name("max-error") + " allows, " + budget_text(plan));
  return over;
}

DecimationChoice choose_decimation(const Options &options, const SampledScene &scene,
                                   const ErrorBudget &error, const LatticeChoice &lattice,
                                   const NormalChoice &normals) {
  const scene::Capture &capture = scene.of();
  DecimationChoice choice;
  choice.budget.pixels = error.value;
  choice.is_length = error.is_length;
  choice.budget.triangles = options.triangles;
  choice.budget.min_piece = options.min_component;
  choice.budget.checks = row_of(options.preset).checks;
  // Delta frames leave errors like those of a coarser lattice.
  choice.budget.lattice = lattice.lattice;
  choice.budget.lattice.step = 2 * lattice.error();
  const decimate::Footprint length = decimate::Footprint::uniform(1);
  for (const SampledScene::Frame &frame : scene.frames()) {
    const decimate::Sight sight = error.is_length ? sharpest(frame.mesh, length) : frame.sharpest;
    choice.pixel = std::min(choice.pixel, sight.metres_per_pixel);
  }
  if (options.keep_geometry) {
    choice.reason = "as " + option_name("keep-geometry") + " says";
  } else if (options.triangles) {
    choice.on = true;
    choice.reason = "as " + option_name("triangles") + " says";
  } else if (error.is_length && !options.max_error) {
    choice.reason = "no camera tells how large a pixel is, and " + option_name("max-error") +
                    " does not say how much may change";
  } else if (capture.lattice && !options.max_error) {
    choice.reason = "the capture brings its lattice, as meshes do that have been in a stream";
  } else if (capture.atlas && !options.max_error) {
    choice.reason = "there is an atlas, and how far texture slides is not measured";
  } else if (normals.bits && !options.max_error) {
    choice.reason = "normals are sent, and how far they turn is not measured";
  } else {
    choice.target_error = INFINITY;
    for (const SampledScene::Frame &frame : scene.frames())
      if (choice.target_error > 0)
        choice.target_error = decimate::find_target_error(
            frame.mesh, error.is_length ? length : frame.footprint, choice.budget, choice.target_error);
    choice.on = choice.target_error > 0;
    choice.reason = choice.on ? "for the budget" : "no decimation keeps the budget, the lattice included";
  }
  return choice;
}

TrackChoice choose_tracking(const Options &options, const SampledScene &scene, const NormalChoice &normals,
                            double constant_topology) {
  if (options.track == Track::never || !scene.of().meshes) return {};
  if (!scene.first().mesh.texture.empty() || scene.of().atlas)
    return {false, "meshes have texture coordinates, which tracking does not move"};
  if (normals.bits) return {false, "normals are sent, which tracking does not turn"};
  if (constant_topology >= 1) return {false, "the frames share their faces as they are"};
  return {true, "as " + option_name("track") + " says"};
}

bool warn_of_tracking(const Plan &plan) {
  if (plan.options.track != Track::always || plan.tracking.on || plan.has_constant_topology) return false;
  plan.observer.warn(plan.capture.path + ": no frame is tracked, as " + option_name("track", "always") +
                     " wants: " + plan.tracking.reason);
  return true;
}

std::string budget_text(const Plan &plan, double times) {
  const double value = times * plan.error.value;
  return plan.error.is_length ? length_text(plan, value) : fvv::format("%g px", value);
}

QuantisationLoss quantisation_loss(const geometry::Mesh &mesh, const geometry::Lattice &lattice,
                                   uint32_t min_component, bool decimated) {
  geometry::Mesh points = mesh; // as whole numbers, of which areas are exact
  for (size_t i = 0; i < points.positions.size(); i++)
    points.positions[i] = std::nearbyint((mesh.positions[i] - lattice.origin[i % 3]) / lattice.step);
  double whole = 0, lost = 0;
  for (size_t f = 0; f < mesh.face_count(); f++) {
    const double area = decimate::face_area(mesh, f);
    whole += area;
    if (!(decimate::face_area(points, f) > 0)) lost += area;
  }
  QuantisationLoss out;
  if (!(whole > 0)) return out;
  out.flat = decimate::flattened_pieces(mesh, lattice);
  // Faces with texture coordinates of their own stay two where they meet.
  if (!decimated && mesh.texture.empty()) lost += decimate::merged_area(mesh, lattice);
  out.share = lost / whole;
  if (decimated || !(lost > 0)) return out;
  decimate::Budget budget;
  budget.lattice = lattice;
  budget.min_piece = min_component;
  out.pieces = decimate::vanishing_pieces(mesh, budget);
  return out;
}

} // namespace fvv::mux
