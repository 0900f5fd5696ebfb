/* mesh/patched.h: the parts of a patched frame: which faces of the mesh before it leaves out, and the mesh
 * that is in their place (clause 8.14). */
#ifndef FVV_MESH_PATCHED_H
#define FVV_MESH_PATCHED_H

#include "fvv/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Where the parts of a payload are, as offsets in it. */
typedef struct fvv_patched_parts {
  size_t absent, absent_size;
  size_t patch, patch_size;
  size_t delta;
  fvv_mesh_header header; /* of the patch; counts of 0 when there is none */
} fvv_patched_parts;

/* What a frame leaves out of the mesh before; released with fvv_patched_change_free. */
typedef struct fvv_patched_change {
  uint8_t *absent; /* of each face: 1 when it is left out */
  uint8_t *used;   /* of each vertex: 1 when a face that remains uses it */
  uint32_t face_count, vertex_count;
  uint32_t kept_faces, kept_vertices; /* which remain */
} fvv_patched_change;

void fvv_patched_change_free(fvv_patched_change *change, const fvv_allocator *allocator);

/* Finds the parts and checks what can be checked without the mesh before: sizes, and the header of the patch,
 * whose counts are checked against limits and against its bytes. header: of the payload; data: after it. */
FVV_MUST_USE fvv_status fvv_patched_split(const uint8_t *data, const fvv_mesh_header *header,
                                          const fvv_limits *limits, fvv_patched_parts *parts,
                                          fvv_diagnostic *diagnostic);

/* Reads the faces that are left out, and the patch into the state of the sequence. header, parts: of the
 * payload. change: empty; released by the caller in any case. */
FVV_MUST_USE fvv_status fvv_patched_read(fvv_mesh_sequence *sequence, const uint8_t *payload,
                                         const fvv_mesh_header *header, const fvv_patched_parts *parts,
                                         const fvv_limits *limits, fvv_patched_change *change,
                                         fvv_diagnostic *diagnostic);

/* Makes one mesh of what remains of the mesh as it has moved and the patch. Work and memory are linear in
 * these. FVV_OK or FVV_ERROR_MEMORY. */
FVV_MUST_USE fvv_status fvv_patched_merge(fvv_mesh_sequence *sequence, const fvv_patched_change *change,
                                          fvv_diagnostic *diagnostic);

/* Before the next frame: forgets the patch and which vertices were kept. */
void fvv_patched_clear(fvv_mesh_sequence *sequence);

#ifdef __cplusplus
}
#endif
#endif
