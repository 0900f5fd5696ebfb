// What pictures say of a stream's meshes: which cameras see each place, as payloads of VISI, and the colours
// of vertices, as payloads of COLR.
#pragma once

#include "mux/src/choose/sampled_scene.h"
#include "mux/src/meshes/meshes.h"
#include "mux/src/stream_writer.h"
#include "mux/src/sums.h"

#include <atomic>
#include <map>
#include <set>

namespace fvv::mux {

// What one camera sees of a mesh, for each vertex. seen: FVV_VERTEX_..., of those that face it.
struct CameraView {
  uint16_t camera;
  int32_t centre[3]; // on the lattice
  std::vector<uint8_t> facing, seen;
};

// FVV_VERTEX_... of each vertex, by camera.
using States = std::map<uint16_t, std::vector<uint8_t>>;

// For each vertex how much of the surface around it a camera sees, 0 to 255, by camera.
using GivenVisibility = std::map<uint16_t, std::vector<uint8_t>>;

// mesh is as decoders have it, and so are cameras. One that is too far away for the lattice is left out.
// previous: of the frame before, if mesh has its faces; weights stay near to it. given:
// of the cameras for which it is known what they see; for the others it is found by rays.
std::vector<CameraView> look(const fvv_mesh &mesh, const geometry::Lattice &lattice,
                             const VisibilityChoice &choice, const std::vector<fvv_camera> &cameras,
                             const States &previous, const GivenVisibility &given = {});

// Whether the stream is to have visibility, of which cameras, and why. tiling: of the cameras. Throws Error
// (usage) if it is requested and there is nothing to see.
VisibilityChoice choose_visibility(const Options &options, const scene::Capture &capture,
                                   const Tiling &tiling);

// Whether the stream is to have colours of vertices, in cells of which size, and why. Throws Error (usage) if
// they are requested and nothing has colours.
ColourChoice choose_colours(const Plan &plan, const SampledScene &scene);

// Whether the pictures of cameras are to be corrected, and by how much, from a few frames. encoded: some
// pictures come encoded. Throws Error (usage) if it is requested and cannot be done.
MatchChoice choose_match(const Plan &plan, const SampledScene &scene, bool encoded);

// By the option, or by drawing cameras from the others in the middle frame, with their gains. encoded:
// likewise.
InsetChoice choose_inset(const Plan &plan, const SampledScene &scene, bool encoded);

// Of some frames. Each is empty if the stream has none.
struct SurfaceFrames {
  std::vector<VisibilityFrame> visibility;
  std::vector<ColourFrame> colours;
};

// For one stream. Every function may be called by several threads at once.
class SurfaceCoder {
public:
  // plan is borrowed; its choice of visibility is copied.
  explicit SurfaceCoder(const Plan &plan);

  // No more visibility is wanted: from now on encode returns frames without it.
  void stop_visibility() { on = false; }

  // Of the frames of a track's meshes; first: the number of the first one, counted from 0; meshes begin with
  // a key frame. Frames with the faces of the one before have its weights as contexts.
  SurfaceFrames encode(const MeshTrack &track, size_t first, const std::vector<MeshFrame> &meshes) const;

private:
  // What frames from memory say of visibility, brought to the vertices of the decoded mesh.
  GivenVisibility given(size_t frame, const fvv_mesh &mesh) const;
  // Of a key mesh. cameras: of the frame; states: what they see of it, of those that have it.
  ColourFrame colours(const MeshTrack &track, size_t frame, const fvv_mesh &mesh, const fvv_mesh &described,
                      const std::vector<fvv_camera> &cameras, const States &states) const;
  // Likewise, of those that the frame's mesh brings.
  ColourFrame vertex_colours(const MeshTrack &track, size_t frame, const fvv_mesh &mesh) const;
  // As decoders have them; those that are not calibrated in that frame are left out. indices: in
  // Capture::cameras.
  std::vector<fvv_camera> cameras_of(size_t frame, const std::vector<size_t> &indices) const;

  const Plan &plan;
  const VisibilityChoice choice;
  std::optional<MovingCameras> moving; // if any camera moves
  std::atomic<bool> on;
};

} // namespace fvv::mux
