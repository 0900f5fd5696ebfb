#include "make_sound.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
}

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

namespace {

constexpr double pi = 3.14159265358979323846;

float click_at(double seconds) { /* since its beginning */
  return seconds < 0 || seconds > 0.01
             ? 0
             : float(0.8 * std::exp(-seconds * 500) * std::cos(2 * pi * 1500 * seconds));
}

void check(int code, const char *what) {
  if (code < 0) throw std::runtime_error(std::string(what) + " failed");
}

/* One encoder and its stream of a file. */
struct Track {
  AVCodecContext *encoder;
  AVStream *stream;

  Track(AVFormatContext *file, const char *name) {
    const AVCodec *codec = avcodec_find_encoder_by_name(name);
    if (!codec) throw std::runtime_error(std::string("no encoder ") + name);
    encoder = avcodec_alloc_context3(codec);
    stream = avformat_new_stream(file, nullptr);
    if (file->oformat->flags & AVFMT_GLOBALHEADER) encoder->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  }
  ~Track() { avcodec_free_context(&encoder); }

  void open() {
    check(avcodec_open2(encoder, encoder->codec, nullptr), "avcodec_open2");
    check(avcodec_parameters_from_context(stream->codecpar, encoder), "parameters");
    stream->time_base = encoder->time_base;
  }
  void encode(AVFormatContext *file, AVFrame *frame) {
    check(avcodec_send_frame(encoder, frame), "send_frame");
    AVPacket *packet = av_packet_alloc();
    while (avcodec_receive_packet(encoder, packet) >= 0) {
      packet->stream_index = stream->index;
      av_packet_rescale_ts(packet, encoder->time_base, stream->time_base);
      check(av_interleaved_write_frame(file, packet), "write_frame");
    }
    av_packet_free(&packet);
  }
};

AVFormatContext *open_file(const std::string &path) {
  AVFormatContext *file = nullptr;
  check(avformat_alloc_output_context2(&file, nullptr, nullptr, path.c_str()), "alloc_output");
  check(avio_open(&file->pb, path.c_str(), AVIO_FLAG_WRITE), "avio_open");
  return file;
}

void close_file(AVFormatContext *file) {
  check(av_write_trailer(file), "write_trailer");
  avio_closep(&file->pb);
  avformat_free_context(file);
}

void prepare_sound(Track &track, int channels, int rate) {
  track.encoder->sample_rate = rate;
  const AVSampleFormat *format = track.encoder->codec->sample_fmts;
  while (*format == AV_SAMPLE_FMT_S32P && format[1] != AV_SAMPLE_FMT_NONE) format++; // of libmp3lame
  track.encoder->sample_fmt = *format;
  track.encoder->time_base = {1, rate};
  track.encoder->bit_rate = 96000 * channels;
  av_channel_layout_default(&track.encoder->ch_layout, channels);
  // Without noise substitution decoded samples do not depend on the packets before.
  av_opt_set(track.encoder, "aac_pns", "0", AV_OPT_SEARCH_CHILDREN);
  track.open();
}

void store(AVFrame *frame, int index, int channel, int channels, float sample) {
  const bool planar = av_sample_fmt_is_planar(AVSampleFormat(frame->format));
  uint8_t *plane = frame->extended_data[planar ? channel : 0];
  const int at = planar ? index : index * channels + channel;
  const double value = std::clamp(double(sample), -1.0, 1.0);
  switch (av_get_packed_sample_fmt(AVSampleFormat(frame->format))) {
  case AV_SAMPLE_FMT_U8:
    plane[at] = uint8_t(128 + std::lround(value * 127));
    break;
  case AV_SAMPLE_FMT_S16:
    reinterpret_cast<int16_t *>(plane)[at] = int16_t(std::lround(value * 32767));
    break;
  case AV_SAMPLE_FMT_FLT:
    reinterpret_cast<float *>(plane)[at] = float(value);
    break;
  default:
    throw std::runtime_error("a sample format that is not known here");
  }
}

void encode_sound_track(AVFormatContext *file, Track &track, const std::vector<float> &samples,
                        int channels) {
  const int total = int(samples.size()) / channels;
  const int step = track.encoder->frame_size ? track.encoder->frame_size : 4096;
  for (int at = 0; at < total; at += step) {
    AVFrame *frame = av_frame_alloc();
    frame->nb_samples = std::min(step, total - at);
    frame->format = track.encoder->sample_fmt;
    frame->sample_rate = track.encoder->sample_rate;
    frame->pts = at;
    check(av_channel_layout_copy(&frame->ch_layout, &track.encoder->ch_layout), "layout");
    check(av_frame_get_buffer(frame, 0), "frame_get_buffer");
    for (int i = 0; i < frame->nb_samples; i++)
      for (int c = 0; c < channels; c++)
        store(frame, i, c, channels, samples[size_t((at + i) * channels + c)]);
    track.encode(file, frame);
    av_frame_free(&frame);
  }
  track.encode(file, nullptr);
}

} // namespace

