// Two sequences compared, frame by frame and as a whole, and meshes whose colours show how far each vertex is
// off.
#include "fvvcompare/compare.h"
#include "cli/output.h"

#include "fvv_cxx/parallel.h"
#include "fvv_scene/mesh_file.h"
#include "fvvcompare/report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

namespace fvv::compare {

namespace {

template <class Value> void put(std::string &out, Value value) {
  uint8_t bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
  out.append(reinterpret_cast<const char *>(bytes), sizeof bytes);
}

// Five colours of viridis (Smith and van der Walt, 2015), and straight lines between them.
std::array<uint8_t, 3> colour_of(double share) {
  constexpr double stops[5][3] = {{68, 1, 84}, {59, 82, 139}, {33, 145, 140}, {94, 201, 98}, {253, 231, 37}};
  const double at = 4 * std::clamp(share, 0.0, 1.0);
  const size_t stop = std::min<size_t>(3, size_t(at));
  std::array<uint8_t, 3> out;
  for (size_t k = 0; k < 3; k++)
    out[k] = uint8_t(stops[stop][k] + (stops[stop + 1][k] - stops[stop][k]) * (at - double(stop)) + 0.5);
  return out;
}

// PLY, binary_little_endian: x y z as double, the distance as float, red green blue as uchar, in the colours
// of viridis: dark blue for 0, yellow for most and beyond. distances: of each vertex; most: >= 0.
std::string format_heatmap(const geometry::Mesh &mesh, const std::vector<double> &distances, double most) {
  char scale[32];
  std::snprintf(scale, sizeof scale, "%.6g", most);
  std::string out = "ply\nformat binary_little_endian 1.0\ncomment yellow: a distance of " +
                    std::string(scale) + " or more\nelement vertex " + std::to_string(mesh.vertex_count()) +
                    "\nproperty double x\nproperty double y\nproperty double z\nproperty float distance\n"
                    "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face " +
                    std::to_string(mesh.face_count()) +
                    "\nproperty list uchar uint vertex_indices\nend_header\n";
  for (size_t v = 0; v < mesh.vertex_count(); v++) {
    for (size_t k = 0; k < 3; k++) put(out, mesh.positions[3 * v + k]);
    put(out, float(distances[v]));
    for (const uint8_t sample : colour_of(most > 0 ? distances[v] / most : 0)) put(out, sample);
  }
  for (size_t f = 0; f < mesh.faces.size(); f += 3) {
    put(out, uint8_t(3));
    for (size_t k = 0; k < 3; k++) put(out, mesh.faces[f + k]);
  }
  return out;
}

Figures worse(const Figures &a, const Figures &b) {
  return {std::max(a.rms, b.rms), std::max(a.mean, b.mean), std::max(a.p99, b.p99), std::max(a.max, b.max)};
}

void add_symmetric(Errors &e) {
  e.distance[symmetric] = worse(e.distance[forth], e.distance[back]);
  e.angle[symmetric] = worse(e.angle[forth], e.angle[back]);
  for (auto *values : {&e.d1, &e.d2, &e.turned})
    (*values)[symmetric] = std::max((*values)[forth], (*values)[back]);
}

void take(Errors &e, Way way, const Direction &direction) {
  e.distance[way] = direction.distance.figures();
  e.distance[way].max = direction.hausdorff;
  e.d1[way] = direction.d1;
  e.d2[way] = direction.d2;
  e.angle[way] = direction.angle.figures();
  e.turned[way] = direction.turned;
}

// Every frame weighs the same: surfaces have the same number of samples in all of them.
Figures pooled(const std::vector<FrameResult> &frames, std::array<Figures, way_count> Errors::*kind, Way way,
               const Histogram &histogram) {
  Figures out;
  for (const FrameResult &frame : frames) {
    const Figures &f = (frame.errors.*kind)[way];
    out.rms += f.rms * f.rms;
    out.mean += f.mean;
    out.max = std::max(out.max, f.max);
  }
  out.rms = std::sqrt(out.rms / double(frames.size()));
  out.mean /= double(frames.size());
  out.p99 = histogram.quantile(0.99);
  return out;
}

double pooled(const std::vector<FrameResult> &frames, std::array<double, way_count> Errors::*kind, Way way) {
  double sum = 0;
  for (const FrameResult &frame : frames) sum += (frame.errors.*kind)[way];
  return sum / double(frames.size());
}

class Comparison {
public:
  Comparison(const Options &chosen, Result &out)
      : options(chosen), result(out), a(chosen.a), b(chosen.b),
        matching(match(a, b, chosen.frames, chosen.start)), slots(matching.pairs.size()) {
    // Refused before the work, not after it.
    const cli::Inputs read = [this](const std::function<void(const std::string &)> &visit) {
      for (const Sequence *sequence : {&a, &b}) sequence->visit_files(visit);
    };
    if (!options.table.empty()) table.emplace(options.table, options.force, read);
    if (!options.heatmap.empty()) folder.emplace(options.heatmap, options.force, read);
    result.scale_unknown = a.scale_unknown();
    result.frames_a = a.frames().size();
    result.frames_b = b.frames().size();
    for (const Sequence *sequence : {&a, &b})
      for (const std::string &text : sequence->warnings())
        result.warnings.push_back(sequence->path() + ": " + text);
    result.warnings.insert(result.warnings.end(), matching.warnings.begin(), matching.warnings.end());
  }

