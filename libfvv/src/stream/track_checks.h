/* stream/track_checks.h: the rules about the payloads of each kind of track, chunk by chunk, with what is
 * known of those before in the group. fvv_checker puts them together. Offsets of diagnostics are relative to
 * the payload. */
#ifndef FVV_STREAM_TRACK_CHECKS_H
#define FVV_STREAM_TRACK_CHECKS_H

#include "fvv/stream.h"
#include "stream/tracks.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Zero-initialise. */
typedef struct checked_environment {
  uint64_t size; /* of the last intact chunk; 0: none */
  uint32_t crc, digest;
} checked_environment;

/* Zero-initialise; reset in the end. */
typedef struct checked_calibration {
  uint64_t block, group;    /* that are being read, both counted from 1 */
  int64_t time;             /* of the last chunk */
  int lost;                 /* a chunk of the group was wrong: those up to the next key cannot be checked */
  fvv_calibration *cameras; /* of the block */
} checked_calibration;

/* Zero-initialise; reset frames in the end. */
typedef struct checked_mesh {
  uint64_t group; /* that is being read, counted from 1 */
  int has_first;  /* the first mesh of the group was seen: texture_bits and normal_bits are its own */
  uint8_t texture_bits, normal_bits;
  int64_t time; /* of the mesh that frames holds */
  int lost;     /* a frame of the group was wrong: delta frames after it cannot be checked */
  fvv_mesh_frames frames;
} checked_mesh;

/* Zero-initialise; reset frames in the end. */
typedef struct checked_visibility {
  uint64_t group; /* that is being read, counted from 1 */
  int lost;       /* a chunk of the group was wrong or could not be checked: those after it cannot be */
  fvv_visibility_frames frames;
} checked_visibility;

/* Zero-initialise. */
typedef struct checked_audio {
  uint64_t group; /* that is being read, counted from 1 */
  int lost;       /* something of the group is missing or wrong: times cannot be compared */
  fvv_audio_place place;
} checked_audio;

/* What the checker knows of the layouts of a track. Zero-initialise. */
typedef struct checked_tiles {
  uint64_t lost_in; /* the group, counted from 1, whose layout is wrong: its samples cannot be used */
} checked_tiles;

/* Checks an intact BACK chunk; with decode, its meshes too. digest: of the configuration, from GRUP. *counts
 * gets what it holds. Offsets of diagnostics are relative to the payload. */
FVV_MUST_USE fvv_status fvv_judge_environment(checked_environment *environment, const fvv_event *event,
                                              uint32_t digest, int decode, const fvv_limits *limits,
                                              const fvv_allocator *allocator, fvv_track_summary *counts,
                                              fvv_diagnostic *diagnostic);

/* Checks an intact AUDI chunk. Offsets of diagnostics are relative to the payload. */
FVV_MUST_USE fvv_status fvv_judge_audio(checked_audio *audio, const fvv_event *event, uint64_t group,
                                        int64_t group_end, const fvv_configuration *configuration,
                                        fvv_track_summary *counts, fvv_diagnostic *diagnostic);

void fvv_reset_calibration(checked_calibration *calibration);

/* Adds what an intact CALB chunk declares. */
void fvv_count_calibrations(fvv_track_summary *summary, const fvv_event *event,
                            const fvv_configuration *configuration);

/* Checks an intact CALB chunk. *whole becomes 0 when one before it is missing, which is no problem of its
 * own. Offsets of diagnostics are relative to the payload. */
FVV_MUST_USE fvv_status fvv_judge_calibration(checked_calibration *calibration, const fvv_event *event,
                                              uint64_t block, uint64_t group,
                                              const fvv_configuration *configuration,
                                              const fvv_allocator *allocator, int *whole,
                                              fvv_diagnostic *diagnostic);

/* Checks the intact TILE of a group, and counts it in summary. */
FVV_MUST_USE fvv_status fvv_judge_group_tiles(checked_tiles *checked, const fvv_event *event, uint64_t group,
                                              const fvv_configuration *configuration,
                                              const fvv_limits *limits, const fvv_allocator *allocator,
                                              fvv_track_summary *summary, fvv_diagnostic *diagnostic);

/* Checks an intact MESH chunk; with decode, its content too. header is filled as far as it is good. *whole
 * becomes 0 when a frame before this one is missing, which is no problem of its own. Offsets of diagnostics
 * are relative to the payload. */
FVV_MUST_USE fvv_status fvv_judge_mesh_chunk(checked_mesh *mesh, const fvv_event *event, uint64_t group,
                                             int decode, const fvv_limits *limits,
                                             const fvv_allocator *allocator, fvv_mesh_header *header,
                                             int *whole, fvv_diagnostic *diagnostic);

/* Checks an intact VISI chunk; with decode, its content too. mesh: what is known in this group of the mesh
 * track that it names, NULL: nothing. calibration: of the track of cameras that move, NULL: there was none.
 * *whole becomes 0 when something before this chunk is missing, which is no problem of its own. Offsets of
 * diagnostics are relative to the payload. */
FVV_MUST_USE fvv_status fvv_judge_visibility_chunk(checked_visibility *visibility, const fvv_event *event,
                                                   uint64_t group, int decode, const checked_mesh *mesh,
                                                   const checked_calibration *calibration,
                                                   const fvv_configuration *configuration,
                                                   const fvv_limits *limits, const fvv_allocator *allocator,
                                                   int *whole, fvv_diagnostic *diagnostic);

/* Checks an intact COLR chunk; with decode, its content too. mesh: what is known in this group of the mesh
 * track that it names, NULL: nothing. *whole and offsets: as above. */
FVV_MUST_USE fvv_status fvv_judge_colours_chunk(const fvv_event *event, uint64_t group, int decode,
                                                const checked_mesh *mesh,
                                                const fvv_configuration *configuration,
                                                const fvv_limits *limits, const fvv_allocator *allocator,
                                                int *whole, fvv_diagnostic *diagnostic);

#ifdef __cplusplus
}
#endif
#endif
