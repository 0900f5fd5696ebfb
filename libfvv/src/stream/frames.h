/* stream/frames.h: fvv_frames for analysis, and with events that do not come from pushed bytes. */
#ifndef FVV_STREAM_FRAMES_H
#define FVV_STREAM_FRAMES_H

#include "fvv/frames.h"

#ifdef __cplusplus
extern "C" {
#endif

/* As fvv_reader_next. */
typedef fvv_status (*fvv_event_source)(void *user, fvv_event *event, fvv_diagnostic *diagnostic);

/* Up to the next seek events come from this source, not from the reader. It reports all chunks of a group but
 * those of tracks that are left out; damaged ones with has_chunk, if it knows their headers. */
void fvv_frames_read_from(fvv_frames *frames, fvv_event_source source, void *user);

/* The kind of an event of the reader, which is reported before what it means. Only after fvv_frames_analyse.
 */
#define FVV_FRAMES_READ ((fvv_frames_kind)7)
/* Before the first push. Events of the reader are reported too; frames that are not whole as well, with whole
 * 0; payloads are not kept, they are only in the events of the reader. */
void fvv_frames_analyse(fvv_frames *frames);
/* Of the event of kind FVV_FRAMES_READ that was reported last: what was read, and whether it is the first
 * chunk of a track at its time. Valid until the next call of fvv_frames_next. */
const fvv_event *fvv_frames_read(const fvv_frames *frames);
int fvv_frames_begins_time(const fvv_frames *frames);

#ifdef __cplusplus
}
#endif
#endif
