/* Encoding a group: JPEG by TurboJPEG, all else through libavcodec. See fvv_media/video.h. */
#include "fvv_media/video.h"

#include "codecs.h"
#include "encoder_options.h"
#include "fvv_media/exr.h"
#include "rate.h"

#include <cmath>
#include <cstring>
#include <optional>
#include <type_traits>
#include <utility>

namespace fvv::media {
namespace {

template <class Sample> void check_settings(const VideoSettings &settings, size_t frames) {
  const VideoCodec *codec = find_video_codec(settings.codec);
  if (!codec) refuse_codec(settings.codec);
  check_bit_depth(*codec, settings.bit_depth);
  constexpr bool linear = std::is_same_v<Sample, float>;
  if (linear != (settings.codec == FVV_CODEC_OEXR))
    throw Error(std::string("pictures of ") + (linear ? "linear light" : "display values") +
                " came for video in " + codec->name);
  if (linear && (settings.quality || settings.bit_rate))
    throw Error("video in OpenEXR has no quality and no bit rate: it is lossless");
  if (!linear && settings.bit_depth != BasicFrame<Sample>::bit_depth)
    throw Error("pictures of " + std::to_string(8 * sizeof(Sample)) + " bits came for video of " +
                std::to_string(settings.bit_depth) + " bits a sample");
  if (!(settings.parts >= 0 && settings.parts < 1) ||
      std::fmod(settings.parts * parts_of_quality(settings.codec), 1) != 0)
    throw Error(std::string("the quality of ") + codec->name + " has " +
                std::to_string(parts_of_quality(settings.codec)) + " parts a unit, found " +
                std::to_string(settings.parts));
  check_dimensions(settings.width, settings.height, "a video frame");
  if (!frames) throw Error("a group needs at least one frame");
}

/* Loads one frame of a group. */
template <class Sample>
std::shared_ptr<const BasicImage<Sample>> load(const VideoSettings &settings,
                                               const GroupSource<Sample> &frames, size_t i) {
  std::shared_ptr<const BasicImage<Sample>> image = frames.load(i).image;
  check_image(*image);
  if (image->width != settings.width || image->height != settings.height || image->channels != 3)
    throw Error("frame " + std::to_string(i) + " of the group is " + std::to_string(image->width) + " x " +
                std::to_string(image->height) + " x " + std::to_string(image->channels) + ", expected " +
                std::to_string(settings.width) + " x " + std::to_string(settings.height) + " x 3");
  return image;
}

/* The pictures that an encoder takes. Each is made once: all of them are kept where there are several passes
 * over the group, else one at a time. */
template <class Input> class Inputs {
public:
  Inputs(size_t count, bool keep, std::function<Input(size_t frame)> make)
      : make_(std::move(make)), count_(count), inputs_(keep ? count : 1) {}

  size_t count() const { return count_; }
  const Input &at(size_t frame) {
    std::optional<Input> &input = inputs_[frame % inputs_.size()];
    if (!input || inputs_.size() < count_) {
      input.reset();
      input = make_(frame);
    }
    return *input;
  }

private:
  const std::function<Input(size_t frame)> make_;
  const size_t count_;
  std::vector<std::optional<Input>> inputs_;
};

std::vector<uint8_t> encode_still(const Image &frame, int quality) {
  return encode_jpeg(frame, quality, Subsampling::yuv420);
}
std::vector<uint8_t> encode_still(const LinearImage &frame, int) {
  return encode_half_exr(frame);
}

template <class SampleType>
EncodedGroup encode_stills(int quality, Inputs<std::shared_ptr<const BasicImage<SampleType>>> &images) {
  EncodedGroup group;
  for (size_t i = 0; i < images.count(); i++)
    group.samples.push_back({encode_still(*images.at(i), quality), true});
  return group;
}

template <class Sample>
void copy_plane(AVFrame *frame, int plane, const std::vector<Sample> &samples, size_t width) {
  const size_t stride = size_t(frame->linesize[plane]);
  for (size_t row = 0; row * width < samples.size(); row++)
    memcpy(frame->data[plane] + row * stride, &samples[row * width], width * sizeof(Sample));
}

template <class Sample>
AvFrame make_picture(const AVCodecContext *context, const BasicFrame<Sample> &yuv, int64_t index) {
  AvFrame frame = make_frame();
  frame->format = context->pix_fmt;
  frame->width = context->width;
  frame->height = context->height;
  const int code = av_frame_get_buffer(frame.get(), 0);
  if (code < 0) fail("a frame cannot be made", code);
  copy_plane(frame.get(), 0, yuv.y, yuv.width);
  copy_plane(frame.get(), 1, yuv.u, yuv.width / 2);
  copy_plane(frame.get(), 2, yuv.v, yuv.width / 2);
  frame->pts = index;
  return frame;
}

/* One encoder at work on one group. */
class GroupEncoder {
public:
  GroupEncoder(const VideoEncoder &encoder, const VideoSettings &settings, double crf, int pass,
               const std::string &statistics = "")
      : library_(encoder.library), bitstream_(encoder.bitstream), settings_(settings),
        context_(open_encoder(encoder, settings, crf, pass, statistics)), packet_(make_packet()) {}

