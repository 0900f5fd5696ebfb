/* decoder.h: a stream as decoded frames, for JavaScript: fvv_frames and the structs of wasm_structs.h. After
 * a chunk that does not decode the rest of its group is dropped, and the next group goes on. */
#ifndef FVV_JS_DECODER_H
#define FVV_JS_DECODER_H

#include "base/memory.h"
#include "module.h"
#include "stream/frames.h"
#include "stream/tracks.h"
#include "wasm_structs.h"

/* What fvvjs_next returns besides FVV_FRAMES_CONFIGURATION to FVV_FRAMES_END; below 0: fvv_status, final. */
enum {
  FVVJS_NEED_DATA = 0,
  FVVJS_DONE = 6,   /* after finish: nothing is left */
  FVVJS_BETWEEN = 7 /* FVV_FRAMES_BETWEEN */
};

/* What decode fills in beside integer positions and faces. */
enum {
  FVVJS_WANT_FLOATS = 1, /* positions and texture coordinates */
  FVVJS_WANT_NORMALS = 2,
  FVVJS_WANT_VISIBILITY = 4,
  FVVJS_WANT_WEIGHTS = 8 /* of vertices, with visibility */
};

/* What is kept of a track between frames. */
typedef struct fvvjs_track {
  uint16_t id;
  int64_t mesh_time; /* of the current mesh */
  fvv_mesh_frames meshes;
  fvv_visibility_frames visibility;
  fvv_bytes positions, normals, texture; /* floats of the current frame */
  fvv_bytes tiles;                       /* fvv_tile: the layout of the group; empty: it has none */
  fvv_bytes weights;                     /* of visibility */
  fvv_bytes colours;                     /* R, G, B, 255 of each vertex; empty: the key mesh has none */
  fvv_bytes sizes;                       /* uint16_t: of the packets of the last chunk of sound */
  fvv_audio_place place;                 /* of sound in the group */
} fvvjs_track;

/* The group that is read through the index, while on. next: 0 is its GRUP, 1 the first of its chunks. */
typedef struct fvvjs_pick {
  int on;
  fvv_chunk_info group;
  const fvv_chunk_info *chunks;
  size_t count, next;
  fvv_bytes payload; /* of the chunk that was reported last */
} fvvjs_pick;

/* The lists of a frame. */
enum {
  FVVJS_MESHES,
  FVVJS_VISIBILITY,
  FVVJS_MOVING,
  FVVJS_SAMPLES,
  FVVJS_LAYOUTS,
  FVVJS_ENVIRONMENTS,
  FVVJS_SOUNDS,
  FVVJS_LISTS
};

typedef struct fvvjs_decoder {
  fvv_allocator allocator;
  fvv_limits limits;
  fvv_frames *frames;                     /* NULL before start */
  fvv_stream *index;                      /* NULL: the source can't be sought in */
  const fvv_configuration *configuration; /* NULL: none yet */
  int64_t group_end;
  fvv_frames_event event; /* that was reported last */
  fvv_bytes tracks;       /* fvvjs_track */
  fvv_calibration *calibration;
  int64_t calibration_time; /* of what it holds */
  fvv_diagnostic diagnostic;
  wasm_frame frame;
  fvv_bytes lists[FVVJS_LISTS]; /* of structs that frame points to */
  fvv_bytes left_out;           /* uint16_t: tracks */
  fvvjs_pick pick;
  double range[3];
  wasm_sample environment; /* of a group of the index */
} fvvjs_decoder;

/* decoder.c: bytes, or events, from a group of the index on. */
fvv_status fvvjs_start_at(fvvjs_decoder *decoder, uint64_t offset, const fvv_configuration *configuration);
/* frame.c */
void fvvjs_release_tracks(fvvjs_decoder *decoder);
void fvvjs_begin_group(fvvjs_decoder *decoder);

#endif
