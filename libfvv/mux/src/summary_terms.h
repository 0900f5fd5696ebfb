// The terms of the summary as text and as JSON.
#pragma once

#include "fvv_cxx/format.h"
#include "fvv_mux/summary.h"
#include "mux/src/pictures.h"

#include <algorithm>

namespace fvv::mux {

inline const char *codec_text(const Summary &s) {
  return media::find_video_codec(s.plan.options.codec)->option;
}

// Frames of the capture at which the stage is empty, also where they are no frames of the stream.
inline size_t empty_frames(const Summary &s) {
  const scene::Frames &frames = s.plan.capture.frames;
  size_t count = 0;
  for (const int64_t number : s.plan.capture.empty) {
    const int64_t place = (number - frames.first) / frames.step;
    count += number >= frames.first && place < frames.places();
  }
  return count;
}

inline const char *profile_text(const Summary &s) {
  return fvv_mesh_profile_name(s.plan.options.mesh_profile);
}

inline double per_second(const Summary &s) {
  return s.seconds > 0 ? double(s.plan.frame_count()) / s.seconds : 0;
}

inline uint64_t overhead(const Summary &s) {
  uint64_t bytes = s.bytes - s.payload() - s.calibration.payload - s.background.payload;
  for (const MeshSums &meshes : s.lower_meshes) bytes -= meshes.payload();
  for (const TrackBytes &video : s.videos) bytes -= video.payload;
  for (const TrackBytes &sound : s.sounds) bytes -= sound.payload;
  return bytes;
}

// As a key of JSON.
inline const char *label_of(const VideoTrack &track) {
  return track.is_atlas() ? "atlas" : "video";
}

// For people: "video 2" where several tracks show cameras, "rung 1" below the first rung, "rung 1 video 2".
inline std::string name_of(const Summary &s, const VideoTrack &track) {
  const bool counted = !track.is_atlas() && s.plan.tile_track_count() > 1;
  const std::string name = label_of(track) + (counted ? " " + std::to_string(track.part + 1) : std::string());
  if (!track.rung) return name;
  const auto same = [&](const VideoTrack &other) { return other.rung == track.rung; };
  const bool alone = std::count_if(s.plan.tracks.begin(), s.plan.tracks.end(), same) == 1;
  return "rung " + std::to_string(track.rung) + (alone ? std::string() : " " + name);
}

struct NamedChange {
  const char *text, *key;
  const Change MeshChanges::*change;
};
inline constexpr NamedChange named_changes[] = {
    {"welded vertices", "welded_vertices", &MeshChanges::welded},
    {"degenerate faces", "degenerate_faces", &MeshChanges::degenerate},
    {"duplicate faces", "duplicate_faces", &MeshChanges::duplicate},
    {"unreferenced vertices", "unreferenced_vertices", &MeshChanges::unreferenced},
    {"flipped faces", "flipped_faces", &MeshChanges::flipped},
    {"dropped components", "dropped_components", &MeshChanges::dropped_components},
    {"faces of those", "dropped_component_faces", &MeshChanges::dropped_faces},
    {"split polygons", "split_polygons", &MeshChanges::split_polygons},
    {"lines and points left out", "lines_and_points", &MeshChanges::left_out},
    {"non-manifold edges", "nonmanifold_edges", &MeshChanges::nonmanifold_edges},
    {"boundary edges", "boundary_edges", &MeshChanges::boundary_edges}};

// Pixels of the video frame over those of all pictures whole.
inline double pixel_share(const Summary &s, const VideoTrack &track) {
  return double(track.tiling.width) * track.tiling.height / double(s.plan.crop.whole_pixels);
}

inline const char *fill_text(const Summary &s) {
  const auto &cameras = s.plan.capture.cameras;
  const bool masks = std::any_of(cameras.begin(), cameras.end(), [](const auto &c) { return bool(c.masks); });
  if (!masks) return "keep";
  const Background background = background_of(s.plan.options);
  return background == Background::flat ? "flat" : background == Background::smooth ? "smooth" : "keep";
}

inline std::string length_text(const Plan &plan, double length) {
  return plan.capture.scale_unknown ? fvv::format("%.3g units", length)
                                    : fvv::format("%.3g mm", length * 1000);
}

inline std::string area_text(const Plan &plan, double area) {
  return plan.capture.scale_unknown ? fvv::format("%.3g square units", area)
                                    : fvv::format("%.3g cm2", area * 1e4);
}

} // namespace fvv::mux
