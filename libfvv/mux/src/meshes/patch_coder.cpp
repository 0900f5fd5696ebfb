#include "mux/src/meshes/patch_coder.h"
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

PatchCoder::PatchCoder(const Plan &chosen, const geometry::Mesh &key, std::vector<uint32_t> mesh_of,
                       std::vector<uint32_t> coded, const fvv_mesh &decoded)
    : plan(chosen), point_of_vertex(std::move(mesh_of)), point_of_decoded(std::move(coded)) {
  find(key, decoded);
}

void PatchCoder::find(const geometry::Mesh &run, const fvv_mesh &decoded) {
  faces = run.faces;
  decoded_corners.assign(decoded.faces, decoded.faces + 3 * size_t(decoded.face_count));
  point_count = 0;
  for (const uint32_t point : point_of_decoded) point_count = std::max(point_count, point + 1);
  std::vector<uint32_t> vertex_of_point(point_count, no_vertex);
  for (uint32_t v = run.vertex_count(); v-- > 0;)
    if (point_of_vertex[v] < point_count) vertex_of_point[point_of_vertex[v]] = v;
  vertex_of_decoded.clear();
  for (const uint32_t point : point_of_decoded) vertex_of_decoded.push_back(vertex_of_point[point]);
  decoded_faces.clear();
  for (uint32_t f = 0; f < decoded.face_count; f++) {
    const uint32_t *face = decoded.faces + 3 * size_t(f);
    decoded_faces[corners_of(point_of_decoded[face[0]], point_of_decoded[face[1]], point_of_decoded[face[2]])]
        .push_back(f);
  }
}

std::vector<uint32_t> PatchCoder::remaining(const std::vector<uint8_t> &absent) const {
  std::vector<uint32_t> out(point_count, no_vertex);
  for (size_t k = 0; k < decoded_corners.size(); k++) {
    uint32_t &first = out[point_of_decoded[decoded_corners[k]]];
    if (!absent[k / 3]) first = std::min(first, decoded_corners[k]);
  }
  return out;
}

PatchCoder::Coded PatchCoder::encode(const track::Patch &patch,
                                     const std::vector<std::vector<int32_t>> &later,
                                     const std::string &name) const {
  Coded out;
  out.profile = plan.options.mesh_profile;
  out.level = *plan.options.mesh_level;
  out.absent.resize(decoded_corners.size() / 3);
  for (size_t f = 0; f < patch.absent.size(); f++) {
    if (!patch.absent[f]) continue;
    const uint32_t *face = &faces[3 * f];
    const auto found = decoded_faces.find(
        corners_of(point_of_vertex[face[0]], point_of_vertex[face[1]], point_of_vertex[face[2]]));
    if (found == decoded_faces.end()) continue; // it has no area on the lattice
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
  out.mesh_of.resize(patch.mesh.vertex_count());
  std::vector<const int32_t *> frames;
  for (const std::vector<int32_t> &frame : later) frames.push_back(frame.data());
  fvv_diagnostic diagnostic = {};
  fvv::check(fvv_mesh_canonicalise_run(&borrowed, frames.data(), frames.size(), &options, nullptr,
                                       out.mesh.get(), out.mesh_of.data(), &report, &diagnostic),
             name, diagnostic);
  out.border.assign(out.mesh->vertex_count, no_vertex);
  const std::vector<uint32_t> decoded_of_point = remaining(out.absent);
  out.decoded.resize(3 * size_t(out.mesh->face_count));
  for (uint32_t v = 0; v < out.mesh_of.size(); v++) {
    if (out.mesh_of[v] == no_vertex || patch.joins[v] == no_vertex) continue;
    const uint32_t point = point_of_vertex[patch.joins[v]];
    if (point < point_count) out.border[out.mesh_of[v]] = decoded_of_point[point];
  }
  return out;
}

fvv_mesh_patch PatchCoder::Coded::described() {
  fvv_mesh_patch out = {};
  out.struct_size = sizeof out;
  out.absent = absent.data();
  out.mesh = mesh.get();
  out.border = border.data();
  out.profile = profile;
  out.level = level;
  out.vertices = mesh ? decoded.data() : nullptr;
  return out;
}

bool PatchCoder::add(const track::Patch &patch, const Coded &coded, const fvv_mesh_sequence &sequence) {
  const fvv_mesh &merged = *fvv_mesh_sequence_mesh(&sequence);
  uint32_t count = 0;
  const uint32_t *kept = fvv_mesh_sequence_kept(&sequence, &count);
  std::vector<uint32_t> number(point_of_decoded.size(), no_vertex), points;
  for (uint32_t v = 0; v < count; v++) {
    points.push_back(point_of_decoded[kept[v]]);
    number[kept[v]] = v;
  }
  // Of the patch's vertices, those on kept ones have the point of these.
  uint32_t next_point = point_count;
  const uint32_t patch_count = coded.mesh ? coded.mesh->vertex_count : 0;
  std::vector<uint32_t> point_of_mesh(patch_count);
  for (uint32_t v = 0; v < patch_count; v++) {
    const uint32_t on = coded.border[v] == no_vertex ? no_vertex : number[coded.border[v]];
    point_of_mesh[v] = on == no_vertex ? next_point++ : points[on];
  }
  for (uint32_t v = count; v < merged.vertex_count; v++)
    points.push_back(point_of_mesh[coded.decoded[v - count]]);
  std::vector<bool> remains(next_point);
  for (const uint32_t point : points) remains[point] = true;
  std::vector<uint32_t> of_vertex(patch.next.vertex_count(), no_vertex);
  const size_t before = point_of_vertex.size();
  for (size_t v = 0; v < patch.next_of.size(); v++) {
    const uint32_t to = patch.next_of[v];
    if (to == no_vertex || of_vertex[to] != no_vertex) continue;
    const uint32_t mesh_vertex = v < before ? no_vertex : coded.mesh_of[v - before];
    const uint32_t point = v < before                 ? point_of_vertex[v]
                           : mesh_vertex == no_vertex ? no_vertex
                                                      : point_of_mesh[mesh_vertex];
    if (point < next_point && remains[point]) of_vertex[to] = point;
  }
  point_of_vertex = std::move(of_vertex);
  point_of_decoded = std::move(points);
  find(patch.next, merged);
  return std::find(vertex_of_decoded.begin(), vertex_of_decoded.end(), no_vertex) == vertex_of_decoded.end();
}

} // namespace fvv::mux
