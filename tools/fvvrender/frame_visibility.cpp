#include "fvvrender/frame_visibility.h"

#include "cli/cli.h"
#include "fvvdemux/plan.h"

#include <algorithm>

namespace fvv::rendering {

namespace {

void add(const fvv_visibility &found, std::vector<CameraBits> &out) {
  const size_t count = found.header.element_count;
  for (size_t i = 0; i < found.header.camera_count; i++) {
    CameraBits bits = {found.cameras[i], found.header.domain, std::vector<uint8_t>(count)};
    for (size_t k = 0; k < count; k++) bits.seen[k] = found.states[i * count + k] == FVV_ELEMENT_SEEN;
    const auto same =
        std::find_if(out.begin(), out.end(), [&](const auto &b) { return b.camera == bits.camera; });
    if (same == out.end())
      out.push_back(std::move(bits));
    else if (bits.domain == FVV_VISIBILITY_FACES && same->domain != FVV_VISIBILITY_FACES)
      *same = std::move(bits);
  }
}

} // namespace

std::vector<CameraBits> load_visibility(fvv_stream *stream, size_t frame,
                                        const fvv_configuration &configuration, uint16_t mesh_track,
                                        const std::string &where, std::vector<std::string> &losses) {
  std::vector<uint16_t> tracks;
  for (size_t i = 0; i < configuration.track_count; i++)
    if (configuration.tracks[i].kind == FVV_TRACK_VISIBILITY) tracks.push_back(configuration.tracks[i].id);
  std::vector<CameraBits> out;
  for (const uint16_t track : tracks) {
    const fvv_visibility *found = nullptr;
    fvv_diagnostic diagnostic = {};
    const fvv_status status = fvv_stream_visibility(stream, frame, track, &found, &diagnostic);
    if (status < 0 && status > FVV_ERROR_DAMAGED) cli::check(status, where, diagnostic);
    if (status < 0)
      losses.push_back(where + ": no visibility of track " + std::to_string(track) +
                       ", depth maps take its place: " + demux::text_of(diagnostic));
    else if (status == FVV_OK && found->header.mesh_track == mesh_track)
      add(*found, out);
  }
  return out;
}

} // namespace fvv::rendering