  void run() {
    cli::Progress progress("fvvcompare: " + a.path() + " and " + b.path(), slots.size());
    fvv::parallel(
        options.threads, slots.size(), [&](size_t i) { one_frame(i); }, [&] { progress.step(); });
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
    std::vector<cli::Output *> outputs;
    if (folder) {
      heatmaps();
      outputs.push_back(&*folder);
    }
    if (table) {
      const std::string lines = csv(result);
      table->write(lines.data(), lines.size());
      outputs.push_back(&*table);
    }
    cli::commit(outputs);
  }

private:
  struct Slot {
    FrameResult frame;
    Surface::Box box = {};
    std::string loss;      // why this frame could not be compared; empty: it was
    bool constant = false; // both have the faces of the slot before, which is the frame before
  };
  struct Meshes {
    geometry::Mesh a, b;
  };

  // Normals of a stream are compared with the other's own, all others are computed from the faces.
  Meshes load(size_t i) const {
    const auto [in_a, in_b] = matching.pairs[i];
    Meshes meshes;
    if (a.is_stream()) {
      meshes.a = a.mesh(in_a);
      meshes.b = b.mesh(in_b, !meshes.a.normals.empty());
    } else {
      meshes.b = b.mesh(in_b);
      meshes.a = a.mesh(in_a, !meshes.b.normals.empty());
    }
    return meshes;
  }

  static Surface surface_of(const geometry::Mesh &mesh, const Sequence &sequence, int64_t number) {
    Surface surface(mesh);
    // Also false for NaN.
    if (!(surface.area() > 0 && std::isfinite(surface.area())))
      throw Error(sequence.path() + ": frame " + std::to_string(number) +
                  ": expected a surface with a finite area above 0");
    return surface;
  }

  void one_frame(size_t i) {
    Slot &slot = slots[i];
    FrameResult &frame = slot.frame;
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
      take(frame.errors, forth, measured.forth);
      take(frame.errors, back, measured.back);
      add_symmetric(frame.errors);
      // Adding counts gives the same sums in any order.
      const std::lock_guard<std::mutex> lock(mutex);
      distances[forth].add(measured.forth.distance.histogram());
      distances[back].add(measured.back.distance.histogram());
      angles[forth].add(measured.forth.angle.histogram());
      angles[back].add(measured.back.angle.histogram());
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
    for (const Way way : {forth, back}) {
      e.distance[way] = pooled(result.frames, &Errors::distance, way, distances[way]);
      e.angle[way] = pooled(result.frames, &Errors::angle, way, angles[way]);
      e.d1[way] = pooled(result.frames, &Errors::d1, way);
      e.d2[way] = pooled(result.frames, &Errors::d2, way);
      e.turned[way] = pooled(result.frames, &Errors::turned, way);
    }
    add_symmetric(e);
  }

  // B in colours of its distance from A, on one scale for all frames.
  void heatmaps() {
    fvv::parallel(options.threads, slots.size(), [&](size_t i) {
      if (!slots[i].loss.empty()) return;
      const Meshes meshes = load(i);
      const Surface in_a(meshes.a);
      std::vector<double> off;
      for (const Vec3 &p : positions_of(meshes.b)) off.push_back(std::sqrt(in_a.nearest(p).squared));
      char name[32];
      std::snprintf(name, sizeof name, "%04lld.ply", (long long)slots[i].frame.number_a);
      folder->write(name, format_heatmap(meshes.b, off, result.errors.distance[back].p99));
    });
  }

  const Options &options;
  Result &result;
  const Sequence a, b;
  const Matching matching;
  std::vector<Slot> slots;
  std::mutex mutex;
  Histogram distances[2], angles[2];
  std::optional<cli::OutputFile> table;
  std::optional<cli::OutputFolder> folder; // for heat maps
};

} // namespace

double psnr(double peak, double mse) {
  return mse > 0 ? 10 * std::log10(peak * peak / mse) : INFINITY;
}

void compare(const Options &options, Result &result) {
  Comparison(options, result).run();
}

} // namespace fvv::compare
