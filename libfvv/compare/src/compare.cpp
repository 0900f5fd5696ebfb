// Two sequences compared, frame by frame and as a whole.
#include "compare/src/measure.h"
#include "compare/src/sequence.h"
#include "fvv_cxx/parallel.h"
#include "fvv_scene/mesh_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <string>
#include <vector>

namespace fvv::compare {

namespace {

Figures worse(const Figures &a, const Figures &b) {
  return {std::max(a.rms, b.rms), std::max(a.mean, b.mean), std::max(a.p99, b.p99), std::max(a.max, b.max)};
}

void add_symmetric(Errors &e) {
  e.distance[symmetric] = worse(e.distance[a_to_b], e.distance[b_to_a]);
  e.angle[symmetric] = worse(e.angle[a_to_b], e.angle[b_to_a]);
  for (auto *values : {&e.d1, &e.d2, &e.turned})
    (*values)[symmetric] = std::max((*values)[a_to_b], (*values)[b_to_a]);
}

void take(Errors &e, Direction direction, const DirectedErrors &found) {
  e.distance[direction] = found.distance.figures();
  e.distance[direction].max = found.hausdorff;
  e.d1[direction] = found.d1;
  e.d2[direction] = found.d2;
  e.angle[direction] = found.angle.figures();
  e.turned[direction] = found.turned;
}

// Every frame weighs the same: surfaces have the same number of samples in all of them.
Figures pooled(const std::vector<FrameResult> &frames, std::array<Figures, direction_count> Errors::*kind,
               Direction direction, const Histogram &histogram) {
  Figures out;
  for (const FrameResult &frame : frames) {
    const Figures &f = (frame.errors.*kind)[direction];
    out.rms += f.rms * f.rms;
    out.mean += f.mean;
    out.max = std::max(out.max, f.max);
  }
  out.rms = std::sqrt(out.rms / double(frames.size()));
  out.mean /= double(frames.size());
  out.p99 = histogram.quantile(0.99);
  return out;
}

double pooled(const std::vector<FrameResult> &frames, std::array<double, direction_count> Errors::*kind,
              Direction direction) {
  double sum = 0;
  for (const FrameResult &frame : frames) sum += (frame.errors.*kind)[direction];
  return sum / double(frames.size());
}

class Comparison {
public:
  Comparison(const Sequence &the_a, const Sequence &the_b, const Options &chosen, Result &out)
      : options(chosen), result(out), a(the_a), b(the_b), matching(match(a, b, chosen.frames, chosen.start)),
        slots(matching.pairs.size()) {
    result.scale_unknown = a.scale_unknown() || b.scale_unknown();
    result.frames_a = a.frames().size();
    result.frames_b = b.frames().size();
    for (const Sequence *sequence : {&a, &b})
      for (const std::string &text : sequence->warnings())
        result.warnings.push_back(sequence->path() + ": " + text);
    result.warnings.insert(result.warnings.end(), matching.warnings.begin(), matching.warnings.end());
  }

  void run() {
    size_t done = 0;
    report(done);
    fvv::parallel(
        options.threads, slots.size(), [&](size_t i) { one_frame(i); }, [&] { report(++done); });
    std::optional<Surface::Box> box;
    for (const Slot &slot : slots) {
      if (!slot.loss.empty()) {
        result.losses.push_back(slot.loss);
        continue;
      }
      const Surface::Box &other = slot.box;
      if (!box) box = other;
      box->low = {std::min(box->low.x, other.low.x), std::min(box->low.y, other.low.y),
                  std::min(box->low.z, other.low.z)};
      box->high = {std::max(box->high.x, other.high.x), std::max(box->high.y, other.high.y),
                   std::max(box->high.z, other.high.z)};
    }
    if (!box) throw Error(a.path() + " and " + b.path() + ": no frame could be compared");
    result.peak = options.peak ? *options.peak : length(box->high - box->low);
    motions();
    for (const Slot &slot : slots)
      if (slot.loss.empty()) result.frames.push_back(slot.frame);
    pool();
  }

private:
  // The nearest point of a triangle is found with products of two squared lengths.
  static constexpr double furthest = 1e70;

  struct Slot {
    FrameResult frame;
    Surface::Box box = {};
    std::string loss;      // why this frame could not be compared; empty: it was
    bool constant = false; // both have the faces of the slot before, which is the frame before
  };

  void report(size_t done) const {
    if (options.progress) options.progress(done, slots.size());
  }

  Meshes load(size_t i) const { return compare::load(a, b, matching.pairs[i]); }

  static Surface surface_of(const geometry::Mesh &mesh, const Sequence &sequence, int64_t number) {
    for (const double x : mesh.positions)
      if (!(std::abs(x) <= furthest))
        throw Error(sequence.path() + ": frame " + std::to_string(number) +
                    ": a vertex is too far out: its squared distances are no numbers");
    Surface surface(mesh);
    // Also false for NaN.
    if (!(surface.area() > 0 && std::isfinite(surface.area())))
      throw Error(sequence.path() + ": frame " + std::to_string(number) +
                  ": expected a surface with a finite area above 0");
    const Surface::Box box = surface.box();
    if (!(length(box.high - box.low) >= 1 / furthest))
      throw Error(sequence.path() + ": frame " + std::to_string(number) +
                  ": the surface is too small: its squared distances are no numbers");
    return surface;
  }

