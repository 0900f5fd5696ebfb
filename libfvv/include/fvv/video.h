/* fvv/video.h: what a video track is (VCFG) and where each camera stands in its frames (TILE).
 * Spec: spec/fvv.md clause 10. No pixels here: see fvv_media. */
#ifndef FVV_VIDEO_H
#define FVV_VIDEO_H

#include "fvv/format.h"
#include "fvv/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* VCFG. codec: FVV_CODEC_...; samples are in MP4 sample format (ISO/IEC 14496-15) for avc1, whole JPEG files
 * for jpeg. record: the MP4 configuration record (avcC for avc1), empty for jpeg. codec_string: RFC 6381, as
 * WebCodecs wants it ("avc1.640028"); empty for jpeg. Colour by ITU-T H.273 code points. Pointers are
 * borrowed. */
typedef struct fvv_video_config {
  uint32_t codec;
  uint32_t width, height; /* of the decoded frame, > 0 */
  uint8_t shows;          /* FVV_SHOWS_... */
  uint8_t bit_depth;      /* 8 ... 16 */
  uint16_t camera_id;     /* FVV_SHOWS_CAMERA only, else FVV_NO_CAMERA */
  uint8_t colour_primaries, transfer_characteristics, matrix_coefficients, full_range;
  const uint8_t *record;
  size_t record_size;
  const char *codec_string;
  size_t codec_string_size;
} fvv_video_config;

/* One camera's part: source rectangle in pixels of the camera's picture, destination rectangle in the video
 * frame. A source point (u, v) is at destination.x + (u - source.x) * destination.width / source.width, the
 * same for v: with pixel centres at +0.5 a pure scale. */
typedef struct fvv_rect {
  uint16_t x, y, width, height;
} fvv_rect;
typedef struct fvv_tile {
  uint16_t camera_id;
  fvv_rect source, destination;
} fvv_tile;

/* Places one tile per camera, all whole pictures scaled to tile sizes given by the caller, in a near-square
 * grid with FVV_TILE_ALIGNMENT-pixel cells. In: camera_id and source of each tile and the wanted
 * destination.width/height. Out: destination.x/y, and the frame's size. Fails when no arrangement fits
 * max_dimension. Deterministic. */
FVV_API FVV_MUST_USE fvv_status fvv_tiles_arrange(fvv_tile *tiles, size_t count, uint32_t max_dimension,
                                                  uint32_t *frame_width, uint32_t *frame_height,
                                                  fvv_diagnostic *diagnostic);
/* Rectangles inside the frame and not overlapping, aligned, sizes > 0, one tile per camera. */
FVV_API FVV_MUST_USE fvv_status fvv_tiles_validate(const fvv_tile *tiles, size_t count, uint32_t frame_width,
                                                   uint32_t frame_height, fvv_diagnostic *diagnostic);
/* Maps a point between picture and video frame, both ways. */
FVV_API void fvv_tile_to_frame(const fvv_tile *tile, const double source[2], double frame[2]);
FVV_API void fvv_tile_to_source(const fvv_tile *tile, const double frame[2], double source[2]);

/* Records. Sizes as fvv_scene_encode. */
FVV_API FVV_MUST_USE fvv_status fvv_video_config_encode(const fvv_video_config *config, uint8_t *out,
                                                        size_t capacity, size_t *written,
                                                        fvv_diagnostic *diagnostic);
FVV_API FVV_MUST_USE fvv_status fvv_video_config_decode(fvv_video_config *config, const uint8_t *payload,
                                                        size_t size, const fvv_limits *limits,
                                                        fvv_diagnostic *diagnostic);
FVV_API FVV_MUST_USE fvv_status fvv_tiles_encode(const fvv_tile *tiles, size_t count, uint8_t *out,
                                                 size_t capacity, size_t *written,
                                                 fvv_diagnostic *diagnostic);
/* Writes up to capacity tiles; *count is the number there is (FVV_ERROR_BUFFER_TOO_SMALL when more). Does not
 * know the frame's size: call fvv_tiles_validate. */
FVV_API FVV_MUST_USE fvv_status fvv_tiles_decode(fvv_tile *tiles, size_t capacity, size_t *count,
                                                 const uint8_t *payload, size_t size,
                                                 const fvv_limits *limits, fvv_diagnostic *diagnostic);

#ifdef __cplusplus
}
#endif
#endif
