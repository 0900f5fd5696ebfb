// Video files: the index of pictures, and pictures at random places.
#include "fvv_media/video_file.h"

#include "codecs.h"
#include "demuxer.h"
#include "ffmpeg.h"
#include "video_rgb.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <numeric>

extern "C" {
#include <libavutil/display.h>
#include <libavutil/pixdesc.h>
}

namespace fvv::media {

namespace {

struct VideoIndex {
  struct Entry {
    int64_t pts, dts; // dts may be AV_NOPTS_VALUE
    bool key;
  };
  VideoInfo info;
  std::vector<Entry> packets;    // as they are stored, those too that are decoded but not shown
  std::vector<size_t> packet_of; // by picture, as they are shown

  int64_t pts(size_t picture) const { return packets[packet_of[picture]].pts; }
};

// Why pictures with this transfer are rejected; NULL if they are not.
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

// Clockwise; nothing for a matrix that is no turn by quarters.
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

// H.264 and HEVC keep 16 besides the one that is decoded; other codecs fewer.
constexpr uint64_t kept_pictures = 17;
constexpr int deepest_pixel = 64; // bits, of four channels

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
  const AVPixFmtDescriptor *format = av_pix_fmt_desc_get(AVPixelFormat(codec.format));
  const int bits = format ? av_get_padded_bits_per_pixel(format) : deepest_pixel;
  info.decoding_memory = uint64_t(info.width + 64) * (info.height + 64) * kept_pictures * uint64_t(bits) / 8 +
                         uint64_t(info.width) * info.height * 3 * sizeof(uint16_t);
  const AVRational of_stream = stream.sample_aspect_ratio, of_codec = codec.sample_aspect_ratio;
  const AVRational pixel = of_stream.num > 0 ? of_stream : of_codec;
  if (pixel.num > 0 && pixel.den > 0 && pixel.num != pixel.den)
    info.warnings.push_back("has pixels of " + ratio(pixel) +
                            ", which are not square: they are taken as they are stored");
  if (codec.field_order != AV_FIELD_UNKNOWN && codec.field_order != AV_FIELD_PROGRESSIVE)
    info.warnings.push_back("is interlaced: its fields are taken as one picture");
  return info;
}

// VP8 alone has pictures of their own in the container that are never shown (alternate references).
bool is_hidden(const AVStream &stream, const AVPacket &packet) {
  return stream.codecpar->codec_id == AV_CODEC_ID_VP8 && !(packet.data[0] & 0x10);
}

// Reads demuxer, which was just opened, to its end.
VideoIndex make_index(Demuxer &demuxer, const std::string &path) {
  VideoIndex index;
  index.info = info_of(demuxer.stream(), path);
  index.info.timecode = demuxer.tag("timecode");
  const Packet packet = make_packet();
  while (demuxer.read(packet.get())) {
    const std::string number = "packet " + std::to_string(index.packets.size());
    if (packet->pts == AV_NOPTS_VALUE)
      throw Error(path, number + " has no presentation time: wrap the video into MP4 or Matroska");
    if (std::abs(packet->pts) > INT64_MAX / 8)
      throw Error(path, number + " has the presentation time " + std::to_string(packet->pts) +
                            ", which is out of range");
    if (index.packets.size() == max_video_pictures)
      throw Error(path, "holds more than " + std::to_string(max_video_pictures) + " pictures");
    // Packets that an edit list omits are decoded, as later ones depend on them, and not shown.
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

} // namespace

class VideoFile::Reader {
public:
  Reader(const std::string &path, std::optional<uint32_t> stream, const MemoryLimit &limit)
      : path_(path), stream_(stream), demuxer_(std::make_unique<Demuxer>(path, Demuxer::video, stream)) {
    index_ = std::make_shared<const VideoIndex>(make_index(*demuxer_, path));
    check_memory(path + ": decoding a video of " + std::to_string(info().width) + " x " +
                     std::to_string(info().height) + " pixels",
                 info().decoding_memory, limit);
    open_decoder();
  }
  explicit Reader(const Reader &other)
      : path_(other.path_), stream_(other.stream_), index_(other.index_),
        demuxer_(std::make_unique<Demuxer>(path_, Demuxer::video, stream_)) {
    open_decoder();
  }

  const VideoInfo &info() const { return index_->info; }
  size_t position() const { return position_; }

  template <class Sample> BasicImage<Sample> picture(size_t picture, int channels) {
    if (picture >= index_->packet_of.size())
      throw Error(path_, "has " + std::to_string(index_->packet_of.size()) + " pictures, picture " +
                             std::to_string(picture) + " was requested");
    if (!(decoded_ && position_ == picture + 1)) find(picture);
    try {
      if (const char *reason = refused_transfer(frame_->color_trc)) throw Error(reason);
      if constexpr (std::is_same_v<Sample, float>)
        return linear_of(with_channels(rgb_.convert<uint16_t>(*frame_), channels));
      else
        return with_channels(rgb_.convert<Sample>(*frame_), channels);
    } catch (const Error &error) {
      throw Error(path_, error.what());
    }
  }

private:
  void open_decoder() {
    const AVCodecParameters &parameters = *demuxer_->stream().codecpar;
    const AVCodec *codec = avcodec_find_decoder(parameters.codec_id);
    if (!codec)
      throw Error(path_, std::string("this build of FFmpeg has no decoder for ") +
                             avcodec_get_name(parameters.codec_id));
    context_ = make_decoder_context(codec);
    int code = avcodec_parameters_to_context(context_.get(), &parameters);
    if (code < 0) fail(path_ + ": cannot be decoded", code);
    context_->pkt_timebase = demuxer_->stream().time_base;
    // Decoders measure padded buffers by this, not only pictures.
    context_->max_pixels = int64_t(max_dimension) * max_dimension;
    code = avcodec_open2(context_.get(), codec, nullptr);
    if (code < 0) fail(path_ + ": cannot be decoded", code);
    packet_ = make_packet();
    frame_ = make_frame();
  }

  // Keys at or before the picture in both orders: what is shown before a key but stored after it (the leading
  // pictures of an open group) needs the key before. The first packet counts as one.
  size_t key_before(size_t packet, int64_t pts) const {
    while (packet > 0 && !(index_->packets[packet].key && index_->packets[packet].pts <= pts)) packet--;
    return packet;
  }

  void find(size_t picture) {
    const size_t target = index_->packet_of[picture];
    const int64_t pts = index_->packets[target].pts;
    const size_t key = key_before(target, pts);
    const bool onwards = decoded_ && picture >= position_ && key <= next_;
    decoded_ = false;
    if (onwards && decode_until(target).empty()) return hold(picture);
    // A key need not be one: with gradual refresh decoding has to begin earlier, at worst at the beginning.
    const size_t earlier = key ? key_before(key - 1, pts) : 0;
    std::string problem;
    for (const size_t from : {key, earlier, size_t(0)}) {
      start_at(from);
      problem = decode_until(target);
      if (problem.empty()) return hold(picture);
      if (from == 0) break;
    }
    char time[64];
    std::snprintf(time, sizeof time, " at %.6f s: ",
                  double(info().times[picture]) * info().tick.numerator / info().tick.denominator);
    throw Error(path_, "picture " + std::to_string(picture) + time + problem);
  }

  void hold(size_t picture) {
    decoded_ = true;
    position_ = picture + 1;
  }

  // The packet of that number is the next one to be decoded, by a decoder without state.
  void start_at(size_t number) {
    avcodec_flush_buffers(context_.get());
    damaged_ = leading_damaged_ = SIZE_MAX;
    drained_ = false;
    start_pts_ = index_->packets[number].pts;
    if (!seek(number)) {
      demuxer_.reset();
      demuxer_ = std::make_unique<Demuxer>(path_, Demuxer::video, stream_);
      for (size_t i = 0; i <= number; i++)
        if (!demuxer_->read(packet_.get())) changed();
    }
    next_ = number;
    pending_ = true;
  }

  // Reads as far as the packet. false when the container cannot go there.
  bool seek(size_t number) {
    const VideoIndex::Entry &wanted = index_->packets[number];
    if (!demuxer_->seek(wanted.dts != AV_NOPTS_VALUE ? wanted.dts : wanted.pts)) return false;
    while (demuxer_->read(packet_.get())) {
      if (packet_->pts == wanted.pts && packet_->dts == wanted.dts) return true;
      if (packet_->dts != AV_NOPTS_VALUE && wanted.dts != AV_NOPTS_VALUE && packet_->dts >= wanted.dts)
        return false;
    }
    return false;
  }

  [[noreturn]] void changed() const { throw Error(path_, "has changed while it was read"); }

  // Leaves the target in frame_, or returns the reason why not.
  std::string decode_until(size_t target) {
    const int64_t wanted = index_->packets[target].pts;
    for (;;) {
      clear_log();
      av_frame_unref(frame_.get());
      const int code = avcodec_receive_frame(context_.get(), frame_.get());
      if (code == AVERROR(EAGAIN)) {
        if (!feed()) return problem_;
        continue;
      }
      if (code == AVERROR_EOF) return reason_missing(target);
      note(code);
      if (code < 0) {
        if (drained_) return problem_;
        continue;
      }
      if (frame_->pts < wanted && frame_->pts != AV_NOPTS_VALUE) {
        if (is_broken(*frame_)) damaged_ = std::min(damaged_, next_ - 1);
        continue;
      }
      if (frame_->pts != wanted) return reason_missing(target);
      return judge(target);
    }
  }

  std::string reason_missing(size_t target) const {
    return damaged_ <= target || leading_damaged_ <= target ? problem_ : "is omitted by the decoder";
  }

  std::string judge(size_t target) {
    const bool leading = index_->packets[target].pts < start_pts_;
    if (damaged_ <= target || (leading && leading_damaged_ <= target)) return problem_;
    if (is_broken(*frame_)) return "is damaged: it is not whole";
    if (uint32_t(frame_->width) != info().width || uint32_t(frame_->height) != info().height)
      return "is " + std::to_string(frame_->width) + " x " + std::to_string(frame_->height) +
             ", the file says " + std::to_string(info().width) + " x " + std::to_string(info().height);
    return "";
  }

  // Sends one more packet, or the end. false when that cannot be.
  bool feed() {
    int code;
    if (!pending_ && !drained_ && !demuxer_->read(packet_.get())) {
      if (next_ != index_->packets.size()) changed();
      drained_ = true;
      code = avcodec_send_packet(context_.get(), nullptr);
    } else {
      if (drained_ || next_ >= index_->packets.size() || packet_->pts != index_->packets[next_].pts)
        changed();
      pending_ = false;
      next_++;
      clear_log();
      code = avcodec_send_packet(context_.get(), packet_.get());
    }
    note(code);
    return true;
  }

  // Stores errors since the log was cleared. Pictures shown before the key where decoding began may lack
  // their references, and no later picture refers to them.
  void note(int code) {
    if (code >= 0 && !log_has_error()) return;
    const size_t packet = next_ - 1;
    try {
      fail("is damaged, or follows a damaged one", code);
    } catch (const Error &error) {
      problem_ = error.what();
    }
    size_t &damaged = index_->packets[packet].pts < start_pts_ ? leading_damaged_ : damaged_;
    damaged = std::min(damaged, packet);
  }

  const std::string path_;
  const std::optional<uint32_t> stream_;
  std::shared_ptr<const VideoIndex> index_;
  std::unique_ptr<Demuxer> demuxer_;
  Context context_;
  Packet packet_;
  AvFrame frame_;
  RgbConverter rgb_;
  size_t position_ = 0;
  bool decoded_ = false; // frame_ is picture position_ - 1
  size_t next_ = 0;      // number of the packet that is sent next
  bool pending_ = false; // that packet is in packet_ already
  bool drained_ = false; // the end was sent to the decoder
  int64_t start_pts_ = 0;
  size_t damaged_ = SIZE_MAX, leading_damaged_ = SIZE_MAX; // first packets that went wrong
  std::string problem_;
};

VideoFile::VideoFile(const std::string &path, std::optional<uint32_t> stream, const MemoryLimit &limit)
    : reader_(std::make_unique<Reader>(path, stream, limit)) {}
VideoFile::VideoFile(std::unique_ptr<Reader> reader) : reader_(std::move(reader)) {}
VideoFile::~VideoFile() = default;
VideoFile::VideoFile(VideoFile &&) noexcept = default;

VideoFile VideoFile::another() const {
  return VideoFile(std::make_unique<Reader>(*reader_));
}
const VideoInfo &VideoFile::info() const {
  return reader_->info();
}
template <class Sample> BasicImage<Sample> VideoFile::picture(size_t index, int channels) {
  return reader_->picture<Sample>(index, channels);
}
template Image VideoFile::picture(size_t index, int channels);
template DeepImage VideoFile::picture(size_t index, int channels);
template LinearImage VideoFile::picture(size_t index, int channels);
size_t VideoFile::position() const {
  return reader_->position();
}

} // namespace fvv::media
