// Decimation of single frames and of runs of frames that share their faces.

#include "fvv_geometry/decimate.h"
#include "fvv_geometry/mesh.h"
#include "fvv_geometry/pieces.h"
#include "geometry/src/fit.h"
#include "geometry/src/simplify.h"
#include "geometry/src/trial.h"

#include <algorithm>
#include <map>
#include <meshoptimizer.h>
#include <numeric>
#include <optional>

namespace fvv::decimate {

namespace {

// How often faces are locked before the target error is reduced.
constexpr int rounds = 6;

// How often the target error is reduced before the source is kept.
constexpr int attempts = 8;

// Rings of faces around an outlier that are locked with it: the surface stays fine there, and the transition
// to the coarse surface lies beyond.
constexpr int rings = 2;
// If more than one face in most_locked has to be locked, the simplifier went too far.
constexpr size_t most_locked = 16;
// When no target error suffices: how often it is reduced, by what factor at least, how often faces are
// locked, and that one face in two may be. Some places then keep all their triangles, and the others save
// some.
constexpr int last_attempts = 4, last_rounds = 16;
constexpr double last_factor = 0.7;
constexpr size_t most_locked_at_last = 2;

// Lattice points as integers, so that areas are exact.
geometry::Mesh on_points(const geometry::Mesh &mesh, const geometry::Lattice &lattice) {
  geometry::Mesh points = mesh;
  for (size_t i = 0; i < points.positions.size(); i++)
    points.positions[i] = std::nearbyint((mesh.positions[i] - lattice.origin[i % 3]) / lattice.step) + 0.0;
  return points;
}

// The faces of a mesh that remain after canonicalisation: those with an area, each set of three points once.
// Other faces must not count as surface.
std::vector<uint32_t> distinct_faces(const geometry::Mesh &points) {
  const std::vector<uint32_t> place = first_alike(points, false);
  std::vector<std::array<uint32_t, 4>> sets; // sorted places, face
  for (uint32_t f = 0; f < points.face_count(); f++) {
    if (!(face_area(points, f) > 0)) continue;
    const uint32_t *c = &points.faces[3 * size_t(f)];
    std::array<uint32_t, 4> set = {place[c[0]], place[c[1]], place[c[2]], f};
    std::sort(set.begin(), set.begin() + 3);
    sets.push_back(set);
  }
  std::sort(sets.begin(), sets.end());
  const auto last = std::unique(sets.begin(), sets.end(), [](const auto &a, const auto &b) {
    return std::equal(a.begin(), a.begin() + 3, b.begin());
  });
  std::vector<uint32_t> faces;
  for (auto set = sets.begin(); set != last; ++set) faces.push_back((*set)[3]);
  std::sort(faces.begin(), faces.end());
  return faces;
}

// The same on the lattice.
std::vector<uint32_t> lasting_faces(const geometry::Mesh &mesh, const geometry::Lattice &lattice) {
  return distinct_faces(on_points(mesh, lattice));
}

// The mesh that a decoder will return.
geometry::Mesh rounded(const geometry::Mesh &mesh, const geometry::Lattice &lattice,
                       const std::vector<uint32_t> &lasting) {
  geometry::Mesh out = mesh;
  for (size_t i = 0; i < out.positions.size(); i++) {
    const double origin = lattice.origin[i % 3];
    out.positions[i] = origin + lattice.step * std::nearbyint((mesh.positions[i] - origin) / lattice.step);
  }
  out.faces.clear();
  for (const uint32_t face : lasting)
    out.faces.insert(out.faces.end(), &mesh.faces[3 * size_t(face)], &mesh.faces[3 * size_t(face)] + 3);
  return out;
}

// Whether there is anything to decimate: finite coordinates, and an area.
bool sound(const geometry::Mesh &mesh) {
  if (!std::all_of(mesh.positions.begin(), mesh.positions.end(), [](double x) { return std::isfinite(x); }))
    return false;
  double area = 0;
  for (size_t f = 0; f < mesh.face_count(); f++) area += face_area(mesh, f);
  return area > 0 && std::isfinite(area);
}

// The faces of pieces that are not below the budget's min_piece and that do not vanish on the lattice, which
// no decimation can prevent. Other pieces are counted in report, as dropped and as vanished. All faces if no
// piece remains: the canonicaliser has a message for that. source has to be sound().
std::vector<uint32_t> without_specks(const geometry::Mesh &source, const Budget &budget, Report &report) {
  const Pieces pieces = find_pieces(source, first_alike(source, false));
  const geometry::Mesh points = on_points(source, budget.lattice);
  std::vector<bool> there(pieces.faces.size());
  const auto piece_of = [&](size_t face) { return pieces.of_vertex[source.faces[3 * face]]; };
  const auto small = [&](size_t piece) { return pieces.faces[piece] < budget.min_piece; };
  for (size_t f = 0; f < source.face_count(); f++)
    if (!there[piece_of(f)] && !small(piece_of(f))) there[piece_of(f)] = face_area(points, f) > 0;
  std::vector<uint32_t> faces;
  for (size_t f = 0; f < source.face_count(); f++)
    if (there[piece_of(f)]) faces.insert(faces.end(), &source.faces[3 * f], &source.faces[3 * f] + 3);
  if (faces.empty()) return source.faces;
  for (size_t i = 0; i < there.size(); i++) {
    if (small(i)) {
      report.dropped_pieces++;
      report.dropped_faces += pieces.faces[i];
    } else if (!there[i] && pieces.area[i] > 0) {
      report.vanished.pieces++;
      report.vanished.area += pieces.area[i];
    }
  }
  return faces;
}

// The unchanged source with its report.
Decimated as_it_is(const geometry::Mesh &source) {
  Decimated out;
  out.mesh = source;
  out.vertices.resize(source.vertex_count());
  std::iota(out.vertices.begin(), out.vertices.end(), 0);
  out.report.faces_before = out.report.faces_after = source.face_count();
  out.report.volume_before = out.report.volume_after = enclosed_volume(source);
  out.report.kept = true;
  return out;
}

} // namespace

Report measure_on_lattice(const Reference &reference, const geometry::Mesh &mesh, const Budget &budget,
                          Outliers &outliers, Looks looks) {
  const std::vector<uint32_t> lasting = lasting_faces(mesh, budget.lattice);
  const geometry::Mesh on_lattice = rounded(mesh, budget.lattice, lasting);
  Report report;
  report.faces_before = reference.mesh().face_count();
  report.faces_after = mesh.face_count();
  report.volume_before = enclosed_volume(reference.mesh());
  report.volume_after = enclosed_volume(on_lattice);
  const compare::Faces surface(on_lattice);
  if (!(surface.area() > 0)) {
    report.error = {INFINITY, INFINITY, INFINITY, INFINITY};
    return report;
  }
  report.error = reference.measure(surface, budget.most(), outliers, looks);
  for (uint32_t &face : outliers.faces) face = lasting[face];
  report.thin_area = outliers.area;
  return report;
}

namespace {

Pieces pieces_of(const geometry::Mesh &mesh) {
  return find_pieces(mesh, first_alike(mesh, false));
}

// Of a frame that is not measured, or not yet.
Report unmeasured_report(size_t faces_before, size_t faces_after) {
  Report report;
  report.faces_before = faces_before;
  report.faces_after = faces_after;
  report.measured = false;
  return report;
}

// Which pieces of a source the mesh, rounded to the lattice, does not contain. vertices: the vertex of the
// source for each vertex of mesh.
std::vector<bool> vanished_pieces(const Pieces &pieces, const geometry::Mesh &mesh,
                                  const std::vector<uint32_t> &vertices, const Budget &budget) {
  std::vector<bool> gone(pieces.faces.size());
  for (size_t i = 0; i < gone.size(); i++) gone[i] = pieces.area[i] > 0;
  for (const uint32_t face : lasting_faces(mesh, budget.lattice))
    gone[pieces.of_vertex[vertices[mesh.faces[3 * size_t(face)]]]] = false;
  return gone;
}

// Their number and area.
Lost vanished(const Pieces &pieces, const geometry::Mesh &mesh, const std::vector<uint32_t> &vertices,
              const Budget &budget) {
  const std::vector<bool> gone = vanished_pieces(pieces, mesh, vertices, budget);
  Lost lost;
  for (size_t i = 0; i < gone.size(); i++) {
    if (!gone[i]) continue;
    lost.pieces++;
    lost.area += pieces.area[i];
  }
  return lost;
}

// Adds to locked the faces of the source around outliers. Returns whether another round is worthwhile: there
// are new ones, and not more than one face in most.
bool lock_around(const geometry::Mesh &source, const std::vector<uint32_t> &alike,
                 const geometry::Mesh &decimated, const std::vector<uint32_t> &vertices,
                 const Outliers &outliers, size_t most, std::vector<bool> &locked) {
  std::vector<bool> marked(source.vertex_count());
  for (const uint32_t v : outliers.vertices) marked[alike[v]] = true;
  for (const uint32_t f : outliers.faces)
    for (size_t k = 0; k < 3; k++) marked[alike[vertices[decimated.faces[3 * size_t(f) + k]]]] = true;
  const auto count = [&] { return std::count(locked.begin(), locked.end(), true); };
  const auto before = count();
  locked.resize(source.face_count());
  for (int ring = 0; ring < rings; ring++) {
    std::vector<bool> wider = marked;
    for (size_t f = 0; f < source.face_count(); f++) {
      const uint32_t *c = &source.faces[3 * f];
      if (!marked[alike[c[0]]] && !marked[alike[c[1]]] && !marked[alike[c[2]]]) continue;
      locked[f] = true;
      for (size_t k = 0; k < 3; k++) wider[alike[c[k]]] = true;
    }
    marked.swap(wider);
  }
  return count() > before && size_t(count()) <= source.face_count() / most;
}

// The next, smaller target error after an error in pixels.
double shorter(double target_error, double pixels, const Budget &budget, bool last) {
  // The error is about proportional to the target error.
  return target_error * std::clamp(0.98 * budget.pixels / pixels, 0.3, last ? last_factor : 0.95);
}

// One frame, prepared for repeated decimation.
class Frame {
public:
  Frame(const geometry::Mesh &mesh, const Footprint &footprint, const Budget &wanted)
      : source(mesh), budget(wanted), alike(first_alike(mesh, true)), reference(mesh, footprint),
        simplifier(mesh, alike) {
    if (budget.checks == Checks::some) pieces = pieces_of(mesh);
  }

