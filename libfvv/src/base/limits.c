#include "base/limits.h"

#include <string.h>

void fvv_limits_default(fvv_limits *limits) {
  memset(limits, 0, sizeof *limits);
  limits->struct_size = sizeof *limits;
  limits->max_payload = UINT64_C(256) << 20;
  limits->max_vertices = 4u << 20;
  limits->max_faces = 8u << 20;
  limits->max_cameras = 1024;
  limits->max_tracks = 256;
  limits->max_dimension = 16384;
  limits->max_groups = 2u << 20;
  limits->max_group_chunks = 1u << 20;
  limits->max_text = 1u << 20;
  limits->max_background = 1024;
}

fvv_limits fvv_limits_or_default(const fvv_limits *limits) {
  fvv_limits result;
  fvv_limits_default(&result);
  if (limits) {
    const size_t size = limits->struct_size < sizeof result ? limits->struct_size : sizeof result;
    memcpy(&result, limits, size);
    result.struct_size = sizeof result;
  }
  return result;
}

const char *fvv_version(void) {
  return FVV_LIBRARY_VERSION;
}
