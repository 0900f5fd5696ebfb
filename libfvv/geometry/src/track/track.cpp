#include "fvv_geometry/track.h"
#include "fvv_geometry/pieces.h"
#include "geometry/src/track/follower.h"
#include "geometry/src/track/outline_judge.h"
#include "geometry/src/track/patch.h"

#include <algorithm>
#include <cmath>
#include <memory>

namespace fvv::track {

namespace {

// Of the budget, for the decimation of the key: the rest is for what following adds. Nothing is of hulls,
// whose distance is not the judge.
constexpr double key_part = 0.7;
// With patches it is only noise that following adds: one after the other, until a frame can be followed.
constexpr double key_parts[] = {1, 0.9, key_part, 0.55};
// Of the area: pieces below do not count when a key is chosen.
constexpr double least_piece = 0.002;
// Of the budget, one after the other: what is further off is patched.
constexpr double patch_limits[] = {decimate::max_over_rms, 4.5, 3.5};
// Of the faces: a patch that is larger is worth another attempt without one.
constexpr double large_patch = 0.05;
constexpr int patch_attempts = 6; // with each: what is beyond the budget with a patch is patched too

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

// The mesh of a run from one frame to the next.
struct Moving {
  std::shared_ptr<Follower> follower;
  std::shared_ptr<const HalfEdges> edges; // of its mesh
  Posture last;                           // in the last frame
  std::optional<Pose> before;             // in the frame before that, where it is known
  double error = 0;                       // rms by which it may be off, metres
};

struct Step {
  Posture posture;
  Frame frame;
};

// The surface of a frame. What is made of it is made once, however often the frame is tried.
class FrameSource {
public:
  // part: of the budget, for a substitute.
  FrameSource(const decimate::Frames &frames, const Settings &given, size_t i, double part)
      : mesh(frames.mesh(i)), reference(mesh, frames.footprint(i)), number(i), footprint(frames.footprint(i)),
        settings(given), share(part) {}
  FrameSource(const FrameSource &) = delete; // the reference is of its own mesh
  FrameSource &operator=(const FrameSource &) = delete;

  // With few faces, of which patches are made.
  const RunMesh &substitute() const {
    if (!few) few = std::make_unique<RunMesh>(decimated(share).mesh);
    return *few;
  }

  // As it would be sent by itself.
  const geometry::Mesh &key() const {
    if (!alone) alone = std::make_unique<geometry::Mesh>(decimated(1).mesh);
    return *alone;
  }

  decimate::Decimated decimated(double part) const {
    decimate::Budget budget = settings.budget;
    budget.pixels *= part;
    return decimate::decimate(mesh, footprint, budget, settings.target_error * part);
  }

