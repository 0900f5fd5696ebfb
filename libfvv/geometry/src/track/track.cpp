#include "fvv_geometry/track.h"
#include "fvv_geometry/pieces.h"
#include "geometry/src/track/follower.h"
#include "geometry/src/track/outline_judge.h"
#include "geometry/src/track/patch.h"

#include <algorithm>
#include <cmath>

namespace fvv::track {

namespace {

// Of the budget, for the decimation of the key: the rest is for what following adds. Nothing is of hulls,
// whose distance is not the judge.
constexpr double key_part = 0.7;
// With patches it is only noise that following adds: one after the other, until a frame can be followed.
constexpr double key_parts[] = {0.9, key_part, 0.55};
// Of the area: pieces below do not count when a key is chosen.
constexpr double least_piece = 0.002;
// Of the budget, one after the other: what is further off is patched.
constexpr double patch_limits[] = {decimate::max_over_rms, 4.5, 3.5};
// What a delta frame takes, of the bytes of its key: with patches a run ends where another key costs less.
constexpr double delta_part = 0.2;
constexpr int patch_attempts = 3; // with each: what is beyond the budget with a patch is patched too

// How good a key a frame is.
struct Merit {
  size_t pieces = 0;
  double area = 0;
  bool sound = false; // it has an area, and finite coordinates

  bool operator<(const Merit &other) const {
    return pieces != other.pieces ? pieces < other.pieces : area < other.area;
  }
};

Merit merit_of(const geometry::Mesh &mesh) {
  Merit merit;
  if (mesh.faces.empty()) return merit;
  const decimate::Pieces pieces = decimate::find_pieces(mesh, decimate::first_alike(mesh, false));
  for (const double area : pieces.area) merit.area += area;
  for (const double area : pieces.area) merit.pieces += area > least_piece * merit.area;
  merit.sound =
      merit.area > 0 && std::isfinite(merit.area) &&
      std::all_of(mesh.positions.begin(), mesh.positions.end(), [](double x) { return std::isfinite(x); });
  return merit;
}

class Tracker {
public:
  Tracker(const decimate::Frames &of, const Settings &given) : frames(of), settings(given) {
    for (size_t i = 0; i < frames.count; i++) {
      check_cancelled();
      merits.push_back(merit_of(frames.mesh(i)));
    }
  }

  // Appends the runs of frames first ... end - 1.
  void find(size_t first, size_t end, std::vector<Run> &runs) {
    if (first + 1 >= end) return;
    const auto at = [&](size_t i) { return merits.begin() + std::ptrdiff_t(i); };
    Run run;
    if (has_patches()) {
      // The first frame of a run is sent alone, so it has no patch: a later key is of no use.
      for (const double part : key_parts)
        if (run.frames.size() < 2) run = follow(first, first, end, part);
    } else {
      const size_t key = size_t(std::max_element(at(first), at(end)) - merits.begin());
      run = follow(key, first, end, settings.masks ? 1 : key_part);
    }
    const size_t begin = run.first, after = begin + run.frames.size();
    find(first, begin, runs);
    if (run.frames.size() > 1) runs.push_back(std::move(run));
    find(after, end, runs);
  }

private:
  // What is wrong with a hull is not its distance from the next.
  bool has_patches() const { return settings.patches && !settings.masks; }

  void check_cancelled() const {
    if (settings.check_cancelled) settings.check_cancelled();
  }

  // In faces of keys.
  static double cost_of(const Frame &frame) {
    return delta_part * frame.mesh.face_count() + (frame.patch ? frame.patch->mesh.face_count() : 0);
  }

  Run follow(size_t key, size_t first, size_t end, double part) {
    Run run;
    run.first = run.key = key;
    run.frames.emplace_back();
    if (!merits[key].sound) return run;
    decimate::Budget tighter = settings.budget;
    tighter.pixels *= part;
    const geometry::Mesh source = frames.mesh(key);
    const decimate::Decimated decimated =
        decimate::decimate(source, frames.footprint(key), tighter, settings.target_error * part);
    if (!merit_of(decimated.mesh).sound) return run;
    Follower follower(decimated.mesh, bool(settings.masks), [this] { check_cancelled(); });
    const HalfEdges edges(follower.mesh().faces);
    const Posture start = follower.start();
    std::vector<Frame> before = follow(follower, edges, part, start, key, first, end, -1), after;
    std::optional<Frame> own = judged(follower, edges, part, start, source, key, false);
    if (!own) return run;
    own->report.target_error = decimated.report.target_error;
    own->report.dropped_pieces = decimated.report.dropped_pieces;
    own->report.dropped_faces = decimated.report.dropped_faces;
    own->report.vanished = decimated.report.vanished;
    after = follow(follower, edges, part, start, key, first, end, 1);
    run.first = key - before.size();
    run.frames.assign(std::make_move_iterator(before.rbegin()), std::make_move_iterator(before.rend()));
    run.frames.push_back(std::move(*own));
    std::move(after.begin(), after.end(), std::back_inserter(run.frames));
    return run;
  }

