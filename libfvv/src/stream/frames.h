/* stream/frames.h: fvv_frames with events that do not come from pushed bytes. */
#ifndef FVV_STREAM_FRAMES_H
#define FVV_STREAM_FRAMES_H

#include "fvv/frames.h"

#ifdef __cplusplus
extern "C" {
#endif

/* As fvv_reader_next. */
typedef fvv_status (*fvv_event_source)(void *user, fvv_event *event, fvv_diagnostic *diagnostic);

/* Up to the next seek events come from this source, not from the reader. */
void fvv_frames_read_from(fvv_frames *frames, fvv_event_source source, void *user);

#ifdef __cplusplus
}
#endif
#endif
