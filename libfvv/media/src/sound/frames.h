// Samples on their way between decoders and encoders. Internal to fvv_media.
#pragma once

#include "fvv_media/sound.h"
#include "media/src/container/muxer.h"
#include "media/src/ffmpeg.h"

extern "C" {
#include <libswresample/swresample.h>
}

namespace fvv::media {

// Frames of a decoder as interleaved floats of a number of channels and a rate, exactly aligned in time.
class SampleConverter {
public:
  // for_opus: in the order of Opus; otherwise that of FFmpeg's default layouts.
  SampleConverter(uint32_t channels, uint32_t rate, bool for_opus);
  ~SampleConverter();
  SampleConverter(const SampleConverter &) = delete;

  // All frames are alike, otherwise Error, without the name of the file.
  void add(const AVFrame &frame, std::vector<float> &samples);
  // Samples at the rate of the frames, after the first frame.
  void add_silence(int64_t count, std::vector<float> &samples);
  // What the conversion of the rate still holds.
  void finish(std::vector<float> &samples);

private:
  void open(const AVFrame &frame);
  void convert(const uint8_t **in, int count, std::vector<float> &samples);

  const uint32_t channels_, rate_;
  const bool for_opus_;
  SwrContext *swr_ = nullptr;
  int format_ = -1, in_rate_ = 0, in_channels_ = 0;
};

class OpusEncoder {
public:
  // bit_rate 0: the default. Error.
  OpusEncoder(uint32_t channels, uint32_t bit_rate);
  void add(const float *samples, size_t count); // interleaved, a multiple of the channels
  void add_silence(size_t samples);             // of each channel
  // first: time of the first sample.
  SoundPackets finish(int64_t first);

private:
  void encode(const float *samples);

  const uint32_t channels_;
  Context context_;
  AvFrame frame_;
  Packet packet_;
  std::vector<float> pending_;
  std::vector<std::vector<uint8_t>> packets_;
  uint64_t total_ = 0;
};

// A stream of a container for packets of a format; times count in samples.
AVStream *add_sound_stream(Muxer &muxer, const SoundFormat &format);
// The same sound with a record by which a decoder drops all that is before time 0.
SoundFormat skipping(const SoundPackets &sound);
// All packets of sound, the first at time.
void write_sound(Muxer &muxer, const AVStream &stream, const SoundPackets &sound, int64_t time);

} // namespace fvv::media
