// Sound: of every file that libavformat and libavcodec read, as packets of Opus or AAC-LC, and packets as
// samples. Times are exact to the sample.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fvv::media {

enum class SoundCodec { opus, aac };

constexpr uint32_t opus_rate = 48000;
constexpr uint32_t opus_packet = 960; // samples of the packets that are encoded here: 20 ms
constexpr uint32_t max_sound_channels = 8;

// Bits a second that sound is encoded with by default: 64,000 for one channel, 96,000 for two, 48,000 more
// for each further one.
uint32_t default_sound_bit_rate(uint32_t channels);
// What libopus takes for one channel.
constexpr uint32_t least_sound_bit_rate = 6000, most_sound_bit_rate = 256000;

// How packets are decoded.
struct SoundFormat {
  SoundCodec codec = SoundCodec::opus;
  uint32_t rate = opus_rate; // samples a second
  uint32_t channels = 0;     // 1 to max_sound_channels; Opus: the layouts of RFC 7845 in FFmpeg's order
  uint32_t packet_duration = opus_packet; // samples of every packet
  uint32_t preroll = 0;                   // packets before the one from which on the output is right
  std::vector<uint8_t> record;            // Opus: the header of RFC 7845 clause 5.1; AAC: AudioSpecificConfig

  // Opus: samples that an encoder puts before the sound; 0 for AAC, which does not say.
  uint32_t delay() const;
};

struct SoundPackets {
  SoundFormat format;
  // Time of the first sample that the first packet decodes to, in samples; below 0 for what the encoder puts
  // before the sound. Packet i begins at start + i * packet_duration.
  int64_t start = 0;
  std::vector<std::vector<uint8_t>>
      packets;          // of 1 to 65,535 bytes; none if there is no sound in the requested part
  bool encoded = false; // here; otherwise they are those of the file
  // What the file has besides: seconds of sound before the requested part, and whether there is some more
  // than a tenth of a second after it.
  double before = 0;
  bool goes_on = false;
  std::vector<std::string> warnings; // parts of sentences whose subject is the file

  int64_t end() const { return start + int64_t(packets.size()) * format.packet_duration; }
};

// What a file holds, by its headers.
struct SoundInfo {
  std::string codec; // FFmpeg's name: "pcm_s16le"
  uint32_t rate = 0, channels = 0;
};

struct SoundRequest {
  std::optional<uint32_t> stream; // index among all of the file's streams; nothing: the first sound
  // The part that is needed, in seconds of the file: 0 is the time of the first picture of a video file,
  // otherwise that of the first sample.
  double from = 0, to = 1e9;
  uint32_t bit_rate = 0;     // 0: packets of Opus and AAC-LC are passed on, other sound has the default
  uint32_t max_channels = 2; // of encoded sound; more are mixed down
};

// The first line of defence: Error for a file that cannot be read, is no sound, or has no decoder.
SoundInfo sound_info(const std::string &path, std::optional<uint32_t> stream = {});

// The sound of a file. The name is a file's, never a URL's, and a file that refers to others (a playlist) is
// not followed. Packets of a file are passed on, from the pre-roll of `from` on, if they are Opus or AAC-LC
// and follow each other without a gap; gaps in other sound become silence. Encoded sound has exactly the
// requested part; one of its packets begins where that begins. Error for a file that cannot be read, is cut
// or damaged, has no sound or no decoder.
SoundPackets load_sound(const std::string &path, const SoundRequest &request);

// Interleaved samples, full scale 1, as Opus: packets of 20 ms, the second of which begins at first, the time
// of the first sample. Error for a bit rate that libopus does not take.
SoundPackets encode_sound(const std::vector<float> &samples, uint32_t channels, int64_t first = 0,
                          uint32_t bit_rate = 0);

// Decodes packets one after the other.
class SoundDecoder {
public:
  // Error for a record that the decoder rejects.
  explicit SoundDecoder(const SoundFormat &format);
  ~SoundDecoder();
  SoundDecoder(SoundDecoder &&) noexcept;

  // Appends exactly packet_duration * channels interleaved samples, those too that the encoder put before the
  // sound. Error for a damaged packet and for one of another duration.
  void decode(const void *packet, size_t size, std::vector<float> &samples);
  void decode(const std::vector<uint8_t> &packet, std::vector<float> &samples) {
    decode(packet.data(), packet.size(), samples);
  }

private:
  struct State;
  std::unique_ptr<State> state_;
};

// "opus", "m4a".
const char *sound_extension(SoundCodec codec);
// The bytes of a file with these packets, unchanged: Ogg Opus, or AAC in MP4. load_sound reads the same
// packets from it, the first one beginning at -format.delay(); start is not written. Error for what the
// container cannot hold.
std::string sound_file(const SoundPackets &sound);

// The bytes of a WAV file: 16-bit samples, interleaved.
std::string wav_file(const std::vector<int16_t> &samples, uint32_t channels, uint32_t rate);

} // namespace fvv::media