  bool seen() const { return std::isfinite(reference.sharpest()); }
  double sharpest() const { return reference.sharpest(); }

  // One simplification, measured. The report's error is infinite if nothing is left.
  Decimated attempt(const SimplifyTarget &target) const {
    const std::vector<bool> none;
    Outliers unwanted;
    Decimated out = simplified(target, none);
    if (!out.mesh.faces.empty()) finish(out, compare::Faces(out.mesh), target, none, unwanted);
    return out;
  }

  // Whether this target error is within the budget. error: the measured rms in pixels.
  bool within(double target_error, bool last, Decimated &out, double &error) const {
    const int rounds_here = last ? last_rounds : rounds;
    const size_t most = last ? most_locked_at_last : most_locked;
    const double limit = budget.most();
    Trial trial(reference, limit);
    std::vector<bool> locked;
    for (int round = 0; round < rounds_here; round++) {
      out = simplified({target_error, 0}, locked);
      error = out.report.error.rms_pixels;
      if (out.mesh.faces.empty()) return false;
      // A piece that is gone may be nearer to others than its places may be off.
      if (budget.checks == Checks::some && round + 1 < rounds_here && lock_vanished(out, locked)) continue;
      const compare::Faces surface(out.mesh);
      // Most parts that are cut off are far off even before vertices are fitted: their faces are locked at
      // once.
      Outliers outliers = trial.look(out.mesh, out.vertices, surface);
      if (!outliers.vertices.empty() && round + 1 < rounds_here) {
        std::vector<bool> more = locked;
        if (lock_around(source, alike, out.mesh, out.vertices, outliers, most, more)) {
          locked.swap(more);
          continue;
        }
      }
      outliers = {};
      finish(out, surface, {target_error, 0}, locked, outliers);
      const SurfaceError &found = out.report.error;
      error = found.rms_pixels;
      if (error <= budget.pixels && found.max_pixels <= limit) return true;
      // A lost limb may be the only reason for a large rms.
      if (!lock_around(source, alike, out.mesh, out.vertices, outliers, most, locked)) return false;
    }
    return false;
  }

private:
  // Without faces and with an infinite error if no surface is left.
  Decimated simplified(const SimplifyTarget &target, const std::vector<bool> &locked) const {
    Decimated out;
    const std::vector<uint32_t> faces = simplifier.simplify(target, locked);
    if (!faces.empty()) out.mesh = compact(source, faces, out.vertices);
    if (faces.empty() || !sound(out.mesh)) {
      out.mesh = {};
      out.report.error = {INFINITY, INFINITY, INFINITY, INFINITY};
    }
    return out;
  }