  void one_frame(size_t i) {
    Slot &slot = slots[i];
    FrameResult &frame = slot.frame;
    frame.pair = matching.pairs[i];
    frame.number_a = a.frames()[matching.pairs[i].a].number;
    frame.number_b = b.frames()[matching.pairs[i].b].number;
    try {
      const Meshes meshes = load(i);
      const Surface in_a = surface_of(meshes.a, a, frame.number_a),
                    in_b = surface_of(meshes.b, b, frame.number_b);
      frame.vertices_a = meshes.a.vertex_count();
      frame.faces_a = meshes.a.face_count();
      frame.vertices_b = meshes.b.vertex_count();
      frame.faces_b = meshes.b.face_count();
      slot.box = in_a.box();
      slot.constant = i && follows(i) && same_faces(i, meshes);
      const Measure measured = measure(in_a, in_b, options.samples, options.points);
      take(frame.errors, a_to_b, measured.a_to_b);
      take(frame.errors, b_to_a, measured.b_to_a);
      add_symmetric(frame.errors);
      // Adding counts gives the same sums in any order.
      const std::lock_guard<std::mutex> lock(mutex);
      distances[a_to_b].add(measured.a_to_b.distance.histogram());
      distances[b_to_a].add(measured.b_to_a.distance.histogram());
      angles[a_to_b].add(measured.a_to_b.angle.histogram());
      angles[b_to_a].add(measured.b_to_a.angle.histogram());
    } catch (const Error &error) {
      slot.loss = error.what();
    }
  }

  // Whether there is no frame between this one and the slot before, in either sequence.
  bool follows(size_t i) const {
    const FramePair &before = matching.pairs[i - 1], &here = matching.pairs[i];
    return before.a + 1 == here.a && before.b + 1 == here.b;
  }

  bool same_faces(size_t i, const Meshes &meshes) const {
    try {
      const Meshes before = load(i - 1);
      return before.a.vertex_count() == meshes.a.vertex_count() && before.a.faces == meshes.a.faces &&
             before.b.vertex_count() == meshes.b.vertex_count() && before.b.faces == meshes.b.faces;
    } catch (const Error &) {
      return false; // its own slot has the loss
    }
  }

  void motions() {
    std::vector<size_t> run_of(slots.size()), starts, pairs;
    for (size_t i = 1; i < slots.size(); i++) {
      if (!slots[i].constant || !slots[i - 1].loss.empty()) continue;
      if (pairs.empty() || pairs.back() + 1 != i) starts.push_back(i - 1);
      run_of[i] = starts.size() - 1;
      pairs.push_back(i);
    }
    if (pairs.empty()) return;
    std::vector<Correspondence> matches(starts.size());
    fvv::parallel(options.threads, starts.size(), [&](size_t r) {
      const Meshes meshes = load(starts[r]);
      matches[r] = correspondence(meshes.a, meshes.b);
    });
    fvv::parallel(options.threads, pairs.size(), [&](size_t p) {
      const size_t i = pairs[p];
      const Meshes before = load(i - 1), here = load(i);
      slots[i].frame.motion = motion_error(before.a, here.a, before.b, here.b, matches[run_of[i]]);
    });
    Temporal temporal;
    temporal.pairs = pairs.size();
    for (const size_t i : pairs) {
      const MotionError &error = *slots[i].frame.motion;
      const Correspondence &used = matches[run_of[i]];
      temporal.rms += error.rms * error.rms;
      temporal.motion += error.motion * error.motion;
      temporal.max = std::max(temporal.max, error.max);
      if (used.by_order)
        temporal.by_order++;
      else
        temporal.furthest = std::max(temporal.furthest, used.furthest);
    }
    temporal.rms = std::sqrt(temporal.rms / double(pairs.size()));
    temporal.motion = std::sqrt(temporal.motion / double(pairs.size()));
    result.temporal = temporal;
  }

  void pool() {
    Errors &e = result.errors;
    for (const Direction direction : {a_to_b, b_to_a}) {
      e.distance[direction] = pooled(result.frames, &Errors::distance, direction, distances[direction]);
      e.angle[direction] = pooled(result.frames, &Errors::angle, direction, angles[direction]);
      e.d1[direction] = pooled(result.frames, &Errors::d1, direction);
      e.d2[direction] = pooled(result.frames, &Errors::d2, direction);
      e.turned[direction] = pooled(result.frames, &Errors::turned, direction);
    }
    add_symmetric(e);
  }

  const Options &options;
  Result &result;
  const Sequence &a, &b;
  const Matching matching;
  std::vector<Slot> slots;
  std::mutex mutex;
  Histogram distances[2], angles[2];
};

} // namespace

double psnr(double peak, double mse) {
  return mse > 0 ? 10 * std::log10(peak * peak / mse) : INFINITY;
}

// Normals of a stream are compared with the other's own, all others are computed from the faces.
Meshes load(const Sequence &a, const Sequence &b, const FramePair &pair) {
  Meshes meshes;
  if (!a.is_capture()) {
    meshes.a = a.mesh(pair.a);
    meshes.b = b.mesh(pair.b, !meshes.a.normals.empty());
  } else {
    meshes.b = b.mesh(pair.b);
    meshes.a = a.mesh(pair.a, !meshes.b.normals.empty());
  }
  return meshes;
}

void compare(const Sequence &a, const Sequence &b, const Options &options, Result &result) {
  Comparison(a, b, options, result).run();
}

} // namespace fvv::compare
