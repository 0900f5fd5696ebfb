/* video/avc.h: the H.264 configuration record with the status and offset that the caller wants. */
#ifndef FVV_VIDEO_AVC_H
#define FVV_VIDEO_AVC_H

#include "fvv/video.h"

enum { FVV_AVC_CODEC_STRING_SIZE = 11 }; /* "avc1.640028" */

/* As fvv_avc_record_check, but does not clear the diagnostic; base is added to offsets. */
fvv_status fvv_avc_record_inspect(const uint8_t *record, size_t size, fvv_status status, uint64_t base,
                                  fvv_diagnostic *diagnostic);

/* Writes the codec string of a record of at least 4 bytes, in lower case and terminated. */
void fvv_avc_codec_string(const uint8_t *record, char out[FVV_AVC_CODEC_STRING_SIZE + 1]);

/* The rules of clause 10.5 for a sample: FVV_ERROR_INVALID, FVV_ISSUE_SAMPLE_AVC. */
fvv_status fvv_avc_sample_inspect(int key, const uint8_t *sample, size_t size, fvv_diagnostic *diagnostic);

#endif