  /* Statistics of a first pass for the second. */
  template <class SampleType> std::string look(Inputs<BasicFrame<SampleType>> &frames) {
    send(frames, [this] {
      while (avcodec_receive_packet(context_.get(), packet_.get()) >= 0) av_packet_unref(packet_.get());
    });
    if (!context_->stats_out) throw Error(library_ + " gave no statistics after its first pass");
    return context_->stats_out;
  }

  template <class SampleType> EncodedGroup encode(Inputs<BasicFrame<SampleType>> &frames) {
    send(frames, [this] { receive_samples(); });
    if (group_.samples.size() != frames.count())
      throw Error(library_ + " gave " + std::to_string(group_.samples.size()) + " samples for " +
                  std::to_string(frames.count()) + " frames");
    make_record();
    check_samples();
    return std::move(group_);
  }

private:
  template <class SampleType, class Receive>
  void send(Inputs<BasicFrame<SampleType>> &frames, const Receive &receive) {
    for (size_t i = 0; i < frames.count(); i++) {
      const AvFrame picture = make_picture(context_.get(), frames.at(i), int64_t(i));
      const int code = avcodec_send_frame(context_.get(), picture.get());
      if (code < 0) fail(library_ + " cannot encode frame " + std::to_string(i), code);
      receive();
    }
    const int code = avcodec_send_frame(context_.get(), nullptr);
    if (code < 0) fail(library_ + " cannot finish the group", code);
    receive();
  }

  void receive_samples() {
    int code;
    while ((code = avcodec_receive_packet(context_.get(), packet_.get())) >= 0) {
      if (packet_->pts != int64_t(group_.samples.size()) || packet_->size <= 0)
        throw Error(library_ + " gave frame " + std::to_string(packet_->pts) + " in place of frame " +
                    std::to_string(group_.samples.size()));
      group_.samples.push_back({bitstream_.sample(packet_->data, size_t(packet_->size)), false});
      av_packet_unref(packet_.get());
    }
    if (code != AVERROR(EAGAIN) && code != AVERROR_EOF) fail(library_ + " cannot encode", code);
  }

  void make_record() {
    const Bytes header(context_->extradata, context_->extradata + context_->extradata_size);
    group_.record = bitstream_.record(settings_, header, group_.samples[0].bytes);
    char text[FVV_CODEC_STRING_CAPACITY];
    fvv_diagnostic diagnostic;
    if (fvv_video_codec_string(settings_.codec, group_.record.data(), group_.record.size(), text,
                               &diagnostic) != FVV_OK)
      throw Error(library_ + " gave headers that make no record: " + diagnostic.message);
    group_.codec_string = text;
  }

  /* Checks the rules of the format, and that the first sample is the only key. */
  void check_samples() {
    const fvv_video_config config = config_of(settings_, group_);
    for (size_t i = 0; i < group_.samples.size(); i++) {
      Sample &sample = group_.samples[i];
      sample.key = i == 0;
      fvv_diagnostic diagnostic;
      if (fvv_video_sample_check(&config, sample.key, sample.bytes.data(), sample.bytes.size(),
                                 &diagnostic) != FVV_OK)
        throw Error(library_ + " gave a sample that is invalid at frame " + std::to_string(i) + ": " +
                    diagnostic.message);
    }
  }

