#include "fvv_geometry/track.h"
#include "fvv_geometry/pieces.h"
#include "geometry/src/track/follower.h"
#include "geometry/src/track/outline_judge.h"

#include <algorithm>
#include <cmath>

namespace fvv::track {

namespace {

// Of the budget, for the decimation of the key: the rest is for what following adds. Nothing is of hulls,
// whose distance is not the judge.
constexpr double key_part = 0.7;
// Of the area: pieces below do not count when a key is chosen.
constexpr double least_piece = 0.002;

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
    const size_t key = size_t(std::max_element(at(first), at(end)) - merits.begin());
    Run run = follow(key, first, end);
    const size_t begin = run.first, after = begin + run.frames.size();
    find(first, begin, runs);
    if (run.frames.size() > 1) runs.push_back(std::move(run));
    find(after, end, runs);
  }

private:
  void check_cancelled() const {
    if (settings.check_cancelled) settings.check_cancelled();
  }

  Run follow(size_t key, size_t first, size_t end) {
    Run run;
    run.first = run.key = key;
    run.frames.emplace_back();
    if (!merits[key].sound) return run;
    decimate::Budget tighter = settings.budget;
    const double part = settings.masks ? 1 : key_part;
    tighter.pixels *= part;
    const geometry::Mesh source = frames.mesh(key);
    const decimate::Decimated decimated =
        decimate::decimate(source, frames.footprint(key), tighter, settings.target_error * part);
    if (!merit_of(decimated.mesh).sound) return run;
    Follower follower(decimated.mesh, bool(settings.masks), [this] { check_cancelled(); });
    const Posture start = follower.start();
    std::vector<Frame> before = follow(follower, start, key, first, end, -1), after;
    std::optional<Frame> own = judged(follower, start, source, key);
    if (!own) return run;
    own->report.target_error = decimated.report.target_error;
    own->report.dropped_pieces = decimated.report.dropped_pieces;
    own->report.dropped_faces = decimated.report.dropped_faces;
    own->report.vanished = decimated.report.vanished;
    after = follow(follower, start, key, first, end, 1);
    run.first = key - before.size();
    run.frames.assign(std::make_move_iterator(before.rbegin()), std::make_move_iterator(before.rend()));
    run.frames.push_back(std::move(*own));
    std::move(after.begin(), after.end(), std::back_inserter(run.frames));
    return run;
  }

  // From the key in one direction, until a frame exceeds the budget.
  std::vector<Frame> follow(Follower &follower, const Posture &start, size_t key, size_t first, size_t end,
                            int direction) const {
    std::vector<Frame> out;
    Posture last = start;
    std::optional<Posture> before;
    for (size_t i = key; direction > 0 ? i + 1 < end : i > first;) {
      direction > 0 ? i++ : i--;
      if (!merits[i].sound) break;
      const geometry::Mesh source = frames.mesh(i);
      const Target target(source);
      std::optional<Posture> next;
      std::optional<Frame> frame;
      if (before) {
        next = follower.follow(last, &*before, target);
        if (next) frame = judged(follower, *next, source, i);
      }
      // What a hand or the ground has stopped is nearer to where it was than to where it would have gone.
      if (!frame) {
        next = follower.follow(last, nullptr, target);
        if (next) frame = judged(follower, *next, source, i);
      }
      if (!frame) break;
      out.push_back(std::move(*frame));
      before = std::move(last);
      last = std::move(*next);
    }
    return out;
  }

  // Nothing: beyond the budget.
  std::optional<Frame> judged(const Follower &follower, const Posture &posture, const geometry::Mesh &source,
                              size_t i) const {
    check_cancelled();
    Frame frame;
    frame.mesh = follower.mesh().at(posture.points);
    decimate::Outliers outliers;
    frame.report = decimate::measure_on_lattice(decimate::Reference(source, frames.footprint(i)), frame.mesh,
                                                settings.budget, outliers);
    if (is_within(frame.report, i)) return frame;
    if (!settings.masks || !has_outlines(frame, source, i)) return {};
    frame.report.by_outlines = true;
    frame.report.thin_area = 0;
    return frame;
  }

  bool is_within(const decimate::Report &report, size_t i) const {
    const double budget = settings.budget.pixels;
    if (!(report.error.rms_pixels <= budget)) return false;
    if (report.thin_area > settings.most_beyond * merits[i].area) return false;
    // Of the other direction: what the mesh has and the source has not.
    return settings.most_beyond > 0 || report.error.max_pixels <= decimate::max_over_rms * budget;
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
