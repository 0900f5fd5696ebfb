#include "fvvmux/meshes.h"

#include "cli/cli.h"
#include "cli/owned.h"
#include "fvvmux/connectivity.h"
#include "fvvmux/geometry.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace fvv::mux {

namespace {

std::string name_of(const Plan &plan, size_t i) {
  const int64_t number = plan.capture.frames.number(int64_t(i));
  return plan.capture.mesh_path(number) + ": frame " + std::to_string(number);
}

fvv_mesh_source borrow(const capture::Mesh &mesh) {
  return {mesh.positions.data(),
          mesh.faces.data(),
          mesh.vertex_count(),
          mesh.face_count(),
          mesh.texture.empty() ? nullptr : mesh.texture.data(),
          mesh.normals.empty() ? nullptr : mesh.normals.data()};
}

fvv_mesh_options options_of(const Plan &plan, const Source &source) {
  fvv_mesh_options options;
  fvv_mesh_options_default(&options);
  std::copy_n(plan.lattice.lattice.origin, 3, options.lattice_origin);
  options.lattice_step = plan.lattice.lattice.step;
  // Decimation has dropped specks already, by the faces that they had before.
  options.min_component_faces = source.decimation ? 0 : plan.options.min_component;
  options.texture_bits = plan.texture_bits;
  options.normal_bits = plan.normals.bits;
  return options;
}

void report_specks(const Source &source, fvv_mesh_report &report) {
  if (!source.decimation) return;
  report.dropped_components = uint32_t(source.decimation->dropped_pieces);
  report.dropped_component_faces = uint32_t(source.decimation->dropped_faces);
}

MeshFrame encode_alone(const Plan &plan, size_t i, const Source &source) {
  MeshFrame frame;
  frame.source = source.report;
  frame.decimation = source.decimation;
  cli::OwnedMesh holder;
  canonicalise(plan, i, source, holder, frame.report);
  cli::OwnedBytes payload;
  fvv_diagnostic diagnostic = {};
  cli::check(fvv_mesh_encode(&holder, plan.options.mesh_profile, plan.options.mesh_level, nullptr, &payload,
                             &diagnostic),
             name_of(plan, i), diagnostic);
  frame.payload = payload.copy();
  return frame;
}

// Frames from one source on whose connectivity is the same.
class Run {
public:
  // Of one frame.
  Run(const Plan &chosen, size_t i, Source &&begin)
      : plan(chosen), first(i), loaded(1), source(std::move(begin)) {}

  size_t size() const { return loaded.size(); }