  // From the key in one direction, until a frame exceeds the budget.
  std::vector<Frame> follow(Follower &follower, const HalfEdges &edges, double part, const Posture &start,
                            size_t key, size_t first, size_t end, int direction) const {
    std::vector<Frame> out;
    Posture last = start;
    std::optional<Posture> before;
    const double faces = double(follower.mesh().faces.size());
    double cost = faces; // of the key and the frames up to now, in faces of keys
    for (size_t i = key; direction > 0 ? i + 1 < end : i > first;) {
      direction > 0 ? i++ : i--;
      if (!merits[i].sound) break;
      const geometry::Mesh source = frames.mesh(i);
      const Target target(source);
      std::optional<Posture> next;
      std::optional<Frame> frame;
      const bool may_patch = has_patches() && direction > 0;
      if (before) {
        next = follower.follow(last, &*before, target);
        if (next) frame = judged(follower, edges, part, *next, source, i, may_patch);
      }
      // What a hand or the ground has stopped is nearer to where it was than to where it would have gone.
      if (!frame) {
        next = follower.follow(last, nullptr, target);
        if (next) frame = judged(follower, edges, part, *next, source, i, may_patch);
      }
      if (!frame) break;
      const double own = cost_of(*frame);
      // Dearer than the frames before on average: those of a new run will cost less.
      if (frame->patch && own * double(out.size() + 1) > cost) break;
      cost += own;
      out.push_back(std::move(*frame));
      before = std::move(last);
      last = std::move(*next);
    }
    return out;
  }

  bool is_within(const decimate::Report &report) const {
    const double budget = settings.budget.pixels;
    return report.error.rms_pixels <= budget && report.error.max_pixels <= decimate::max_over_rms * budget;
  }

  // Nothing: beyond the budget.
  std::optional<Frame> judged(const Follower &follower, const HalfEdges &edges, double part,
                              const Posture &posture, const geometry::Mesh &source, size_t i,
                              bool patches) const {
    check_cancelled();
    const decimate::Reference reference(source, frames.footprint(i));
    Frame frame;
    frame.mesh = follower.mesh().at(posture.points);
    decimate::Outliers outliers;
    frame.report = decimate::measure_on_lattice(reference, frame.mesh, settings.budget, outliers);
    if (is_within(frame.report)) return frame;
    if (patches && patch(follower, edges, part, posture, reference, i, frame)) return frame;
    if (!settings.masks || !has_outlines(frame, source, i)) return {};
    frame.report.by_outlines = true;
    frame.report.thin_area = 0;
    return frame;
  }

  // A hull may be anywhere inside of its outlines, but what is far from it has lost it.
  bool has_outlines(const Frame &frame, const geometry::Mesh &source, size_t i) const {
    if (!(frame.report.error.rms_pixels <= decimate::max_over_rms * settings.budget.pixels)) return false;
    check_cancelled();
    const decimate::Decimated own =
        decimate::decimate(source, frames.footprint(i), settings.budget, settings.target_error);
    const std::vector<MaskView> masks = settings.masks(i);
    return OutlineJudge(masks, own.mesh, settings.budget.pixels).accepts(frame.mesh);
  }

  // Whether the frame is within the budget with the patch that it then has.
  bool patch(const Follower &follower, const HalfEdges &edges, double part, const Posture &posture,
             const decimate::Reference &reference, size_t i, Frame &frame) const {
    decimate::Budget tighter = settings.budget;
    tighter.pixels *= part;
    const RunMesh substitute(
        decimate::decimate(reference.mesh(), frames.footprint(i), tighter, settings.target_error * part)
            .mesh);
    const Patcher patcher(follower.mesh(), edges, posture.points, reference, substitute);
    for (const double limit : patch_limits) {
      std::vector<uint8_t> also;
      for (int attempt = 0; attempt < patch_attempts; attempt++) {
        check_cancelled();
        std::optional<Patch> patch = patcher.make(limit * settings.budget.pixels, also);
        if (!patch) break;
        decimate::Outliers outliers;
        const decimate::Report report =
            decimate::measure_on_lattice(reference, patched(frame.mesh, *patch), settings.budget, outliers);
        if (is_within(report)) {
          frame.patch = std::move(patch);
          frame.report = report;
          return true;
        }
        if (report.error.max_pixels <= decimate::max_over_rms * settings.budget.pixels) break;
        also = patcher.widened(*patch, outliers);
      }
    }
    return false;
  }

  const decimate::Frames &frames;
  const Settings &settings;
  std::vector<Merit> merits;
};

} // namespace

std::vector<Run> track(const decimate::Frames &frames, const Settings &settings) {
  std::vector<Run> runs;
  Tracker(frames, settings).find(0, frames.count, runs);
  return runs;
}

} // namespace fvv::track
