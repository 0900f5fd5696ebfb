#include "mux/src/meshes/meshes.h"
#include "fvv_cxx/error.h"
#include "fvv_cxx/owned.h"
#include "mux/src/choose/choices.h"
#include "mux/src/encode/vertex_colours.h"
#include "mux/src/meshes/patch_coder.h"
#include "mux/src/options/effort_steps.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

namespace fvv::mux {

namespace {

constexpr uint32_t none = UINT32_MAX;

// Vertices by the corners that they take in both; those without a face take what is left, in order.
std::optional<std::vector<uint32_t>> by_corners(const geometry::Mesh &a, const geometry::Mesh &b) {
  std::vector<uint32_t> there(a.vertex_count(), none), back(b.vertex_count(), none);
  for (size_t i = 0; i < a.faces.size(); i++) {
    const uint32_t from = a.faces[i], to = b.faces[i];
    if (from >= there.size() || to >= back.size()) return {}; // the canonicaliser says what is wrong
    if (there[from] == none && back[to] == none) {
      there[from] = to;
      back[to] = from;
    }
    if (there[from] != to || back[to] != from) return {};
  }
  uint32_t next = 0;
  for (uint32_t &to : there) {
    if (to != none) continue;
    while (back[next] != none) next++;
    to = next++;
  }
  return there;
}

bool same_texture(const geometry::Mesh &a, const geometry::Mesh &b, const std::vector<uint32_t> &there) {
  if (a.texture.size() != b.texture.size()) return false;
  for (size_t i = 0; i < a.texture.size(); i++)
    if (a.texture[i] != b.texture[2 * size_t(there[i / 2]) + i % 2]) return false;
  return true;
}

} // namespace

std::optional<std::vector<uint32_t>> same_connectivity(const geometry::Mesh &a, const geometry::Mesh &b) {
  if (a.vertex_count() != b.vertex_count() || a.face_count() != b.face_count()) return {};
  std::optional<std::vector<uint32_t>> there;
  if (a.faces == b.faces) {
    there.emplace(a.vertex_count());
    std::iota(there->begin(), there->end(), 0);
  } else {
    there = by_corners(a, b);
  }
  if (there && !same_texture(a, b, *there)) there.reset();
  return there;
}

geometry::Mesh reordered(const geometry::Mesh &mesh, const std::vector<uint32_t> &order,
                         const geometry::Mesh &like) {
  geometry::Mesh out = like;
  for (size_t k = 0; k < out.positions.size(); k++)
    out.positions[k] = mesh.positions[3 * size_t(order[k / 3]) + k % 3];
  out.normals.resize(mesh.normals.size());
  for (size_t k = 0; k < out.normals.size(); k++)
    out.normals[k] = mesh.normals[3 * size_t(order[k / 3]) + k % 3];
  return out;
}

MeshLoader::MeshLoader(const Plan &plan, const DecimationChoice &decimation, const Tiling &tiles)
    : capture(plan.capture), tiling(tiles), choice(decimation), spans(plan.groups),
      has_constant_topology(plan.has_constant_topology), normals(plan.normals.bits != 0),
      track(plan.tracking.on ? *plan.options.track : Track::never), by_outlines(plan.tracking.by_outlines),
      videos(plan.videos), outline_cameras(plan.outline_cameras), observer(plan.observer) {}

MeshLoader::MeshLoader(const MeshLoader &other, Track other_track)
    : capture(other.capture), tiling(other.tiling), choice(other.choice), spans(other.spans),
      has_constant_topology(other.has_constant_topology), normals(other.normals), track(other_track),
      by_outlines(other.by_outlines), videos(other.videos), outline_cameras(other.outline_cameras),
      observer(other.observer) {}

void MeshLoader::extend(const Plan &plan) {
  capture.frames = plan.capture.frames;
  capture.empty = plan.capture.empty;
  for (size_t i = 0; i < capture.cameras.size(); i++) {
    auto &known = capture.cameras[i].per_frame;
    const auto &all = plan.capture.cameras[i].per_frame;
    known.insert(known.empty() ? all.begin() : all.upper_bound(known.rbegin()->first), all.end());
  }
  spans = plan.groups;
}

void MeshLoader::forget(size_t group) {
  const std::lock_guard<std::mutex> lock(mutex);
  groups.erase(group);
}

std::shared_ptr<MeshLoader::Group> MeshLoader::group_at(size_t index) const {
  const std::lock_guard<std::mutex> lock(mutex);
  std::shared_ptr<Group> &group = groups[index];
  if (!group) group = std::make_shared<Group>();
  return group;
}

geometry::Mesh MeshLoader::source(size_t i, scene::MeshReport *report) const {
  return frame_mesh(capture, capture.frames.number(int64_t(i)), report, normals);
}

decimate::Footprint MeshLoader::cameras(size_t i) const {
  return footprint(capture, tiling, capture.frames.number(int64_t(i)), choice.is_length);
}

void MeshLoader::add_run(Group &group, size_t group_first, size_t first,
                         std::vector<std::vector<uint32_t>> orders) const {
  if (orders.size() < 2) return;
  const auto mesh = [this, first, &orders](size_t i) {
    return orders[i].empty() ? source(first + i) : reordered(source(first + i), orders[i], source(first));
  };
  const decimate::Frames frames = {orders.size(), mesh,
                                   [this, first](size_t i) { return cameras(first + i); }};
  std::fill_n(group.run_of.begin() + std::ptrdiff_t(first - group_first), orders.size(), group.runs.size());
  decimate::TopologyRun run(frames, choice.budget, choice.target_error);
  group.runs.push_back({first, std::move(run), std::move(orders)});
}

void MeshLoader::find_runs(Group &group, size_t first, size_t count) const {
  group.run_of.assign(count, SIZE_MAX);
  if (!has_constant_topology) return;
  const size_t last = first + count;
  size_t begin = first; // only before its first mesh has a group frames without one
  while (begin < last && !capture.has_mesh(capture.frames.number(int64_t(begin)))) begin++;
  if (begin == last) return;
  geometry::Mesh begun = source(begin);
  std::vector<std::vector<uint32_t>> orders(1);
  for (size_t i = begin + 1; i < last; i++) {
    geometry::Mesh mesh = source(i);
    if (std::optional<std::vector<uint32_t>> order = same_connectivity(begun, mesh)) {
      if (mesh.faces == begun.faces) order->clear();
      orders.push_back(std::move(*order));
      continue;
    }
    add_run(group, first, begin, std::move(orders));
    begin = i;
    begun = std::move(mesh);
    orders.assign(1, {});
  }
  add_run(group, first, begin, std::move(orders));
}

size_t MeshLoader::group_index(size_t i) const {
  const auto after = std::upper_bound(spans.begin(), spans.end(), i,
                                      [](size_t frame, const GroupSpan &span) { return frame < span.first; });
  return size_t(after - spans.begin()) - 1;
}

void MeshLoader::track_frames(Group &group, size_t first, size_t count) const {
  track::Settings settings;
  settings.budget = choice.budget;
  settings.target_error = choice.target_error;
  settings.patches = true;
  settings.check_cancelled = [this] { observer.check_cancelled(); };
  for (size_t begin = first, last = first + count; begin < last; begin++) {
    size_t end = begin; // frames with a mesh, after each other
    while (end < last && capture.has_mesh(capture.frames.number(int64_t(end)))) end++;
    const decimate::Frames frames = {end - begin, [&](size_t i) { return source(begin + i); },
                                     [&](size_t i) { return cameras(begin + i); }};
    if (by_outlines)
      settings.masks = [&](size_t i) {
        return mask_views(capture, outline_cameras ? *outline_cameras : capture.cameras, *videos, tiling,
                          capture.frames.number(int64_t(begin + i)));
      };
    for (track::Run &run : track::track(frames, settings)) {
      run.first += begin;
      run.key += begin;
      group.tracked.push_back(std::move(run));
    }
    begin = end;
  }
}

std::shared_ptr<MeshLoader::Group> MeshLoader::known_group(size_t i) const {
  const size_t index = group_index(i);
  const std::shared_ptr<Group> group = group_at(index);
  std::call_once(group->known, [&] {
    find_runs(*group, spans[index].first, spans[index].count);
    const bool changes = group->runs.empty(); // of constant topology nothing needs to be tracked
    if (track != Track::never && choice.on && changes)
      track_frames(*group, spans[index].first, spans[index].count);
  });
  return group;
}

namespace {

auto run_with(std::vector<track::Run> &runs, size_t i) {
  return std::find_if(runs.begin(), runs.end(), [i](const track::Run &run) {
    return run.first <= i && i < run.first + run.frames.size();
  });
}

} // namespace

bool MeshLoader::is_tracked(size_t i) const {
  if (track == Track::never || !choice.on) return false;
  const std::shared_ptr<Group> group = known_group(i);
  return run_with(group->tracked, i) != group->tracked.end();
}

void MeshLoader::leave_untracked(size_t i) {
  const std::shared_ptr<Group> group = known_group(i);
  const auto run = run_with(group->tracked, i);
  if (run == group->tracked.end()) return;
  if (run->first == i)
    group->tracked.erase(run);
  else
    run->frames.resize(i - run->first);
}

PreparedMesh MeshLoader::load(size_t i) const {
  PreparedMesh loaded;
  loaded.mesh = source(i, &loaded.report);
  if (!choice.on) return loaded;
  const std::shared_ptr<Group> group = known_group(i);
  if (const auto run = run_with(group->tracked, i); run != group->tracked.end()) {
    const track::Frame &frame = run->frames[i - run->first];
    loaded.decimation = frame.report;
    loaded.mesh = frame.patch ? frame.patch->next : frame.mesh;
    if (frame.patch) loaded.body = {frame.mesh, *frame.patch};
    return loaded;
  }
  const size_t of = group->run_of[i - spans[group_index(i)].first];
  decimate::Decimated out;
  if (of == SIZE_MAX) {
    out = decimate::decimate(loaded.mesh, cameras(i), choice.budget, choice.target_error);
  } else {
    const DecimatedRun &run = group->runs[of];
    const std::vector<uint32_t> &order = run.orders[i - run.first];
    if (!order.empty()) loaded.mesh = reordered(loaded.mesh, order, source(run.first));
    out = run.run.apply(loaded.mesh, i - run.first);
  }
  loaded.decimation = out.report;
  loaded.mesh = std::move(out.mesh);
  return loaded;
}

namespace {

std::string name_of(const Plan &plan, size_t i) {
  const int64_t number = plan.capture.frames.number(int64_t(i));
  return plan.capture.mesh_path(number) + ": frame " + std::to_string(number);
}

int mesh_level_of(const Plan &plan) {
  return std::min(*plan.options.mesh_level, effort_step(plan.effort).mesh_level);
}

fvv_mesh_source borrow(const geometry::Mesh &mesh) {
  return {mesh.positions.data(),
          mesh.faces.data(),
          mesh.vertex_count(),
          mesh.face_count(),
          mesh.texture.empty() ? nullptr : mesh.texture.data(),
          mesh.normals.empty() ? nullptr : mesh.normals.data()};
}

fvv_mesh_options options_of(const Plan &plan, const PreparedMesh &source) {
  fvv_mesh_options options;
  fvv_mesh_options_default(&options);
  options.keep_winding = plan.options.winding == Winding::keep;
  std::copy_n(plan.lattice.lattice.origin, 3, options.lattice_origin);
  options.lattice_step = plan.lattice.lattice.step;
  // Decimation has dropped specks already, by the faces that they had before.
  options.min_component_faces = source.decimation ? 0 : plan.options.min_component;
  options.texture_bits = plan.texture_bits;
  options.normal_bits = plan.normals.bits;
  return options;
}

void report_specks(const PreparedMesh &source, fvv_mesh_report &report) {
  if (!source.decimation) return;
  report.dropped_components = uint32_t(source.decimation->dropped_pieces);
  report.dropped_component_faces = uint32_t(source.decimation->dropped_faces);
}

MeshFrame encode_alone(const Plan &plan, size_t i, const PreparedMesh &source) {
  MeshFrame frame;
  frame.source = source.report;
  frame.decimation = source.decimation;
  frame.loss = source.loss;
  OwnedMesh holder;
  canonicalise(plan, i, source, holder, frame.report);
  OwnedBytes payload;
  fvv_diagnostic diagnostic = {};
  fvv::check(fvv_mesh_encode(&holder, plan.options.mesh_profile, mesh_level_of(plan), nullptr, &payload,
                             &diagnostic),
             name_of(plan, i), diagnostic);
  frame.payload = payload.copy();
  frame.faces = holder.face_count;
  return frame;
}

// Frames from one source on whose connectivity is the same.
class DeltaRun {
public:
  // Of one frame.
  DeltaRun(const Plan &chosen, const MeshTrack &of, size_t i, PreparedMesh &&begin)
      : plan(chosen), track(of), first(i), loaded(1), source(std::move(begin)) {}

