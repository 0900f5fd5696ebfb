#include "decimate/attempt.h"
#include "decimate/fit.h"
#include "decimate/pieces.h"
#include "decimate/trial.h"

#include <algorithm>

namespace fvv::decimate {

namespace {

// One frame, ready to be decimated again and again.
class Frame {
public:
  Frame(const capture::Mesh &mesh, const Footprint &footprint, const Budget &wanted)
      : source(mesh), budget(wanted), alike(first_alike(mesh, true)), reference(mesh, footprint),
        simplifier(mesh, alike) {}

  bool seen() const { return std::isfinite(reference.sharpest()); }
  double sharpest() const { return reference.sharpest(); }

  // One simplification, measured. The report's error is infinite when nothing is left.
  Decimated attempt(const Reach &reach) const {
    const std::vector<bool> none;
    Outliers unwanted;
    Decimated out = simplified(reach, none);
    if (!out.mesh.faces.empty()) finish(out, compare::Faces(out.mesh), reach, none, unwanted);
    return out;
  }

  // False when the budget breaks at this reach. error: the rms in pixels that it came to.
  bool within(double reach, Decimated &out, double &error) const {
    const double limit = max_over_rms * budget.pixels;
    Trial trial(reference, limit);
    std::vector<bool> held;
    for (int round = 0; round < rounds; round++) {
      out = simplified({reach, 0}, held);
      error = out.report.error.rms_pixels;
      if (out.mesh.faces.empty()) return false;
      const compare::Faces surface(out.mesh);
      // Most of what is cut off is far off, whether vertices are fitted or not, and is given back at once.
      Outliers outliers = trial.look(out.mesh, out.vertices, surface);
      if (!outliers.vertices.empty() && round + 1 < rounds) {
        std::vector<bool> more = held;
        if (hold(source, alike, out.mesh, out.vertices, outliers, more)) {
          held.swap(more);
          continue;
        }
      }
      outliers = {};
      finish(out, surface, {reach, 0}, held, outliers);
      const Error &found = out.report.error;
      error = found.rms_pixels;
      if (error <= budget.pixels && found.max_pixels <= limit) return true;
      // A limb that is lost may be all that breaks the rms too.
      if (!hold(source, alike, out.mesh, out.vertices, outliers, held)) return false;
    }
    return false;
  }

private:
  // Without faces, and with an infinite error, when no surface is left.
  Decimated simplified(const Reach &reach, const std::vector<bool> &held) const {
    Decimated out;
    const std::vector<uint32_t> faces = simplifier.simplify(reach, held);
    if (!faces.empty()) out.mesh = compact(source, faces, out.vertices);
    if (faces.empty() || !sound(out.mesh)) {
      out.mesh = {};
      out.report.error = {INFINITY, INFINITY, INFINITY, INFINITY};
    }
    return out;
  }

  // Fits and measures. surface: of the mesh before.
  void finish(Decimated &out, const compare::Faces &surface, const Reach &reach,
              const std::vector<bool> &held, Outliers &outliers) const {
    fit(out.mesh, surface, source, fixed_by(held, out.vertices), reach.error > 0 ? reach.error : INFINITY);
    out.report = look_at(reference, out.mesh, budget, outliers);
    out.report.reach = reach.error;
    out.report.held_faces = size_t(std::count(held.begin(), held.end(), true));
  }

  // What is held is as good as it can be.
  std::vector<bool> fixed_by(const std::vector<bool> &held, const std::vector<uint32_t> &vertices) const {
    std::vector<bool> of_source(source.vertex_count()), fixed;
    for (size_t f = 0; f < held.size(); f++)
      for (size_t k = 0; held[f] && k < 3; k++) of_source[alike[source.faces[3 * f + k]]] = true;
    for (const uint32_t v : vertices) fixed.push_back(of_source[v]);
    return fixed;
  }

  const capture::Mesh &source;
  const Budget &budget;
  const std::vector<uint32_t> alike;
  const Reference reference;
  const Simplifier simplifier;
};

} // namespace

Decimated decimate(const capture::Mesh &given, const Footprint &footprint, const Budget &budget,
                   double reach) {
  if (!sound(given)) return as_it_is(given);
  Report before;
  std::vector<uint32_t> vertices;
  const capture::Mesh source = compact(given, without_specks(given, budget, before), vertices);
  Decimated out = as_it_is(source);
  if (sound(source)) {
    const Frame frame(source, footprint, budget);
    if (budget.triangles) {
      Decimated attempt = frame.attempt({0, budget.triangles});
      if (std::isfinite(attempt.report.error.rms)) out = std::move(attempt);
    } else if (frame.seen()) {
      for (int i = 0; i < attempts && reach > 0; i++) {
        Decimated attempt;
        double error;
        if (frame.within(reach, attempt, error)) {
          out = std::move(attempt);
          break;
        }
        reach = shorter(reach, error, budget);
      }
    }
  }
  if (!out.report.kept) out.report.vanished = vanished(source, out.mesh, out.vertices, budget);
  out.report.vanished.pieces += before.vanished.pieces;
  out.report.vanished.area += before.vanished.area;
  for (uint32_t &v : out.vertices) v = vertices[v];
  out.report.dropped_pieces = before.dropped_pieces;
  out.report.dropped_faces = before.dropped_faces;
  return out;
}

double find_reach(const capture::Mesh &given, const Footprint &footprint, const Budget &budget,
                  double at_most) {
  constexpr int steps = 6;
  constexpr double near_enough = 0.97;
  // Of the rms that it came to with hulls; any other guess costs an attempt.
  constexpr double reach_over_rms = 4;
  if (!sound(given)) return 0;
  Report unused;
  std::vector<uint32_t> vertices;
  const capture::Mesh source = compact(given, without_specks(given, budget, unused), vertices);
  if (!sound(source)) return 0;
  const Frame frame(source, footprint, budget);
  if (!frame.seen()) return 0;
  double good = 0, bad = INFINITY;
  double reach = std::isfinite(at_most) ? at_most : reach_over_rms * budget.pixels * frame.sharpest();
  for (int i = 0; i < steps && good < near_enough * bad; i++) {
    const double error = frame.attempt({reach, 0}).report.error.rms_pixels;
    (error <= budget.pixels ? good : bad) = reach;
    if (good >= at_most || (good == reach && error >= near_enough * budget.pixels)) break;
    // While nothing is good somewhat lower than in proportion, or steps down would become ever smaller.
    const double next =
        std::min(at_most, reach * std::clamp(budget.pixels / error, 0.25, 4.0) * (good > 0 ? 1 : 0.95));
    // Between what is good and what is bad, and not at either end, or the search would stand still.
    reach = std::isfinite(bad) && good > 0 ? std::clamp(next, good * 1.01, std::max(good * 1.01, bad * 0.99))
                                           : next;
  }
  return good;
}

} // namespace fvv::decimate
