#include "mux/src/sound/sound.h"
#include "fvv_cxx/format.h"
#include "fvv_cxx/owned.h"
#include "fvv_scene/file_io.h"

#include <algorithm>
#include <cmath>

namespace fvv::mux {

namespace {

__extension__ using Wide = __int128; // products of times and rates

constexpr double chunk_seconds = 0.25;

// The first sample that is not before a tick.
int64_t sample_at(const SoundTrack &track, const fvv_rational &frame, int64_t tick) {
  const Wide samples = Wide(tick) * frame.numerator * track.packets.format.rate;
  return int64_t((samples + frame.denominator - 1) / frame.denominator); // ticks are not negative
}

// The last tick that is not after a sample.
int64_t tick_of(const SoundTrack &track, const fvv_rational &frame, int64_t sample) {
  return int64_t(Wide(sample) * frame.denominator / (Wide(frame.numerator) * track.packets.format.rate));
}

// Time of the capture's first frame in the file, as a fraction.
struct FileTime {
  Wide numerator, denominator;

  double seconds() const { return double(numerator) / double(denominator); }
  int64_t samples(uint32_t rate) const { // rounded
    const Wide twice = 2 * numerator * rate + denominator;
    const Wide whole = twice / (2 * denominator);
    return int64_t(whole * 2 * denominator > twice ? whole - 1 : whole);
  }
};

FileTime begin_in_file(const scene::Capture &capture, const scene::SoundSource &source) {
  const fvv_rational &frame = capture.frame_duration;
  const int64_t frames = (capture.frames.first - source.first) / capture.frames.step;
  return {Wide(source.offset.numerator) * frame.denominator +
              Wide(frames) * frame.numerator * source.offset.denominator,
          Wide(source.offset.denominator) * frame.denominator};
}

// Error unless libopus takes the bit rate for this file.
void check_bit_rate(const Options &options, const std::string &path, const media::SoundRequest &request) {
  if (!options.sound_bit_rate) return;
  const uint32_t channels = std::min(media::sound_info(path, request.stream).channels, request.max_channels);
  const uint32_t least = media::least_sound_bit_rate * channels, most = media::most_sound_bit_rate * channels;
  if (options.sound_bit_rate < least || options.sound_bit_rate > most)
    throw Error(option_name("sound-bitrate") + ": expected " + std::to_string(least) + " to " +
                    std::to_string(most) + " bit/s for the " + std::to_string(channels) +
                    (channels == 1 ? " channel" : " channels") + " of " + path + ", found " +
                    std::to_string(options.sound_bit_rate),
                Error::usage);
}

// Packets are kept until their groups are written: of the largest bit rate, as a file's own are passed on.
void check_sound_memory(const std::string &path, const media::SoundRequest &request, double duration,
                        const media::MemoryLimit &limit) {
  const uint32_t channels = media::sound_info(path, request.stream).channels;
  const double bytes = duration * media::most_sound_bit_rate / 8 * channels;
  media::check_memory(path + ": decoding " + fvv::format("%.3g s", duration) + " of sound in " +
                          std::to_string(channels) + (channels == 1 ? " channel" : " channels"),
                      uint64_t(std::min(bytes, 1e18)), limit);
}

std::string seconds_text(double seconds) {
  return fvv::format("%.3g s", seconds);
}

} // namespace

SoundInput sound_of_samples(const std::vector<float> &samples, uint32_t channels, double start,
                            uint32_t bit_rate) {
  const double first = start * media::opus_rate;
  if (!(std::abs(first) < 1e15))
    throw Error("sound: start: expected seconds, found " + std::to_string(start), Error::usage);
  try {
    SoundInput out;
    out.packets = std::make_shared<const media::SoundPackets>(
        media::encode_sound(samples, channels, int64_t(std::llround(first)), bit_rate));
    return out;
  } catch (const Error &error) {
    throw Error(error.what(), Error::usage);
  }
}

SoundInput sound_of_file(const std::string &path) {
  SoundInput out;
  out.packets = std::make_shared<const media::SoundPackets>(media::load_sound(path, {}));
  return out;
}

std::vector<scene::SoundSource> sounds_of(const std::vector<SoundInput> &inputs) {
  if (inputs.size() > scene::max_sounds)
    throw Error("encoder: expected at most " + std::to_string(scene::max_sounds) + " sounds, found " +
                    std::to_string(inputs.size()),
                Error::usage);
  std::vector<scene::SoundSource> out;
  for (const SoundInput &input : inputs) {
    scene::SoundSource sound;
    sound.file = "sound " + std::to_string(out.size());
    sound.title = input.title;
    sound.language = input.language;
    sound.position = input.position;
    for (size_t i = 0; i < input.per_frame.size(); i++) sound.per_frame[int64_t(i)] = input.per_frame[i];
    sound.memory = input.packets;
    if (!input.packets || input.packets->packets.empty())
      throw Error("encoder: " + sound.file + ": expected packets, found none", Error::usage);
    if (!input.language.empty() && !scene::is_language(input.language))
      throw Error("encoder: " + sound.file + ": language: expected a tag such as en or pt-BR, found " +
                      scene::quote(input.language),
                  Error::usage);
    out.push_back(std::move(sound));
  }
  return out;
}

bool load_sounds(Plan &plan) {
  const scene::Capture &capture = plan.capture;
  const fvv_rational &frame = capture.frame_duration;
  const double frame_seconds = double(frame.numerator) / frame.denominator;
  const double duration = double(plan.end()) * frame_seconds;
  bool warned = false;
  const auto warn = [&](const std::string &file, const std::string &what) {
    plan.observer.warn(capture.path + ": audio: " + file + ": " + what);
    warned = true;
  };
  for (const scene::SoundSource &source : capture.sounds) {
    plan.observer.check_cancelled();
    if (source.memory) {
      // How long the stream becomes is not known yet: groups take what falls into them.
      plan.sounds.push_back({source, *source.memory});
      continue;
    }
    const std::string path = capture.resolve(source.file);
    const FileTime begin = begin_in_file(capture, source);
    media::SoundRequest request;
    request.stream = source.stream;
    request.from = begin.seconds();
    request.to = request.from + duration;
    request.bit_rate = plan.options.sound_bit_rate;
    request.max_channels = source.is_placed() ? 1 : plan.options.sound_channels;
    check_bit_rate(plan.options, path, request);
    check_sound_memory(path, request, duration, capture.memory_limit);
    SoundTrack track = {source, media::load_sound(path, request)};
    for (const std::string &warning : track.packets.warnings) warn(source.file, warning);
    track.packets.start -= begin.samples(track.packets.format.rate);
    if (track.packets.end() <= 0 || track.packets.packets.empty()) {
      warn(source.file, "has no sound at the time of the frames and is left out");
      continue;
    }
    // As pictures that no frame has: intended if the user chose the frames.
    if (!plan.options.frames && track.packets.before > frame_seconds)
      warn(source.file, seconds_text(track.packets.before) + " of sound before the first frame are not used");
    if (!plan.options.frames && track.packets.goes_on)
      warn(source.file, "its sound goes on after the last frame and is cut there");
    plan.sounds.push_back(std::move(track));
  }
  return warned;
}

bool warn_of_lost_sound(const Plan &plan) {
  constexpr double most = 0.1; // seconds, as of files
  const fvv_rational &frame = plan.capture.frame_duration;
  const double end = double(plan.end()) * frame.numerator / frame.denominator;
  bool warned = false;
  for (const SoundTrack &track : plan.sounds) {
    if (!track.source.memory) continue;
    const double rate = track.packets.format.rate;
    const bool none = track.packets.end() <= 0 || double(track.packets.start) / rate >= end;
    if (!none && double(track.packets.end()) / rate <= end + most) continue;
    plan.observer.warn(plan.capture.path + ": audio: " + track.source.file + ": " +
                       (none ? "has no sound at the time of the frames"
                             : "its sound goes on after the last frame and is cut there"));
    warned = true;
  }
  return warned;
}

fvv_audio_config config_of(const SoundTrack &track) {
  const media::SoundFormat &format = track.packets.format;
  fvv_audio_config config = {};
  config.codec = format.codec == media::SoundCodec::opus ? FVV_CODEC_OPUS : FVV_CODEC_MP4A;
  config.channels = uint8_t(format.channels);
  config.packet_duration = format.packet_duration;
  config.preroll = format.preroll;
  config.record = format.record.data();
  config.record_size = format.record.size();
  config.language = track.source.language.data();
  config.language_size = track.source.language.size();
  const bool moves = !track.source.per_frame.empty();
  if (!track.source.is_placed()) return config;
  config.flags = uint8_t(FVV_AUDIO_PLACED | (moves ? FVV_AUDIO_MOVES : 0));
  const scene::Place place = moves ? track.source.per_frame.begin()->second : *track.source.position;
  std::copy(place.begin(), place.end(), config.position);
  return config;
}

fvv_rational time_base_of(const SoundTrack &track) {
  return {1, track.packets.format.rate};
}

uint32_t bit_rate_of(const SoundTrack &track) {
  uint64_t bytes = 0;
  for (const std::vector<uint8_t> &packet : track.packets.packets) bytes += packet.size();
  const double seconds = double(track.packets.end() - track.packets.start) / track.packets.format.rate;
  return uint32_t(std::lround(double(bytes) * 8 / seconds));
}

const char *sound_codec_text(const SoundTrack &track) {
  return track.packets.format.codec == media::SoundCodec::opus ? "Opus" : "AAC";
}

SoundSpan span_of(const Plan &plan, const SoundTrack &track) {
  const double rate = track.packets.format.rate;
  const int64_t end = sample_at(track, plan.capture.frame_duration, plan.end());
  return {double(std::max<int64_t>(track.packets.start, 0)) / rate,
          double(std::min<int64_t>(track.packets.end(), end)) / rate};
}

namespace {

// The chunks of one track in one group.
class GroupSound {
public:
  GroupSound(const Plan &chosen, size_t number, std::vector<SoundChunk> &to)
      : plan(chosen), index(number), track(chosen.sounds[number]), out(to) {}

