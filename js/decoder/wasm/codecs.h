/* codecs.h: the codecs that are modules of their own (codec_imports.c), as JavaScript is told of them. */
#ifndef FVV_JS_CODECS_H
#define FVV_JS_CODECS_H

#include "fvv/mesh.h"

enum { FVVJS_CODEC_DRACO = 1, FVVJS_CODEC_FAST = 2, FVVJS_CODEC_OPENEXR = 4 };

static inline uint32_t fvvjs_mesh_codec(uint8_t profile) {
  return profile == FVV_MESH_DRACO ? FVVJS_CODEC_DRACO : profile == FVV_MESH_FAST ? FVVJS_CODEC_FAST : 0;
}

#endif
