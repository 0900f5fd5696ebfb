#include "fvv_demux/sounds.h"
#include "fvv_cxx/error.h"
#include "fvv_demux/frame_plan.h"

#include <algorithm>
#include <memory>

namespace fvv::demux {

scene::Place UnpackedSound::position_at(int64_t tick) const {
  if (places.empty()) return position.value_or(scene::Place{});
  const auto after = places.lower_bound(tick);
  if (after == places.end()) return places.rbegin()->second;
  if (after->first == tick || after == places.begin()) return after->second;
  const auto before = std::prev(after);
  const double part = double(tick - before->first) / double(after->first - before->first);
  scene::Place out;
  for (size_t k = 0; k < out.size(); k++)
    out[k] = before->second[k] + part * (after->second[k] - before->second[k]);
  return out;
}

media::SoundFormat sound_format(const fvv_audio_config &config) {
  if (!fvv_audio_codec_known(config.codec)) throw Error("the codec of the sound is not known");
  media::SoundFormat out;
  out.codec = config.codec == FVV_CODEC_OPUS ? media::SoundCodec::opus : media::SoundCodec::aac;
  out.rate = fvv_audio_sample_rate(&config);
  out.channels = config.channels;
  out.packet_duration = config.packet_duration;
  out.preroll = config.preroll;
  out.record.assign(config.record, config.record + config.record_size);
  return out;
}

namespace {

// What one track has become so far.
class TrackSound {
public:
  TrackSound(const fvv_configuration &configuration, const fvv_audio_layout &layout) : config(layout.config) {
    start_.track = layout.track;
    start_.packets.format = sound_format(config);
    const fvv_track *track = fvv_configuration_track(&configuration, layout.track);
    if (track && track->name_size) start_.title.assign(track->name, track->name_size);
    if (config.language_size) start_.language.assign(config.language, config.language_size);
    if (config.flags & FVV_AUDIO_PLACED && !(config.flags & FVV_AUDIO_MOVES))
      start_.position = {config.position[0], config.position[1], config.position[2]};
  }

  void take(const fvv_chunk_info &info, const uint8_t *payload) {
    std::vector<fvv_audio_packet> packets(info.size / 3 + 1);
    fvv_audio_chunk chunk;
    fvv_diagnostic diagnostic = {};
    fvv::check(fvv_audio_decode(&config, payload, size_t(info.size), &chunk, packets.data(), packets.size(),
                                &diagnostic),
               "", diagnostic);
    const int64_t duration = config.packet_duration;
    const bool follows =
        !runs.empty() && chunk.start + int64_t(chunk.preroll_count) * duration == runs.back().packets.end();
    if (!follows) {
      runs.push_back(start_);
      runs.back().packets.start = chunk.start;
    }
    UnpackedSound &run = runs.back();
    for (uint32_t i = follows ? chunk.preroll_count : 0; i < chunk.packet_count; i++)
      run.packets.packets.emplace_back(packets[i].data, packets[i].data + packets[i].size);
    if (config.flags & FVV_AUDIO_MOVES)
      run.places[info.time] = {chunk.position[0], chunk.position[1], chunk.position[2]};
  }

  std::vector<UnpackedSound> runs;

private:
  const fvv_audio_config config; // borrows from the configuration
  UnpackedSound start_;          // a run without packets
};

} // namespace

UnpackedSounds unpack_sounds(const InputFile &input, size_t first, size_t last, const fvv_limits *limits) {
  UnpackedSounds out;
  const Stream stream = open_stream(input, limits);
  const fvv_configuration *configuration = nullptr;
  fvv_diagnostic diagnostic = {};
  if (fvv_stream_configuration(stream.get(), first, &configuration, &diagnostic) != FVV_OK) return out;
  if (!configuration->sound_count) return out;
  std::map<uint16_t, TrackSound> tracks;
  for (size_t i = 0; i < configuration->sound_count; i++) {
    const fvv_audio_layout &layout = configuration->sounds[i];
    if (fvv_audio_codec_known(layout.config.codec))
      tracks.try_emplace(layout.track, *configuration, layout);
    else
      out.losses.push_back("track " + std::to_string(layout.track) + ": the codec of the sound is not known");
  }
  const auto lose = [&](const std::string &what) { out.losses.push_back("sound is lost: " + what); };
  for (size_t group = first; group <= last && group < fvv_stream_group_count(stream.get()); group++) {
    const fvv_chunk_info *chunks = nullptr;
    size_t count = 0;
    diagnostic = {};
    if (fvv_stream_group_chunks(stream.get(), group, &chunks, &count, &diagnostic) < 0) {
      lose(text_of(diagnostic));
      continue;
    }
    for (size_t i = 0; i < count; i++) {
      const auto track = tracks.find(chunks[i].track);
      if (chunks[i].type != FVV_CHUNK_AUDIO || track == tracks.end()) continue;
      const uint8_t *payload = nullptr;
      diagnostic = {};
      if (fvv_stream_read_chunk(stream.get(), &chunks[i], &payload, &diagnostic) < 0) {
        lose(text_of(diagnostic));
        continue;
      }
      try {
        track->second.take(chunks[i], payload);
      } catch (const Error &error) {
        lose(error.what());
      }
    }
  }
  for (auto &[id, track] : tracks)
    for (UnpackedSound &run : track.runs) out.sounds.push_back(std::move(run));
  return out;
}

} // namespace fvv::demux
