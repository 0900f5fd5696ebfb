#include "fvvdemux/background.h"

#include "cli/owned.h"
#include "fvvdemux/plan.h"

#include <algorithm>

namespace fvv::demux {

namespace {

capture::EnvironmentPart part_of(const fvv_background &background, const fvv_background_part &source,
                                 const fvv_mesh &mesh) {
  capture::EnvironmentPart out;
  if (source.picture != FVV_NO_PICTURE) out.picture = source.picture;
  for (int k = 0; k < 3; k++) out.colour[k] = source.colour[k] / 65535.0;
  out.unlit = source.flags & FVV_PART_UNLIT;
  out.double_sided = source.flags & FVV_PART_DOUBLE_SIDED;
  out.clamped = source.flags & FVV_PART_CLAMPED;
  out.mesh.positions.resize(3 * size_t(mesh.vertex_count));
  for (size_t v = 0; v < mesh.vertex_count; v++)
    fvv_lattice_to_metres(background.lattice_origin, background.lattice_step, mesh.positions + 3 * v,
                          &out.mesh.positions[3 * v]);
  out.mesh.faces.assign(mesh.faces, mesh.faces + 3 * size_t(mesh.face_count));
  if (mesh.texture) {
    const double step = 1.0 / double(1u << mesh.texture_bits);
    for (size_t i = 0; i < 2 * size_t(mesh.vertex_count); i++)
      out.mesh.texture.push_back(source.texture_origin[i % 2] +
                                 source.texture_size[i % 2] * (mesh.texture[i] * step));
  }
  if (mesh.normals) {
    std::vector<float> normals(3 * size_t(mesh.vertex_count));
    fvv_normals_to_floats(mesh.normal_bits, mesh.normals, mesh.vertex_count, normals.data());
    out.mesh.normals.assign(normals.begin(), normals.end());
  }
  return out;
}

} // namespace

const fvv_track *background_track_of(const fvv_configuration &configuration,
                                     std::vector<std::string> *warnings) {
  const fvv_track *found = nullptr;
  for (size_t i = 0; i < configuration.track_count; i++) {
    const fvv_track &track = configuration.tracks[i];
    if (track.kind != FVV_TRACK_BACKGROUND) continue;
    if (!found)
      found = &track;
    else if (warnings)
      warnings->push_back("track " + std::to_string(track.id) + " is left out: only one background is taken");
  }
  return found;
}

std::optional<UnpackedBackground> unpack_background(fvv_stream *stream, size_t group, uint16_t track,
                                                    std::string &why) {
  const fvv_background *background;
  fvv_diagnostic diagnostic = {};
  fvv_status status = fvv_stream_background(stream, group, track, &background, &diagnostic);
  UnpackedBackground out;
  if (status == FVV_OK) {
    std::copy_n(background->lattice_origin, 3, out.lattice.origin);
    out.lattice.step = background->lattice_step;
    for (size_t i = 0; i < background->picture_count; i++)
      out.environment.pictures.emplace_back(reinterpret_cast<const char *>(background->pictures[i].data),
                                            background->pictures[i].size);
    out.environment.lights.assign(background->lights, background->lights + background->light_count);
  }
  for (size_t i = 0; status == FVV_OK && i < background->part_count; i++) {
    cli::OwnedMesh holder;
    status = fvv_background_mesh(background, i, nullptr, nullptr, &holder, &diagnostic);
    if (status == FVV_OK) out.environment.parts.push_back(part_of(*background, background->parts[i], holder));
  }
  if (status < 0) why = text_of(diagnostic);
  return status == FVV_OK ? std::optional(std::move(out)) : std::nullopt;
}

} // namespace fvv::demux
