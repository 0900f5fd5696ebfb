/* video/jpeg.h: what can be told of a JPEG file without decoding it. */
#ifndef FVV_VIDEO_JPEG_H
#define FVV_VIDEO_JPEG_H

#include "fvv/video.h"

/* The rules of clause 10.4 for a sample: FVV_ERROR_INVALID, FVV_ISSUE_SAMPLE_JPEG. */
fvv_status fvv_jpeg_inspect(uint32_t width, uint32_t height, const uint8_t *sample, size_t size,
                            fvv_diagnostic *diagnostic);

#endif
