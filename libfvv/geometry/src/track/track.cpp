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
const std::vector<double> patch_limits = {decimate::max_over_rms, 4.5, 3.5};
// Hulls are that far from each other where no hand or ball is lost.
const std::vector<double> patch_limits_of_hulls = {24, 12, 6};
// Of the faces: a patch that is larger is worth another attempt. With a tenth the captured player takes a
// quarter more time, 1 % fewer bytes at 2 mm and as many at 1 and 0.5 mm.
constexpr double large_patch = 0.2;
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
    if (!few) few = std::make_unique<RunMesh>(share == 1 ? key() : decimated(share).mesh);
    return *few;
  }

  const OutlineJudge &outlines() const {
    if (!masks) masks = std::make_unique<std::vector<MaskView>>(settings.masks(number));
    if (!judge) judge = std::make_unique<OutlineJudge>(*masks, key(), settings.budget.pixels);
    return *judge;
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

private:
  const size_t number;
  const decimate::Footprint footprint;
  const Settings &settings;
  const double share;
  mutable std::unique_ptr<RunMesh> few;
  mutable std::unique_ptr<geometry::Mesh> alone;
  mutable std::unique_ptr<std::vector<MaskView>> masks;
  mutable std::unique_ptr<OutlineJudge> judge;
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
    if (settings.patches && !settings.masks) {
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
      std::optional<Step> best = step(now, source, settings.patches && direction > 0);
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

  // Into the next frame. Nothing: beyond the budget.
  std::optional<Step> step(const Moving &now, const FrameSource &source, bool may_patch) const {
    const Target target(source.mesh);
    const Pose *before = now.before ? &*now.before : nullptr;
    std::optional<Step> best;
    const auto attempt = [&](const Approach &approach, bool patches) {
      std::optional<Posture> next = now.follower->follow(now.last, approach, target);
      if (!next) return;
      std::optional<Frame> frame = judged(now, *next, source, patches);
      if (frame && (!best || size_of_patch(*frame) < size_of_patch(best->frame)))
        best = {std::move(*next), std::move(*frame)};
    };
    const auto is_poor = [&] {
      return !best ||
             double(size_of_patch(best->frame)) > large_patch * double(best->frame.mesh.face_count());
    };
    // What a hand or the ground has stopped is nearer to where it was than to where it would have gone.
    if (settings.masks) {
      for (const bool steady : {true, false}) {
        if (before && !best) attempt({before, false, steady}, false);
        if (!best) attempt({nullptr, false, steady}, false);
      }
      if (!best && may_patch) attempt({before, false, false}, true);
      return best;
    }
    if (before) attempt({before}, may_patch);
    if (is_poor()) attempt({}, may_patch);
    // What has come is not to pull at what is next to it.
    if (may_patch && is_poor()) attempt({before, true}, may_patch);
    return best;
  }

  bool is_within(const decimate::Report &report) const {
    const double budget = settings.budget.pixels;
    return report.error.rms_pixels <= budget && report.error.max_pixels <= decimate::max_over_rms * budget;
  }

  // The distance is not the judge of hulls.
  decimate::Looks looks() const {
    return settings.masks ? decimate::Looks::at_vertices : decimate::Looks::within_faces;
  }

  // Nothing: beyond the budget.
  std::optional<Frame> judged(const Moving &moving, const Posture &posture, const FrameSource &source,
                              bool patches) const {
    check_cancelled();
    Frame frame;
    frame.mesh = moving.follower->mesh().at(posture.points);
    decimate::Outliers outliers;
    frame.report =
        decimate::measure_on_lattice(source.reference, frame.mesh, settings.budget, outliers, looks());
    if (is_within(frame.report)) return frame;
    if (settings.masks && has_outlines(frame.mesh, frame.report, source)) {
      judge_by_outlines(frame);
      return frame;
    }
    if (patches && patch(moving, posture, source, frame)) return frame;
    return {};
  }

  static void judge_by_outlines(Frame &frame) {
    frame.report.by_outlines = true;
    frame.report.thin_area = 0;
  }

  // A hull may be anywhere inside of its outlines, but what is far from it has lost it.
  bool has_outlines(const geometry::Mesh &mesh, const decimate::Report &report,
                    const FrameSource &source) const {
    if (!(report.error.rms_pixels <= decimate::max_over_rms * settings.budget.pixels)) return false;
    check_cancelled();
    return source.outlines().accepts(mesh);
  }

  // Whether the frame is within the budget with the patch that it then has.
  bool patch(const Moving &moving, const Posture &posture, const FrameSource &source, Frame &frame) const {
    const Patcher patcher(moving.follower->mesh(), *moving.edges, posture.points, source.reference,
                          source.substitute());
    for (const double limit : settings.masks ? patch_limits_of_hulls : patch_limits) {
      Patcher::Wanted wanted;
      for (int attempt = 0; attempt < (settings.masks ? 1 : patch_attempts); attempt++) {
        check_cancelled();
        std::optional<Patch> patch = patcher.make(limit * settings.budget.pixels, wanted);
        if (!patch) break;
        decimate::Outliers outliers;
        const geometry::Mesh whole = patched(frame.mesh, *patch);
        const decimate::Report report =
            decimate::measure_on_lattice(source.reference, whole, settings.budget, outliers, looks());
        const bool outlines = settings.masks && has_outlines(whole, report, source);
        if (is_within(report) || outlines) {
          const RunMesh next(whole);
          patch->next = next.at(next.points);
          patch->next_of = next.number;
          frame.patch = std::move(patch);
          frame.report = report;
          if (outlines) judge_by_outlines(frame);
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
