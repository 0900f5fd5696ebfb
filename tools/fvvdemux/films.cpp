#include "fvvdemux/films.h"

#include "fvv_demux/views.h"
#include "fvv_media/movie.h"

#include <algorithm>
#include <vector>

namespace fvv::demux {

namespace {

bool is_film(const fvv_video_config &config) {
  return config.codec == FVV_CODEC_AVC1 || config.codec == FVV_CODEC_HVC1;
}

// One description holds for a whole film.
bool is_same(const fvv_video_config &a, const fvv_video_config &b) {
  return a.codec == b.codec && a.width == b.width && a.height == b.height &&
         std::equal(a.record, a.record + a.record_size, b.record, b.record + b.record_size);
}

// A track as the first group has it. Owns its record: configurations do not stay in memory.
struct Track {
  uint16_t id;
  fvv_video_config config;
  std::vector<uint8_t> record;
  fvv_rational tick;
  int64_t frame_duration;
};

class Films {
public:
  Films(fvv_stream *opened, const std::string &name, const Plan &chosen, const Options &wanted, Result &out)
      : stream(opened), file(name), plan(chosen), options(wanted), result(out) {}

  // Of the first group that can be read.
  std::vector<Track> tracks() const {
    std::vector<Track> out;
    for (size_t i = 0; i < plan.groups.size() && out.empty(); i++)
      if (const fvv_configuration *found = configuration_of(plan.groups[i]))
        for (const VideoViews &one : views_of(*found, options.rung, options.cameras, nullptr)) {
          const fvv_video_config &config = one.video->config;
          out.push_back({one.video->track,
                         config,
                         {config.record, config.record + config.record_size},
                         found->scene.time_base,
                         found->scene.frame_duration});
          out.back().config.codec_string = nullptr;
        }
    for (Track &track : out) track.config.record = track.record.data();
    return out;
  }

  // The bytes of the film, or none, with a warning.
  std::string film(const Track &video) {
    const std::string track = "track " + std::to_string(video.id);
    if (!is_film(video.config)) {
      const media::VideoCodec *codec = media::find_video_codec(video.config.codec);
      return warn(track + " is in " + (codec ? codec->name : "an unknown codec") + ", not in H.264 or HEVC");
    }
    std::vector<media::TimedSample> samples;
    uint64_t bytes = 0;
    for (const GroupPlan &group : plan.groups) {
      const fvv_configuration *configuration = configuration_of(group);
      if (!configuration) continue; // its frames are lost, which is said
      const fvv_video_layout *now = nullptr;
      for (const VideoViews &one : views_of(*configuration, options.rung, options.cameras, nullptr))
        if (one.video->track == video.id) now = one.video;
      if (!now) continue;
      const fvv_rational &a = configuration->scene.time_base, &b = video.tick;
      if (!is_same(now->config, video.config) || a.numerator != b.numerator || a.denominator != b.denominator)
        return warn(track + " changes its form within the stream");
      if (!append(group, video.id, video.frame_duration, samples, bytes))
        result.losses.push_back(file + ": " + track + ": the film lacks frames from group " +
                                std::to_string(group.group) + " on to the next group");
    }
    if (samples.empty()) return warn(track + " has no frames");
    return media::movie_file(video.config, video.tick, samples);
  }

private:
  std::string warn(const std::string &why) {
    result.warnings.push_back("no MP4: " + why);
    return "";
  }

  const fvv_configuration *configuration_of(const GroupPlan &group) const {
    const fvv_configuration *out = nullptr;
    return fvv_stream_configuration(stream, group.group, &out, nullptr) == FVV_OK ? out : nullptr;
  }

  // Up to the first sample that is lost: later ones need it. Returns whether there is none.
  bool append(const GroupPlan &group, uint16_t track, int64_t duration,
              std::vector<media::TimedSample> &samples, uint64_t &bytes) const {
    for (int64_t i = 0; i < group.count; i++) {
      const size_t frame = group.frame + size_t(i);
      fvv_frame info;
      const uint8_t *data;
      size_t size;
      int key = 0;
      // Beyond the frames that a damaged group still has come those of the next.
      if (fvv_stream_frame(stream, frame, &info, nullptr) < 0 || info.group != group.group) return false;
      const fvv_status status = fvv_stream_sample(stream, frame, track, &data, &size, &key, nullptr);
      if (status == FVV_END) continue;
      if (status < 0) return false;
      bytes += size;
      media::check_memory("a film of track " + std::to_string(track), bytes, options.memory);
      // A picture is shown until the next.
      if (!samples.empty())
        samples.back().duration = int64_t(uint64_t(info.time) - uint64_t(samples.back().time));
      samples.push_back({{data, data + size}, key != 0, info.time, duration});
    }
    return true;
  }

  fvv_stream *stream;
  const std::string &file;
  const Plan &plan;
  const Options &options;
  Result &result;
};

} // namespace

void check_whole_groups(const Plan &plan, const Selection &frames) {
  for (const GroupPlan &group : plan.groups) {
    const int64_t last = group.number + group.count - 1;
    const auto chosen = frames.within(group.number, last);
    if (chosen.size() != 1 || chosen[0].first != group.number || chosen[0].last != last)
      throw Error("--frames: with --mp4 expected whole groups; frames " + std::to_string(group.number) + "-" +
                      std::to_string(last) + " are one",
                  Error::usage);
  }
}

uint64_t write_films(fvv_stream *stream, const std::string &file, const Plan &plan, const Options &options,
                     cli::OutputFolder &folder, Result &result) {
  Films films(stream, file, plan, options, result);
  uint64_t count = 0;
  for (const Track &track : films.tracks()) {
    const std::string bytes = films.film(track);
    if (bytes.empty()) continue;
    folder.write("video/" + std::to_string(track.id) + ".mp4", bytes);
    count++;
  }
  return count;
}

} // namespace fvv::demux
