/* What a video file holds, found by demuxing alone. See demuxer.h. */
#include "codecs.h"
#include "demuxer.h"

extern "C" {
#include <libavutil/display.h>
}

#include <algorithm>
#include <cmath>
#include <numeric>

namespace fvv::media {
namespace {

/* Clockwise; nothing for a matrix that is no turn by quarters. */
std::optional<int> rotation_of(const AVStream &stream) {
  const uint8_t *bytes = av_stream_get_side_data(&stream, AV_PKT_DATA_DISPLAYMATRIX, nullptr);
  if (!bytes) return 0;
  const auto *m = reinterpret_cast<const int32_t *>(bytes);
  const double angle = av_display_rotation_get(m); // counter-clockwise, as seen on a screen
  const double quarters = std::isnan(angle) ? 0.5 : -angle / 90;
  const int64_t determinant_sign = int64_t(m[0]) * m[4] > int64_t(m[1]) * m[3] ? 1 : -1; // negative: mirrored
  if (std::fabs(quarters - std::round(quarters)) > 1e-6 || determinant_sign < 0) return {};
  return (int(std::lround(quarters)) % 4 + 4) % 4 * 90;
}

std::string ratio(AVRational value) {
  return std::to_string(value.num) + ":" + std::to_string(value.den);
}

VideoInfo info_of(const AVStream &stream, const std::string &path) {
  const AVCodecParameters &codec = *stream.codecpar;
  VideoInfo info;
  check_dimensions(uint32_t(std::max(codec.width, 0)), uint32_t(std::max(codec.height, 0)), path);
  info.width = uint32_t(codec.width);
  info.height = uint32_t(codec.height);
  if (const char *reason = refused_transfer(codec.color_trc)) throw Error(path, reason);
  if (stream.time_base.num <= 0 || stream.time_base.den <= 0)
    throw Error(path, "has the time base " + std::to_string(stream.time_base.num) + "/" +
                          std::to_string(stream.time_base.den) + ", expected a number > 0");
  const int divisor = std::gcd(stream.time_base.num, stream.time_base.den);
  info.tick = {uint32_t(stream.time_base.num / divisor), uint32_t(stream.time_base.den / divisor)};
  info.rotation = rotation_of(stream);
  const AVRational of_stream = stream.sample_aspect_ratio, of_codec = codec.sample_aspect_ratio;
  const AVRational pixel = of_stream.num > 0 ? of_stream : of_codec;
  if (pixel.num > 0 && pixel.den > 0 && pixel.num != pixel.den)
    info.warnings.push_back("has pixels of " + ratio(pixel) +
                            ", which are not square: they are taken as they are stored");
  if (codec.field_order != AV_FIELD_UNKNOWN && codec.field_order != AV_FIELD_PROGRESSIVE)
    info.warnings.push_back("is interlaced: its fields are taken as one picture");
  return info;
}

/* VP8 alone has pictures of their own in the container that are never shown (alternate references). */
bool is_hidden(const AVStream &stream, const AVPacket &packet) {
  return stream.codecpar->codec_id == AV_CODEC_ID_VP8 && !(packet.data[0] & 0x10);
}

} // namespace

const char *refused_transfer(AVColorTransferCharacteristic transfer) {
  switch (transfer) {
  case AVCOL_TRC_SMPTE2084:
    return "is HDR video (PQ, SMPTE ST 2084): its samples cannot be shown as sRGB, convert it first";
  case AVCOL_TRC_ARIB_STD_B67:
    return "is HDR video (HLG, ARIB STD-B67): its samples cannot be shown as sRGB, convert it first";
  default:
    return nullptr;
  }
}

VideoIndex make_index(Demuxer &demuxer, const std::string &path) {
  VideoIndex index;
  index.info = info_of(demuxer.stream(), path);
  const Packet packet = make_packet();
  while (demuxer.read(packet.get())) {
    const std::string number = "packet " + std::to_string(index.packets.size());
    if (packet->pts == AV_NOPTS_VALUE)
      throw Error(path, number + " has no presentation time: wrap the video into MP4 or Matroska");
    if (std::abs(packet->pts) > INT64_MAX / 8)
      throw Error(path, number + " has the presentation time " + std::to_string(packet->pts) +
                            ", which is too far out");
    if (index.packets.size() == max_video_pictures)
      throw Error(path, "holds more than " + std::to_string(max_video_pictures) + " pictures");
    // What an edit list leaves out is decoded, for what follows, and not shown.
    if (!(packet->flags & AV_PKT_FLAG_DISCARD) && !is_hidden(demuxer.stream(), *packet))
      index.packet_of.push_back(index.packets.size());
    index.packets.push_back({packet->pts, packet->dts, (packet->flags & AV_PKT_FLAG_KEY) != 0});
  }
  if (index.packet_of.empty()) throw Error(path, "holds no picture");
  std::stable_sort(index.packet_of.begin(), index.packet_of.end(),
                   [&](size_t a, size_t b) { return index.packets[a].pts < index.packets[b].pts; });
  constexpr int64_t longest = int64_t(1) << 53; // 104 days in nanoseconds
  if (index.pts(index.packet_of.size() - 1) - index.pts(0) > longest)
    throw Error(path, "has presentation times that are too far apart");
  for (size_t i = 0; i < index.packet_of.size(); i++) {
    index.info.times.push_back(index.pts(i) - index.pts(0));
    if (i && index.info.times[i] == index.info.times[i - 1])
      throw Error(path, "pictures " + std::to_string(i - 1) + " and " + std::to_string(i) +
                            " have the same presentation time");
  }
  return index;
}

} // namespace fvv::media