  size_t size() const { return loaded.size(); }

  const PreparedMesh &key() const { return source; }

  // Takes frame first + size() when it belongs to the run.
  bool extend(const PreparedMesh &candidate) {
    DeltaInput next;
    if (candidate.body) next.patch = candidate.body->patch;
    next.source = candidate.report;
    next.decimation = candidate.decimation;
    next.loss = candidate.loss;
    const size_t i = first + size();
    const geometry::Mesh &moved = base();
    const geometry::Mesh &mesh = candidate.body ? candidate.body->mesh : candidate.mesh;
    const std::optional<std::vector<uint32_t>> there = same_connectivity(moved, mesh);
    if (!there) return false;
    const std::vector<double> positions = reordered(mesh, *there, moved).positions;
    next.order = *there;
    next.lattice.resize(positions.size());
    const geometry::Lattice &lattice = plan.lattice.lattice;
    fvv_diagnostic diagnostic = {};
    fvv::check(fvv_lattice_from_metres(lattice.origin, lattice.step, positions.data(), moved.vertex_count(),
                                       next.lattice.data(), &diagnostic),
               name_of(plan, i), diagnostic);
    for (size_t v = 0; v < moved.vertex_count(); v++) {
      double metres[3];
      fvv_lattice_to_metres(lattice.origin, lattice.step, &next.lattice[3 * v], metres);
      for (size_t k = 0; k < 3; k++)
        next.rounding = std::max(next.rounding, std::abs(metres[k] - positions[3 * v + k]));
    }
    loaded.push_back(std::move(next));
    return true;
  }

