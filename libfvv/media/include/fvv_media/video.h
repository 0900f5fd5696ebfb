/* fvv_media/video.h: video groups: encoding a whole group, decoding sample by sample, choosing the quality.
 *
 * It knows two codecs, JPEG per frame and H.264, and their samples and records as fvv carries them. It knows
 * nothing of tracks, chunks or time beyond the frame rate that H.264 wants to hear. */
#ifndef FVV_MEDIA_VIDEO_H
#define FVV_MEDIA_VIDEO_H

#include "fvv/video.h"
#include "fvv_media/colour.h"
#include "fvv_media/image.h"

#include <memory>
#include <string>
#include <vector>

namespace fvv::media {

struct VideoSettings {
  uint32_t codec;         /* FVV_CODEC_JPEG or FVV_CODEC_AVC1 */
  uint32_t width, height; /* of every frame; even for FVV_CODEC_AVC1 */
  int quality; /* JPEG: libjpeg's 1 ... 100, more is better. AVC1: CRF 1 ... 51, less is better (0 is
                  lossless in x264: another profile, which browsers need not know). */
  fvv_rational frame_rate; /* as a time base: seconds per frame, 1/25 for 25 Hz */
};

struct Sample {
  std::vector<uint8_t> bytes;
  bool key; /* decodable with the record alone */
};

struct EncodedGroup {
  std::vector<Sample> samples; /* one per frame, in order; the first is a key */
  std::vector<uint8_t> record; /* AVCDecoderConfigurationRecord (ISO/IEC 14496-15, 5.3.3); empty for JPEG */
  std::string codec_string;    /* RFC 6381, "avc1.640028"; empty for JPEG */
};

/* Code points that encode_group gives to a codec's pictures. */
Colour colour_of_codec(uint32_t codec);

/* One closed group of RGB frames. A pure function: the same settings and frames give the same bytes, on one
 * thread, without looking at other groups; the same settings give the same record and codec_string.
 * JPEG: every sample a JFIF file, 4:2:0, every one a key.
 * AVC1: High profile, 4:2:0, one IDR picture and then P pictures only, decoding order is display order.
 * Samples are NAL units behind 4-byte big-endian lengths; parameter sets stand in the record only; no access
 * unit delimiters, no SEI. */
EncodedGroup encode_group(const VideoSettings &settings, const std::vector<Image> &frames);

class SampleDecoder;

/* Decodes the samples of a track in order. Movable; one per thread of decoding. */
class Decoder {
public:
  /* Copies what it needs of config. Error when the codec, depth, colour or record cannot be decoded. */
  explicit Decoder(const fvv_video_config &config);
  ~Decoder();
  Decoder(Decoder &&) noexcept;
  Decoder &operator=(Decoder &&) noexcept;

  /* One sample in, its RGB picture out, at once, in the primaries and transfer of config. The first sample
   * and the first after an Error must be a key; a key may come at any time (seeking). Error when the bytes
   * are malformed or damaged in any way the codec can see, when the picture has another size than config
   * says, or when the stream states another matrix or range than config does. Damage that a codec cannot see
   * (most flipped bits that still parse, a sample left out) is the container's to find: CRC and continuity.
   */
  Image decode(const uint8_t *bytes, size_t size);

private:
  std::unique_ptr<SampleDecoder> decoder_;
};

/* fvv_video_config that decodes group: pointers are into group. shows is FVV_SHOWS_TILES. */
fvv_video_config config_of(const VideoSettings &settings, const EncodedGroup &group);

/* The cheapest quality at which the frames, encoded as one group and decoded, reach target_db of luma PSNR,
 * squared errors pooled over all frames (settings.quality is not looked at). masks: empty, or one grey
 * picture per frame: > 127 counts (see compose_masks). Found by interpolation, three to five encodings.
 * Error, saying what was reached, when the best quality does not reach target_db. */
int choose_quality(const VideoSettings &settings, const std::vector<Image> &frames, double target_db,
                   const std::vector<Image> &masks = {});

} // namespace fvv::media

#endif