  // Locks the pieces of the source that are gone. Returns whether some of their faces were not locked.
  bool lock_vanished(const Decimated &out, std::vector<bool> &locked) const {
    const std::vector<bool> gone = vanished_pieces(pieces, out.mesh, out.vertices, budget);
    if (std::find(gone.begin(), gone.end(), true) == gone.end()) return false;
    locked.resize(source.face_count());
    bool is_new = false;
    for (size_t f = 0; f < source.face_count(); f++) {
      if (locked[f] || !gone[pieces.of_vertex[source.faces[3 * f]]]) continue;
      locked[f] = is_new = true;
    }
    return is_new;
  }

  // Fits and measures. surface: of the mesh before.
  void finish(Decimated &out, const compare::Faces &surface, const SimplifyTarget &target,
              const std::vector<bool> &locked, Outliers &outliers) const {
    fit(out.mesh, surface, source, fixed_by(locked, out.vertices),
        target.error > 0 ? target.error : INFINITY);
    out.report = measure_on_lattice(reference, out.mesh, budget, outliers);
    out.report.target_error = target.error;
    out.report.locked_faces = size_t(std::count(locked.begin(), locked.end(), true));
  }

  // Vertices of locked faces do not move.
  std::vector<bool> fixed_by(const std::vector<bool> &locked, const std::vector<uint32_t> &vertices) const {
    std::vector<bool> of_source(source.vertex_count()), fixed;
    for (size_t f = 0; f < locked.size(); f++)
      for (size_t k = 0; locked[f] && k < 3; k++) of_source[alike[source.faces[3 * f + k]]] = true;
    for (const uint32_t v : vertices) fixed.push_back(of_source[v]);
    return fixed;
  }

