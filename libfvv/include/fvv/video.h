/* fvv/video.h: what a video track is (VCFG) and where each camera is in its frames (TILE).
 * Spec: spec/fvv.md clause 10. No pixels here: see fvv_media. */
#ifndef FVV_VIDEO_H
#define FVV_VIDEO_H

#include "fvv/calibration.h"
#include "fvv/format.h"
#include "fvv/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* VCFG. codec: FVV_CODEC_...; samples are whole files for jpeg and oexr, else in MP4 sample format. record:
 * the MP4 configuration record (the payload of avcC, hvcC, vpcC or av1C), empty for jpeg and oexr.
 * codec_string: RFC 6381, as WebCodecs expects it ("avc1.640028", "hvc1.1.6.L93.B0", "vp09.00.31.08",
 * "av01.0.04M.08"); empty for jpeg and oexr. oexr has 16 bits, transfer 8, matrix 0 and full range. Colour by
 * ITU-T H.273 code points. Pointers are borrowed. */
typedef struct fvv_video_config {
  uint32_t codec;
  uint32_t width, height; /* of the decoded frame, > 0 */
  uint8_t shows;          /* FVV_SHOWS_... */
  uint8_t bit_depth;      /* 8 ... 16 */
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

/* The camera of the picture that a tile holds: the source rectangle moved to the origin and scaled to the
 * size of the destination. Projecting a point and mapping it by the tile gives the same pixel, less the
 * corner of the destination. Lens and pose stay as they are. The rectangles are not empty. */
FVV_API fvv_camera fvv_camera_of_tile(const fvv_camera *camera, const fvv_tile *tile);

/* Places one tile per camera, all whole pictures scaled to tile sizes given by the caller, in rows of cells
 * whose sides are multiples of FVV_TILE_ALIGNMENT pixels; tiles of one size make a grid. In: camera_id and
 * source of each tile and the wanted destination.width/height. Out: destination.x/y, and the frame's size,
 * multiples of FVV_TILE_ALIGNMENT, at most max_dimension and 65535.
 *
 * Tiles keep their order, from left to right and top to bottom; a tile that would pass the frame's width
 * opens the next row. Of all widths the one is taken whose frame is smallest among those at most twice as
 * long as short, then most nearly square; without such a frame, the most nearly square. Deterministic.
 *
 * FVV_ERROR_INPUT: no tiles, an empty rectangle, two tiles of one camera, or no rows fit; tiles are unchanged
 * then. */
FVV_API FVV_MUST_USE fvv_status fvv_tiles_arrange(fvv_tile *tiles, size_t count, uint32_t max_dimension,
                                                  uint32_t *frame_width, uint32_t *frame_height,
                                                  fvv_diagnostic *diagnostic);
/* Rectangles inside the frame and not overlapping, aligned, sizes > 0, one tile per camera: else
 * FVV_ERROR_INVALID. Whether a source lies inside its camera's picture is not checked: the caller checks this
 * against its cameras. Compares all pairs: bound count by fvv_limits.max_cameras first. */
FVV_API FVV_MUST_USE fvv_status fvv_tiles_validate(const fvv_tile *tiles, size_t count, uint32_t frame_width,
                                                   uint32_t frame_height, fvv_diagnostic *diagnostic);

/* Checks a configuration record and writes the codec string that belongs to it, ended by NUL. Does not parse
 * parameter sets or further than the first bits of a sequence header. FVV_ERROR_INVALID with
 * FVV_ISSUE_VIDEO_RECORD; FVV_ERROR_UNSUPPORTED for jpeg and oexr, which have no record, and for other
 * codecs.
 * avc1: AVCDecoderConfigurationRecord (ISO/IEC 14496-15 clause 5.3.3.1): version 1, 4-byte lengths, reserved
 * bits set, at least one SPS and one PPS, units of the right types that fill it exactly; profiles other than
 * 66, 77 and 88 may add chroma format, bit depths (luma's and chroma's the same) and SPS extensions.
 * hvc1: HEVCDecoderConfigurationRecord (the same, 8.3.3.1): version 1, profile space 0, 4-byte lengths,
 * reserved bits set, luma and chroma of one depth, one complete array each of VPS, SPS and PPS in this order,
 * which fill it exactly.
 * vp09: VPCodecConfigurationRecord (VP Codec ISO Media File Format Binding) after version and flags of its
 * box: 12 bytes, version 1, flags 0, no codec initialisation data; profile, bit depth and chroma agree.
 * av01: AV1CodecConfigurationRecord (AV1 Codec ISO Media File Format Binding): version 1, reserved bits 0,
 * OBUs with size fields that fill it exactly, one sequence header of the same profile and then metadata. */
#define FVV_CODEC_STRING_CAPACITY 48
FVV_API FVV_MUST_USE fvv_status fvv_video_codec_string(uint32_t codec, const uint8_t *record, size_t size,
                                                       char out[FVV_CODEC_STRING_CAPACITY],
                                                       fvv_diagnostic *diagnostic);

/* Checks a sample (VPKT payload) as far as it goes without decoding, in one pass that is bounded by size.
 * key: the chunk's key flag. JPEG: key, SOI first, EOI last, a frame header of the configured size with 8
 * bits and 1 or 3 components (ITU-T T.81 annex B; FVV_ISSUE_SAMPLE_JPEG). H.264: 4-byte lengths above 0 that
 * fill the sample exactly, forbidden_zero_bit 0, an IDR slice exactly in key samples (FVV_ISSUE_SAMPLE_AVC).
 * HEVC: the same lengths, one picture, no leading picture, an IRAP picture exactly in key samples
 * (FVV_ISSUE_SAMPLE_HEVC). VP9: one frame, or a superframe whose index fills the sample, the last frame alone
 * shown, a key frame first exactly in key samples (FVV_ISSUE_SAMPLE_VP9). AV1: OBUs with size fields that
 * fill the sample, no temporal delimiter, one shown frame, a sequence header and then a shown key frame
 * exactly in key samples (FVV_ISSUE_SAMPLE_AV1). OpenEXR: key, version word 2, a header that declares half B,
 * G and R in windows of the configured size, a known compression, and blocks that fill the sample exactly
 * (FVV_ISSUE_SAMPLE_OEXR). FVV_ERROR_INVALID, for other codecs FVV_ERROR_UNSUPPORTED.
 * For a valid configuration. */
FVV_API FVV_MUST_USE fvv_status fvv_video_sample_check(const fvv_video_config *config, int key,
                                                       const uint8_t *sample, size_t size,
                                                       fvv_diagnostic *diagnostic);

/* As fvv_video_sample_check, for callers who do not know the key flag: *key becomes 0 or 1. */
FVV_API FVV_MUST_USE fvv_status fvv_video_sample_inspect(const fvv_video_config *config,
                                                         const uint8_t *sample, size_t size, int *key,
                                                         fvv_diagnostic *diagnostic);

/* Records. Sizes as fvv_scene_encode. encode returns FVV_ERROR_INPUT where decode returns
 * FVV_ERROR_INVALID or, for a codec that is not known, FVV_ERROR_UNSUPPORTED. The record is checked as by
 * fvv_video_codec_string, and the codec string must be the one that belongs to it, hexadecimal digits in
 * either case. Where the record states a bit depth, or its profile (66, 77, 88 and 100 of H.264: 8), it must
 * be that of the configuration. */
FVV_API FVV_MUST_USE fvv_status fvv_video_config_encode(const fvv_video_config *config, uint8_t *out,
                                                        size_t capacity, size_t *written,
                                                        fvv_diagnostic *diagnostic);
FVV_API FVV_MUST_USE fvv_status fvv_video_config_decode(fvv_video_config *config, const uint8_t *payload,
                                                        size_t size, const fvv_limits *limits,
                                                        fvv_diagnostic *diagnostic);
FVV_API FVV_MUST_USE fvv_status fvv_tiles_encode(const fvv_tile *tiles, size_t count, uint8_t *out,
                                                 size_t capacity, size_t *written,
                                                 fvv_diagnostic *diagnostic);
/* Writes up to capacity tiles; *count is the number there is (FVV_ERROR_BUFFER_TOO_SMALL when more). Checks
 * all that fvv_tiles_validate does but the frame's size, which is in VCFG: call that as well. */
FVV_API FVV_MUST_USE fvv_status fvv_tiles_decode(fvv_tile *tiles, size_t capacity, size_t *count,
                                                 const uint8_t *payload, size_t size,
                                                 const fvv_limits *limits, fvv_diagnostic *diagnostic);

#ifdef __cplusplus
}
#endif
#endif
