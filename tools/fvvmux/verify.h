// fvvmux/verify.h: reads a written stream back and compares every frame with what the capture holds. Knows
// both ends: the stream through libfvv's reader, the capture through the plan.
#pragma once

#include "fvv_media/image.h"
#include "fvvmux/verify_mesh.h"

#include <cmath>

namespace fvv::mux {

// What was found in a stream that passed.
struct VideoVerdict {
  size_t pictures = 0;
  media::LumaError luma;      // pooled
  double min_psnr = INFINITY; // dB, of the worst frame; infinite when all are exact

  void add(const VideoVerdict &other);
};
struct Verdict {
  size_t meshes = 0, cameras = 0;
  std::vector<VideoVerdict> videos; // as Plan::tracks
  MeshVerdict mesh;
  // Pixels between a point's pixels in the capture's and the stream's camera; of cameras that stand still,
  // and of those that move.
  double max_reprojection = 0, moving_reprojection = 0;
  size_t visible = 0;     // frames whose visibility is what their cameras see
  size_t backgrounds = 0; // groups for which a reader finds the capture's environment
};

// plan.options.output was written by plan; origins: of each frame, unless there are no meshes. Throws
// cli::Failure, naming file and frame, when a frame is missing or does not decode, when a mesh is not that of
// the source (verify_mesh.h), when a picture is more than 10 dB worse than the sample by which the quality
// was judged, or not exact where it is lossless, when a camera projects elsewhere, when a bit is not what the
// camera sees of the mesh that was read, when the environment is not the capture's (verify_background.h).
Verdict verify(const Plan &plan, const std::vector<MeshOrigins> &origins);

} // namespace fvv::mux