std::vector<float> clicks(int rate, int channels, double duration, const std::vector<double> &times) {
  std::mt19937 random(3);
  std::vector<float> out;
  for (int64_t i = 0; i < std::llround(duration * rate); i++) {
    float sample = float(int(random() % 2001) - 1000) * 1e-6f;
    for (const double time : times) sample += click_at(double(i) / rate - time);
    out.insert(out.end(), size_t(channels), sample);
  }
  return out;
}

std::vector<float> tones(int rate, int channels, double duration) {
  std::mt19937 random(5);
  std::vector<float> out;
  for (int64_t i = 0; i < std::llround(duration * rate); i++)
    for (int c = 0; c < channels; c++) {
      double sample = 0;
      for (int k = 1; k <= 4; k++)
        sample += 0.12 * std::sin(2 * pi * (110 + 37 * c) * k * (1 + 0.05 * std::sin(double(i) / rate * 3)) *
                                  double(i) / rate);
      out.push_back(float(sample) + float(int(random() % 2001) - 1000) * 2e-5f);
    }
  return out;
}

int64_t find_click(const std::vector<float> &samples, uint32_t channels, uint32_t rate, int64_t about) {
  const auto total = int64_t(samples.size() / channels);
  const auto mono = [&](int64_t i) {
    double sum = 0;
    for (uint32_t c = 0; i >= 0 && i < total && c < channels; c++) sum += samples[size_t(i) * channels + c];
    return sum;
  };
  const int64_t around = rate / 25;
  int64_t best = INT64_MIN;
  double most = -1e30;
  for (int64_t at = about - around; at <= about + around; at++) {
    double sum = 0;
    for (int64_t i = 0; i < rate / 100; i++) sum += mono(at + i) * click_at(double(i) / rate);
    if (sum > most) {
      most = sum;
      best = at;
    }
  }
  return best;
}

void write_sound(const std::string &path, const char *encoder, const std::vector<float> &samples,
                 int channels, int rate) {
  AVFormatContext *file = open_file(path);
  {
    Track track(file, encoder);
    prepare_sound(track, channels, rate);
    check(avformat_write_header(file, nullptr), "write_header");
    encode_sound_track(file, track, samples, channels);
  }
  close_file(file);
}

void write_video_with_sound(const std::string &path, double picture_start, const std::vector<float> &samples,
                            int channels, int rate) {
  AVFormatContext *file = open_file(path);
  {
    Track picture(file, "mpeg4"), sound(file, "pcm_s16le");
    picture.encoder->width = picture.encoder->height = 64;
    picture.encoder->pix_fmt = AV_PIX_FMT_YUV420P;
    picture.encoder->time_base = {1, 25};
    picture.open();
    prepare_sound(sound, channels, rate);
    check(avformat_write_header(file, nullptr), "write_header");
    const auto first = std::llround(picture_start * 25);
    for (int64_t i = 0; i < 25; i++) {
      AVFrame *frame = av_frame_alloc();
      frame->width = frame->height = 64;
      frame->format = AV_PIX_FMT_YUV420P;
      frame->pts = first + i;
      check(av_frame_get_buffer(frame, 0), "frame_get_buffer");
      for (int plane = 0; plane < 3; plane++)
        std::fill_n(frame->data[plane], frame->linesize[plane] * (plane ? 32 : 64), uint8_t(128));
      picture.encode(file, frame);
      av_frame_free(&frame);
    }
    picture.encode(file, nullptr);
    encode_sound_track(file, sound, samples, channels);
  }
  close_file(file);
}