  void run(const GroupSpan &group) {
    const fvv_rational &frame = plan.capture.frame_duration;
    const size_t first = packet_from(sample_at(track, frame, group.start)),
                 last = packet_from(sample_at(track, frame, group.end));
    for (size_t from = first; from < last;) {
      const size_t to =
          std::min(last, track.source.per_frame.empty() ? from + in_chunk() : end_of_frame(from, group));
      write(from, to, from == first, group);
      from = to;
    }
  }

private:
  // The first packet that begins at or after a sample.
  size_t packet_from(int64_t sample) const {
    const media::SoundPackets &packets = track.packets;
    const int64_t duration = packets.format.packet_duration, since = sample - packets.start;
    return since <= 0 ? 0
                      : size_t(std::min((since + duration - 1) / duration, int64_t(packets.packets.size())));
  }

  size_t in_chunk() const {
    const media::SoundFormat &format = track.packets.format;
    return size_t(std::max(1.0, std::floor(chunk_seconds * format.rate / format.packet_duration)));
  }

  int64_t time_of(size_t packet) const {
    return track.packets.start + int64_t(packet) * track.packets.format.packet_duration;
  }

  // The frame of the group that is shown when a packet begins; the first one before that.
  size_t frame_at(size_t packet, const GroupSpan &group) const {
    const int64_t tick = tick_of(track, plan.capture.frame_duration, time_of(packet));
    size_t frame = group.first;
    while (frame + 1 < group.first + group.count && plan.tick_of(frame + 1) <= tick) frame++;
    return frame;
  }

