/* video/tiles.h: the rules of a tile layout, with the status that the caller wants for their breach. */
#ifndef FVV_VIDEO_TILES_H
#define FVV_VIDEO_TILES_H

#include "base/layout.h"
#include "fvv/video.h"

/* As fvv_tiles_validate, but does not clear the diagnostic. status: FVV_ERROR_INPUT while encoding, else
 * FVV_ERROR_INVALID. A frame of UINT32_MAX x UINT32_MAX stands for one whose size is not known. */
fvv_status fvv_tiles_check(const fvv_tile *tiles, size_t count, uint32_t frame_width, uint32_t frame_height,
                           fvv_status status, fvv_diagnostic *diagnostic);

#endif
