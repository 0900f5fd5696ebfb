/* mesh/payload.h: encoding of key meshes for those who need to know how it came out. */
#ifndef FVV_MESH_PAYLOAD_H
#define FVV_MESH_PAYLOAD_H

#include "mesh/draco_bridge.h"

/* fvv_mesh_encode, and which of Draco's codings it took; coding means nothing for other profiles. */
FVV_MUST_USE fvv_status fvv_mesh_encode_telling(const fvv_mesh *mesh, uint8_t profile, int level,
                                                const fvv_allocator *allocator, fvv_bytes *payload,
                                                fvv_draco_coding *coding, fvv_diagnostic *diagnostic);

/* Decodes what this process has encoded: without a reader's limits, and whatever fails is a bug. */
FVV_MUST_USE fvv_status fvv_mesh_decode_own(const fvv_bytes *payload, const fvv_allocator *allocator,
                                            fvv_mesh *decoded, fvv_diagnostic *diagnostic);

#endif
