/* Which tracks a rung of a ladder has: clause 5.2. */
#include <string.h>

#include "fvv/container.h"

/* By rank. A group with two tracks of one rank is invalid; the lower identifier counts as the better one. */
static int is_better(const fvv_track *a, const fvv_track *b) {
  return a->rank != b->rank ? a->rank < b->rank : a->id < b->id;
}

static int is_best(const fvv_track *tracks, size_t count, const fvv_track *track) {
  for (size_t i = 0; i < count; i++)
    if (tracks[i].alternate_group == track->alternate_group && is_better(&tracks[i], track)) return 0;
  return 1;
}

/* The ranks of all tracks with alternatives but the best of each group: every one is a rung. */
typedef struct rank_set {
  uint8_t bits[65536 / 8];
} rank_set;

static size_t find_ranks(const fvv_track *tracks, size_t count, rank_set *ranks) {
  size_t found = 0;
  memset(ranks, 0, sizeof *ranks);
  for (size_t i = 0; i < count; i++) {
    if (!tracks[i].alternate_group || is_best(tracks, count, &tracks[i])) continue;
    uint8_t *byte = &ranks->bits[tracks[i].rank / 8];
    const uint8_t bit = (uint8_t)(1u << (tracks[i].rank % 8));
    found += !(*byte & bit);
    *byte = (uint8_t)(*byte | bit);
  }
  return found;
}

/* The greatest rank that a rung admits; -1: the best tracks alone. */
static int32_t greatest_rank(const rank_set *ranks, size_t rung) {
  int32_t greatest = -1;
  for (int32_t rank = 0; rung && rank < 65536; rank++)
    if (ranks->bits[rank / 8] >> (rank % 8) & 1) {
      greatest = rank;
      rung--;
    }
  return greatest;
}

size_t fvv_rung_count(const fvv_track *tracks, size_t count) {
  rank_set ranks;
  return find_ranks(tracks, count, &ranks) + 1;
}

/* Whether no other track of the group is taken in its place. */
static int is_taken(const fvv_track *tracks, size_t count, const fvv_track *track, int32_t greatest) {
  if (!track->alternate_group) return 1;
  if (track->rank > greatest) return is_best(tracks, count, track);
  for (size_t i = 0; i < count; i++)
    if (tracks[i].alternate_group == track->alternate_group && tracks[i].rank <= greatest &&
        is_better(track, &tracks[i]))
      return 0;
  return 1;
}

void fvv_rung_tracks(const fvv_track *tracks, size_t count, size_t rung, uint8_t *has) {
  rank_set ranks;
  (void)find_ranks(tracks, count, &ranks);
  const int32_t greatest = greatest_rank(&ranks, rung);
  for (size_t i = 0; i < count; i++) has[i] = (uint8_t)is_taken(tracks, count, &tracks[i], greatest);
}