  // Takes frame first + size() when it belongs to the run.
  bool extend(const Source &candidate) {
    Later next;
    next.source = candidate.report;
    next.decimation = candidate.decimation;
    const size_t i = first + size();
    const capture::Mesh &mesh = candidate.mesh;
    const std::optional<std::vector<uint32_t>> there = same_connectivity(source.mesh, mesh);
    if (!there) return false;
    const std::vector<double> positions = reordered(mesh, *there, source.mesh).positions;
    next.order = *there;
    next.lattice.resize(positions.size());
    const capture::Lattice &lattice = plan.lattice.lattice;
    fvv_diagnostic diagnostic = {};
    cli::check(fvv_lattice_from_metres(lattice.origin, lattice.step, positions.data(),
                                       source.mesh.vertex_count(), next.lattice.data(), &diagnostic),
               name_of(plan, i), diagnostic);
    for (size_t v = 0; v < source.mesh.vertex_count(); v++) {
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
    std::vector<const int32_t *> later;
    for (size_t i = 1; i < size(); i++) later.push_back(loaded[i].lattice.data());
    const fvv_mesh_source borrowed = borrow(source.mesh);
    const fvv_mesh_options options = options_of(plan, source);
    std::vector<MeshFrame> frames(1);
    frames[0].source = source.report;
    frames[0].decimation = source.decimation;
    frames[0].report.struct_size = sizeof frames[0].report;
    fvv_diagnostic diagnostic = {};
    cli::OwnedMesh mesh, decoded;
    std::vector<uint32_t> mesh_of(source.mesh.vertex_count());
    cli::check(fvv_mesh_canonicalise_run(&borrowed, later.data(), later.size(), &options, nullptr, &mesh,
                                         mesh_of.data(), &frames[0].report, &diagnostic),
               name_of(plan, first), diagnostic);
    report_specks(source, frames[0].report);
    std::vector<uint32_t> coded(3 * size_t(mesh.face_count));
    cli::OwnedBytes payload;
    cli::check(fvv_mesh_encode_mapped(&mesh, plan.options.mesh_profile, plan.options.mesh_level, nullptr,
                                      &payload, &decoded, coded.data(), &diagnostic),
               name_of(plan, first), diagnostic);
    frames[0].payload = payload.copy();
    frames[0].origins = origins_of(mesh_of, coded, decoded.vertex_count, mesh.vertex_count);
    follow(decoded, frames);
    return frames;
  }

private:
  struct Later {
    capture::MeshReport source;
    std::optional<decimate::Report> decimation;
    std::vector<int32_t> lattice; // in the order of the first frame's vertices
    std::vector<uint32_t> order;  // vertex of the first frame -> vertex of this one
    double rounding = 0;          // metres, by which the lattice differs from the file
  };

  // Of the vertices that were welded the first stands for all.
  static std::shared_ptr<const std::vector<uint32_t>> origins_of(const std::vector<uint32_t> &mesh_of,
                                                                 const std::vector<uint32_t> &coded,
                                                                 size_t decoded_count, size_t mesh_count) {
    std::vector<uint32_t> source_of(mesh_count);
    for (size_t v = mesh_of.size(); v-- > 0;)
      if (mesh_of[v] != UINT32_MAX) source_of[mesh_of[v]] = uint32_t(v);
    auto origins = std::make_shared<std::vector<uint32_t>>(decoded_count);
    for (size_t v = 0; v < decoded_count; v++) (*origins)[v] = source_of[coded[v]];
    return origins;
  }

  void follow(const fvv_mesh &key, std::vector<MeshFrame> &frames) const {
    fvv_diagnostic diagnostic = {};
    fvv_mesh_sequence *opened = nullptr;
    const fvv_status status = fvv_mesh_sequence_open(&key, nullptr, &opened, &diagnostic);
    const std::unique_ptr<fvv_mesh_sequence, void (*)(fvv_mesh_sequence *)> sequence(opened,
                                                                                     fvv_mesh_sequence_close);
    cli::check(status, name_of(plan, first), diagnostic);
    const std::vector<uint32_t> origins = *frames[0].origins;
    fvv_mesh_delta_options options;
    fvv_mesh_delta_options_default(&options);
    options.max_error = plan.lattice.delta_error;
    cli::OwnedBytes payload;
    for (size_t i = 1; i < size(); i++) {
      std::vector<int32_t> wanted(3 * origins.size());
      for (size_t k = 0; k < wanted.size(); k++)
        wanted[k] = loaded[i].lattice[3 * size_t(origins[k / 3]) + k % 3];
      cli::check(fvv_mesh_sequence_encode(sequence.get(), wanted.data(), &options, &payload, &diagnostic),
                 name_of(plan, first + i), diagnostic);
      uint32_t off = 0;
      const int32_t *got = fvv_mesh_sequence_mesh(sequence.get())->positions;
      for (size_t k = 0; k < wanted.size(); k++) off = std::max(off, uint32_t(std::abs(got[k] - wanted[k])));
      if (off > options.max_error || payload.size >= frames[0].payload.size()) return;
      MeshFrame frame;
      frame.key = false;
      frame.source = loaded[i].source;
      frame.decimation = loaded[i].decimation;
      frame.report = frames[0].report;
      frame.report.max_error = loaded[i].rounding + off * plan.lattice.lattice.step;
      frame.payload = payload.copy();
      auto own = std::make_shared<std::vector<uint32_t>>(origins);
      for (uint32_t &vertex : *own) vertex = loaded[i].order[vertex];
      frame.origins = *own == origins ? frames[0].origins : own;
      frames.push_back(std::move(frame));
    }
  }

  const Plan &plan;
  size_t first;
  std::vector<Later> loaded; // of the first frame nothing
  Source source;
};

} // namespace

Source load_source(const Plan &plan, size_t i) {
  Source source;
  source.mesh = plan.geometry->load(i, &source.report, source.decimation);
  if (plan.normals.bits && source.mesh.normals.empty())
    throw cli::Failure(name_of(plan, i) +
                       ": expected a normal for every corner as in the first frame, found " +
                       "none (--normals never sends none)");
  return source;
}

void canonicalise(const Plan &plan, size_t i, const Source &source, fvv_mesh &mesh, fvv_mesh_report &report) {
  const fvv_mesh_source borrowed = borrow(source.mesh);
  const fvv_mesh_options options = options_of(plan, source);
  report.struct_size = sizeof report;
  fvv_diagnostic diagnostic = {};
  cli::check(fvv_mesh_canonicalise(&borrowed, &options, nullptr, &mesh, &report, &diagnostic),
             name_of(plan, i), diagnostic);
  report_specks(source, report);
}

std::vector<MeshFrame> encode_meshes(const Plan &plan, size_t first, size_t count) {
  std::vector<MeshFrame> frames;
  std::optional<Source> next; // of the frame behind those in frames, when it was looked at already
  while (frames.size() < count) {
    const size_t begin = first + frames.size();
    Run run(plan, begin, next ? std::move(*next) : load_source(plan, begin));
    for (next.reset(); begin + run.size() < first + count; next.reset()) {
      next = load_source(plan, begin + run.size());
      if (!run.extend(*next)) break;
    }
    std::vector<MeshFrame> coded = run.encode();
    if (coded.size() < run.size()) next.reset();
    std::move(coded.begin(), coded.end(), std::back_inserter(frames));
  }
  return frames;
}

} // namespace fvv::mux
