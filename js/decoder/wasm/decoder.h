/* decoder.h: a stream as frames, pushed in. Knows libfvv and the flat structs; must not know files, networks
 * or JavaScript, of which decoder.c and index.c name the few functions that they import.
 *
 * A frame comes out only when it is whole. Behind damage or a chunk that does not decode the rest of its
 * group is dropped, and the next group goes on. */
#ifndef FVV_JS_DECODER_H
#define FVV_JS_DECODER_H

#include "base/memory.h"
#include "flat.h"
#include "module.h"
#include "stream/configuration.h"
#include "stream/tracks.h"

/* What next answers; below 0: fvv_status, final. */
enum {
  FVVJS_NEED_DATA = 0,
  FVVJS_CONFIGURATION = 1, /* another one holds from here on */
  FVVJS_GROUP = 2,         /* a group begins */
  FVVJS_FRAME = 3,         /* decode it, or go on without */
  FVVJS_DAMAGE = 4,        /* the diagnostic says what is lost or against the rules */
  FVVJS_END = 5,           /* the footer: the stream is complete */
  FVVJS_DONE = 6           /* behind finish: nothing is left */
};

/* What decode fills in beside integer positions and faces. */
enum {
  FVVJS_WANT_FLOATS = 1, /* positions and texture coordinates */
  FVVJS_WANT_NORMALS = 2,
  FVVJS_WANT_VISIBILITY = 4,
  FVVJS_WANT_SHARES = 8 /* of vertices, with visibility */
};

/* What is kept of a track between frames. */
typedef struct fvvjs_track {
  uint16_t id;
  int64_t mesh_time; /* of the current mesh */
  fvv_mesh_frames meshes;
  fvv_visibility_frames visibility;
  fvv_bytes positions, normals, texture; /* floats of the current frame */
  fvv_bytes tiles;                       /* flat_tile: the layout of the group; empty: it has none */
  fvv_bytes shares, counts;              /* of visibility, and to work in */
} fvvjs_track;

/* A chunk of a frame; offset: where its payload stands in the frame's bytes. */
typedef struct fvvjs_chunk {
  fvv_chunk_header header;
  size_t payload;
  uint64_t offset;
} fvvjs_chunk;

/* A frame as its chunks came in. */
typedef struct fvvjs_frame {
  int64_t time;
  fvv_bytes chunks, payloads;
  int is_open, whole;
} fvvjs_frame;

/* The group that is read through the index, while on. next: 0 is its GRUP, 1 the first of its chunks. */
typedef struct fvvjs_pick {
  int on;
  fvv_chunk_info group;
  const fvv_chunk_info *chunks;
  size_t count, next;
  fvv_bytes left_out, payload; /* uint16_t, tracks; of the chunk that was told last */
} fvvjs_pick;

/* Those of the configuration, and behind them those of the frame. */
enum {
  FVVJS_TRACKS,
  FVVJS_CAMERAS,
  FVVJS_VIDEOS,
  FVVJS_TILES,
  FVVJS_METADATA,
  FVVJS_MESHES,
  FVVJS_VISIBILITY,
  FVVJS_MOVING,
  FVVJS_SAMPLES,
  FVVJS_LAYOUTS,
  FVVJS_BACKGROUNDS,
  FVVJS_LISTS
};

typedef struct fvvjs_decoder {
  fvv_allocator allocator;
  fvv_limits limits;
  fvv_reader *reader;
  fvv_stream *index; /* NULL: the source can't be sought in */
  fvv_configuration_builder building, complete;
  int block_open, block_bad;
  const fvv_configuration *configuration; /* NULL: none yet */
  uint64_t block_offset;
  fvvjs_frame incoming, ready; /* ready: what FVVJS_FRAME speaks of */
  int lost;                    /* up to the next group */
  fvv_bytes tracks;            /* fvvjs_track */
  fvv_calibration *calibration;
  int64_t calibration_time; /* of what it holds */
  fvv_event event;          /* that was read, and is not worked on yet */
  int has_event;
  fvv_diagnostic diagnostic;
  flat_event about;
  flat_configuration flat;
  flat_frame frame;
  fvv_bytes lists[FVVJS_LISTS]; /* of flat structs, which the two above point to */
  flat_group group;
  fvvjs_pick pick;
  double range[3];
  flat_sample background; /* of a group of the index */
} fvvjs_decoder;

/* decoder.c */
int32_t fvvjs_start(fvvjs_decoder *decoder, double offset, int keep);
/* index.c. FVV_END: behind the group; FVV_NEED_DATA: fetch what was lacking. */
fvv_status fvvjs_next_picked(fvvjs_decoder *decoder, fvv_event *event, fvv_diagnostic *diagnostic);
/* describe.c */
void fvvjs_flatten_camera(const fvv_camera *camera, int calibrated, flat_camera *flat);
int fvvjs_put_tiles(fvv_bytes *list, const fvv_tile *tiles, size_t count);
/* frame.c */
void fvvjs_release_tracks(fvvjs_decoder *decoder);
void fvvjs_begin_group(fvvjs_decoder *decoder);
void fvvjs_free_flat(fvvjs_decoder *decoder);

#endif
