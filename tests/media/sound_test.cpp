// fvv_media: sound of files as packets, and back to samples, exact to the sample.
#include "fvv_media/sound.h"

#include "fvv_catch.h"
#include "fvv_cxx/error.h"
#include "make_sound.h"
#include "make_video.h"

#include <algorithm>
#include <cmath>
#include <fstream>

using namespace fvv::media;

namespace {

void write_bytes(const std::string &path, const std::string &bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
}

std::vector<float> decoded(const SoundPackets &sound) {
  SoundDecoder decoder(sound.format);
  std::vector<float> samples;
  for (const std::vector<uint8_t> &packet : sound.packets) decoder.decode(packet, samples);
  return samples;
}

// Where the click that clicks() puts is in decoded sound, in samples of its rate: by correlation.
int64_t click_in(const SoundPackets &sound, int64_t about) {
  return sound.start +
         find_click(decoded(sound), sound.format.channels, sound.format.rate, about - sound.start);
}

std::string error_of(const std::string &path, const SoundRequest &request = {}) {
  try {
    load_sound(path, request);
    return "";
  } catch (const fvv::Error &error) {
    return error.what();
  }
}

} // namespace

TEST_CASE("sound of every kind of file is where it was put") {
  struct Case {
    const char *name, *encoder;
    int rate, channels;
    bool passed_on;
    int64_t tolerance;
  };
  for (const Case &c :
       {Case{"a.wav", "pcm_s16le", 48000, 1, false, 1}, Case{"b.wav", "pcm_f32le", 44100, 2, false, 1},
        Case{"c.flac", "flac", 96000, 2, false, 1}, Case{"d.opus", "libopus", 48000, 2, true, 1},
        Case{"e.mka", "libopus", 48000, 1, true, 48}, Case{"f.m4a", "aac", 44100, 2, true, 1},
        Case{"g.m4a", "aac", 48000, 1, true, 1}, Case{"h.wav", "pcm_u8", 8000, 1, false, 2},
        // The encoder's delay, which a LAME header declares, is before the sound.
        Case{"i.mp3", "libmp3lame", 44100, 2, false, 2}, Case{"j.mp3", "libmp3lame", 48000, 1, false, 2}}) {
    INFO(c.name);
    const double at = 1.2345;
    write_sound(c.name, c.encoder, clicks(c.rate, c.channels, 2.5, {at}), c.channels, c.rate);
    const SoundInfo info = sound_info(c.name);
    CHECK(info.rate == uint32_t(c.rate));
    CHECK(info.channels == uint32_t(c.channels));
    const SoundPackets sound = load_sound(c.name, {});
    CHECK(sound.encoded == !c.passed_on);
    CHECK(sound.warnings.empty());
    CHECK(sound.format.channels == uint32_t(c.channels));
    CHECK(sound.format.rate == uint32_t(c.passed_on ? c.rate : 48000));
    const auto wanted = int64_t(std::llround(at * sound.format.rate));
    CHECK(std::llabs(click_in(sound, wanted) - wanted) <= c.tolerance);
    CHECK(sound.end() >= int64_t(2.5 * sound.format.rate));
    CHECK(sound.end() < int64_t(2.6 * sound.format.rate));
    // The same as an encoder of its own, and by a part.
    SoundRequest request;
    request.bit_rate = 64000;
    request.from = 1;
    request.to = 2;
    const SoundPackets part = load_sound(c.name, request);
    CHECK(part.encoded);
    CHECK(part.start == 48000 - 960);
    CHECK(part.packets.size() == 51);
    CHECK(std::fabs(part.before - 1) < 0.001);
    CHECK(part.goes_on);
    CHECK(!sound.goes_on);
    CHECK(sound.before == 0);
    const auto there = int64_t(std::llround(at * 48000));
    CHECK(std::llabs(click_in(part, there) - there) <= std::max<int64_t>(c.tolerance, 2));
  }
}