  // Key and as many delta frames as pay; at least one frame.
  std::vector<MeshFrame> encode() {
    if (size() == 1) return {encode_alone(plan, first, source)};
    std::vector<uint32_t> each(source.mesh.vertex_count());
    std::iota(each.begin(), each.end(), 0);
    const std::vector<std::vector<int32_t>> places = places_from(1, std::move(each));
    std::vector<const int32_t *> later;
    for (const std::vector<int32_t> &frame : places) later.push_back(frame.data());
    const fvv_mesh_source borrowed = borrow(source.mesh);
    const fvv_mesh_options options = options_of(plan, source);
    std::vector<MeshFrame> frames(1);
    frames[0].source = source.report;
    frames[0].decimation = source.decimation;
    frames[0].loss = source.loss;
    frames[0].report.struct_size = sizeof frames[0].report;
    fvv_diagnostic diagnostic = {};
    OwnedMesh mesh, decoded;
    std::vector<uint32_t> mesh_of(source.mesh.vertex_count());
    fvv::check(fvv_mesh_canonicalise_run(&borrowed, later.data(), later.size(), &options, nullptr, &mesh,
                                         mesh_of.data(), &frames[0].report, &diagnostic),
               name_of(plan, first), diagnostic);
    report_specks(source, frames[0].report);
    std::vector<uint32_t> coded(3 * size_t(mesh.face_count));
    OwnedBytes payload;
    fvv::check(fvv_mesh_encode_mapped(&mesh, plan.options.mesh_profile, mesh_level_of(plan), nullptr,
                                      &payload, &decoded, coded.data(), &diagnostic),
               name_of(plan, first), diagnostic);
    frames[0].payload = payload.copy();
    frames[0].faces = decoded.face_count;
    coded.resize(decoded.vertex_count);
    PatchCoder patches(plan, source.mesh, std::move(mesh_of), std::move(coded), decoded);
    frames[0].origins = std::make_shared<std::vector<uint32_t>>(patches.origins());
    follow(patches, decoded, frames);
    return frames;
  }

private:
  struct DeltaInput {
    scene::MeshReport source;
    std::optional<decimate::Report> decimation;
    QuantisationLoss loss;
    std::vector<int32_t> lattice; // in the order of the base's vertices
    std::vector<uint32_t> order;  // vertex of the base -> vertex of this frame
    double rounding = 0;          // metres, by which the lattice differs from the file
    std::optional<track::Patch> patch;
  };

