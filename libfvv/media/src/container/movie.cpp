/* See fvv_media/movie.h. */
#include "fvv_media/movie.h"

#include "media/src/container/muxer.h"
#include "media/src/sound/frames.h"

namespace fvv::media {

namespace {

AVStream *add_pictures(Muxer &muxer, const fvv_video_config &config, AVRational tick) {
  if (config.codec != FVV_CODEC_AVC1 && config.codec != FVV_CODEC_HVC1) {
    const VideoCodec *known = find_video_codec(config.codec);
    throw Error("a film in MP4 is in H.264 or HEVC, not in " +
                std::string(known ? known->name : "this codec"));
  }
  AVStream *pictures = muxer.add_stream(tick);
  AVCodecParameters &codec = *pictures->codecpar;
  codec.codec_type = AVMEDIA_TYPE_VIDEO;
  codec.codec_id = config.codec == FVV_CODEC_AVC1 ? AV_CODEC_ID_H264 : AV_CODEC_ID_HEVC;
  codec.codec_tag = config.codec == FVV_CODEC_AVC1 ? MKTAG('a', 'v', 'c', '1') : MKTAG('h', 'v', 'c', '1');
  codec.width = int(config.width);
  codec.height = int(config.height);
  codec.format = pixel_format(config.bit_depth);
  codec.color_primaries = AVColorPrimaries(config.colour_primaries);
  codec.color_trc = AVColorTransferCharacteristic(config.transfer_characteristics);
  codec.color_space = AVColorSpace(config.matrix_coefficients);
  codec.color_range = config.full_range ? AVCOL_RANGE_JPEG : AVCOL_RANGE_MPEG;
  codec.sample_aspect_ratio = {1, 1};
  copy_record({config.record, config.record + config.record_size}, codec.extradata, codec.extradata_size);
  return pictures;
}

} // namespace

std::string movie_file(const VideoSettings &settings, const EncodedGroup &group, const SoundPackets *sound) {
  Muxer muxer("mp4", "a film");
  const AVRational duration = {int(settings.frame_rate.numerator), int(settings.frame_rate.denominator)};
  AVStream *pictures = add_pictures(muxer, config_of(settings, group), duration);
  pictures->avg_frame_rate = av_inv_q(duration);
  const AVStream *heard = sound ? add_sound_stream(muxer, skipping(*sound)) : nullptr;
  muxer.write_header();
  for (size_t i = 0; i < group.samples.size(); i++)
    muxer.write(*pictures, group.samples[i].bytes, int64_t(i), 1, group.samples[i].key);
  if (sound) write_sound(muxer, *heard, *sound, sound->start);
  return muxer.finish();
}

std::string movie_file(const fvv_video_config &config, const fvv_rational &tick,
                       const std::vector<TimedSample> &samples) {
  if (tick.numerator > INT32_MAX || tick.denominator > INT32_MAX)
    throw Error("a film in MP4 cannot have the ticks of this stream");
  Muxer muxer("mp4", "a film");
  const AVStream *pictures = add_pictures(muxer, config, {int(tick.numerator), int(tick.denominator)});
  muxer.write_header();
  for (const TimedSample &sample : samples) {
    const uint64_t since = uint64_t(sample.time) - uint64_t(samples.front().time);
    if (sample.time < samples.front().time || since > uint64_t(INT64_MAX))
      throw Error("a film in MP4 cannot have the times of this stream");
    muxer.write(*pictures, sample.bytes, int64_t(since), sample.duration, sample.key);
  }
  return muxer.finish();
}

} // namespace fvv::media
