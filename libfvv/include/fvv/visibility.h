/* fvv/visibility.h: how much each camera sees of the surface around each vertex of a decoded mesh, coded.
 * Spec: spec/fvv.md clause 17.
 *
 * Only vertices that face the camera within a threshold have a weight; encoder and decoder find them from the
 * mesh in integers (the facing test). Every camera has a range coder's stream of its own, so that any of them
 * can be fetched and decoded without the others. */
#ifndef FVV_VISIBILITY_H
#define FVV_VISIBILITY_H

#include "fvv/calibration.h"
#include "fvv/container.h"
#include "fvv/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The state of a vertex for one camera: its visibility weight as it is coded. `states` arrays have one byte
 * for each vertex of the mesh, in decoded order. fvv_visibility_weights gives the weights from 0 to 255 that
 * players interpolate; FVV_VERTEX_IS_SEEN the side of one half on which a weight is. */
enum {
  FVV_VERTEX_BACKFACING = 0, /* fails the facing test: no weight is sent */
  FVV_VERTEX_HIDDEN = 1,     /* weights of 0 and 255 */
  FVV_VERTEX_SEEN = 2,
  FVV_VERTEX_HIDDEN_NEAR = 3, /* 85 and 170 */
  FVV_VERTEX_SEEN_NEAR = 4,
  FVV_VERTEX_HIDDEN_NEARER = 5, /* 113 and 142 */
  FVV_VERTEX_SEEN_NEARER = 6
};

/* 1 for each of the states that are seen. */
#define FVV_VERTEX_IS_SEEN(state) ((state) != 0 && !((state)&1))

/* Below this cosine between normal and ray view-dependent texturing drops a camera: 0.25 in 2^-8. */
#define FVV_VISIBILITY_THRESHOLD 64

/* ---- the facing test, clause 17.2 ------------------------------------------------------------------- */

/* The camera's centre as the lattice point nearest to it, ties to even. FVV_ERROR_INPUT when it lies outside
 * the lattice. camera is valid; one that moves is as it is at the time of the mesh. */
FVV_API FVV_MUST_USE fvv_status fvv_visibility_centre(const fvv_camera *camera, const fvv_scene *scene,
                                                      int32_t centre[3], fvv_diagnostic *diagnostic);

/* facing: for each vertex 1 when one of its faces has a cosine between its normal and the way to centre above
 * threshold in 2^-8, else 0. mesh: its lattice and centre within +-FVV_LATTICE_MAX, faces index its vertices.
 * facing: vertex_count entries. The same on every machine. */
FVV_API void fvv_visibility_facing(const fvv_mesh *mesh, const int32_t centre[3], uint8_t threshold,
                                   uint8_t *facing);

/* ---- payloads, clause 17.1 -------------------------------------------------------------------------- */

typedef struct fvv_visibility_header {
  uint8_t threshold;     /* cosine in 2^-8 */
  uint16_t mesh_track;   /* of the mesh at the same time */
  uint32_t vertex_count; /* of that mesh */
  uint32_t number;       /* 0: decodes alone; else the n-th after such a chunk, and needs the one before */
  uint32_t camera_count;
} fvv_visibility_header;

/* The bytes of one camera within a payload. */
typedef struct fvv_visibility_stream {
  uint16_t camera;
  size_t offset, size; /* size 0: sees nothing */
} fvv_visibility_stream;

/* Reads and checks header and table. streams: camera_count entries in rising order of camera, capacity is how
 * many there is room for; NULL and 0: only the header is wanted. FVV_ERROR_BUFFER_TOO_SMALL: *header has
 * their number. limits NULL: defaults; camera and vertex counts are checked against them. */
FVV_API FVV_MUST_USE fvv_status fvv_visibility_peek(const uint8_t *payload, size_t size,
                                                    const fvv_limits *limits, fvv_visibility_header *header,
                                                    fvv_visibility_stream *streams, size_t capacity,
                                                    fvv_diagnostic *diagnostic);

/* ---- coding, clause 17.3 ---------------------------------------------------------------------------- */

/* The order in which the vertices of a mesh are coded, and room to work. It depends on the faces alone: one
 * serves all frames of a tracked mesh and all cameras. Not thread-safe; separate ones are independent. */
typedef struct fvv_visibility_order fvv_visibility_order;

