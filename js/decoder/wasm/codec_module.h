/* codec_module.h: what the modules that the core borrows from have in common: bytes in, a diagnostic out, and
 * for codecs of meshes room for one mesh. JavaScript copies between their memories and the core's. */
#ifndef FVV_JS_CODEC_MODULE_H
#define FVV_JS_CODEC_MODULE_H

#include "fvv/mesh.h"

#define FVVJS_EXPORT __attribute__((visibility("default"), used))

/* Of the last call. */
extern fvv_diagnostic fvvcodec_diagnostic;

/* The mesh that comes out. It holds until the next one, or fvvcodec_release. */
extern fvv_mesh fvvcodec_mesh;

/* Clears the diagnostic and makes room in fvvcodec_mesh. */
fvv_status fvvcodec_prepare(uint32_t vertices, uint32_t faces, int has_texture, int has_normals);

#endif