  // The mesh that the next frame moves.
  const geometry::Mesh &base() const {
    for (size_t i = size(); i-- > 1;)
      if (loaded[i].patch) return loaded[i].patch->next;
    return source.mesh;
  }

  // In each frame from one on, the lattice indices of vertices of the base of that: while they last.
  std::vector<std::vector<int32_t>> places_from(size_t frame, std::vector<uint32_t> vertices) const {
    std::vector<std::vector<int32_t>> out;
    std::vector<int32_t> places(3 * vertices.size());
    for (; frame < size(); frame++) {
      for (size_t k = 0; k < places.size(); k++)
        if (vertices[k / 3] != none) places[k] = loaded[frame].lattice[3 * size_t(vertices[k / 3]) + k % 3];
      out.push_back(places);
      for (size_t v = 0; v < vertices.size() && loaded[frame].patch; v++)
        if (vertices[v] != none) vertices[v] = loaded[frame].patch->next_of[vertices[v]];
    }
    return out;
  }

  void follow(PatchCoder &patches, const fvv_mesh &key, std::vector<MeshFrame> &frames) const {
    fvv_diagnostic diagnostic = {};
    fvv_mesh_sequence *opened = nullptr;
    const fvv_status status = fvv_mesh_sequence_open(&key, nullptr, &opened, &diagnostic);
    const std::unique_ptr<fvv_mesh_sequence, void (*)(fvv_mesh_sequence *)> sequence(opened,
                                                                                     fvv_mesh_sequence_close);
    fvv::check(status, name_of(plan, first), diagnostic);
    fvv_mesh_delta_options options;
    fvv_mesh_delta_options_default(&options);
    options.max_error = track.lattice.delta_error;
    OwnedBytes payload;
    for (size_t i = 1; i < size(); i++) {
      const std::vector<uint32_t> &origins = patches.origins();
      std::vector<int32_t> wanted(3 * origins.size());
      for (size_t k = 0; k < wanted.size(); k++)
        wanted[k] = loaded[i].lattice[3 * size_t(origins[k / 3]) + k % 3];
      std::optional<PatchCoder::Coded> patch;
      if (loaded[i].patch) {
        const std::vector<uint32_t> &next = loaded[i].patch->next_of;
        const auto own = next.end() - std::ptrdiff_t(loaded[i].patch->joins.size());
        patch =
            patches.encode(*loaded[i].patch, places_from(i + 1, {own, next.end()}), name_of(plan, first + i));
        fvv_mesh_patch described = patch->described();
        fvv::check(fvv_mesh_sequence_encode_patched(sequence.get(), wanted.data(), &options, &described,
                                                    &payload, &diagnostic),
                   name_of(plan, first + i), diagnostic);
      } else {
        fvv::check(fvv_mesh_sequence_encode(sequence.get(), wanted.data(), &options, &payload, &diagnostic),
                   name_of(plan, first + i), diagnostic);
      }
      uint32_t off = 0, kept_count = 0;
      const int32_t *got = fvv_mesh_sequence_mesh(sequence.get())->lattice;
      const uint32_t *kept = fvv_mesh_sequence_kept(sequence.get(), &kept_count);
      for (size_t k = 0; k < 3 * size_t(kept_count); k++)
        off = std::max(off, uint32_t(std::abs(got[k] - wanted[kept ? 3 * size_t(kept[k / 3]) + k % 3 : k])));
      if (off > options.max_error || payload.size >= frames[0].payload.size()) return;
      MeshFrame frame;
      frame.key = false;
      frame.patched = patch.has_value();
      frame.faces = fvv_mesh_sequence_mesh(sequence.get())->face_count;
      frame.source = loaded[i].source;
      frame.decimation = loaded[i].decimation;
      frame.loss = loaded[i].loss;
      frame.report = frames[0].report;
      frame.report.max_error = loaded[i].rounding + off * plan.lattice.lattice.step;
      frame.payload = payload.copy();
      if (patch && !patches.add(*loaded[i].patch, *patch, *sequence)) return;
      auto own = std::make_shared<std::vector<uint32_t>>(patches.origins());
      for (size_t v = 0; v < own->size() && !patch; v++) (*own)[v] = loaded[i].order[(*own)[v]];
      frame.origins = *own == *frames.back().origins ? frames.back().origins : own;
      frames.push_back(std::move(frame));
    }
  }