TEST_CASE("packets of Opus and AAC survive a file and a decoder in the middle") {
  for (const char *name : {"in.opus", "in.m4a"}) {
    INFO(name);
    const bool is_opus = std::string(name) == "in.opus";
    write_sound(name, is_opus ? "libopus" : "aac", tones(48000, 2, 3), 2, 48000);
    const SoundPackets sound = load_sound(name, {});
    REQUIRE(!sound.encoded);
    CHECK(sound.format.packet_duration == (is_opus ? 960 : 1024));
    CHECK(sound.format.preroll == (is_opus ? 4 : 2));
    const std::string file = std::string("out.") + sound_extension(sound.format.codec);
    write_bytes(file, sound_file(sound));
    CHECK(sound_file(sound) == sound_file(sound));
    const SoundPackets again = load_sound(file, {});
    CHECK(again.packets == sound.packets);
    CHECK(again.format.record == sound.format.record);
    CHECK(again.start == -int64_t(sound.format.delay()));

    // From any packet on: after the pre-roll, the samples are those of decoding everything.
    const std::vector<float> whole = decoded(sound);
    const size_t in_packet = size_t(sound.format.packet_duration) * sound.format.channels;
    for (const size_t first : {size_t(1), size_t(20), size_t(77)}) {
      SoundPackets part = sound;
      part.packets.erase(part.packets.begin(), part.packets.begin() + std::ptrdiff_t(first));
      const std::vector<float> samples = decoded(part);
      double signal = 0, noise = 0;
      for (size_t i = part.format.preroll * in_packet; i < samples.size(); i++) {
        const double wanted = whole[i + first * in_packet];
        signal += wanted * wanted;
        noise += (samples[i] - wanted) * (samples[i] - wanted);
      }
      const double snr = 10 * std::log10(signal / std::max(noise, 1e-30));
      INFO("from packet " << first << ": " << snr << " dB");
      CHECK(snr > (is_opus ? 35 : 100));
    }

    SoundRequest request;
    request.from = 1;
    request.to = 2;
    const SoundPackets part = load_sound(name, request);
    const int64_t duration = part.format.packet_duration;
    CHECK(part.start + int64_t(part.format.preroll) * duration <= 48000);
    CHECK(part.start + int64_t(part.format.preroll + 1) * duration > 48000);
    CHECK(part.end() >= 96000);
    CHECK(part.end() - duration < 96000);
    CHECK((part.start - sound.start) % duration == 0);
    const auto offset = size_t((part.start - sound.start) / duration);
    CHECK(part.packets[0] == sound.packets[offset]);
  }
}

TEST_CASE("the sound of a video counts from its first picture") {
  Clip clip;
  clip.times = steady(40, 3600);
  write_video("silent.mp4", clip);
  CHECK(error_of("silent.mp4") == "silent.mp4: has no sound stream");
  write_video_with_sound("spoken.mkv", 0.48, clicks(48000, 1, 2, {1.25}), 1, 48000);
  const SoundPackets sound = load_sound("spoken.mkv", {});
  const auto wanted = int64_t(std::llround((1.25 - 0.48) * 48000));
  CHECK(std::llabs(click_in(sound, wanted) - wanted) <= 48);
}

TEST_CASE("more channels than asked for are mixed down") {
  write_sound("six.wav", "pcm_s16le", tones(48000, 6, 1), 6, 48000);
  const SoundPackets two = load_sound("six.wav", {});
  CHECK(two.format.channels == 2);
  REQUIRE(two.warnings.size() == 1);
  CHECK(two.warnings[0] == "has 6 channels, which are mixed to 2");
  SoundRequest request;
  request.max_channels = 8;
  const SoundPackets six = load_sound("six.wav", request);
  CHECK(six.format.channels == 6);
  CHECK(decoded(six).size() == six.packets.size() * 960 * 6);
  request.max_channels = 1;
  CHECK(load_sound("six.wav", request).format.channels == 1);
}

TEST_CASE("files without sound, damaged and odd ones are refused") {
  CHECK(error_of("none.wav").find("none.wav: ") == 0);
  write_bytes("text.wav", "this is not sound, whatever its name is");
  CHECK(error_of("text.wav").find("text.wav: is no sound file, or is cut or damaged") == 0);
  write_bytes("list.m3u8", "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\na.ts\n");
  CHECK(error_of("list.m3u8").find("is a list of other files") != std::string::npos);
  write_sound("whole.flac", "flac", tones(48000, 2, 2), 2, 48000);
  std::ifstream in("whole.flac", std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), {}};
  bytes[bytes.size() / 2] = char(bytes[bytes.size() / 2] ^ 0x55);
  write_bytes("damaged.flac", bytes);
  CHECK(error_of("damaged.flac").find("damaged.flac: ") == 0);
  SoundRequest request;
  request.bit_rate = 1000;
  CHECK(error_of("whole.flac", request) ==
        "expected a bit rate of sound from 12000 to 512000 bit/s for 2 channels, found 1000");
  request.bit_rate = 0;
  request.stream = 3;
  CHECK(error_of("whole.flac", request) == "whole.flac: has 1 streams, stream 3 is not among them");
}

