#include "fvv_demux/meshes.h"
#include "fvv_cxx/owned.h"
#include "fvv_cxx/rung.h"
#include "fvv_demux/frame_plan.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace fvv::demux {

geometry::Lattice lattice_of(const double origin[3], double step) {
  return {{origin[0], origin[1], origin[2]}, step};
}

geometry::Mesh in_metres(const fvv_mesh &mesh, const geometry::Lattice &lattice) {
  geometry::Mesh out;
  out.positions.resize(size_t(mesh.vertex_count) * 3);
  for (size_t v = 0; v < mesh.vertex_count; v++)
    fvv_lattice_to_metres(lattice.origin, lattice.step, mesh.lattice + 3 * v, &out.positions[3 * v]);
  const double step = mesh.texture ? std::ldexp(1.0, -int(mesh.texture_bits)) : 0;
  for (size_t i = 0; mesh.texture && i < size_t(mesh.vertex_count) * 2; i++)
    out.texture.push_back(mesh.texture[i] * step);
  if (mesh.normals) {
    std::vector<float> normals(out.positions.size());
    fvv_normals_to_floats(mesh.normal_bits, mesh.normals, mesh.vertex_count, normals.data());
    out.normals.assign(normals.begin(), normals.end());
  }
  out.faces.assign(mesh.faces, mesh.faces + size_t(mesh.face_count) * 3);
  return out;
}

namespace {

// Turns a vector so that the axis that was up is +y.
template <class Number> void turn_up(uint8_t up, Number *v) {
  const Number x = v[0], y = v[1], z = v[2];
  const auto set = [v](Number a, Number b, Number c) {
    v[0] = a;
    v[1] = b;
    v[2] = c;
  };
  if (up == FVV_UP_X) set(-y, x, z);
  if (up == FVV_UP_Z) set(x, z, -y);
  if (up == FVV_UP_MINUS_X) set(y, -x, z);
  if (up == FVV_UP_MINUS_Y) set(x, -y, -z);
  if (up == FVV_UP_MINUS_Z) set(x, -z, y);
}

} // namespace

fvv_status colours_of(fvv_stream *stream, const fvv_configuration &configuration, size_t frame,
                      uint16_t mesh_track, std::vector<uint8_t> &colours, fvv_diagnostic &diagnostic) {
  colours.clear();
  if (configuration.video_count) return FVV_OK;
  const uint8_t *found = nullptr;
  uint32_t count = 0;
  const fvv_status status = fvv_stream_colours(stream, frame, mesh_track, &found, &count, &diagnostic);
  if (status == FVV_OK) colours.assign(found, found + size_t(count) * 3);
  return status < 0 ? status : FVV_OK;
}

bool is_of_run(const fvv_mesh &mesh, const std::vector<uint8_t> &colours, const scene::MeshRun &run) {
  const size_t texture = mesh.texture ? size_t(mesh.vertex_count) * 2 : 0;
  const scene::MeshRun::Frame &first = run.frames.at(0);
  return mesh.vertex_count == run.vertex_count() && size_t(mesh.face_count) * 3 == run.faces.size() &&
         texture == run.texture.size() && unsigned(mesh.texture_bits) == run.texture_bits &&
         !mesh.normals == first.normals.empty() && colours == run.colours &&
         std::equal(run.faces.begin(), run.faces.end(), mesh.faces) &&
         std::equal(run.texture.begin(), run.texture.end(), mesh.texture);
}

void append_frame(const fvv_mesh &mesh, const std::vector<uint8_t> &colours, double time,
                  const std::string &name, scene::MeshRun &run) {
  const size_t count = size_t(mesh.vertex_count) * 3;
  if (run.frames.empty()) {
    run.faces.assign(mesh.faces, mesh.faces + size_t(mesh.face_count) * 3);
    if (mesh.texture) run.texture.assign(mesh.texture, mesh.texture + size_t(mesh.vertex_count) * 2);
    run.texture_bits = mesh.texture_bits;
    run.colours = colours;
  }
  scene::MeshRun::Frame frame;
  frame.positions.assign(mesh.lattice, mesh.lattice + count);
  if (mesh.normals) {
    frame.normals.resize(count);
    fvv_normals_to_floats(mesh.normal_bits, mesh.normals, mesh.vertex_count, frame.normals.data());
  }
  frame.time = time;
  frame.name = name;
  run.frames.push_back(std::move(frame));
}

