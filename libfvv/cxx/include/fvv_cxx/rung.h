// Rungs of a ladder of quality: which tracks a reader takes of a stream that has some of them at several
// ranks (fvv.md clause 5.2), and a rung as a stream of its own.
#pragma once

#include "fvv/stream.h"

#include <memory>
#include <string>
#include <vector>

namespace fvv {

// fvv_rung_count.
size_t rung_count(const fvv_track *tracks, size_t count);

// Whether a rung has a track of tracks, as fvv_rung_tracks finds it.
bool in_rung(const fvv_track *tracks, size_t count, const fvv_track &track, size_t rung);
inline bool in_rung(const fvv_configuration &configuration, uint16_t track, size_t rung) {
  const fvv_track *found = fvv_configuration_track(&configuration, track);
  return !found || in_rung(configuration.tracks, configuration.track_count, *found, rung);
}

struct RungInfo {
  size_t rung = 0;
  uint64_t bit_rate = 0; // nominal, of all tracks; 0: not stated
  uint64_t size = 0;     // pixels of all video frames of one time; 0: not stated
  double scale = 0;      // of a side of a camera's picture, by the layouts of the configuration; 0: no tiles
  std::vector<uint16_t> tracks;
};

// Best first.
std::vector<RungInfo> rungs_of(const fvv_configuration &configuration);

template <class Json> Json json_of(const RungInfo &info) {
  Json out = {{"rung", info.rung}, {"bit_rate", info.bit_rate}, {"size", info.size}};
  if (info.scale > 0) out["scale"] = info.scale;
  out["tracks"] = info.tracks;
  return out;
}

// A configuration block, chunk by chunk.
class ConfigurationBlock {
public:
  // The next chunk, SCEN first. Throws Error for a SCEN or TRAK that cannot be read.
  void add(const fvv_chunk_header &header, const uint8_t *payload);

  size_t rung_count() const { return fvv::rung_count(tracks.data(), tracks.size()); }
  std::vector<RungInfo> rungs() const;
  fvv_rational time_base() const { return ticks; } // seconds per tick
  // Whether chunks with this track are left out of a rung.
  bool leaves_out(uint16_t track, size_t rung) const;
  // The bytes of the block with the tracks of a rung alone. Throws Error.
  std::string of_rung(size_t rung) const;

private:
  friend class RungGroup;
  struct Chunk {
    fvv_chunk_header header;
    std::vector<uint8_t> payload;
  };
  std::vector<Chunk> chunks;
  fvv_rational ticks = {};
  std::vector<fvv_track> tracks; // without names
  struct Layout {
    uint16_t track;
    std::vector<fvv_tile> tiles;
  };
  std::vector<Layout> layouts;
};

// The chunks of a group that belong to a rung, with continuity counters, table and digest of their own.
// Payloads, times and the number of the group stay. Every function throws Error.
class RungGroup {
public:
  // block: the one that holds for the group.
  RungGroup(const ConfigurationBlock &block, size_t rung);
  ~RungGroup();
  RungGroup(const RungGroup &) = delete;
  RungGroup &operator=(const RungGroup &) = delete;

  // Each returns the bytes of a chunk: GRUP, one of the group or nothing, GEND.
  std::string begin(uint32_t sequence, int64_t start, int64_t end);
  std::string chunk(const fvv_chunk_header &header, const uint8_t *payload);
  std::string end();

private:
  friend class ConfigurationBlock;
  struct State;
  std::unique_ptr<State> state;
};

} // namespace fvv
