// Meshes and pictures of a few frames that stand for a capture: loaded once, and given to every chooser of a
// plan. A chooser takes a scene, options and earlier choices, and returns its choice as a value.
#pragma once

#include "fvv_geometry/decimate.h"
#include "fvv_media/image.h"
#include "mux/src/plan.h"

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

namespace fvv::mux {

struct SampledMesh {
  int64_t number;      // of the frame, in file names
  geometry::Mesh mesh; // without normals
};

// The first, the middle and the last frame with a mesh, by rising number, each once, with faces as in the
// files. Throws Error.
std::vector<SampledMesh> sample_meshes(const scene::Capture &capture);

// The sharpest look at any of some vertices, enough of them to find it.
decimate::Sight sharpest(const geometry::Mesh &mesh, const decimate::Footprint &cameras);

class SampledScene {
public:
  struct Frame : SampledMesh {
    decimate::Footprint footprint; // of a pixel of the cameras
    decimate::Sight sharpest;      // at the mesh; infinite where no camera sees it
  };

  // A camera's picture as display values, and its mask if it has masks, in the size of its calibration.
  struct View {
    media::Image picture, mask;
  };

  // capture: as in the plan, borrowed. meshes: sample_meshes() of it; their faces are turned round if the
  // plan's are. cameras: whose pictures are sent.
  SampledScene(const scene::Capture &capture, std::vector<SampledMesh> meshes, const Tiling &cameras);

  const scene::Capture &of() const { return capture; }
  // Empty: the capture has no meshes.
  const std::vector<Frame> &frames() const { return all; }
  // There are meshes.
  const Frame &first() const { return all.front(); }
  const Frame &middle() const;

  // Of the first mesh. Throws Error.
  geometry::Mesh first_with_normals() const;
  // Of any frame with a mesh, by its number. Throws Error.
  geometry::Mesh mesh(int64_t number) const;
  // Of some pairs of neighbouring frames, evenly over the capture, the fraction that has the same
  // connectivity. Frames without a mesh do not count.
  double constant_topology_fraction() const;

  // With the plan's gains, as far as they are chosen. camera: index in the capture, calibrated as in
  // calibration; number: of the frame. Those of the middle frame are kept, because two choices use them. None
  // where the picture has another size, which is refused later. May be called by several threads.
  std::optional<View> view(const Plan &plan, size_t camera, int64_t number,
                           const fvv_camera &calibration) const;

private:
  struct Kept;
  View load(const Plan &plan, size_t camera, int64_t number) const;

  const scene::Capture &capture;
  std::vector<Frame> all;
  mutable std::mutex mutex;                                   // of what follows
  mutable std::map<size_t, std::shared_ptr<const Kept>> kept; // by camera
  mutable size_t kept_bytes = 0;
};

} // namespace fvv::mux
