/* What is said of each codec, in one table. See fvv_media/video.h. */
#include "fvv_media/video.h"

#include "codecs.h"
#include "fvv_media/exr.h"

namespace fvv::media {

const std::vector<VideoCodec> &video_codecs() {
  /* CRF 0 would be lossless in libx264, libvpx and libaom: another profile, which browsers need not know. */
  static const std::vector<VideoCodec> all = {
      {FVV_CODEC_JPEG, "jpeg", "JPEG", "quality", 100, 1, 8, 8},
      {FVV_CODEC_AVC1, "h264", "H.264", "CRF", 1, 51, 8, 8},
      {FVV_CODEC_HVC1, "hevc", "HEVC", "CRF", 1, 51, 8, 10},
      {FVV_CODEC_VP09, "vp9", "VP9", "CRF", 1, 63, 8, 10},
      {FVV_CODEC_AV01, "av1", "AV1", "CRF", 1, 63, 8, 10},
      {FVV_CODEC_OEXR, "exr", "OpenEXR", "DWA level", 0, max_dwa_level, 16, 16}};
  return all;
}

const VideoCodec *find_video_codec(uint32_t code) {
  for (const VideoCodec &codec : video_codecs())
    if (codec.code == code) return &codec;
  return nullptr;
}

void check_bit_depth(const VideoCodec &codec, int bit_depth) {
  if (bit_depth == codec.shallowest || bit_depth == codec.deepest) return;
  const char *why = codec.deepest > 8 ? ""
                    : codec.code == FVV_CODEC_JPEG
                        ? ": a baseline file has no more"
                        : ": browsers do not decode High 10; HEVC, VP9 and AV1 have 10 bits";
  throw Error("the video has " + std::to_string(bit_depth) + " bits a sample, expected " +
              std::to_string(codec.shallowest) +
              (codec.deepest > codec.shallowest ? " or " + std::to_string(codec.deepest) : "") + " for " +
              codec.name + why);
}

void refuse_codec(uint32_t code) {
  std::string text = "the video's codec ";
  for (int shift = 0; shift < 32; shift += 8) {
    const char c = char(code >> shift & 255);
    text += c >= 0x20 && c <= 0x7e ? c : '?';
  }
  text += " is none of";
  for (const VideoCodec &codec : video_codecs()) text += std::string(" ") + codec.name;
  throw Error(text);
}

Colour colour_of_codec(uint32_t code) {
  if (!find_video_codec(code)) refuse_codec(code);
  return code == FVV_CODEC_JPEG ? colour_of_jpeg : code == FVV_CODEC_OEXR ? colour_of_exr : colour_of_video;
}

} // namespace fvv::media
