// fvvmux/stream_writer.h: the chunks of a plan's stream in their order, through libfvv's writer. Knows what
// stands in the configuration; knows nothing of files to read and of threads.
#pragma once

#include "cli/cli.h"
#include "fvv/container.h"
#include "fvvmux/moving.h"
#include "fvvmux/plan.h"

#include <memory>

namespace fvv::mux {

constexpr uint16_t mesh_track = 1, camera_track = 2, atlas_track = 3, calibration_track = 4,
                   visibility_track = 5, background_track = 6;
// Of a track of Plan::tracks. Further tracks with cameras stand behind all others.
inline uint16_t track_id(const VideoTrack &track) {
  return track.is_atlas() ? atlas_track : track.part ? uint16_t(background_track + track.part) : camera_track;
}

// Every function throws cli::Failure when the output does not take the bytes.
class StreamWriter {
public:
  // Writes file header and configuration. plan and output are borrowed.
  StreamWriter(const Plan &plan, cli::OutputFile &output);

  void repeat_configuration();
  // Frames first ... first + count - 1, one tick each.
  void begin_group(size_t first, size_t count);
  void mesh(size_t frame, const std::vector<uint8_t> &payload, bool key);
  // The calibration of a frame, if any camera moves; key: its group begins. Answers the bytes of payload.
  uint64_t calibration(size_t frame, bool key);
  // The layout of a group, unless it is that of the configuration, in front of the track's first sample.
  // Answers whether there was something to write.
  bool layout(const VideoTrack &track, size_t group);
  // Behind mesh and calibration of the frame.
  void visibility(size_t frame, const std::vector<uint8_t> &payload, bool key);
  void sample(const VideoTrack &track, size_t frame, const media::Sample &sample);
  // The environment, behind the other chunks of a frame, if the plan has one. Answers the bytes of payload.
  uint64_t background(size_t frame);
  void end_group();
  // Index and footer, unless the stream is live. Answers the number of bytes written.
  uint64_t finish();

private:
  void check(fvv_status status);
  void configure(uint32_t type, uint16_t track, const std::vector<uint8_t> &payload);
  void write_configuration();
  void write_video(const VideoTrack &track);
  // Of the plan, by rising identifier.
  std::vector<const VideoTrack *> video_tracks() const;
  void write_video_track(const VideoTrack &track);
  std::vector<uint8_t> layout_record(const std::vector<fvv_tile> &tiles) const;
  void write_track(uint16_t id, uint8_t kind, const std::string &name);

  const Plan &plan;
  cli::OutputFile &output;
  fvv_diagnostic diagnostic = {};
  std::optional<MovingCameras> moving;
  std::unique_ptr<fvv_writer, void (*)(fvv_writer *)> writer;
};

} // namespace fvv::mux
