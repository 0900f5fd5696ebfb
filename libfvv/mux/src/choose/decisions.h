// What the first group of a stream settles: choices that a plan leaves open because they depend on encoded
// bytes. The configuration of the stream follows from plan and decisions.
#pragma once

#include "fvv_media/video.h"
#include "mux/src/plan.h"

#include <map>
#include <string>
#include <vector>

namespace fvv::mux {

// The quality of a video track.
struct VideoDecision {
  media::VideoSettings settings = {};
  bool masks = false;          // the PSNR is that of the foreground
  uint32_t sample_frames = 0;  // by which quality was chosen or judged, of one group
  double target_psnr = 0;      // dB; 0: none was searched
  double sample_psnr = 0;      // dB; may be infinite; below target_psnr where no quality reaches that
  double sample_rate = 0;      // bits a second
  std::vector<uint8_t> record; // the codec's, the same for every group
  std::string codec_string;
};

struct VisibilityDecision {
  bool on = false;
  std::string reason;
};

// bytes: of visibility in the first group; pictures: of the pictures there.
VisibilityDecision decide_visibility(const VisibilityChoice &choice, uint64_t bytes, uint64_t pictures);

// Of a mesh track: whether it is sent, and which fraction of the bytes of its rung it saves there.
struct MeshDecision {
  bool sent = true;
  double saving = 0;
};

// For TRAK, by track identifier.
struct NominalRates {
  std::map<uint16_t, double> rates; // bits a second
  std::map<uint16_t, double> sizes; // faces of a mesh
};

struct Decisions {
  std::vector<VideoDecision> videos; // as Plan::tracks
  std::vector<MeshDecision> meshes;  // as Plan::meshes
  VisibilityDecision visibility;
  NominalRates nominal; // of a ladder

  // Index of the mesh track that a rung takes. There are meshes.
  size_t mesh_of(const Plan &plan, size_t rung) const;
  // Whether rungs take different meshes.
  bool has_mesh_rungs(const Plan &plan) const;
};

// Payload of the first group.
struct FirstGroup {
  struct Meshes {
    uint64_t mesh = 0, visibility = 0, colours = 0; // bytes
    size_t frames = 0;                              // with a mesh
    double faces = 0;                               // of all of them
  };
  std::vector<Meshes> meshes;   // as Plan::meshes
  std::vector<uint64_t> videos; // bytes, as Plan::tracks
};

// videos: as Plan::tracks.
Decisions decide(const Plan &plan, std::vector<VideoDecision> videos, const FirstGroup &first);

} // namespace fvv::mux
