#include "fvvrender/frame_visibility.h"

#include "cli/cli.h"
#include "fvv_demux/frame_plan.h"

#include <algorithm>

namespace fvv::rendering {

namespace {

// Weights that are coded are finer than those of bits of faces, and these than those of vertices.
int fineness(uint8_t domain) {
  return domain == FVV_VISIBILITY_WEIGHTS ? 2 : domain == FVV_VISIBILITY_FACES;
}

void add(const fvv_visibility &found, const fvv_mesh &mesh, std::vector<CameraWeights> &out) {
  const size_t count = found.header.element_count;
  std::vector<uint32_t> counts(2 * size_t(mesh.vertex_count));
  for (size_t i = 0; i < found.header.camera_count; i++) {
    CameraWeights camera = {found.cameras[i], found.header.domain, std::vector<uint8_t>(mesh.vertex_count)};
    fvv_visibility_weights(&mesh, camera.domain, found.states + i * count, counts.data(),
                           camera.weights.data());
    const auto same =
        std::find_if(out.begin(), out.end(), [&](const auto &c) { return c.camera == camera.camera; });
    if (same == out.end())
      out.push_back(std::move(camera));
    else if (fineness(camera.domain) > fineness(same->domain))
      *same = std::move(camera);
  }
}

} // namespace

std::vector<CameraWeights> load_visibility(fvv_stream *stream, size_t frame, const fvv_mesh &mesh,
                                           const fvv_configuration &configuration, uint16_t mesh_track,
                                           const std::string &where, std::vector<std::string> &losses) {
  std::vector<uint16_t> tracks;
  for (size_t i = 0; i < configuration.track_count; i++)
    if (configuration.tracks[i].kind == FVV_TRACK_VISIBILITY) tracks.push_back(configuration.tracks[i].id);
  std::vector<CameraWeights> out;
  for (const uint16_t track : tracks) {
    const fvv_visibility *found = nullptr;
    fvv_diagnostic diagnostic = {};
    const fvv_status status = fvv_stream_visibility(stream, frame, track, &found, &diagnostic);
    if (status < 0 && status > FVV_ERROR_DAMAGED) fvv::check(status, where, diagnostic);
    if (status < 0)
      losses.push_back(where + ": no visibility of track " + std::to_string(track) +
                       ", depth maps take its place: " + demux::text_of(diagnostic));
    else if (status == FVV_OK && found->header.mesh_track == mesh_track)
      add(*found, mesh, out);
  }
  return out;
}

} // namespace fvv::rendering