  const Plan &plan;
  const MeshTrack &track;
  size_t first;
  std::vector<DeltaInput> loaded; // of the first frame nothing
  PreparedMesh source;
};

} // namespace

void check_normals(const Plan &plan, size_t i, const geometry::Mesh &mesh) {
  if (plan.normals.bits && mesh.normals.empty())
    throw Error(name_of(plan, i) + ": expected a normal for every corner as in the first frame, found " +
                "none (" + option_name("normals", "never") + " sends none)");
}

PreparedMesh prepare_mesh(const Plan &plan, const MeshTrack &track, size_t i) {
  PreparedMesh source = track.loader->load(i);
  check_normals(plan, i, source.mesh);
  source.loss = quantisation_loss(source.mesh, plan.lattice.lattice, plan.options.min_component,
                                  source.decimation.has_value());
  return source;
}

void canonicalise(const Plan &plan, size_t i, const PreparedMesh &source, fvv_mesh &mesh,
                  fvv_mesh_report &report) {
  const fvv_mesh_source borrowed = borrow(source.mesh);
  const fvv_mesh_options options = options_of(plan, source);
  report.struct_size = sizeof report;
  fvv_diagnostic diagnostic = {};
  fvv::check(fvv_mesh_canonicalise(&borrowed, &options, nullptr, &mesh, &report, &diagnostic),
             name_of(plan, i), diagnostic);
  report_specks(source, report);
}

namespace {

size_t bytes_of(const std::vector<MeshFrame> &frames) {
  size_t bytes = 0;
  for (const MeshFrame &frame : frames) bytes += frame.payload.size();
  return bytes;
}

// Whether frames that were tracked take fewer bytes than key frames of their own. If not, they are left as
// they are.
bool saves(const Plan &plan, const MeshTrack &track, size_t first, const std::vector<MeshFrame> &coded) {
  MeshTrack own = track;
  own.loader = std::make_shared<MeshLoader>(*track.loader, Track::never);
  std::vector<MeshFrame> keys;
  for (size_t i = 0; i < coded.size(); i++)
    keys.push_back(encode_alone(plan, first + i, prepare_mesh(plan, own, first + i)));
  if (bytes_of(coded) < bytes_of(keys)) return true;
  track.loader->leave_untracked(first);
  return false;
}

std::vector<MeshFrame> encode_in_turn(const Plan &plan, const MeshTrack &track, size_t first, size_t count) {
  std::vector<MeshFrame> frames;
  std::optional<PreparedMesh> next; // of the frame behind those in frames, when it was looked at already
  while (frames.size() < count) {
    const size_t begin = first + frames.size();
    if (!plan.has_mesh(begin)) {
      frames.emplace_back();
      continue;
    }
    DeltaRun run(plan, track, begin, next ? std::move(*next) : prepare_mesh(plan, track, begin));
    KeyColours colours(plan, begin, run.key());
    for (next.reset(); begin + run.size() < first + count && plan.has_mesh(begin + run.size());
         next.reset()) {
      next = prepare_mesh(plan, track, begin + run.size());
      if (!colours.serve(begin + run.size(), *next) || !run.extend(*next)) break;
    }
    std::vector<MeshFrame> coded = run.encode();
    if (coded.size() < run.size()) next.reset();
    if (plan.options.track == Track::automatic && track.loader->is_tracked(begin) &&
        !saves(plan, track, begin, coded)) {
      next.reset();
      continue;
    }
    std::move(coded.begin(), coded.end(), std::back_inserter(frames));
  }
  return frames;
}

} // namespace

std::vector<MeshFrame> encode_meshes(const Plan &plan, const MeshTrack &track, size_t first, size_t count) {
  return about_frame(plan.capture, {}, [&] { return encode_in_turn(plan, track, first, count); });
}

} // namespace fvv::mux