  const geometry::Mesh &source;
  const Budget &budget;
  const std::vector<uint32_t> alike;
  const Reference reference;
  const Simplifier simplifier;
  Pieces pieces; // with Checks::some
};

// The first target error within the budget, or nothing. source: as sound() wants it.
std::optional<Decimated> within_budget(const geometry::Mesh &source, const Footprint &footprint,
                                       const Budget &budget, double target_error) {
  const Frame frame(source, footprint, budget);
  for (int i = 0; i < attempts + last_attempts && target_error > 0 && frame.seen(); i++) {
    Decimated attempt;
    double error;
    const bool last = i >= attempts;
    if (frame.within(target_error, last, attempt, error)) return attempt;
    target_error = shorter(target_error, error, budget, last);
  }
  return {};
}

// A mesh with more faces is first simplified a little, and what is left stands for it: every attempt then
// takes a fraction of the time. Of 1.3 million faces, the simplifier takes three quarters of the time
// otherwise.
constexpr size_t many_faces = 200000;
// Of the target error that follows, and what the budget leaves for it.
constexpr double fine = 1.0 / 16;

struct Proxy {
  geometry::Mesh mesh;
  std::vector<uint32_t> vertices; // of the source
};

// Nothing where little is gained.
std::optional<Proxy> proxy_of(const geometry::Mesh &source, double target_error) {
  if (source.face_count() <= many_faces || !(target_error > 0)) return {};
  const std::vector<uint32_t> faces =
      Simplifier(source, first_alike(source, true)).simplify({fine * target_error, 0}, {});
  if (faces.empty() || faces.size() > source.faces.size() / 2) return {};
  Proxy proxy;
  proxy.mesh = compact(source, faces, proxy.vertices);
  if (!sound(proxy.mesh)) return {};
  return proxy;
}

// As within_budget, of a proxy; measured against the source. Nothing also where that breaks the budget.
std::optional<Decimated> by_proxy(const geometry::Mesh &source, const Footprint &footprint,
                                  const Budget &budget, double target_error) {
  const std::optional<Proxy> proxy = proxy_of(source, target_error);
  if (!proxy) return {};
  Budget tighter = budget;
  tighter.pixels *= 1 - fine;
  std::optional<Decimated> out = within_budget(proxy->mesh, footprint, tighter, target_error);
  if (!out) return {};
  for (uint32_t &v : out->vertices) v = proxy->vertices[v];
  Outliers unused;
  Report report = measure_on_lattice(Reference(source, footprint), out->mesh, budget, unused);
  report.target_error = out->report.target_error;
  report.locked_faces = out->report.locked_faces;
  out->report = report;
  if (report.error.rms_pixels > budget.pixels || report.error.max_pixels > budget.most()) return {};
  return out;
}

// The sharpest view of some vertices, which are enough to begin a search.
double sharpest(const geometry::Mesh &mesh, const Footprint &footprint) {
  double least = INFINITY;
  for (size_t v = 0; v < mesh.vertex_count(); v += 1 + mesh.vertex_count() / 1000)
    least = std::min(least, footprint.look(&mesh.positions[3 * v]).metres_per_pixel);
  return least;
}

// One simplification whose error is not measured; pieces that would vanish stay as they are. Nothing where no
// camera sees the mesh.
std::optional<Decimated> unmeasured(const geometry::Mesh &source, const Pieces &pieces,
                                    const Footprint &footprint, const Budget &budget, double target_error) {
  if (!(target_error > 0) || !std::isfinite(sharpest(source, footprint))) return {};
  std::vector<uint32_t> faces = Simplifier(source, first_alike(source, true)).simplify({target_error, 0}, {});
  Decimated out;
  out.mesh = compact(source, faces, out.vertices);
  const std::vector<bool> gone = vanished_pieces(pieces, out.mesh, out.vertices, budget);
  const size_t simplified = faces.size();
  for (size_t k = 0; k < source.faces.size(); k++)
    if (gone[pieces.of_vertex[source.faces[k - k % 3]]]) faces.push_back(source.faces[k]);
  if (faces.size() > simplified) out.mesh = compact(source, faces, out.vertices);
  if (!sound(out.mesh)) return {};
  out.report = unmeasured_report(source.face_count(), out.mesh.face_count());
  out.report.locked_faces = (faces.size() - simplified) / 3;
  out.report.target_error = target_error;
  return out;
}

} // namespace

Lost vanishing_pieces(const geometry::Mesh &source, const Budget &budget) {
  Report report;
  if (sound(source)) without_specks(source, budget, report);
  return report.vanished;
}

double merged_area(const geometry::Mesh &source, const geometry::Lattice &lattice) {
  const geometry::Mesh points = on_points(source, lattice);
  std::vector<bool> merged(source.face_count());
  for (const uint32_t face : distinct_faces(source)) merged[face] = face_area(points, face) > 0;
  for (const uint32_t face : distinct_faces(points)) merged[face] = false;
  double area = 0;
  for (size_t f = 0; f < merged.size(); f++)
    if (merged[f]) area += face_area(source, f);
  return area;
}

Decimated decimate(const geometry::Mesh &given, const Footprint &footprint, const Budget &budget,
                   double target_error) {
  if (!sound(given)) return as_it_is(given);
  Report before;
  std::vector<uint32_t> vertices;
  const geometry::Mesh source = compact(given, without_specks(given, budget, before), vertices);
  Decimated out = as_it_is(source);
  const Pieces pieces = pieces_of(source);
  if (sound(source) && budget.triangles) {
    Decimated attempt = Frame(source, footprint, budget).attempt({0, budget.triangles});
    if (std::isfinite(attempt.report.error.rms)) out = std::move(attempt);
  } else if (sound(source) && budget.checks == Checks::none) {
    if (std::optional<Decimated> found = unmeasured(source, pieces, footprint, budget, target_error))
      out = std::move(*found);
  } else if (sound(source)) {
    std::optional<Decimated> found = by_proxy(source, footprint, budget, target_error);
    if (!found) found = within_budget(source, footprint, budget, target_error);
    if (found) out = std::move(*found);
  }
  if (!out.report.kept) out.report.vanished = vanished(pieces, out.mesh, out.vertices, budget);
  out.report.vanished.pieces += before.vanished.pieces;
  out.report.vanished.area += before.vanished.area;
  for (uint32_t &v : out.vertices) v = vertices[v];
  out.report.dropped_pieces = before.dropped_pieces;
  out.report.dropped_faces = before.dropped_faces;
  return out;
}

double find_target_error(const geometry::Mesh &given, const Footprint &footprint, const Budget &budget,
                         double at_most) {
  constexpr int steps = 6;
  constexpr double near_enough = 0.97;
  // A guess from the measured rms of hulls; a worse guess costs an attempt.
  constexpr double target_error_over_rms = 4;
  if (!sound(given)) return 0;
  Report unused;
  std::vector<uint32_t> vertices;
  const geometry::Mesh source = compact(given, without_specks(given, budget, unused), vertices);
  if (!sound(source)) return 0;
  const double guess = target_error_over_rms * budget.pixels * sharpest(source, footprint);
  const std::optional<Proxy> proxy =
      std::isfinite(guess) ? proxy_of(source, std::min(at_most, guess)) : std::nullopt;
  const Frame frame(proxy ? proxy->mesh : source, footprint, budget);
  if (!frame.seen()) return 0;
  double good = 0, bad = INFINITY;
  double target_error =
      std::isfinite(at_most) ? at_most : target_error_over_rms * budget.pixels * frame.sharpest();
  for (int i = 0; i < steps && good < near_enough * bad; i++) {
    const double error = frame.attempt({target_error, 0}).report.error.rms_pixels;
    (error <= budget.pixels ? good : bad) = target_error;
    if (good >= at_most || (good == target_error && error >= near_enough * budget.pixels)) break;
    // Until a target error is good, go lower than in proportion, or the steps would become ever smaller.
    const double next = std::min(at_most, target_error * std::clamp(budget.pixels / error, 0.25, 4.0) *
                                              (good > 0 ? 1 : 0.95));
    // Between a good and a bad one, and at neither end, or the search would stop.
    target_error = std::isfinite(bad) && good > 0
                       ? std::clamp(next, good * 1.01, std::max(good * 1.01, bad * 0.99))
                       : next;
  }
  return good;
}

namespace {

// Vertices that are alike in every frame; those that are alike in the first one only separate later.
std::vector<uint32_t> alike_throughout(const Frames &frames, const geometry::Mesh &first) {
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

// The frames that are measured: first, last, middle, then the others. If a frame exceeds the budget, one of
// these mostly does.
std::vector<size_t> order_of(size_t count, Checks checks) {
  std::vector<size_t> order;
  if (checks == Checks::none) return order;
  for (const size_t i : {size_t(0), count - 1, count / 2})
    if (std::find(order.begin(), order.end(), i) == order.end()) order.push_back(i);
  const size_t step = checks == Checks::some ? 8 : 1;
  for (size_t i = step; i + 1 < count; i += step)
    if (i != count / 2) order.push_back(i);
  return order;
}

} // namespace

// Measures frames until one exceeds the budget; worst: its rms in pixels. That frame is first next time, as
// it is most likely to exceed it again. like: of any frame.
bool TopologyRun::try_faces(const Frames &frames, const Budget &budget, const Reference &like,
                            std::vector<size_t> &order, Outliers &outliers, double &worst) {
  for (size_t at = 0; at < order.size(); at++) {
    const size_t i = order[at];
    geometry::Mesh source = frames.mesh(i);
    source.faces = large_pieces;
    if (!sound(source)) return false;
    std::vector<uint32_t> vertices;
    const geometry::Mesh mesh = compact(source, faces, vertices);
    if (!sound(mesh)) return false;
    outliers = {}; // those of frames before this one were mapped already, and were within the limit
    Report &report = reports[i];
    report = measure_on_lattice(Reference(source, frames.footprint(i), &like), mesh, budget, outliers);
    report.vanished = vanished(pieces_of(source), mesh, vertices, budget);
    worst = report.error.rms_pixels;
    if (budget.triangles) continue;
    if (worst <= budget.pixels && report.error.max_pixels <= budget.most()) continue;
    std::rotate(order.begin(), order.begin() + std::ptrdiff_t(at), order.begin() + std::ptrdiff_t(at) + 1);
    return false;
  }
  return true;
}

TopologyRun::TopologyRun(const Frames &frames, const Budget &budget, double target_error)
    : reports(frames.count) {
  geometry::Mesh first = frames.mesh(0);
  large_pieces = first.faces;
  if (sound(first)) large_pieces = first.faces = without_specks(first, budget, dropped);
  if (!sound(first) || !(target_error > 0 || budget.triangles)) return;
  const std::vector<uint32_t> alike = alike_throughout(frames, first);
  const Simplifier simplifier(first, alike);
  const Reference like(first, frames.footprint(0));
  std::vector<size_t> order = order_of(frames.count, budget.triangles ? Checks::all : budget.checks);
  for (int i = 0; i < attempts + last_attempts; i++) {
    const bool last = i >= attempts;
    std::vector<bool> locked;
    double worst = 0;
    for (int round = 0; round < (last ? last_rounds : rounds); round++) {
      faces = simplifier.simplify({target_error, budget.triangles}, locked);
      reports.assign(frames.count, unmeasured_report(first.face_count(), faces.size() / 3));
      Outliers outliers;
      if (try_faces(frames, budget, like, order, outliers, worst)) {
        for (Report &report : reports) {
          report.target_error = target_error;
          report.dropped_pieces = dropped.dropped_pieces;
          report.dropped_faces = dropped.dropped_faces;
          report.vanished.pieces += dropped.vanished.pieces;
          report.vanished.area += dropped.vanished.area;
          report.locked_faces = size_t(std::count(locked.begin(), locked.end(), true));
        }
        return;
      }
      std::vector<uint32_t> vertices;
      const geometry::Mesh mesh = compact(first, faces, vertices);
      if (!lock_around(first, alike, mesh, vertices, outliers, last ? most_locked_at_last : most_locked,
                       locked))
        break;
    }
    if (budget.triangles) break; // it failed for another reason than the budget
    target_error = shorter(target_error, worst, budget, last);
  }
  faces.clear();
}

Decimated TopologyRun::apply(const geometry::Mesh &source, size_t frame) const {
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
