/* fvv/frames.h: a stream as whole frames. Push bytes, pull events; no I/O and no decoding of meshes or
 * pixels.
 *
 * It is built on fvv_reader: chunks are put together to configurations and frames, and a frame is reported
 * only when nothing of it is missing. After damage the rest of the group is left out, because its frames may
 * depend on what was lost; the next group continues. Where a payload alone is damaged, its header shows the
 * track: sound, environments and tracks that the caller leaves out cost no frame, and a track that lost a
 * chunk has none up to the next group. Any split of the bytes gives the same events. Handles are not
 * thread-safe; separate handles are independent. */
#ifndef FVV_FRAMES_H
#define FVV_FRAMES_H

#include "fvv/stream.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct fvv_frames fvv_frames;

typedef struct fvv_frames_options {
  size_t struct_size;
  /* Non-zero: a frame is reported as soon as every track has a chunk in it, so that live playback does not
   * wait for the next frame. Sound is not waited for. 0: when the next frame or the end of the group shows
   * that it is over; then the last frame of a stream that was cut is not reported. Frames with tracks that
   * rarely have chunks (environments) always wait. Default: 1. */
  int eager;
} fvv_frames_options;

FVV_API void fvv_frames_options_default(fvv_frames_options *options);

typedef enum fvv_frames_kind {
  FVV_FRAMES_CONFIGURATION = 1, /* a configuration block is complete and holds from here on; or the block of
                                   the next group is lost and an earlier one with its digest replaces it */
  FVV_FRAMES_GROUP = 2,         /* a group begins */
  FVV_FRAMES_FRAME = 3,         /* a frame is over */
  FVV_FRAMES_DAMAGE = 4,        /* bytes were passed over, or a rule is broken */
  FVV_FRAMES_END = 5,           /* the footer was read: the stream is complete */
  FVV_FRAMES_GROUP_END = 6,     /* the group is over; without its GEND chunk, where something else follows */
  FVV_FRAMES_BETWEEN = 8 /* chunks of tracks at a time that is no frame, or after its frame was reported:
                            sound, environments */
} fvv_frames_kind;

/* A chunk of a frame. payload: header.size bytes, 8-byte aligned. */
typedef struct fvv_frame_chunk {
  fvv_chunk_header header;
  uint64_t offset; /* of the chunk header in the stream */
  const uint8_t *payload;
} fvv_frame_chunk;

/* Fields whose comment names no kind are set for every event, others for these kinds alone. Pointers are
 * valid until the next call of fvv_frames_next; the configuration is, until the next event
 * FVV_FRAMES_CONFIGURATION. */
typedef struct fvv_frames_event {
  fvv_frames_kind kind;
  uint64_t offset;                        /* of the first byte that the event is about */
  const fvv_configuration *configuration; /* CONFIGURATION */
  int repeated;                           /* CONFIGURATION: the same chunks as the one that held before */
  int64_t time;                           /* FRAME, BETWEEN: ticks; GROUP: its start */
  int64_t end;                            /* GROUP: its end */
  uint32_t sequence, configuration_crc;   /* GROUP: its number, and the digest of its configuration */
  const fvv_frame_chunk *chunks;          /* FRAME, BETWEEN: in order of the stream */
  size_t chunk_count;
  int whole; /* FRAME, BETWEEN: 1; GROUP: its configuration is known; GROUP_END: no frame of the group was
                left out; DAMAGE: no frame is lost by it */
  uint64_t skipped;          /* DAMAGE: bytes passed over; 0 when a rule is broken but no byte is lost */
  fvv_diagnostic diagnostic; /* DAMAGE */
} fvv_frames_event;

/* options, limits, allocator NULL: defaults. */
FVV_API FVV_MUST_USE fvv_status fvv_frames_create(const fvv_frames_options *options, const fvv_limits *limits,
                                                  const fvv_allocator *allocator, fvv_frames **frames);
FVV_API void fvv_frames_destroy(fvv_frames *frames);
/* Bytes are copied. */
FVV_API FVV_MUST_USE fvv_status fvv_frames_push(fvv_frames *frames, const void *bytes, size_t size);
/* No more bytes will come. */
FVV_API void fvv_frames_finish(fvv_frames *frames);
/* FVV_OK: *event is set. FVV_NEED_DATA: push more, or finish. FVV_END: after finish, when all events are out.
 * Errors are those of fvv_reader_next, final, and repeat. */
FVV_API FVV_MUST_USE fvv_status fvv_frames_next(fvv_frames *frames, fvv_frames_event *event,
                                                fvv_diagnostic *diagnostic);
/* 1: *chunk is the first chunk of a type in the frame that is still arriving, so that what it needs can be
 * prepared; its payload is valid until the next call of another function. 0: there is none yet. */
FVV_API int fvv_frames_peek(const fvv_frames *frames, uint32_t type, fvv_frame_chunk *chunk);
/* The configuration that holds for the frames that come; NULL: there is none, or the last block was wrong. */
FVV_API const fvv_configuration *fvv_frames_configuration(const fvv_frames *frames);
/* Bytes that are pushed from now on begin at offset in the stream, best with a group or a configuration
 * block; what was pushed before is forgotten. configuration holds for them, borrowed until the next
 * FVV_FRAMES_CONFIGURATION: fvv_frames_configuration to keep the one that is known, or that of
 * fvv_stream_configuration. NULL: a block has to come before frames do. */
FVV_API FVV_MUST_USE fvv_status fvv_frames_seek(fvv_frames *frames, uint64_t offset,
                                                const fvv_configuration *configuration);
/* After the end of the stream. Non-zero: groups were left out because their configuration block is damaged or
 * lost, and an intact repetition of it came later. The last four blocks are remembered: fvv_frames_seek to 0,
 * without a configuration, and the same bytes again give these groups as well. */
FVV_API int fvv_frames_missed_groups(const fvv_frames *frames);
/* Before the first push, or after a seek to 0: the stream is joined late, as with fvv_reader_join. */
FVV_API FVV_MUST_USE fvv_status fvv_frames_join(fvv_frames *frames);
/* The tracks that the caller does not use, as those of other rungs (fvv_rung_tracks): their chunks are in no
 * frame, frames do not wait for them, and their damage costs nothing. Call it when
 * FVV_FRAMES_CONFIGURATION or FVV_FRAMES_GROUP was reported last; the list, which is copied, is valid until
 * the next call. Default: none. */
FVV_API FVV_MUST_USE fvv_status fvv_frames_leave_out(fvv_frames *frames, const uint16_t *tracks,
                                                     size_t count);
/* The rest of the group that is being read is left out, as after damage: for frames that turn out not to
 * decode. */
FVV_API void fvv_frames_drop_group(fvv_frames *frames);

#ifdef __cplusplus
}
#endif
#endif
