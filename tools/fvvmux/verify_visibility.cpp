#include "fvvmux/verify_visibility.h"

#include "cli/cli.h"
#include "fvvmux/stream_writer.h"

namespace fvv::mux {

namespace {

// As the stream has them in that frame; nothing of those that are not calibrated.
std::vector<fvv_camera> cameras_in(fvv_stream *stream, size_t frame, const Plan &plan,
                                   const std::string &name) {
  std::vector<fvv_camera> out;
  for (const size_t index : plan.visibility.cameras) {
    fvv_camera camera;
    fvv_diagnostic diagnostic = {};
    const fvv_status status =
        fvv_stream_camera(stream, frame, plan.capture.cameras[index].calibration.id, &camera, &diagnostic);
    cli::check(status, name, diagnostic);
    if (status == FVV_OK) out.push_back(camera);
  }
  return out;
}

// As a decoder should have it.
uint8_t state_of(const CameraView &view, uint8_t domain, size_t element) {
  if (!view.facing[element]) return FVV_ELEMENT_AVERSE;
  if (domain == FVV_VISIBILITY_SHARES) return view.seen[element];
  return view.seen[element] ? FVV_ELEMENT_SEEN : FVV_ELEMENT_HIDDEN;
}

} // namespace

std::string VisibilityVerifier::frame(fvv_stream *stream, size_t frame, const fvv_mesh &mesh) {
  const fvv_visibility *found = nullptr;
  fvv_diagnostic diagnostic = {};
  const fvv_status status = fvv_stream_visibility(stream, frame, visibility_track, &found, &diagnostic);
  cli::check(status, name, diagnostic);
  if (!found || !found->header.number) former.clear();
  const std::vector<CameraView> wanted =
      look(mesh, plan.lattice.lattice, plan.visibility, cameras_in(stream, frame, plan, name), former);
  former.clear();
  const size_t cameras = found ? found->header.camera_count : 0;
  if (cameras != wanted.size())
    return "expected visibility of " + std::to_string(wanted.size()) + " cameras, found " +
           std::to_string(cameras);
  for (size_t i = 0; i < cameras; i++) {
    const uint8_t *states = found->states + i * found->header.element_count;
    for (size_t k = 0; k < wanted[i].facing.size(); k++)
      if (found->cameras[i] != wanted[i].camera ||
          states[k] != state_of(wanted[i], plan.visibility.domain, k))
        return "what camera " + std::to_string(wanted[i].camera) + " sees of element " + std::to_string(k) +
               " is not what was read back";
    former[found->cameras[i]].assign(states, states + found->header.element_count);
  }
  return "";
}

} // namespace fvv::mux