std::string format_glb(scene::MeshRun run, const geometry::Lattice &lattice, uint8_t up,
                       const std::string &picture, scene::Compression compression, const std::string &name,
                       bool *is_local) {
  geometry::Lattice turned = lattice;
  turn_up(up, turned.origin);
  for (scene::MeshRun::Frame &frame : run.frames) {
    for (size_t i = 0; i < frame.positions.size(); i += 3) turn_up(up, &frame.positions[i]);
    for (size_t i = 0; i < frame.normals.size(); i += 3) turn_up(up, &frame.normals[i]);
  }
  return scene::format_run(run, turned, picture, compression, name, is_local);
}

namespace {

scene::EnvironmentPart part_of(const fvv_environment &environment, const fvv_environment_part &source,
                               const fvv_mesh &mesh) {
  scene::EnvironmentPart out;
  out.lattice = lattice_of(environment.lattice_origin, environment.lattice_step);
  if (source.picture != FVV_NO_PICTURE) out.picture = source.picture;
  for (int k = 0; k < 3; k++) out.colour[k] = source.colour[k] / 65535.0;
  out.unlit = source.flags & FVV_PART_UNLIT;
  out.double_sided = source.flags & FVV_PART_DOUBLE_SIDED;
  out.clamped = source.flags & FVV_PART_CLAMPED;
  out.mesh = in_metres(mesh, *out.lattice);
  for (size_t i = 0; i < out.mesh.texture.size(); i++)
    out.mesh.texture[i] = source.texture_origin[i % 2] + source.texture_size[i % 2] * out.mesh.texture[i];
  return out;
}

// Appends what belongs to a group on one track. Parts and pictures follow those of other tracks.
fvv_status append(fvv_stream *stream, size_t group, uint16_t track, UnpackedEnvironment &out,
                  fvv_diagnostic &diagnostic) {
  const fvv_environment *environment;
  fvv_status status = fvv_stream_environment(stream, group, track, &environment, &diagnostic);
  if (status != FVV_OK) return status;
  std::vector<scene::EnvironmentPart> parts;
  for (size_t i = 0; i < environment->part_count; i++) {
    OwnedMesh holder;
    status = fvv_environment_mesh(environment, i, nullptr, nullptr, &holder, &diagnostic);
    if (status != FVV_OK) return status;
    parts.push_back(part_of(*environment, environment->parts[i], holder));
    if (parts.back().picture) *parts.back().picture += out.environment.pictures.size();
  }
  scene::Environment &all = out.environment;
  std::move(parts.begin(), parts.end(), std::back_inserter(all.parts));
  for (size_t i = 0; i < environment->picture_count; i++)
    all.pictures.emplace_back(reinterpret_cast<const char *>(environment->pictures[i].data),
                              environment->pictures[i].size);
  all.lights.insert(all.lights.end(), environment->lights, environment->lights + environment->light_count);
  if (!out.lattice || environment->lattice_step < out.lattice->step)
    out.lattice = lattice_of(environment->lattice_origin, environment->lattice_step);
  return FVV_OK;
}

} // namespace

UnpackedEnvironment unpack_environment(fvv_stream *stream, size_t group,
                                       const fvv_configuration &configuration,
                                       std::vector<std::string> &lost) {
  UnpackedEnvironment out;
  for (size_t i = 0; i < configuration.track_count; i++) {
    const fvv_track &track = configuration.tracks[i];
    if (track.kind != FVV_TRACK_ENVIRONMENT || !in_rung(configuration, track.id, 0)) continue;
    fvv_diagnostic diagnostic = {};
    if (append(stream, group, track.id, out, diagnostic) < 0)
      lost.push_back("track " + std::to_string(track.id) + ": " + text_of(diagnostic));
  }
  return out;
}

} // namespace fvv::demux
