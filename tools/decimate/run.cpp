#include "decimate/attempt.h"
#include "decimate/pieces.h"

#include <algorithm>
#include <map>

namespace fvv::decimate {

namespace {

// Vertices that are alike in every frame. What merely touches in the first one parts again.
std::vector<uint32_t> alike_throughout(const Frames &frames, const capture::Mesh &first) {
  std::vector<uint32_t> alike = first_alike(first, true);
  for (size_t i = 1; i < frames.count; i++) {
    const std::vector<uint32_t> here = first_alike(frames.mesh(i), true);
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> both;
    for (uint32_t v = 0; v < alike.size(); v++) {
      const auto [known, fresh] = both.try_emplace({alike[v], here[v]}, v);
      alike[v] = known->second;
    }
  }
  return alike;
}

// First, last, middle, and then the others: what breaks the budget anywhere tends to break it early.
std::vector<size_t> order_of(size_t count) {
  std::vector<size_t> order;
  for (const size_t i : {size_t(0), count - 1, count / 2})
    if (std::find(order.begin(), order.end(), i) == order.end()) order.push_back(i);
  for (size_t i = 1; i + 1 < count; i++)
    if (i != count / 2) order.push_back(i);
  return order;
}

} // namespace

// Measures frames until one is beyond the budget; worst: its rms in pixels. That one comes first next time:
// it is the most likely to be beyond it again. like: of any frame.
bool Run::try_faces(const Frames &frames, const Budget &budget, const Reference &like,
                    std::vector<size_t> &order, Outliers &outliers, double &worst) {
  for (size_t at = 0; at < order.size(); at++) {
    const size_t i = order[at];
    capture::Mesh source = frames.mesh(i);
    source.faces = large_pieces;
    if (!sound(source)) return false;
    std::vector<uint32_t> vertices;
    const capture::Mesh mesh = compact(source, faces, vertices);
    if (!sound(mesh)) return false;
    Report &report = reports[i];
    report = look_at(Reference(source, frames.footprint(i), &like), mesh, budget, outliers);
    report.vanished = vanished(source, mesh, vertices, budget);
    worst = report.error.rms_pixels;
    if (budget.triangles) continue;
    if (worst <= budget.pixels && report.error.max_pixels <= max_over_rms * budget.pixels) continue;
    std::rotate(order.begin(), order.begin() + std::ptrdiff_t(at), order.begin() + std::ptrdiff_t(at) + 1);
    return false;
  }
  return true;
}

Run::Run(const Frames &frames, const Budget &budget, double reach) : reports(frames.count) {
  capture::Mesh first = frames.mesh(0);
  large_pieces = first.faces;
  if (sound(first)) large_pieces = first.faces = without_specks(first, budget, dropped);
  if (!sound(first) || !(reach > 0 || budget.triangles)) return;
  const std::vector<uint32_t> alike = alike_throughout(frames, first);
  const Simplifier simplifier(first, alike);
  const Reference like(first, frames.footprint(0));
  std::vector<size_t> order = order_of(frames.count);
  for (int i = 0; i < attempts; i++) {
    std::vector<bool> held;
    double worst = 0;
    for (int round = 0; round < rounds; round++) {
      faces = simplifier.simplify({reach, budget.triangles}, held);
      Outliers outliers;
      if (try_faces(frames, budget, like, order, outliers, worst)) {
        for (Report &report : reports) {
          report.reach = reach;
          report.dropped_pieces = dropped.dropped_pieces;
          report.dropped_faces = dropped.dropped_faces;
          report.vanished.pieces += dropped.vanished.pieces;
          report.vanished.area += dropped.vanished.area;
          report.held_faces = size_t(std::count(held.begin(), held.end(), true));
        }
        return;
      }
      std::vector<uint32_t> vertices;
      const capture::Mesh mesh = compact(first, faces, vertices);
      if (!hold(first, alike, mesh, vertices, outliers, held)) break;
    }
    if (budget.triangles) break; // it failed for another reason than the budget
    reach = shorter(reach, worst, budget);
  }
  faces.clear();
}

Decimated Run::apply(const capture::Mesh &source, size_t frame) const {
  Decimated out;
  if (faces.empty()) {
    out.report = as_it_is(source).report;
    out.report.dropped_pieces = dropped.dropped_pieces;
    out.report.dropped_faces = dropped.dropped_faces;
    out.mesh = compact(source, large_pieces, out.vertices);
    return out;
  }
  out.mesh = compact(source, faces, out.vertices);
  out.report = reports[frame];
  return out;
}

} // namespace fvv::decimate
