// Names that the report has as text and as JSON.
#pragma once

#include "fvv_mux/report.h"

#include <algorithm>
#include <string>

namespace fvv::mux {

// As a key of JSON.
inline const char *label_of(const VideoTrackReport &video) {
  return video.is_atlas ? "atlas" : "video";
}

// For people: "video 2" where several tracks show cameras, "rung 1" below the first rung, "rung 1 video 2".
inline std::string name_of(const Report &r, const VideoTrackReport &video) {
  const bool counted = !video.is_atlas && r.tile_track_count() > 1;
  const std::string name = label_of(video) + (counted ? " " + std::to_string(video.part + 1) : std::string());
  if (!video.rung) return name;
  const auto same = [&](const VideoTrackReport &other) { return other.rung == video.rung; };
  const bool alone = std::count_if(r.videos.begin(), r.videos.end(), same) == 1;
  return "rung " + std::to_string(video.rung) + (alone ? std::string() : " " + name);
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
    {"polygons that cross themselves", "self_crossing_polygons", &MeshChanges::self_crossing},
    {"lines and points left out", "lines_and_points", &MeshChanges::left_out},
    {"faces without texture coordinates", "untextured_faces", &MeshChanges::untextured},
    {"non-manifold edges", "nonmanifold_edges", &MeshChanges::nonmanifold_edges},
    {"boundary edges", "boundary_edges", &MeshChanges::boundary_edges}};

inline double frame_rate(const Report &r) {
  return double(r.frame_duration.denominator) / r.frame_duration.numerator;
}

inline double frames_per_second(const Report &r) {
  return r.seconds > 0 ? double(r.frames) / r.seconds : 0;
}

// Bytes that are no payload.
inline uint64_t overhead(const Report &r) {
  uint64_t bytes = r.bytes - r.payload() - r.calibration.payload - r.environment_chunks.payload;
  for (const LowerMeshes &meshes : r.lower_meshes) bytes -= meshes.payload();
  for (const VideoTrackReport &video : r.videos) bytes -= video.payload;
  for (const SoundReport &sound : r.sounds) bytes -= sound.payload;
  return bytes;
}

// Bytes of payload of the pictures of a rung, those included that all rungs share.
inline uint64_t picture_bytes(const Report &r, size_t rung) {
  uint64_t bytes = 0;
  for (const VideoTrackReport &video : r.videos)
    if (video.rung == rung || !video.alternate_group) bytes += video.payload;
  return bytes;
}

// Bits a second of that many bytes.
inline double rate_of(const Report &r, uint64_t bytes) {
  return 8 * double(bytes) * frame_rate(r) / double(r.ticks);
}

inline double triangles_of(const MeshSums &sums) {
  return sums.mesh.chunks ? double(sums.faces) / double(sums.mesh.chunks) : 0;
}

// The meshes that were considered for a rung of their own; NULL: none were.
inline const LowerMeshes *considered(const Report &r, size_t rung) {
  for (const LowerMeshes &meshes : r.lower_meshes)
    if (meshes.rung == rung) return &meshes;
  return nullptr;
}

} // namespace fvv::mux
