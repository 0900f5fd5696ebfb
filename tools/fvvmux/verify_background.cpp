#include "fvvmux/verify_background.h"

#include "cli/cli.h"
#include "cli/owned.h"
#include "fvvmux/background.h"
#include "fvvmux/meshes.h"
#include "fvvmux/picture_file.h"
#include "fvvmux/stream_writer.h"

#include <algorithm>
#include <cmath>

namespace fvv::mux {

namespace {

bool is_packed(const fvv_background &found, const std::vector<uint8_t> &payload, const std::string &name) {
  cli::OwnedBytes again;
  fvv_diagnostic diagnostic = {};
  cli::check(fvv_background_encode(&found, nullptr, &again, &diagnostic), name, diagnostic);
  return std::equal(payload.begin(), payload.end(), again.data, again.data + again.size);
}

// Every vertex lies within the part's bounds, but for the lattice; faces are at most left out.
bool is_part(const fvv_mesh &mesh, const capture::Mesh &source, const fvv_background &background) {
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (size_t i = 0; i < source.positions.size(); i++) {
    low[i % 3] = std::min(low[i % 3], source.positions[i]);
    high[i % 3] = std::max(high[i % 3], source.positions[i]);
  }
  const double slack = 0.51 * background.lattice_step;
  for (size_t i = 0; i < 3 * size_t(mesh.vertex_count); i++) {
    const double value =
        background.lattice_origin[i % 3] + background.lattice_step * double(mesh.positions[i]);
    if (!(value >= low[i % 3] - slack && value <= high[i % 3] + slack)) return false;
  }
  return mesh.face_count <= source.faces.size() / 3;
}

std::string against_capture(const fvv_background &found, const capture::Capture &capture,
                            const std::string &name) {
  const capture::Environment source = capture::load_environment(capture);
  if (found.part_count != source.parts.size() || found.picture_count != source.pictures.size() ||
      found.light_count != source.lights.size())
    return "expected " + std::to_string(source.parts.size()) + " parts, " +
           std::to_string(source.pictures.size()) + " pictures and " + std::to_string(source.lights.size()) +
           " lights, found " + std::to_string(found.part_count) + ", " + std::to_string(found.picture_count) +
           " and " + std::to_string(found.light_count);
  for (size_t i = 0; i < found.part_count; i++) {
    cli::OwnedMesh holder;
    fvv_diagnostic diagnostic = {};
    cli::check(fvv_background_mesh(&found, i, nullptr, nullptr, &holder, &diagnostic), name, diagnostic);
    const capture::EnvironmentPart &part = source.parts[i];
    const uint32_t picture = part.picture ? uint32_t(*part.picture) : FVV_NO_PICTURE;
    if (found.parts[i].picture != picture || !is_part(holder, part.mesh, found))
      return "part " + std::to_string(i) + " is not that of the capture";
  }
  for (size_t i = 0; i < found.picture_count; i++) {
    const std::string wanted = fit_picture(source.pictures[i], name).file;
    const auto *bytes = reinterpret_cast<const char *>(found.pictures[i].data);
    if (wanted.compare(0, wanted.npos, bytes, found.pictures[i].size))
      return "picture " + std::to_string(i) + " is not that of the capture";
  }
  return "";
}

} // namespace

std::string verify_background(fvv_stream *stream, size_t group, const Plan &plan, const std::string &name) {
  if (!plan.background) return "";
  const fvv_background *found = nullptr;
  fvv_diagnostic diagnostic = {};
  const fvv_status status = fvv_stream_background(stream, group, background_track, &found, &diagnostic);
  cli::check(status, name, diagnostic);
  std::string wrong;
  if (status == FVV_END)
    wrong = "there is none";
  else if (group == 0)
    wrong = against_capture(*found, plan.capture, name);
  if (wrong.empty() && !is_packed(*found, plan.background->payload, name))
    wrong = "it is not the one that was written";
  return wrong.empty() ? "" : "group " + std::to_string(group) + ": environment: " + wrong;
}

} // namespace fvv::mux
