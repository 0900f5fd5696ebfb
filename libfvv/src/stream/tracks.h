/* stream/tracks.h: the state of a track from chunk to chunk: meshes and visibility that later frames depend
 * on; and what single chunks hold: the colours of a key mesh, the tile layout of a group. */
#ifndef FVV_STREAM_TRACKS_H
#define FVV_STREAM_TRACKS_H

#include "base/memory.h"
#include "fvv/colours.h"
#include "fvv/container.h"
#include "fvv/mesh.h"
#include "fvv/stream.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Zero-initialise; release with fvv_mesh_frames_reset. */
typedef struct fvv_mesh_frames {
  fvv_mesh key;                /* without a lattice: none */
  fvv_mesh_sequence *sequence; /* NULL until a delta frame comes: all-key streams need none */
} fvv_mesh_frames;

void fvv_mesh_frames_reset(fvv_mesh_frames *frames);

/* The profile of a chunk and its key flag agree (FVV-3017). */
FVV_MUST_USE fvv_status fvv_mesh_frames_check_flag(const fvv_mesh_header *header, int key,
                                                   fvv_diagnostic *diagnostic);

/* Decodes the next chunk, key or not. Offsets of diagnostics are relative to the payload. On error the frames
 * are reset: up to the next key frame nothing can be decoded. */
FVV_MUST_USE fvv_status fvv_mesh_frames_add(fvv_mesh_frames *frames, const uint8_t *payload, size_t size,
                                            int key, const fvv_limits *limits, const fvv_allocator *allocator,
                                            fvv_diagnostic *diagnostic);

/* The frame that was added last; NULL before the first. Belongs to frames, until the next add or reset. */
const fvv_mesh *fvv_mesh_frames_current(const fvv_mesh_frames *frames);

/* What of it no frame before had, and COLR describes: all of a key mesh, the patch of a patched frame,
 * otherwise NULL. */
const fvv_mesh *fvv_mesh_frames_new(const fvv_mesh_frames *frames);

/* Values of vertices, width bytes each, from the frame before to the one that was added last: those of
 * vertices that are kept go with them, new ones get those of fresh. For frames after a key. FVV_OK or
 * FVV_ERROR_MEMORY. */
FVV_MUST_USE fvv_status fvv_mesh_frames_carry(const fvv_mesh_frames *frames, size_t width,
                                              const uint8_t *fresh, fvv_bytes *values);

/* Zero-initialise; release with fvv_visibility_frames_reset. */
typedef struct fvv_visibility_frames {
  fvv_visibility current; /* header.camera_count 0: none */
  fvv_allocator allocator;
  fvv_visibility_order *order; /* of faces; kept as long as they do not change */
  uint32_t *faces;
  uint32_t vertex_count, face_count;
} fvv_visibility_frames;

void fvv_visibility_frames_reset(fvv_visibility_frames *frames);

/* Checks what can be checked without the mesh: header, table, key flag and number, cameras. */
FVV_MUST_USE fvv_status fvv_visibility_frames_check(const fvv_visibility_frames *frames,
                                                    const uint8_t *payload, size_t size, int key,
                                                    const fvv_configuration *configuration,
                                                    const fvv_limits *limits, fvv_visibility_header *header,
                                                    fvv_diagnostic *diagnostic);

/* Decodes the next chunk, key or not, for all of its cameras. mesh: that of its time; NULL: there is none.
 * calibration: of the cameras that move, at its time; NULL: there is none. Offsets of diagnostics are
 * relative to the payload. On error the frames are reset: up to the next key chunk nothing can be decoded. */
FVV_MUST_USE fvv_status fvv_visibility_frames_add(fvv_visibility_frames *frames, const uint8_t *payload,
                                                  size_t size, int key, const fvv_mesh *mesh,
                                                  const fvv_calibration *calibration,
                                                  const fvv_configuration *configuration,
                                                  const fvv_limits *limits, const fvv_allocator *allocator,
                                                  fvv_diagnostic *diagnostic);

/* Checks what can be checked of a COLR chunk without the mesh: header, key flag, mesh track. */
FVV_MUST_USE fvv_status fvv_colours_check(const uint8_t *payload, size_t size, int key,
                                          const fvv_configuration *configuration, const fvv_limits *limits,
                                          fvv_colours_header *header, fvv_diagnostic *diagnostic);

/* Decodes a COLR chunk. mesh: the key mesh or patch of its time on its mesh track; NULL: there is none.
 * colours: R, G, B of each vertex, in place of what it holds. Offsets of diagnostics are relative to the
 * payload. */
FVV_MUST_USE fvv_status fvv_colours_add(const uint8_t *payload, size_t size, int key, const fvv_mesh *mesh,
                                        const fvv_configuration *configuration, const fvv_limits *limits,
                                        fvv_bytes *colours, fvv_diagnostic *diagnostic);

/* Decodes the payload of a group's TILE into fvv_tile, and checks it against the configuration. *tiles
 * belongs to the caller, also after an error. Offsets of diagnostics are relative to the payload. */
FVV_MUST_USE fvv_status fvv_group_tiles_decode(const fvv_configuration *configuration, uint16_t track,
                                               const uint8_t *payload, size_t size, const fvv_limits *limits,
                                               fvv_bytes *tiles, fvv_diagnostic *diagnostic);

#ifdef __cplusplus
}
#endif
#endif
