/* mesh/patched.h: the parts of a patched frame: which faces of the key mesh it leaves out, and the mesh that
 * is in their place (clause 8.14). */
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

/* Finds the parts and checks what can be checked without the key mesh: sizes, and the header of the patch,
 * whose counts are checked against limits and against its bytes. header: of the payload; data: after it. */
FVV_MUST_USE fvv_status fvv_patched_split(const uint8_t *data, const fvv_mesh_header *header,
                                          const fvv_limits *limits, fvv_patched_parts *parts,
                                          fvv_diagnostic *diagnostic);

/* Reads the faces that are left out and the patch into the state of the sequence. header, parts: of the
 * payload. */
FVV_MUST_USE fvv_status fvv_patched_read(fvv_mesh_sequence *sequence, const uint8_t *payload,
                                         const fvv_mesh_header *header, const fvv_patched_parts *parts,
                                         const fvv_limits *limits, fvv_diagnostic *diagnostic);

/* Decodes the patch of a MESH payload alone, without the frames before it; *patch is empty where the payload
 * has none. */
FVV_MUST_USE fvv_status fvv_patched_decode_patch(const uint8_t *payload, size_t size,
                                                 const fvv_limits *limits, const fvv_allocator *allocator,
                                                 fvv_mesh *patch, fvv_diagnostic *diagnostic);

/* The mesh of the frame from the key mesh as it has moved and the patch. FVV_OK or FVV_ERROR_MEMORY. */
FVV_MUST_USE fvv_status fvv_patched_merge(fvv_mesh_sequence *sequence, fvv_diagnostic *diagnostic);

/* Releases merged mesh and patch: the frame has the faces of its key mesh. The flags of faces are kept, all
 * 0. */
void fvv_patched_clear(fvv_mesh_sequence *sequence);

#ifdef __cplusplus
}
#endif
#endif
