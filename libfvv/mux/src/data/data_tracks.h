// Data tracks of a plan (spec/fvv.md clause 21): captions of a WebVTT file, or a sequence of files, one for
// each frame.
#pragma once

#include "fvv/data.h"
#include "mux/src/plan.h"

namespace fvv::mux {

// Of Plan::data number i; above the audio tracks.
constexpr uint16_t first_data_track = 10201;
constexpr size_t max_data_tracks = 64;
inline uint16_t data_track_id(size_t i) {
  return uint16_t(first_data_track + i);
}

// Reads captions, and lists the files of sequences, for the frames of the plan. Throws Error.
std::vector<DataTrack> load_data(const Plan &plan);

// What DCFG says; borrows from the track.
fvv_data_config config_of(const DataTrack &track);

// A DATA chunk. All of them can be decoded alone.
struct DataChunk {
  size_t track; // of Plan::data
  int64_t time; // ticks of the scene
  std::vector<uint8_t> payload;
};
// Of all tracks in a group, by rising time; reads files. Throws Error.
std::vector<DataChunk> data_chunks(const Plan &plan, size_t group);

} // namespace fvv::mux
