/* Pictures of a video file at random: from the key before on, and onwards while they are asked for in order.
 * See fvv_media/video_file.h. */
#include "fvv_media/video_file.h"

#include "codecs.h"
#include "demuxer.h"
#include "linear.h"
#include "video_rgb.h"

#include <algorithm>
#include <array>
#include <cstdio>

namespace fvv::media {

class VideoFile::Reader {
public:
  Reader(const std::string &path, std::optional<uint32_t> stream)
      : path_(path), stream_(stream), demuxer_(std::make_unique<Demuxer>(path, stream)) {
    index_ = std::make_shared<const VideoIndex>(make_index(*demuxer_, path));
    open_decoder();
  }
  explicit Reader(const Reader &other)
      : path_(other.path_), stream_(other.stream_), index_(other.index_),
        demuxer_(std::make_unique<Demuxer>(path_, stream_)) {
    open_decoder();
  }

  const VideoInfo &info() const { return index_->info; }
  size_t position() const { return position_; }

  template <class Sample> BasicImage<Sample> picture(size_t picture, int channels) {
    if (picture >= index_->packet_of.size())
      throw Error(path_, "has " + std::to_string(index_->packet_of.size()) + " pictures, picture " +
                             std::to_string(picture) + " was asked for");
    if (!(held_ && position_ == picture + 1)) find(picture);
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

  /* Keys at or before the picture in both orders: what is shown before a key but stored behind it (the
   * leading pictures of an open group) needs the key before. The first packet counts as one. */
  size_t key_before(size_t packet, int64_t pts) const {
    while (packet > 0 && !(index_->packets[packet].key && index_->packets[packet].pts <= pts)) packet--;
    return packet;
  }

  void find(size_t picture) {
    const size_t target = index_->packet_of[picture];
    const int64_t pts = index_->packets[target].pts;
    const size_t key = key_before(target, pts);
    const bool onwards = held_ && picture >= position_ && key <= next_;
    held_ = false;
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
    held_ = true;
    position_ = picture + 1;
  }

  /* The packet of that number is the next one to be decoded, by a decoder that knows nothing. */
  void start_at(size_t number) {
    avcodec_flush_buffers(context_.get());
    damaged_ = leading_damaged_ = SIZE_MAX;
    drained_ = false;
    start_pts_ = index_->packets[number].pts;
    if (!seek(number)) {
      demuxer_.reset();
      demuxer_ = std::make_unique<Demuxer>(path_, stream_);
      for (size_t i = 0; i <= number; i++)
        if (!demuxer_->read(packet_.get())) changed();
    }
    next_ = number;
    pending_ = true;
  }

  /* Reads as far as the packet. false when the container cannot go there. */
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

  /* Leaves the target in frame_, or answers why it cannot be had. */
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
      if (code == AVERROR_EOF) return left_out(target);
      note(code);
      if (code < 0) {
        if (drained_) return problem_;
        continue;
      }
      if (frame_->pts < wanted && frame_->pts != AV_NOPTS_VALUE) {
        if (is_broken(*frame_)) damaged_ = std::min(damaged_, next_ - 1);
        continue;
      }
      if (frame_->pts != wanted) return left_out(target);
      return judge(target);
    }
  }

  std::string left_out(size_t target) const {
    return damaged_ <= target || leading_damaged_ <= target ? problem_ : "is left out by the decoder";
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

  /* Sends one more packet, or the end. false when that cannot be. */
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

  /* Remembers what went wrong since the log was cleared. Whatever is shown before the key that decoding began
   * with may lack what it refers to, and nothing that is shown later refers to it. */
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
  bool held_ = false;    // frame_ is picture position_ - 1
  size_t next_ = 0;      // number of the packet that is sent next
  bool pending_ = false; // that packet is in packet_ already
  bool drained_ = false; // the decoder was told the end
  int64_t start_pts_ = 0;
  size_t damaged_ = SIZE_MAX, leading_damaged_ = SIZE_MAX; // first packets that went wrong
  std::string problem_;
};

VideoFile::VideoFile(const std::string &path, std::optional<uint32_t> stream)
    : reader_(std::make_unique<Reader>(path, stream)) {}
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