TEST_CASE("a WAV file of unknown length ends where it ends") {
  write_sound("known.wav", "pcm_s16le", clicks(44100, 1, 1, {0.5}), 1, 44100);
  std::ifstream in("known.wav", std::ios::binary);
  const std::string known((std::istreambuf_iterator<char>(in)), {});
  const size_t data = known.find("data");
  REQUIRE(data != std::string::npos);
  const auto with_lengths = [&](uint32_t riff, uint32_t samples) {
    std::string bytes = known;
    for (int i = 0; i < 4; i++) {
      bytes[size_t(4 + i)] = char(riff >> 8 * i);
      bytes[data + 4 + size_t(i)] = char(samples >> 8 * i);
    }
    return bytes;
  };
  // ffmpeg, arecord and sox to a pipe; and a program that was ended.
  for (const auto &[riff, samples] :
       {std::pair(0xffffffffu, 0xffffffffu), std::pair(0x80000024u, 0x80000000u),
        std::pair(0x7ffff024u, 0x7ffff000u), std::pair(0u, 0u)}) {
    INFO(riff);
    write_bytes("unknown.wav", with_lengths(riff, samples));
    const SoundPackets sound = load_sound("unknown.wav", {});
    CHECK(std::llabs(click_in(sound, 24000) - 24000) <= 1);
    CHECK(sound.end() >= 48000);
  }
  const auto size = uint32_t(known.size());
  write_bytes("cut.wav", with_lengths(size, size).substr(0, size - 1001));
  CHECK(!error_of("cut.wav").empty());
}

TEST_CASE("a rate at which few bytes are hours of sound is refused") {
  for (const uint32_t rate : {1u, 999u, 768001u}) {
    std::string bytes = wav_file(std::vector<int16_t>(4096), 1, 48000);
    for (int i = 0; i < 4; i++) bytes[size_t(24 + i)] = char(rate >> 8 * i);
    write_bytes("rate.wav", bytes);
    CHECK(error_of("rate.wav").find("expected 1 to 64 channels at 1000 to 768000 Hz") != std::string::npos);
  }
}

TEST_CASE("a damaged packet is an error, never other samples") {
  const SoundPackets sound = encode_sound(tones(48000, 1, 1), 1);
  CHECK(sound.start == -960);
  SoundDecoder decoder(sound.format);
  std::vector<float> samples;
  CHECK_THROWS_AS(decoder.decode(nullptr, 0, samples), fvv::Error);
  const std::vector<uint8_t> odd = {0x03, 0x00}; // code 3 with no frame
  CHECK_THROWS_AS(decoder.decode(odd, samples), fvv::Error);
  CHECK(samples.empty());
  decoder.decode(sound.packets[3], samples);
  CHECK(samples.size() == 960);
  SoundFormat other = sound.format;
  other.packet_duration = 480;
  CHECK_THROWS_AS(SoundDecoder(other).decode(sound.packets[3], samples), fvv::Error);
}

TEST_CASE("Opus takes the bit rate that it is given") {
  const std::vector<float> samples = tones(48000, 2, 10);
  for (const uint32_t rate : {32000u, 96000u, 192000u}) {
    size_t bytes = 0;
    const SoundPackets sound = encode_sound(samples, 2, 0, rate);
    for (const std::vector<uint8_t> &packet : sound.packets) bytes += packet.size();
    const double got = double(bytes) * 8 / 10;
    INFO(rate << " bit/s: " << got);
    CHECK(got < 1.25 * rate);
    CHECK(got > 0.4 * rate);
  }
}

TEST_CASE("channels come back in their order") {
  // FFmpeg 5 confuses the channels of 5.0, and has no layout of 7 channels that libopus takes.
  for (const uint32_t channels : {1u, 2u, 3u, 4u, 6u, 8u}) {
    CAPTURE(channels);
    // A burst of 60 Hz, which an LFE channel keeps too, in one channel after the other.
    constexpr size_t burst = 9600;
    std::vector<float> samples(channels * channels * burst);
    for (size_t i = 0; i < channels * burst; i++)
      samples[i * channels + i / burst] =
          float(0.5 * std::sin(double(i % burst) * 2 * 3.14159265 * 60 / 48000));
    const SoundPackets sound = encode_sound(samples, channels, 960);
    CHECK(sound.format.channels == channels);
    const std::vector<float> back = decoded(sound);
    for (size_t i = 0; i < channels; i++) {
      std::vector<double> power(channels);
      // The second packet begins with the first sample.
      for (size_t k = i * burst + burst / 4; k < i * burst + burst / 2; k++)
        for (size_t c = 0; c < channels; c++) power[c] += std::pow(back[(k + 960) * channels + c], 2);
      CHECK(std::max_element(power.begin(), power.end()) - power.begin() == std::ptrdiff_t(i));
    }
  }
}
