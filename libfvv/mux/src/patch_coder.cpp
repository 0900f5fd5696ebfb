#include "mux/src/patch_coder.h"
#include "fvv_cxx/error.h"

#include <algorithm>

namespace fvv::mux {

namespace {

constexpr uint32_t no_vertex = UINT32_MAX;

} // namespace

PatchCoder::Corners PatchCoder::corners_of(uint32_t a, uint32_t b, uint32_t c) {
  Corners out = {a, b, c};
  std::sort(out.begin(), out.end());
  return out;
}

PatchCoder::PatchCoder(const Plan &chosen, const geometry::Mesh &source, std::vector<uint32_t> canonical,
                       const std::vector<uint32_t> &coded, const fvv_mesh &decoded)
    : plan(chosen), mesh_of(std::move(canonical)), run(source), face_count(decoded.face_count) {
  for (uint32_t v = 0; v < coded.size(); v++) {
    if (coded[v] >= decoded_of.size()) decoded_of.resize(coded[v] + size_t(1), no_vertex);
    if (decoded_of[coded[v]] == no_vertex) decoded_of[coded[v]] = v;
  }
  for (uint32_t f = 0; f < decoded.face_count; f++) {
    const uint32_t *face = decoded.faces + 3 * size_t(f);
    faces[corners_of(coded[face[0]], coded[face[1]], coded[face[2]])].push_back(f);
  }
}

PatchCoder::Coded PatchCoder::encode(const track::Patch &patch, const std::string &name) const {
  Coded out;
  out.profile = plan.options.mesh_profile;
  out.level = plan.options.mesh_level;
  out.absent.resize(face_count);
  for (size_t f = 0; f < patch.absent.size(); f++) {
    if (!patch.absent[f]) continue;
    const uint32_t *face = &run.faces[3 * f];
    const auto found = faces.find(corners_of(mesh_of[face[0]], mesh_of[face[1]], mesh_of[face[2]]));
    if (found == faces.end()) continue; // it has no area on the lattice
    for (const uint32_t one : found->second) out.absent[one] = 1;
  }
  if (patch.mesh.faces.empty()) return out;
  out.mesh = std::make_shared<OwnedMesh>();
  const fvv_mesh_source borrowed = {patch.mesh.positions.data(),
                                    patch.mesh.faces.data(),
                                    patch.mesh.vertex_count(),
                                    patch.mesh.face_count(),
                                    nullptr,
                                    nullptr};
  fvv_mesh_options options;
  fvv_mesh_options_default(&options);
  options.keep_winding = 1;
  options.min_component_faces = 0;
  std::copy_n(plan.lattice.lattice.origin, 3, options.lattice_origin);
  options.lattice_step = plan.lattice.lattice.step;
  fvv_mesh_report report = {};
  report.struct_size = sizeof report;
  std::vector<uint32_t> patch_of(patch.mesh.vertex_count());
  fvv_diagnostic diagnostic = {};
  fvv::check(fvv_mesh_canonicalise_run(&borrowed, nullptr, 0, &options, nullptr, out.mesh.get(),
                                       patch_of.data(), &report, &diagnostic),
             name, diagnostic);
  out.border.assign(out.mesh->vertex_count, no_vertex);
  out.source.assign(out.mesh->vertex_count, no_vertex);
  for (uint32_t v = 0; v < patch_of.size(); v++) {
    if (patch_of[v] == no_vertex) continue;
    out.source[patch_of[v]] = v;
    const uint32_t canonical = patch.joins[v] == no_vertex ? no_vertex : mesh_of[patch.joins[v]];
    if (canonical != no_vertex && canonical < decoded_of.size())
      out.border[patch_of[v]] = decoded_of[canonical];
  }
  return out;
}

fvv_mesh_patch PatchCoder::Coded::described() const {
  fvv_mesh_patch out = {};
  out.struct_size = sizeof out;
  out.absent = absent.data();
  out.mesh = mesh.get();
  out.border = border.data();
  out.profile = profile;
  out.level = level;
  return out;
}

std::vector<uint32_t> PatchCoder::Coded::origins(const std::vector<uint32_t> &former, uint32_t vertex_count,
                                                 const fvv_mesh_sequence &sequence) const {
  using Place = std::array<int32_t, 3>;
  const fvv_mesh &merged = *fvv_mesh_sequence_mesh(&sequence);
  uint32_t count = 0;
  const uint32_t *kept = fvv_mesh_sequence_kept(&sequence, &count);
  std::vector<uint32_t> number(former.size(), no_vertex), out(count);
  for (uint32_t v = 0; v < count; v++) {
    out[v] = former[kept[v]];
    number[kept[v]] = v;
  }
  std::map<Place, uint32_t> vertices;
  for (uint32_t v = 0; mesh && v < mesh->vertex_count; v++) {
    const uint32_t on = border[v] == no_vertex ? no_vertex : number[border[v]];
    const int32_t *at = on == no_vertex ? mesh->lattice + 3 * size_t(v) : merged.lattice + 3 * size_t(on);
    vertices.emplace(Place{at[0], at[1], at[2]}, source[v]);
  }
  for (uint32_t v = count; v < merged.vertex_count; v++) {
    const int32_t *at = merged.lattice + 3 * size_t(v);
    out.push_back(vertex_count + vertices.at({at[0], at[1], at[2]}));
  }
  return out;
}

} // namespace fvv::mux
