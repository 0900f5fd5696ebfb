// Which chunks of a group are of use. A frame is kept with all its chunks or not at all (FVV-9005), and only
// when everything that it is decoded from is kept.
#include "recover/src/group.h"

#include <map>
#include <utility>

namespace fvv::recover {

namespace {

using Chain = std::pair<uint32_t, uint16_t>; // type and track
Chain chain_of(const fvv_chunk_header &header) {
  return {header.type, header.track};
}

// Types whose chunks without the key flag continue the one before; of types that are not known nothing says
// so.
bool is_chained(const fvv_chunk_header &header) {
  return place_of(header.type, header.flags) != Place::unknown && header.type != FVV_CHUNK_TILES;
}

class Selection {
public:
  Selection(const Slots &of, const std::set<uint16_t> &tracks_with_tiles)
      : slots(of.slots), gap_after(of.gap_after), tiled(tracks_with_tiles) {}

  std::vector<Part> run() {
    find_layouts();
    for (size_t first = 0; first < slots.size();) {
      size_t last = first;
      while (last < slots.size() && header(last).time == header(first).time) last++;
      take_time(first, last);
      first = last;
    }
    return std::move(out);
  }

private:
  const fvv_chunk_header &header(size_t i) const { return slots[i].chunk.header; }

  // The layout of a track, by which all its samples in the group are read, has to be known (FVV-9022).
  void find_layouts() {
    bool gap = false;
    std::set<uint16_t> begun;
    for (size_t i = 0; i < slots.size(); i++) {
      gap = gap || slots[i].gap_before;
      const fvv_chunk_header &h = header(i);
      if (h.type == FVV_CHUNK_TILES) {
        if (slots[i].usable)
          layouts[h.track] = i;
        else
          no_layout.insert(h.track);
        begun.insert(h.track);
      } else if (h.type == FVV_CHUNK_VIDEO_PACKET && begun.insert(h.track).second && gap &&
                 tiled.count(h.track)) {
        no_layout.insert(h.track); // it may have been among the missing chunks
      }
    }
  }

  bool follows(size_t i) const {
    const fvv_chunk_header &h = header(i);
    if (!is_chained(h) || h.flags & FVV_FLAG_KEY) return true;
    const auto former = unbroken.find(chain_of(h));
    return former != unbroken.end() && former->second;
  }

  // The slots [first, last) have one time.
  void take_time(size_t first, size_t last) {
    // Chunks of any track may be missing in a gap: those before and after it at its times, and all between.
    bool is_whole = last < slots.size() ? !slots[last].gap_before : !gap_after;
    for (size_t i = first; i < last; i++) {
      const fvv_chunk_header &h = header(i);
      if (slots[i].gap_before) {
        unbroken.clear();
        is_whole = false;
      }
      if (!is_of_frame(h)) continue;
      const bool can_be_read = h.type != FVV_CHUNK_VIDEO_PACKET || !no_layout.count(h.track);
      is_whole = is_whole && slots[i].usable && can_be_read && follows(i);
    }
    for (size_t i = first; i < last; i++) {
      const fvv_chunk_header &h = header(i);
      const bool is_kept = is_of_frame(h) ? is_whole : slots[i].usable && follows(i);
      if (is_chained(h)) unbroken[chain_of(h)] = is_kept;
      if (!is_kept) continue;
      if (h.type == FVV_CHUNK_TILES) layouts.erase(h.track); // it stays where it is
      if (h.type == FVV_CHUNK_VIDEO_PACKET) place_layout(h);
      out.push_back({i, h.time});
    }
  }

  // The frame with the layout is lost: it moves to the first sample that is kept (FVV-4104).
  void place_layout(const fvv_chunk_header &sample) {
    const auto layout = layouts.find(sample.track);
    if (layout == layouts.end()) return;
    out.push_back({layout->second, sample.time});
    layouts.erase(layout);
  }

  const std::vector<Slot> &slots;
  const bool gap_after;
  const std::set<uint16_t> &tiled;
  std::map<uint16_t, size_t> layouts; // not placed yet
  std::set<uint16_t> no_layout;
  std::map<Chain, bool> unbroken; // whether the last chunk was kept
  std::vector<Part> out;
};

} // namespace

std::vector<Part> select(const Slots &slots, const std::set<uint16_t> &tiled) {
  return Selection(slots, tiled).run();
}

} // namespace fvv::recover