/* mesh is not kept. 20 bytes a face and 8 a vertex, one a vertex more while it works. allocator NULL: malloc.
 * On error *order is NULL. */
FVV_API FVV_MUST_USE fvv_status fvv_visibility_order_open(const fvv_mesh *mesh,
                                                          const fvv_allocator *allocator,
                                                          fvv_visibility_order **order,
                                                          fvv_diagnostic *diagnostic);
FVV_API void fvv_visibility_order_close(fvv_visibility_order *order);

/* What one camera sees. */
typedef struct fvv_visibility_view {
  uint16_t camera;
  int32_t centre[3];     /* fvv_visibility_centre */
  const uint8_t *seen;   /* FVV_VERTEX_... of each vertex, not BACKFACING; vertices without a neighbour on the
                            other side become HIDDEN or SEEN. Vertices that fail the facing test are not read */
  const uint8_t *former; /* FVV_VERTEX_... of the frame before, or NULL; not read when number is 0 */
  uint8_t *states;       /* receives FVV_VERTEX_... of each vertex as decoders get it, or NULL; may be
                            former */
} fvv_visibility_view;

/* VISI payload; replaces what payload holds. header: threshold, mesh_track and number are read.
 * views: in rising order of camera, at least one. mesh: the decoded mesh, with the faces that order was made
 * of. Deterministic. */
FVV_API FVV_MUST_USE fvv_status fvv_visibility_encode(fvv_visibility_order *order, const fvv_mesh *mesh,
                                                      const fvv_visibility_header *header,
                                                      const fvv_visibility_view *views, size_t view_count,
                                                      fvv_bytes *payload, fvv_diagnostic *diagnostic);

/* Decodes what one camera sees, from its stream alone: data and size are the bytes of its
 * fvv_visibility_stream. header is the payload's, former and states as in fvv_visibility_view, states not
 * NULL. Safe for hostile bytes: work and memory are those of the mesh. */
FVV_API FVV_MUST_USE fvv_status fvv_visibility_decode(fvv_visibility_order *order, const fvv_mesh *mesh,
                                                      const fvv_visibility_header *header,
                                                      const uint8_t *data, size_t size,
                                                      const int32_t centre[3], const uint8_t *former,
                                                      uint8_t *states, fvv_diagnostic *diagnostic);

/* ---- for players, clause 17.4 ----------------------------------------------------------------------- */

/* What a camera sees of the surface around each vertex, 0 to 255. Interpolated over a face, a place is seen
 * from 127.5 on. states: count of them, of one camera, none above FVV_VERTEX_SEEN_NEARER. weights may be
 * states. */
FVV_API void fvv_visibility_weights(const uint8_t *states, size_t count, uint8_t *weights);

/* ---- texturing, clause 17.5 ------------------------------------------------------------------------- */

/* How players blend the colours of the cameras that show a place. */
typedef struct fvv_texturing {
  double threshold; /* least cosine between the normal and the direction to a camera, 0 to 1 */
  double depth_bias,
      depth_slope;   /* tolerance of depth maps: pixels' breadths, and times what a pixel recedes */
  double inset;      /* metres from the mesh inward to the surface that cameras show, 0 or more */
  uint8_t best;      /* most cameras at a place, > 0 */
  uint8_t unseen[3]; /* R, G, B, display values where no camera shows the surface */
  uint8_t blend;     /* FVV_BLEND_VIEWER or FVV_BLEND_PAPER: how cameras are weighted */
} fvv_texturing;

/* 0.05, 0.2, 0.5, 0, 3, grey, by the viewer's direction. */
FVV_API void fvv_texturing_default(fvv_texturing *texturing);

/* The threshold that suits a blend: 0.05 for FVV_BLEND_VIEWER, 0.25 for FVV_BLEND_PAPER. */
FVV_API double fvv_texturing_threshold(uint8_t blend);

/* TEXR payload. Sizes as fvv_scene_encode. */
FVV_API FVV_MUST_USE fvv_status fvv_texturing_encode(const fvv_texturing *texturing, uint8_t *out,
                                                     size_t capacity, size_t *written,
                                                     fvv_diagnostic *diagnostic);
FVV_API FVV_MUST_USE fvv_status fvv_texturing_decode(fvv_texturing *texturing, const uint8_t *payload,
                                                     size_t size, fvv_diagnostic *diagnostic);

#ifdef __cplusplus
}
#endif
#endif
