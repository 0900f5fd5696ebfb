// The chunks of a plan's stream in their order, through libfvv's writer, with the calibration track of
// cameras that move.
#pragma once

#include "fvv/container.h"
#include "fvv_cxx/error.h"
#include "fvv_cxx/owned.h"
#include "fvv_mux/report.h"
#include "fvv_scene/capture.h"
#include "mux/src/choose/decisions.h"
#include "mux/src/data/data_tracks.h"
#include "mux/src/sound/sound.h"

#include <map>
#include <memory>
#include <optional>

namespace fvv::mux {

// Pixels by which the steps of a calibration may move a point of a picture, for all but the centre, which is
// off by less than a hundredth of the rounding of a vertex to the lattice.
constexpr double calibration_error = 0.01;

// The camera as its CAMR has it: one that moves, as it is in the first frame in which it is calibrated, and
// with its flag.
fvv_camera described(const scene::Capture &capture, const scene::Camera &camera);

bool any_moves(const scene::Capture &capture);

class MovingCameras {
public:
  // The bits are chosen for all frames. lattice_step: metres. Throws Error.
  MovingCameras(const scene::Capture &capture, double lattice_step);

  // The payload of frame i of the capture; valid until the next call. Frames come in order, key at the first
  // of each group. Throws Error, naming the frame.
  const fvv_bytes &payload(size_t frame, bool key);

  // The decoded cameras that are calibrated in frame i, by rising identifier. May be called on any thread.
  std::vector<fvv_camera> decoded(size_t frame) const;

private:
  std::vector<fvv_camera> cameras_at(int64_t number) const;

  const scene::Capture &capture;
  std::vector<fvv_camera> constant; // as CAMR has them
  fvv_calibration_bits bits = {};
  std::unique_ptr<fvv_calibration, void (*)(fvv_calibration *)> encoder;
  OwnedBytes bytes;
};

constexpr uint16_t mesh_track = 1, camera_track = 2, atlas_track = 3, calibration_track = 4,
                   visibility_track = 5, environment_track = 6, colour_track = 7;
// Further tracks with cameras follow all others, then the video tracks of further rungs, then their meshes
// with visibility and colours.
constexpr uint16_t last_track = colour_track;

// Every function throws Error if writing fails.
class StreamWriter {
public:
  // Writes file header and configuration. plan, decisions and sink are borrowed.
  StreamWriter(const Plan &plan, const Decisions &decisions, const Sink &sink);

  // Before the first group: its number, as if the groups before it had been written.
  void join(size_t group);
  void repeat_configuration();
  void begin_group(size_t group);
  void mesh(const MeshTrack &track, size_t frame, const std::vector<uint8_t> &payload, bool key);
  // The calibration of a frame, if any camera moves; key: its group begins. Returns the bytes of payload.
  uint64_t calibration(size_t frame, bool key);
  // The layout of a group, unless it is that of the configuration, before the track's first sample. Returns
  // whether it was written.
  bool layout(const VideoTrack &track, size_t group);
  // After mesh and calibration of the frame.
  void visibility(const MeshTrack &track, size_t frame, const std::vector<uint8_t> &payload, bool key);
  // Of a key mesh, likewise.
  void colours(const MeshTrack &track, size_t frame, const std::vector<uint8_t> &payload);
  void sample(const VideoTrack &track, size_t frame, const media::Sample &sample);
  // The environment, after the other chunks of a frame, if the plan has one. Returns the bytes of payload.
  uint64_t environment(size_t frame);
  void sound(const SoundChunk &chunk);
  void data(const DataChunk &chunk);
  // A chunk of a group that was written elsewhere.
  void chunk(const fvv_chunk_header &header, const uint8_t *payload);
  // What was written so far, as Plan::sounds.
  const std::vector<TrackBytes> &sounds() const { return sound_bytes; }
  void end_group();
  // If the stage is empty at the end of a stream without pictures, a group of sound alone for that time; then
  // index and footer, unless the stream is live. Returns the number of bytes written.
  uint64_t finish();

private:
  static fvv_status write(void *user, const void *bytes, size_t size);
  void check_groups() const;
  void open(const fvv_output &output);
  void check(fvv_status status);
  void configure(uint32_t type, uint16_t track, const std::vector<uint8_t> &payload);
  void write_configuration();
  void write_video(const VideoTrack &track);
  // Of the plan, by rising identifier.
  std::vector<const VideoTrack *> video_tracks() const;
  void write_video_track(const VideoTrack &track);
  std::vector<uint8_t> layout_record(const std::vector<fvv_tile> &tiles) const;
  void write_track(uint16_t id, uint8_t kind, const std::string &name, const VideoTrack *video = nullptr);
  // One of the tracks of a mesh track: each kind has an alternate group, if several rungs have meshes.
  void write_mesh_track(const MeshTrack &track, uint8_t kind);
  bool is_sent(const MeshTrack &track) const;
  uint32_t rate_of(uint16_t id) const;
  void write_track(const fvv_track &track);
  void write_sound_track(size_t number);
  void write_sound(size_t number);
  void write_data_track(size_t number);
  void write_data(size_t number);

  const Plan &plan;
  const Decisions &decisions;
  const Sink &sink;
  std::exception_ptr failure; // of sink
  fvv_diagnostic diagnostic = {};
  std::optional<MovingCameras> moving;
  std::vector<TrackBytes> sound_bytes;
  std::unique_ptr<fvv_writer, void (*)(fvv_writer *)> writer;
};

} // namespace fvv::mux