  const geometry::Mesh mesh;
  const decimate::Reference reference;
  const size_t number;

private:
  const decimate::Footprint footprint;
  const Settings &settings;
  const double share;
  mutable std::unique_ptr<RunMesh> few;
  mutable std::unique_ptr<geometry::Mesh> alone;
};

size_t size_of_patch(const Frame &frame) {
  return frame.patch ? frame.patch->mesh.face_count() : 0;
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

  Run follow(size_t key, size_t first, size_t end, double part) {
    Run run;
    run.first = run.key = key;
    run.frames.emplace_back();
    if (!merits[key].sound) return run;
    const FrameSource source(frames, settings, key, part);
    const decimate::Decimated decimated = source.decimated(part);
    if (!merit_of(decimated.mesh).sound) return run;
    const Moving begin = moving(decimated.mesh, decimated.report.error.rms / part);
    std::vector<Frame> before = follow(begin, part, key, first, end, -1), after;
    std::optional<Frame> own = judged(begin, begin.last, source, false);
    if (!own) return run;
    own->report.target_error = decimated.report.target_error;
    own->report.dropped_pieces = decimated.report.dropped_pieces;
    own->report.dropped_faces = decimated.report.dropped_faces;
    own->report.vanished = decimated.report.vanished;
    after = follow(begin, part, key, first, end, 1);
    run.first = key - before.size();
    run.frames.assign(std::make_move_iterator(before.rbegin()), std::make_move_iterator(before.rend()));
    run.frames.push_back(std::move(*own));
    std::move(after.begin(), after.end(), std::back_inserter(run.frames));
    return run;
  }

  Moving moving(const geometry::Mesh &mesh, double error) const {
    Moving out;
    out.error = error;
    out.follower = std::make_shared<Follower>(
        mesh, settings.masks ? std::nullopt : std::optional<double>(error), [this] { check_cancelled(); });
    out.edges = std::make_shared<HalfEdges>(out.follower->mesh().faces);
    out.last = out.follower->start();
    return out;
  }

  // What moves on from a frame with a patch, into which the other moved by a step.
  Moving moving(const Patch &patch, const Moving &other, const Posture &step) const {
    Moving out = moving(patch.next, other.error);
    std::vector<uint32_t> like(out.last.points.size(), UINT32_MAX);
    for (uint32_t v = 0; v < step.points.size(); v++)
      if (patch.next_of[v] != UINT32_MAX) like[patch.next_of[v]] = v;
    out.before = out.follower->before_start(*other.follower, step, other.last, like);
    return out;
  }

  // From the key in one direction, until a frame exceeds the budget.
  std::vector<Frame> follow(Moving now, double part, size_t key, size_t first, size_t end,
                            int direction) const {
    std::vector<Frame> out;
    for (size_t i = key; direction > 0 ? i + 1 < end : i > first;) {
      direction > 0 ? i++ : i--;
      if (!merits[i].sound) break;
      const FrameSource source(frames, settings, i, part);
      const Target target(source.mesh);
      const bool may_patch = has_patches() && direction > 0;
      std::optional<Step> best;
      const auto attempt = [&](const Pose *before, bool near) {
        std::optional<Posture> next = now.follower->follow(now.last, before, near, target);
        if (!next) return;
        std::optional<Frame> frame = judged(now, *next, source, may_patch);
        if (frame && (!best || size_of_patch(*frame) < size_of_patch(best->frame)))
          best = {std::move(*next), std::move(*frame)};
      };
      if (now.before) attempt(&*now.before, false);
      // What a hand or the ground has stopped is nearer to where it was than to where it would have gone.
      if (!best || (now.before && best->frame.patch)) attempt(nullptr, false);
      // What has come is not to pull at what is next to it.
      if (may_patch &&
          (!best || double(size_of_patch(best->frame)) > large_patch * double(best->frame.mesh.face_count())))
        attempt(now.before ? &*now.before : nullptr, true);
      if (!best) break;
      if (best->frame.patch) {
        now = moving(*best->frame.patch, now, best->posture);
      } else {
        now.before = std::move(now.last.pose);
        now.last = std::move(best->posture);
      }
      out.push_back(std::move(best->frame));
    }
    return out;
  }

  bool is_within(const decimate::Report &report) const {
    const double budget = settings.budget.pixels;
    return report.error.rms_pixels <= budget && report.error.max_pixels <= decimate::max_over_rms * budget;
  }

  // Nothing: beyond the budget.
  std::optional<Frame> judged(const Moving &moving, const Posture &posture, const FrameSource &source,
                              bool patches) const {
    check_cancelled();
    Frame frame;
    frame.mesh = moving.follower->mesh().at(posture.points);
    decimate::Outliers outliers;
    frame.report = decimate::measure_on_lattice(source.reference, frame.mesh, settings.budget, outliers);
    if (is_within(frame.report)) return frame;
    if (patches && patch(moving, posture, source, frame)) return frame;
    if (!settings.masks || !has_outlines(frame, source)) return {};
    frame.report.by_outlines = true;
    frame.report.thin_area = 0;
    return frame;
  }

  // A hull may be anywhere inside of its outlines, but what is far from it has lost it.
  bool has_outlines(const Frame &frame, const FrameSource &source) const {
    if (!(frame.report.error.rms_pixels <= decimate::max_over_rms * settings.budget.pixels)) return false;
    check_cancelled();
    const std::vector<MaskView> masks = settings.masks(source.number);
    return OutlineJudge(masks, source.key(), settings.budget.pixels).accepts(frame.mesh);
  }

  // Whether the frame is within the budget with the patch that it then has.
  bool patch(const Moving &moving, const Posture &posture, const FrameSource &source, Frame &frame) const {
    const Patcher patcher(moving.follower->mesh(), *moving.edges, posture.points, source.reference,
                          source.substitute());
    for (const double limit : patch_limits) {
      Patcher::Wanted wanted;
      for (int attempt = 0; attempt < patch_attempts; attempt++) {
        check_cancelled();
        std::optional<Patch> patch = patcher.make(limit * settings.budget.pixels, wanted);
        if (!patch) break;
        decimate::Outliers outliers;
        const geometry::Mesh whole = patched(frame.mesh, *patch);
        const decimate::Report report =
            decimate::measure_on_lattice(source.reference, whole, settings.budget, outliers);
        if (is_within(report)) {
          const RunMesh next(whole);
          patch->next = next.at(next.points);
          patch->next_of = next.number;
          frame.patch = std::move(patch);
          frame.report = report;
          return true;
        }
        if (report.error.max_pixels <= decimate::max_over_rms * settings.budget.pixels) break;
        patcher.widen(*patch, outliers, wanted);
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
