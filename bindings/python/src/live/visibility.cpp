#include "live/visibility.h"

#include <algorithm>
#include <cstring>

namespace fvv::python {

void LiveVisibility::call(fvv_status status, fvv_diagnostic &diagnostic, const fvv_frame_chunk &chunk) const {
  if (status >= 0) return;
  diagnostic.offset += chunk.offset;
  require(status, diagnostic, file);
}

void LiveVisibility::reject(uint32_t issue, const std::string &message, const fvv_frame_chunk &chunk) const {
  fvv_diagnostic diagnostic = {};
  diagnostic.status = FVV_ERROR_INVALID;
  diagnostic.issue = issue;
  diagnostic.chunk_type = FVV_CHUNK_VISIBILITY;
  diagnostic.offset = chunk.offset;
  std::strncpy(diagnostic.message, message.c_str(), sizeof diagnostic.message - 1);
  throw Failure(diagnostic, file);
}

void LiveVisibility::check_number(const Track &track, const fvv_visibility_header &header,
                                  const fvv_frame_chunk &chunk) const {
  const bool key = (chunk.header.flags & FVV_FLAG_KEY) != 0;
  const fvv_visibility_header &former = track.header;
  if (key != !header.number)
    reject(FVV_ISSUE_VISIBILITY_NUMBER, "the number of the chunk contradicts its key flag", chunk);
  if (!key && (track.states.empty() || header.number != former.number + 1 ||
               header.mesh_track != former.mesh_track || header.vertex_count != former.vertex_count))
    reject(FVV_ISSUE_VISIBILITY_NUMBER, "the chunk does not follow the one before", chunk);
}

void LiveVisibility::keep_order(Track &track, const fvv_mesh &mesh, const fvv_frame_chunk &chunk) const {
  const size_t count = 3 * size_t(mesh.face_count);
  if (track.order && track.header.vertex_count == mesh.vertex_count && track.faces.size() == count &&
      std::equal(track.faces.begin(), track.faces.end(), mesh.faces))
    return;
  fvv_visibility_order *opened = nullptr;
  fvv_diagnostic diagnostic = {};
  call(fvv_visibility_order_open(&mesh, nullptr, &opened, &diagnostic), diagnostic, chunk);
  track.order.reset(opened);
  track.faces.assign(mesh.faces, mesh.faces + count);
}

void LiveVisibility::centre_of(uint16_t id, const fvv_calibration *calibration, int32_t centre[3],
                               const fvv_frame_chunk &chunk) const {
  const fvv_camera *camera = fvv_configuration_camera(&configuration, id);
  fvv_camera now;
  if (camera && camera->flags & FVV_CAMERA_MOVES)
    camera = calibration && fvv_calibration_camera(calibration, id, &now) == FVV_OK ? &now : nullptr;
  fvv_diagnostic diagnostic = {};
  if (!camera || fvv_visibility_centre(camera, &configuration.scene, centre, &diagnostic) != FVV_OK)
    reject(FVV_ISSUE_VISIBILITY_CAMERA, "camera " + std::to_string(id) + " has no place at this time", chunk);
}

void LiveVisibility::decode(const fvv_frame_chunk &chunk, const Meshes &meshes,
                            const fvv_calibration *calibration, Weights &out) {
  const auto size = size_t(chunk.header.size);
  Track &track = tracks[chunk.header.track];
  fvv_visibility_header header;
  fvv_diagnostic diagnostic = {};
  call(fvv_visibility_peek(chunk.payload, size, &limits.core, &header, nullptr, 0, &diagnostic), diagnostic,
       chunk);
  check_number(track, header, chunk);
  const auto found = meshes.find(header.mesh_track);
  if (found == meshes.end() || found->second->mesh.vertex_count != header.vertex_count)
    reject(FVV_ISSUE_VISIBILITY_MESH, "visibility and the mesh at its time differ in vertices", chunk);
  const fvv_mesh &mesh = found->second->mesh;
  std::vector<fvv_visibility_stream> streams(header.camera_count);
  call(fvv_visibility_peek(chunk.payload, size, &limits.core, &header, streams.data(), streams.size(),
                           &diagnostic),
       diagnostic, chunk);
  keep_order(track, mesh, chunk);
  std::map<uint16_t, std::vector<uint8_t>> next;
  for (const fvv_visibility_stream &stream : streams) {
    int32_t centre[3];
    // Before there is memory for it: a table names a camera in two bytes.
    centre_of(stream.camera, calibration, centre, chunk);
    const auto former = track.states.find(stream.camera);
    const uint8_t *before = header.number && former != track.states.end() ? former->second.data() : nullptr;
    std::vector<uint8_t> &states = next[stream.camera];
    states.resize(header.vertex_count);
    call(fvv_visibility_decode(track.order.get(), &mesh, &header, chunk.payload + stream.offset, stream.size,
                               centre, before, states.data(), &diagnostic),
         diagnostic, chunk);
    std::vector<uint8_t> weights(states.size());
    fvv_visibility_weights(states.data(), states.size(), weights.data());
    out.try_emplace({header.mesh_track, stream.camera}, std::move(weights));
  }
  track.header = header;
  track.states = std::move(next);
}

} // namespace fvv::python
