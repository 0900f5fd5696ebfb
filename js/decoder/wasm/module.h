/* module.h: what the modules share: how a function is exported, and the codecs that are modules of their
 * own, as JavaScript loads them. */
#ifndef FVV_JS_MODULE_H
#define FVV_JS_MODULE_H

#include "fvv/mesh.h"

#define FVVJS_EXPORT __attribute__((visibility("default"), used))

enum { FVVJS_CODEC_DRACO = 1, FVVJS_CODEC_FAST = 2, FVVJS_CODEC_OPENEXR = 4 };

static inline uint32_t fvvjs_mesh_codec(uint8_t profile) {
  return profile == FVV_MESH_DRACO ? FVVJS_CODEC_DRACO : profile == FVV_MESH_FAST ? FVVJS_CODEC_FAST : 0;
}

#endif
