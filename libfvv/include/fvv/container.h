/* fvv/container.h: chunks, groups, configuration records, index. Spec: spec/fvv.md clauses 3 to 7.
 *
 * Two ways in and out, each in one pass:
 *   fvv_writer  append-only, works on a pipe;
 *   fvv_reader  push bytes, pull events, no I/O: live streams, pipes, checks.
 * Random access to groups, chunks and frames is in fvv/stream.h.
 * No function here decodes meshes or pixels. Handles are not thread-safe; separate handles are independent.
 */
#ifndef FVV_CONTAINER_H
#define FVV_CONTAINER_H

#include "fvv/format.h"
#include "fvv/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A chunk header as of clause 4. On writing only type, flags, track and time are read. */
typedef struct fvv_chunk_header {
  uint32_t type;   /* FVV_CHUNK_... */
  uint8_t flags;   /* FVV_FLAG_... */
  uint8_t counter; /* continuity counter, clause 4.4 */
  uint16_t track;  /* 0: no track */
  int64_t time;    /* ticks of the scene's time base */
  uint64_t size;   /* payload bytes, without padding */
  uint32_t payload_crc;
  uint32_t header_crc;
} fvv_chunk_header;

/* ---- configuration records ------------------------------------------------------------------------ */

/* SCEN, clause 5.1: what holds for the whole stream. World axes are right-handed, metres. */
typedef struct fvv_scene {
  fvv_rational time_base;   /* seconds per tick */
  int64_t frame_duration;   /* ticks, nominal, > 0 */
  double lattice_origin[3]; /* metres */
  double lattice_step;      /* metres, > 0 */
  uint8_t up_axis;          /* FVV_UP_... */
  uint8_t flags;            /* FVV_SCENE_... */
} fvv_scene;

/* TRAK, clause 5.2. name is UTF-8, not terminated, and points into the parsed payload. */
typedef struct fvv_track {
  uint16_t id;              /* from the chunk header, 1 ... 65535 */
  uint8_t kind;             /* FVV_TRACK_... */
  uint8_t flags;            /* FVV_TRACK_FLAG_...; encoding sets those that a known kind requires */
  uint16_t alternate_group; /* 0: none. Tracks that share another number show the same thing */
  uint16_t rank;            /* among these: 0 is the best */
  uint32_t bit_rate;        /* nominal, bits per second; 0: not stated */
  uint32_t size;            /* nominal: pixels of a video frame, faces of a mesh; 0: not stated */
  fvv_rational time_base;   /* seconds per tick of times in payloads; 0/0: as the scene's */
  const char *name;
  size_t name_size;
} fvv_track;

/* Sizes are exact: *written is set on success and, with FVV_ERROR_BUFFER_TOO_SMALL, to what is needed.
 * diagnostic may be NULL everywhere in this library. */
FVV_API FVV_MUST_USE fvv_status fvv_scene_encode(const fvv_scene *scene, uint8_t *out, size_t capacity,
                                                 size_t *written, fvv_diagnostic *diagnostic);
FVV_API FVV_MUST_USE fvv_status fvv_scene_decode(fvv_scene *scene, const uint8_t *payload, size_t size,
                                                 fvv_diagnostic *diagnostic);
FVV_API FVV_MUST_USE fvv_status fvv_track_encode(const fvv_track *track, uint8_t *out, size_t capacity,
                                                 size_t *written, fvv_diagnostic *diagnostic);
/* id is not in the payload: set it from the chunk header. */
FVV_API FVV_MUST_USE fvv_status fvv_track_decode(fvv_track *track, const uint8_t *payload, size_t size,
                                                 const fvv_limits *limits, fvv_diagnostic *diagnostic);

/* ---- rungs ---------------------------------------------------------------------------------------- */

/* Rungs of a ladder of quality: which tracks a reader takes of a stream that has some at several ranks
 * (clause 5.2). Rung 0 has the best track of each alternate group; each rank of another track makes one more
 * rung. Without alternatives: 1. tracks: those of one configuration. No allocation; about count^2 steps. */
FVV_API size_t fvv_rung_count(const fvv_track *tracks, size_t count);
/* has: count bytes; each becomes 1 when the rung has that track, else 0. A rung has every track without an
 * alternate group and, of each group, the track with the greatest rank not above that of the rung, or the
 * best track. A number beyond the last rung names the last one. */
FVV_API void fvv_rung_tracks(const fvv_track *tracks, size_t count, size_t rung, uint8_t *has);

/* ---- writer --------------------------------------------------------------------------------------- */

typedef struct fvv_writer fvv_writer;

/* allocator NULL: malloc. output is copied. Writes the file header at once. */
FVV_API FVV_MUST_USE fvv_status fvv_writer_create(const fvv_output *output, const fvv_allocator *allocator,
                                                  fvv_writer **writer, fvv_diagnostic *diagnostic);
/* Frees without finishing: what was written is a valid live stream up to the last ended group. */
FVV_API void fvv_writer_destroy(fvv_writer *writer);

/* Sets the sequence number of the first group; those of later groups follow. For writers of part of a stream.
 * FVV_ERROR_STATE: a group was begun. */
FVV_API FVV_MUST_USE fvv_status fvv_writer_join(fvv_writer *writer, uint32_t sequence);

/* Configuration chunks, outside groups. The first of a block is SCEN, which opens a new block that replaces
 * the former one; fvv_writer_repeat_configuration writes the present block again, byte for byte. */
FVV_API FVV_MUST_USE fvv_status fvv_writer_configuration(fvv_writer *writer, uint32_t type, uint16_t track,
                                                         uint8_t flags, const void *payload, size_t size,
                                                         fvv_diagnostic *diagnostic);
