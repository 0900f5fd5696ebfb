// Packets of sound: encoding by libopus, decoding, and files that are written.
#include "fvv_media/sound.h"

#include "media/src/sound/frames.h"

extern "C" {
#include <libavutil/opt.h>
}

#include <algorithm>
#include <cstring>

namespace fvv::media {

namespace {

constexpr size_t opus_header_size = 19, opus_delay_at = 10;
constexpr uint32_t opus_preroll = 4; // 80 ms, RFC 7845 clause 4.6
constexpr size_t max_packet_size = 65535;

// Of interleaved samples. Opus has one layout for each number of channels (RFC 7845 clause 5.1.1.2), which is
// not FFmpeg's default for 3 and 4.
void set_layout(AVChannelLayout &out, uint32_t channels, bool is_opus) {
  if (is_opus && channels == 3)
    av_channel_layout_from_mask(&out, AV_CH_LAYOUT_SURROUND);
  else if (is_opus && channels == 4)
    av_channel_layout_from_mask(&out, AV_CH_LAYOUT_QUAD);
  else
    av_channel_layout_default(&out, int(channels));
}

} // namespace

uint32_t default_sound_bit_rate(uint32_t channels) {
  return channels == 1 ? 64000 : 48000 * channels;
}

uint32_t SoundFormat::delay() const {
  if (codec != SoundCodec::opus || record.size() < opus_header_size) return 0;
  return uint32_t(record[opus_delay_at] | record[opus_delay_at + 1] << 8);
}

// ---- frames ----------------------------------------------------------------------------------------------

SampleConverter::SampleConverter(uint32_t channels, uint32_t rate, bool for_opus)
    : channels_(channels), rate_(rate), for_opus_(for_opus) {}

SampleConverter::~SampleConverter() {
  swr_free(&swr_);
}

void SampleConverter::open(const AVFrame &frame) {
  AVChannelLayout out = {}, in = {};
  set_layout(out, channels_, for_opus_);
  if (frame.ch_layout.order == AV_CHANNEL_ORDER_UNSPEC)
    av_channel_layout_default(&in, frame.ch_layout.nb_channels);
  else if (av_channel_layout_copy(&in, &frame.ch_layout) < 0)
    throw std::bad_alloc();
  int code = swr_alloc_set_opts2(&swr_, &out, AV_SAMPLE_FMT_FLT, int(rate_), &in,
                                 AVSampleFormat(frame.format), frame.sample_rate, 0, nullptr);
  av_channel_layout_uninit(&in);
  if (code >= 0) code = swr_init(swr_);
  if (code < 0) fail("sound cannot be converted", code);
  format_ = frame.format;
  in_rate_ = frame.sample_rate;
  in_channels_ = frame.ch_layout.nb_channels;
}

void SampleConverter::add(const AVFrame &frame, std::vector<float> &samples) {
  if (!swr_) open(frame);
  if (frame.format != format_ || frame.sample_rate != in_rate_ || frame.ch_layout.nb_channels != in_channels_)
    throw Error("changes its rate, channels or kind of samples on the way");
  convert(const_cast<const uint8_t **>(frame.extended_data), frame.nb_samples, samples);
}

void SampleConverter::add_silence(int64_t count, std::vector<float> &samples) {
  std::vector<uint8_t> zeros(size_t(8) * 4096 * size_t(in_channels_),
                             format_ == AV_SAMPLE_FMT_U8 || format_ == AV_SAMPLE_FMT_U8P ? 0x80 : 0);
  const std::vector<const uint8_t *> planes(size_t(in_channels_), zeros.data());
  for (; count > 0; count -= 4096)
    convert(const_cast<const uint8_t **>(planes.data()), int(std::min<int64_t>(count, 4096)), samples);
}

void SampleConverter::finish(std::vector<float> &samples) {
  if (swr_) convert(nullptr, 0, samples);
}

void SampleConverter::convert(const uint8_t **in, int count, std::vector<float> &samples) {
  const int most = swr_get_out_samples(swr_, count);
  const size_t before = samples.size();
  samples.resize(before + size_t(std::max(most, 0)) * channels_);
  uint8_t *out = reinterpret_cast<uint8_t *>(samples.data() + before);
  const int got = most > 0 ? swr_convert(swr_, &out, most, in, count) : most;
  samples.resize(before + size_t(std::max(got, 0)) * channels_);
  if (got < 0) fail("sound cannot be converted", got);
}

// ---- encoding --------------------------------------------------------------------------------------------

OpusEncoder::OpusEncoder(uint32_t channels, uint32_t bit_rate) : channels_(channels) {
  quiet_log();
  clear_log();
  if (!bit_rate) bit_rate = default_sound_bit_rate(channels);
  if (bit_rate < least_sound_bit_rate * channels || bit_rate > most_sound_bit_rate * channels)
    throw Error("expected a bit rate of sound from " + std::to_string(least_sound_bit_rate * channels) +
                " to " + std::to_string(most_sound_bit_rate * channels) + " bit/s for " +
                std::to_string(channels) + (channels == 1 ? " channel" : " channels") + ", found " +
                std::to_string(bit_rate));
  const AVCodec *codec = avcodec_find_encoder_by_name("libopus");
  if (!codec) throw Error("this build of FFmpeg has no libopus, which encodes sound");
  context_ = make_context(codec);
  context_->sample_rate = int(opus_rate);
  context_->sample_fmt = AV_SAMPLE_FMT_FLT;
  context_->bit_rate = bit_rate;
  context_->time_base = {1, int(opus_rate)};
  set_layout(context_->ch_layout, channels, true);
  av_opt_set(context_->priv_data, "frame_duration", "20", 0);
  av_opt_set(context_->priv_data, "application", "audio", 0);
  av_opt_set(context_->priv_data, "vbr", "on", 0);
  const int code = avcodec_open2(context_.get(), codec, nullptr);
  if (code < 0) fail("sound cannot be encoded as Opus", code);
  if (context_->frame_size != int(opus_packet) || context_->extradata_size < int(opus_header_size))
    throw Error("FFmpeg's libopus does not encode packets of 20 ms");
  frame_ = make_frame();
  packet_ = make_packet();
  SoundFormat format;
  format.record.assign(context_->extradata, context_->extradata + context_->extradata_size);
  if (format.delay() > opus_packet) throw Error("FFmpeg's libopus has a delay of more than a packet");
  add_silence(opus_packet - format.delay()); // so that the second packet begins with the sound
  total_ = 0;
}

void OpusEncoder::add_silence(size_t samples) {
  const std::vector<float> silence(samples * channels_);
  add(silence.data(), silence.size());
}

void OpusEncoder::add(const float *samples, size_t count) {
  total_ += count / channels_;
  pending_.insert(pending_.end(), samples, samples + count);
  const size_t in_packet = size_t(opus_packet) * channels_;
  size_t at = 0;
  for (; pending_.size() - at >= in_packet; at += in_packet) encode(pending_.data() + at);
  pending_.erase(pending_.begin(), pending_.begin() + std::ptrdiff_t(at));
}

void OpusEncoder::encode(const float *samples) {
  av_frame_unref(frame_.get());
  frame_->nb_samples = int(opus_packet);
  frame_->format = AV_SAMPLE_FMT_FLT;
  frame_->sample_rate = int(opus_rate);
  frame_->pts = int64_t(packets_.size()) * opus_packet;
  if (av_channel_layout_copy(&frame_->ch_layout, &context_->ch_layout) < 0) throw std::bad_alloc();
  if (av_frame_get_buffer(frame_.get(), 0) < 0) throw std::bad_alloc();
  std::copy_n(samples, size_t(opus_packet) * channels_, reinterpret_cast<float *>(frame_->data[0]));
  int code = avcodec_send_frame(context_.get(), frame_.get());
  if (code >= 0) code = avcodec_receive_packet(context_.get(), packet_.get());
  if (code < 0) fail("sound cannot be encoded as Opus", code);
  if (packet_->size <= 0 || size_t(packet_->size) > max_packet_size)
    throw Error("FFmpeg's libopus returned a packet of " + std::to_string(packet_->size) + " bytes");
  packets_.emplace_back(packet_->data, packet_->data + packet_->size);
  av_packet_unref(packet_.get());
}

SoundPackets OpusEncoder::finish(int64_t first) {
  SoundPackets out;
  out.encoded = true;
  out.format.channels = channels_;
  out.format.preroll = opus_preroll;
  out.format.record.assign(context_->extradata, context_->extradata + context_->extradata_size);
  out.start = first - int64_t(opus_packet);
  if (!total_) return out;
  const uint64_t wanted = opus_packet + total_;
  while (packets_.size() * opus_packet < wanted) add_silence(opus_packet);
  out.packets = std::move(packets_);
  return out;
}

SoundPackets encode_sound(const std::vector<float> &samples, uint32_t channels, int64_t first,
                          uint32_t bit_rate) {
  OpusEncoder encoder(channels, bit_rate);
  encoder.add(samples.data(), samples.size());
  return encoder.finish(first);
}

// ---- decoding --------------------------------------------------------------------------------------------

struct SoundDecoder::State {
  explicit State(const SoundFormat &given)
      : format(given), converter(given.channels, given.rate, given.codec == SoundCodec::opus) {}

