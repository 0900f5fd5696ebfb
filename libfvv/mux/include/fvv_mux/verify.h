// Reads a written stream back and compares every frame with the capture.
#pragma once

#include "fvv_cxx/input_file.h"
#include "fvv_media/image.h"
#include "fvv_mux/plan.h"

#include <cmath>
#include <memory>
#include <vector>

namespace fvv::mux {

// What the encoder reports about a mesh, for comparison with its source.
struct MeshOrigins {
  std::shared_ptr<const std::vector<uint32_t>> vertices; // MeshFrame::origins
  uint32_t flipped_faces;                                // at most this number are reversed
};

struct MeshVerdict {
  // metres: largest difference of a coordinate between a source vertex and its decoded one
  double max_vertex_error = 0;
  double max_texture_error = 0; // likewise, in sides of the atlas
  double max_normal_error = 0;  // degrees, between a source vertex's normal and the sent or turned one

  void add(const MeshVerdict &other);
};

// The results for a stream that passed.
struct VideoVerdict {
  size_t pictures = 0;
  media::LumaError luma;      // pooled
  double min_psnr = INFINITY; // dB, of the worst frame; infinite when all are exact

  void add(const VideoVerdict &other);
};
struct MeshTrackVerdict {
  size_t meshes = 0, visible = 0; // frames with a mesh; with correct visibility
  MeshVerdict mesh;

  void add(const MeshTrackVerdict &other);
};
// What it has itself is that of the first rung's meshes.
struct Verdict : MeshTrackVerdict {
  std::vector<MeshTrackVerdict> lower_meshes; // of Plan::meshes without the first one
  size_t cameras = 0;
  std::vector<VideoVerdict> videos; // as Plan::tracks
  // Pixels between a point's pixels in the capture's and the stream's camera; of cameras that stand still,
  // and of those that move.
  double max_reprojection = 0, moving_reprojection = 0;
  size_t backgrounds = 0; // groups for which a reader finds the capture's environment
  size_t sounds = 0;      // groups whose sound is that of the plan
};

// file was written by plan; origins: of each track of Plan::meshes and frame. Throws
// Error, naming file and frame, when a frame is missing or does not decode, when a mesh is not that of
// the source (verify_mesh.h), when a picture is more than 10 dB worse than the sample by which the quality
// was judged, or not exact where it is lossless, when a camera projects elsewhere, when a bit is not what the
// camera sees of the mesh that was read, when the environment is not the capture's (verify_background.h).
Verdict verify(const Plan &plan, const std::vector<std::vector<MeshOrigins>> &origins, const InputFile &file);

} // namespace fvv::mux
