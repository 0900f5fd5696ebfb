/* video/oexr.h: what can be told of an OpenEXR file without decoding it. */
#ifndef FVV_VIDEO_OEXR_H
#define FVV_VIDEO_OEXR_H

#include "fvv/video.h"

/* The rules of clause 10.12 for a sample: FVV_ERROR_INVALID, FVV_ISSUE_SAMPLE_OEXR. */
fvv_status fvv_oexr_inspect(uint32_t width, uint32_t height, const uint8_t *sample, size_t size,
                            fvv_diagnostic *diagnostic);

#endif