  std::string library_;
  const Bitstream &bitstream_;
  const VideoSettings &settings_;
  Context context_;
  Packet packet_;
  EncodedGroup group_;
};

} // namespace

template <class SampleType>
GroupSource<SampleType> GroupSource<SampleType>::borrowed(const std::vector<BasicImage<SampleType>> &frames,
                                                          const std::vector<Image> &masks) {
  if (!masks.empty() && masks.size() != frames.size())
    throw Error(std::to_string(masks.size()) + " masks came with " + std::to_string(frames.size()) +
                " frames");
  const auto lent = [](const auto &image) {
    using Lent = std::remove_reference_t<decltype(image)>;
    return std::shared_ptr<Lent>(&image, [](Lent *) {});
  };
  return {frames.size(), [&, lent](size_t i) {
            return GroupFrame<SampleType>{lent(frames[i]), masks.empty() ? nullptr : lent(masks[i])};
          }};
}

template <class SampleType>
EncodedGroup encode_group(const VideoSettings &settings, const GroupSource<SampleType> &frames) {
  check_settings<SampleType>(settings, frames.count);
  const VideoEncoder *encoder = find_encoder(settings.codec);
  std::shared_ptr<void> room;
  if (frames.reserve) room = frames.reserve(encoding_memory(settings, frames.count));
  const bool again = settings.bit_rate || (encoder && encoder->two_passes);
  const auto loaded = [&](size_t i) { return load(settings, frames, i); };
  std::function<EncodedGroup(double quality)> encode_at;
  if constexpr (!std::is_same_v<SampleType, uint16_t>)
    if (!encoder)
      encode_at = [images =
                       Inputs<std::shared_ptr<const BasicImage<SampleType>>>(frames.count, again, loaded)](
                      double quality) mutable { return encode_stills(int(quality), images); };
  if constexpr (!std::is_same_v<SampleType, float>)
    if (encoder)
      encode_at = [&,
                   planes = Inputs<BasicFrame<SampleType>>(
                       frames.count, again,
                       [&](size_t i) { return to_yuv(*loaded(i), colour_of_codec(settings.codec)); }),
                   // Of a first pass, which does not depend on the quality.
                   statistics = std::string()](double quality) mutable {
        if (encoder->two_passes && statistics.empty())
          statistics = GroupEncoder(*encoder, settings, quality, AV_CODEC_FLAG_PASS1).look(planes);
        const int pass = encoder->two_passes ? AV_CODEC_FLAG_PASS2 : 0;
        return GroupEncoder(*encoder, settings, quality, pass, statistics).encode(planes);
      };
  const auto with_quality = [&](double quality) {
    EncodedGroup group = encode_at(quality);
    group.quality = quality;
    return group;
  };
  return settings.bit_rate ? encode_to_rate(settings, frames.count, with_quality)
                           : with_quality(settings.quality + settings.parts);
}

#define FVV_INSTANTIATE(Sample)                                                                              \
  template class GroupSource<Sample>;                                                                        \
  template EncodedGroup encode_group(const VideoSettings &, const GroupSource<Sample> &);
FVV_INSTANTIATE(uint8_t)
FVV_INSTANTIATE(uint16_t)
FVV_INSTANTIATE(float)
#undef FVV_INSTANTIATE

fvv_video_config config_of(const VideoSettings &settings, const EncodedGroup &group) {
  const Colour colour = colour_of_codec(settings.codec);
  fvv_video_config config = {};
  config.codec = settings.codec;
  config.width = settings.width;
  config.height = settings.height;
  config.shows = FVV_SHOWS_TILES;
  config.bit_depth = uint8_t(settings.bit_depth);
  config.colour_primaries = colour.primaries;
  config.transfer_characteristics = colour.transfer;
  config.matrix_coefficients = colour.matrix;
  config.full_range = colour.full_range;
  config.record = group.record.data();
  config.record_size = group.record.size();
  config.codec_string = group.codec_string.data();
  config.codec_string_size = group.codec_string.size();
  return config;
}

} // namespace fvv::media