  // The packet after those that begin within the frame of this one.
  size_t end_of_frame(size_t packet, const GroupSpan &group) const {
    const size_t frame = frame_at(packet, group);
    if (frame + 1 >= group.first + group.count) return track.packets.packets.size();
    return packet_from(sample_at(track, plan.capture.frame_duration, plan.tick_of(frame + 1)));
  }

  void write(size_t from, size_t to, bool key, const GroupSpan &group) {
    const fvv_audio_config config = config_of(track);
    // Those that the decoder needs to be right where the group begins, which the packet before may reach
    // beyond.
    size_t begin = from;
    if (key) {
      const bool reaches = from && time_of(from) > sample_at(track, plan.capture.frame_duration, group.start);
      begin = from - std::min<size_t>(from, config.preroll + reaches);
    }
    std::vector<fvv_audio_packet> packets;
    for (size_t i = begin; i < to; i++)
      packets.push_back({track.packets.packets[i].data(), track.packets.packets[i].size()});
    fvv_audio_chunk chunk = {};
    chunk.start = time_of(begin);
    chunk.packet_count = uint32_t(to - begin);
    chunk.preroll_count = uint32_t(from - begin);
    if (config.flags & FVV_AUDIO_MOVES) {
      const scene::Place place =
          track.source.position_at(plan.capture.frames.number(int64_t(frame_at(from, group))));
      std::copy(place.begin(), place.end(), chunk.position);
    }
    SoundChunk made = {
        index, tick_of(track, plan.capture.frame_duration, time_of(from)), key, uint32_t(to - from), {}};
    size_t size = 0;
    fvv_diagnostic diagnostic = {};
    fvv_status status = fvv_audio_encode(&config, &chunk, packets.data(), nullptr, 0, &size, &diagnostic);
    if (status == FVV_ERROR_BUFFER_TOO_SMALL) {
      made.payload.resize(size);
      status =
          fvv_audio_encode(&config, &chunk, packets.data(), made.payload.data(), size, &size, &diagnostic);
    }
    fvv::check(status, plan.capture.resolve(track.source.file), diagnostic);
    out.push_back(std::move(made));
  }

  const Plan &plan;
  const size_t index;
  const SoundTrack &track;
  std::vector<SoundChunk> &out;
};

} // namespace

std::vector<SoundChunk> sound_chunks(const Plan &plan, const GroupSpan &group) {
  std::vector<SoundChunk> out;
  for (size_t i = 0; i < plan.sounds.size(); i++) GroupSound(plan, i, out).run(group);
  std::stable_sort(out.begin(), out.end(), [](const auto &a, const auto &b) { return a.time < b.time; });
  return out;
}

} // namespace fvv::mux
