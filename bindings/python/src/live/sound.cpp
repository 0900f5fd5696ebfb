#include "live/sound.h"

#include "fvv_cxx/error.h"
#include "fvv_demux/sounds.h"

#include <algorithm>
#include <cmath>

namespace fvv::python {

void LiveSounds::begin_group(int64_t start, int64_t end) {
  group_start = start;
  group_end = end;
  for (auto &[id, track] : tracks) {
    track.place = {};
    track.in_group = false;
  }
}

std::optional<LiveSound> LiveSounds::decode(const fvv_frame_chunk &chunk) {
  const uint16_t id = chunk.header.track;
  const fvv_audio_config *config = fvv_configuration_audio(&configuration, id);
  if (!config) return std::nullopt;
  const auto size = size_t(chunk.header.size);
  std::vector<fvv_audio_packet> packets(size / 3 + 1);
  fvv_audio_chunk sound;
  fvv_diagnostic diagnostic = {};
  const auto call = [&](fvv_status status) {
    diagnostic.offset += chunk.offset;
    require(status, diagnostic, file);
  };
  call(fvv_audio_decode(config, chunk.payload, size, &sound, packets.data(), packets.size(), &diagnostic));
  Track &track = tracks[id];
  call(fvv_audio_follow(&track.place, config, configuration.scene.time_base, &sound,
                        chunk.header.flags & FVV_FLAG_KEY, chunk.header.time, group_end, &diagnostic));
  try {
    const media::SoundFormat format = demux::sound_format(*config);
    const int64_t duration = config->packet_duration;
    const bool follows = track.decoder && sound.start + int64_t(sound.preroll_count) * duration == track.end;
    if (!follows) {
      const fvv_rational base = configuration.scene.time_base;
      const double begin = double(group_start) * base.numerator / base.denominator * format.rate;
      track.decoder.emplace(format);
      track.end = sound.start;
      // A group repeats what its first chunk needs; after a gap within it the decoder begins in the sound.
      track.heard =
          track.in_group ? sound.start + int64_t(config->preroll) * duration : int64_t(std::llround(begin));
    }
    track.in_group = true;
    LiveSound out;
    out.track = id;
    out.rate = format.rate;
    out.channels = format.channels;
    out.start = track.end;
    for (uint32_t i = follows ? sound.preroll_count : 0; i < sound.packet_count; i++) {
      track.decoder->decode(packets[i].data, packets[i].size, out.samples);
      track.end += duration;
    }
    const int64_t early = std::clamp<int64_t>(track.heard - out.start, 0, track.end - out.start);
    out.samples.erase(out.samples.begin(),
                      out.samples.begin() + std::ptrdiff_t(early) * std::ptrdiff_t(out.channels));
    out.start += early;
    if (config->flags & FVV_AUDIO_PLACED) {
      const double *place = config->flags & FVV_AUDIO_MOVES ? sound.position : config->position;
      out.position = {place[0], place[1], place[2]};
    }
    if (out.samples.empty()) return std::nullopt;
    return out;
  } catch (const Error &error) {
    track.decoder.reset();
    throw Failure(fvv_audio_codec_known(config->codec) ? FVV_ERROR_DAMAGED : FVV_ERROR_UNSUPPORTED,
                  "track " + std::to_string(id) + ": " + error.what(), file);
  }
}

} // namespace fvv::python