  const SoundFormat format;
  SampleConverter converter;
  Context context;
  AvFrame frame;
  Packet packet;
};

SoundDecoder::SoundDecoder(const SoundFormat &format) : state_(std::make_unique<State>(format)) {
  quiet_log();
  clear_log();
  const bool is_opus = format.codec == SoundCodec::opus;
  // libopus is the reference; FFmpeg's own decoder is the fallback.
  const AVCodec *codec = is_opus ? avcodec_find_decoder_by_name("libopus") : nullptr;
  if (!codec) codec = avcodec_find_decoder(is_opus ? AV_CODEC_ID_OPUS : AV_CODEC_ID_AAC);
  if (!codec)
    throw Error(std::string("this build of FFmpeg has no decoder for ") + (is_opus ? "Opus" : "AAC"));
  Context &context = state_->context;
  context = make_decoder_context(codec);
  std::vector<uint8_t> record = format.record;
  // All samples are wanted, those of the encoder's delay too.
  if (is_opus && record.size() >= opus_header_size) record[opus_delay_at] = record[opus_delay_at + 1] = 0;
  copy_record(record, context->extradata, context->extradata_size);
  context->sample_rate = int(format.rate);
  set_layout(context->ch_layout, format.channels, is_opus);
  context->request_sample_fmt = AV_SAMPLE_FMT_FLT;
  const int code = avcodec_open2(context.get(), codec, nullptr);
  if (code < 0) fail("sound cannot be decoded", code);
  state_->frame = make_frame();
  state_->packet = make_packet();
}

SoundDecoder::~SoundDecoder() = default;
SoundDecoder::SoundDecoder(SoundDecoder &&) noexcept = default;

void SoundDecoder::decode(const void *packet, size_t size, std::vector<float> &samples) {
  if (!size || size > max_packet_size)
    throw Error("expected a packet of sound of 1 to " + std::to_string(max_packet_size) + " bytes, found " +
                std::to_string(size));
  clear_log();
  State &s = *state_;
  av_packet_unref(s.packet.get());
  if (av_new_packet(s.packet.get(), int(size)) < 0) throw std::bad_alloc();
  std::memcpy(s.packet->data, packet, size);
  int code = avcodec_send_packet(s.context.get(), s.packet.get());
  if (code >= 0) code = avcodec_receive_frame(s.context.get(), s.frame.get());
  if (code < 0) fail("a packet of sound is damaged", code);
  if (s.frame->sample_rate != int(s.format.rate) ||
      s.frame->ch_layout.nb_channels != int(s.format.channels) ||
      s.frame->nb_samples != int(s.format.packet_duration))
    throw Error("expected a packet of " + std::to_string(s.format.packet_duration) + " samples of " +
                std::to_string(s.format.channels) + " channels at " + std::to_string(s.format.rate) +
                " Hz, found " + std::to_string(s.frame->nb_samples) + " of " +
                std::to_string(s.frame->ch_layout.nb_channels) + " at " +
                std::to_string(s.frame->sample_rate));
  s.converter.add(*s.frame, samples);
}

// ---- files -----------------------------------------------------------------------------------------------

const char *sound_extension(SoundCodec codec) {
  return codec == SoundCodec::opus ? "opus" : "m4a";
}

AVStream *add_sound_stream(Muxer &muxer, const SoundFormat &format) {
  const bool is_opus = format.codec == SoundCodec::opus;
  AVStream *stream = muxer.add_stream({1, int(format.rate)});
  AVCodecParameters &codec = *stream->codecpar;
  codec.codec_type = AVMEDIA_TYPE_AUDIO;
  codec.codec_id = is_opus ? AV_CODEC_ID_OPUS : AV_CODEC_ID_AAC;
  codec.sample_rate = int(format.rate);
  codec.frame_size = int(format.packet_duration);
  codec.initial_padding = int(format.delay());
  set_layout(codec.ch_layout, format.channels, is_opus);
  copy_record(format.record, codec.extradata, codec.extradata_size);
  return stream;
}

SoundFormat skipping(const SoundPackets &sound) {
  SoundFormat format = sound.format;
  if (format.codec != SoundCodec::opus || sound.start >= 0) return format;
  format.record[opus_delay_at] = uint8_t(-sound.start & 0xff);
  format.record[opus_delay_at + 1] = uint8_t(-sound.start >> 8);
  return format;
}

void write_sound(Muxer &muxer, const AVStream &stream, const SoundPackets &sound, int64_t time) {
  for (const std::vector<uint8_t> &bytes : sound.packets) {
    muxer.write(stream, bytes, time, sound.format.packet_duration, true);
    time += sound.format.packet_duration;
  }
}

std::string sound_file(const SoundPackets &sound) {
  Muxer muxer(sound.format.codec == SoundCodec::opus ? "opus" : "ipod", "sound");
  const AVStream *stream = add_sound_stream(muxer, sound.format);
  muxer.write_header();
  write_sound(muxer, *stream, sound, -int64_t(sound.format.delay()));
  return muxer.finish();
}

std::string wav_file(const std::vector<int16_t> &samples, uint32_t channels, uint32_t rate) {
  Muxer muxer("wav", "sound");
  AVStream *stream = muxer.add_stream({1, int(rate)});
  AVCodecParameters &codec = *stream->codecpar;
  codec.codec_type = AVMEDIA_TYPE_AUDIO;
  codec.codec_id = AV_CODEC_ID_PCM_S16LE;
  codec.sample_rate = int(rate);
  codec.block_align = int(2 * channels);
  codec.bits_per_coded_sample = 16;
  codec.bit_rate = int64_t(rate) * channels * 16;
  av_channel_layout_default(&codec.ch_layout, int(channels));
  muxer.write_header();
  constexpr size_t most = 32768;
  for (size_t at = 0; at < samples.size(); at += most) {
    const size_t count = std::min(most, samples.size() - at);
    std::vector<uint8_t> bytes;
    for (size_t i = 0; i < count; i++) {
      bytes.push_back(uint8_t(uint16_t(samples[at + i]) & 0xff));
      bytes.push_back(uint8_t(uint16_t(samples[at + i]) >> 8));
    }
    muxer.write(*stream, bytes, int64_t(at / channels), int64_t(count / channels), true);
  }
  return muxer.finish();
}

} // namespace fvv::media