FVV_API FVV_MUST_USE fvv_status fvv_writer_repeat_configuration(fvv_writer *writer,
                                                                fvv_diagnostic *diagnostic);

/* A group covers [start, end) ticks; groups come in order of time and do not overlap. */
FVV_API FVV_MUST_USE fvv_status fvv_writer_begin_group(fvv_writer *writer, int64_t start, int64_t end,
                                                       fvv_diagnostic *diagnostic);
FVV_API FVV_MUST_USE fvv_status fvv_writer_chunk(fvv_writer *writer, uint32_t type, uint16_t track,
                                                 uint8_t flags, int64_t time, const void *payload,
                                                 size_t size, fvv_diagnostic *diagnostic);
FVV_API FVV_MUST_USE fvv_status fvv_writer_end_group(fvv_writer *writer, fvv_diagnostic *diagnostic);

/* Index and footer. Only fvv_writer_destroy may follow. */
FVV_API FVV_MUST_USE fvv_status fvv_writer_finish(fvv_writer *writer, fvv_diagnostic *diagnostic);
/* Bytes handed to the output so far. */
FVV_API uint64_t fvv_writer_position(const fvv_writer *writer);

/* ---- push reader ---------------------------------------------------------------------------------- */

typedef struct fvv_reader fvv_reader;

typedef enum fvv_event_kind {
  FVV_EVENT_HEADER = 1, /* once, first: the file header is good */
  FVV_EVENT_CHUNK = 2,  /* any number: an intact chunk; payload is valid until the next call */
  FVV_EVENT_DAMAGE = 3, /* any number: diagnostic says what, skipped says how many bytes were passed over */
  FVV_EVENT_END =
      4 /* at most once: footer seen and it fits the stream; only DAMAGE may follow (trailing bytes) */
} fvv_event_kind;

typedef struct fvv_event {
  fvv_event_kind kind;
  uint64_t offset;        /* of the first byte that the event is about */
  fvv_chunk_header chunk; /* CHUNK; DAMAGE when has_chunk */
  const uint8_t *payload; /* CHUNK: chunk.size bytes, 8-byte aligned */
  int has_chunk;          /* DAMAGE: the header was intact, its payload was not: this chunk is lost */
  int group_intact;       /* CHUNK inside a group: no damage since the group began */
  uint16_t written_major; /* HEADER: version of the format that the writer followed */
  uint16_t written_minor;
  uint64_t skipped;          /* DAMAGE: bytes passed over; 0 when a rule is broken but no byte is lost */
  fvv_diagnostic diagnostic; /* DAMAGE */
} fvv_event;

/* limits NULL: default. start_offset: where in the stream the first pushed byte is (0 normally). With
 * start_offset > 0 no file header is expected but a chunk, best SCEN or GRUP; configuration, sequence number
 * and index can't be checked then. */
FVV_API FVV_MUST_USE fvv_status fvv_reader_create(const fvv_limits *limits, const fvv_allocator *allocator,
                                                  uint64_t start_offset, fvv_reader **reader);
FVV_API void fvv_reader_destroy(fvv_reader *reader);
/* Tells the reader that it joins a live stream late: the first bytes are an initialisation object (file
 * header and configuration block), and the groups of a stream follow in order, beginning with any
 * (clause 6.4). Call it before the first push, with start_offset 0. The first sequence number is taken as it
 * comes; everything else is checked as always, except index and footer, which describe a whole stream.
 * Offsets count from the first byte pushed. FVV_ERROR_STATE: bytes were pushed, or they begin elsewhere. */
FVV_API FVV_MUST_USE fvv_status fvv_reader_join(fvv_reader *reader);
/* Bytes are copied. Any split of the same bytes gives the same events. */
FVV_API FVV_MUST_USE fvv_status fvv_reader_push(fvv_reader *reader, const void *bytes, size_t size);
/* No more bytes will come: what was "need data" becomes "truncated". */
FVV_API void fvv_reader_finish(fvv_reader *reader);
/* FVV_OK: *event is set. FVV_NEED_DATA. FVV_END: after finish, when all events are out. Any error (not a
 * fvv file, a version that cannot be read, an unknown critical chunk, limits, memory) is final and repeats;
 * *diagnostic says why. Damage is an event, not an error. */
FVV_API FVV_MUST_USE fvv_status fvv_reader_next(fvv_reader *reader, fvv_event *event,
                                                fvv_diagnostic *diagnostic);

/* ---- groups and chunks, as fvv_stream lists them -------------------------------------------------- */

typedef enum fvv_index_state {
  FVV_INDEX_PRESENT = 1, /* footer and index are good */
  FVV_INDEX_REBUILT = 2  /* none, or damaged: rebuilt by scanning; see fvv_stream_damage_count */
} fvv_index_state;

typedef struct fvv_group_info {
  uint64_t offset; /* of the GRUP header */
  uint64_t size;   /* bytes up to and with GEND */
  int64_t start, end;
  uint32_t sequence;
  uint32_t frame_count;        /* clause 11 */
  int intact;                  /* present index: claimed; rebuilt: every chunk was seen and GEND agrees */
  uint32_t configuration_size; /* bytes of the configuration block that holds for this group, 0: not known */
  uint64_t configuration_offset; /* of its SCEN header */
} fvv_group_info;

/* One chunk as the group's table (GEND, clause 6.3) or the scan lists it. */
typedef struct fvv_chunk_info {
  uint64_t offset; /* of the chunk header */
  uint64_t size;   /* payload bytes */
  int64_t time;
  uint32_t type;
  uint16_t track;
  uint8_t flags;
} fvv_chunk_info;

#ifdef __cplusplus
}
#endif
#endif
