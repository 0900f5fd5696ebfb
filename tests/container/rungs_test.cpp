// Which tracks a rung has, against clause 5.2 as it is written.
#include "container_fixture.h"

#include <set>

namespace {

fvv_track track_of(uint16_t id, uint16_t group, uint16_t rank) {
  fvv_track track = {};
  track.id = id;
  track.kind = FVV_TRACK_VIDEO;
  track.alternate_group = group;
  track.rank = rank;
  return track;
}

std::vector<uint16_t> tracks_of(const std::vector<fvv_track> &tracks, size_t rung) {
  std::vector<uint8_t> has(tracks.size(), 2);
  fvv_rung_tracks(tracks.data(), tracks.size(), rung, has.data());
  std::vector<uint16_t> out;
  for (size_t i = 0; i < tracks.size(); i++) {
    REQUIRE(has[i] <= 1);
    if (has[i]) out.push_back(tracks[i].id);
  }
  return out;
}

using Ids = std::vector<uint16_t>;

} // namespace

TEST_CASE("a stream without alternatives has one rung with all tracks") {
  CHECK(fvv_rung_count(nullptr, 0) == 1);
  const std::vector<fvv_track> tracks = {track_of(1, 0, 0), track_of(2, 0, 5), track_of(3, 7, 2)};
  CHECK(fvv_rung_count(tracks.data(), tracks.size()) == 1);
  CHECK(tracks_of(tracks, 0) == Ids{1, 2, 3});
  CHECK(tracks_of(tracks, 9) == Ids{1, 2, 3});
}

TEST_CASE("each rank below the best of a group is a rung") {
  // Group 1 has three ranks; group 2 two, of which the lower is between those of group 1.
  const std::vector<fvv_track> tracks = {track_of(1, 0, 0),     track_of(2, 1, 0), track_of(3, 1, 2),
                                         track_of(4, 1, 65535), track_of(5, 2, 1), track_of(6, 2, 3)};
  REQUIRE(fvv_rung_count(tracks.data(), tracks.size()) == 4);
  CHECK(tracks_of(tracks, 0) == Ids{1, 2, 5});
  CHECK(tracks_of(tracks, 1) == Ids{1, 3, 5});
  CHECK(tracks_of(tracks, 2) == Ids{1, 3, 6});
  CHECK(tracks_of(tracks, 3) == Ids{1, 4, 6});
  CHECK(tracks_of(tracks, 1000) == tracks_of(tracks, 3));
}

TEST_CASE("a group whose best rank is below that of a rung gives its best track") {
  const std::vector<fvv_track> tracks = {track_of(1, 1, 0), track_of(2, 1, 1), track_of(3, 2, 8),
                                         track_of(4, 2, 9)};
  REQUIRE(fvv_rung_count(tracks.data(), tracks.size()) == 3);
  CHECK(tracks_of(tracks, 1) == Ids{2, 3});
  CHECK(tracks_of(tracks, 2) == Ids{2, 4});
}

TEST_CASE("every rung has one track of each group, ranks equal or not") {
  uint32_t state = 1;
  for (int round = 0; round < 200; round++) {
    std::vector<fvv_track> tracks;
    std::set<uint16_t> groups;
    for (uint16_t id = 1; id <= 12; id++) {
      state = state * 1664525u + 1013904223u;
      tracks.push_back(track_of(id, uint16_t(1 + (state >> 28) % 3), uint16_t((state >> 20) % 5)));
      groups.insert(tracks.back().alternate_group);
    }
    for (size_t rung = 0; rung < fvv_rung_count(tracks.data(), tracks.size()); rung++)
      CHECK(tracks_of(tracks, rung).size() == groups.size());
  }
}
