// From arrays in memory to a stream: frames are pushed one after the other, and the bytes of a group are
// passed on as soon as its last frame is there. Live sources and bindings use it; captures on disk go through
// Muxer (muxer.h). fvv/encoder.h is the same in C.
#pragma once

#include "fvv/calibration.h"
#include "fvv/video.h"
#include "fvv_cxx/values.h"
#include "fvv_mux/options.h"
#include "fvv_mux/report.h"

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fvv::media {
struct SoundPackets; // internal
}

namespace fvv::mux {

// A camera of the rig.
struct CameraInput {
  fvv_camera calibration = {}; // world -> camera, metres, pixels (fvv/calibration.h); its name is not used
  std::string name;
  bool pictures = true; // every frame has a picture of it, of the calibration's size
  bool masks = false;   // and a mask: what is above 127 shows the scene
  bool moves = false;   // every frame has a calibration of its own
  // If set, frames provide per-vertex visibility; otherwise it is ray cast.
  bool visibility = false;
};

// A recording: sound_of_samples() and sound_of_file() make it.
struct SoundInput {
  std::shared_ptr<const media::SoundPackets> packets; // of Opus or AAC-LC; times from frame 0
  std::string title = "";
  std::string language = ""; // BCP 47
  // Where it is heard from, in metres; nothing: everywhere. per_frame: of a source that moves, for every
  // frame that is added.
  std::optional<std::array<double, 3>> position = {};
  std::vector<std::array<double, 3>> per_frame = {};
};

// Interleaved samples at 48 kHz, full scale 1, encoded as Opus. start: time of the first sample, in seconds
// after frame 0; may be negative. bit_rate: bits a second; 0: 64,000 for one channel, 96,000 for two, 48,000
// more for each further one. Throws Error (usage) for channels, bit rates and samples that Opus does not
// take.
SoundInput sound_of_samples(const std::vector<float> &samples, uint32_t channels, double start = 0,
                            uint32_t bit_rate = 0);
// The first sound of a file, which begins with frame 0. Packets of Opus and AAC-LC are kept, other sound is
// encoded as Opus. Throws Error.
SoundInput sound_of_file(const std::string &path);

// A video track whose samples come encoded with the frames, from cameras or a GPU, and are sent as they are.
struct EncodedTrack {
  // Codec, size, bit depth and colours. shows, record and codec_string are not used.
  fvv_video_config config = {};
  std::vector<uint8_t> record; // the codec's configuration record (fvv/video.h)
  std::vector<fvv_tile> tiles; // where each camera's picture is; the same in all frames
};

// What does not change from frame to frame.
struct Configuration {
  std::string name;                      // of the scene, for metadata
  fvv_rational frame_duration = {1, 25}; // seconds
  bool meshes = true;                    // frames have one, unless the stage is empty
  std::vector<CameraInput> cameras;      // each with an identifier of its own
  // Every frame has a sample of each. The cameras that their tiles show have no pictures besides.
  std::vector<EncodedTrack> encoded = {};
  std::vector<SoundInput> sounds = {}; // groups take what falls into them
  uint8_t up = FVV_UP_UNKNOWN;         // FVV_UP_...: the axis that points up
  bool scale_unknown = false;          // lengths are in an unknown unit
};

// One moment. All arrays are in the order of Configuration::cameras; those of cameras without them are empty
// elements, and arrays without any element may be left out.
struct Frame {
  geometry::Mesh mesh; // metres; without vertices and faces: the stage is empty
  // RGB; samples of 8 bits, of 16 bits for Options::bit_depth 10, or float for OpenEXR.
  std::vector<media::AnyImage> pictures;
  std::vector<media::Image> masks;      // one channel
  std::vector<fvv_camera> calibrations; // of this frame; used of cameras that move
  // Of each of Configuration::encoded: a still image file, or one MP4 sample for this frame; a key frame of
  // the codec where a group begins.
  std::vector<std::vector<uint8_t>> samples = {};
  // Of each camera, for each vertex of mesh, how much of the surface around it the camera sees: 0 nothing,
  // 255 all of it; from 128 on a vertex counts as seen. The stream's vertices may be fewer or others: each
  // has that of the nearest vertex. What does not face the camera has no visibility (fvv.md clause 17.2).
  std::vector<std::vector<uint8_t>> visibility = {};
};

// Decisions for the whole stream (lattice, decimation, quality, size of the video frame) are made when the
// first group with a mesh is complete, by the frames so far, which are kept in memory until then. A group
// ends early where the stage becomes empty: samples that were encoded before need a key frame there. The
// video frame keeps an eighth of room around what they show; a group that needs more is sent smaller. The
// bytes depend on configuration, options other than threads, and frames.
class Encoder {
public:
  // What options say of a capture on disk (capture, inputs, frames, cameras, verify) has no effect. sink is
  // called by add() and finish() on their thread.
  // Throws Error for options that do not fit the configuration.
  Encoder(const Configuration &configuration, const Options &options, const Sink &sink,
          const Observer &observer = {});
  ~Encoder();
  Encoder(const Encoder &) = delete;
  Encoder &operator=(const Encoder &) = delete;

  // Throws Error (usage) that names the next frame if add() would refuse what it holds.
  void check_next(const Frame &frame) const;

  // The next frame. When it completes a group (Options::group frames, default: one second), encodes and
  // writes the group with Options::threads threads before it returns. Throws Error that names the frame, and
  // whatever sink throws; the stream has to be given up then.
  void add(Frame frame);

  // The next frame is missing: its time passes, and the frame before it lasts until the next one or the end
  // of its group. Samples of encoded tracks that follow must not need it.
  void skip();

  // For a source that does not wait: from the next group on, less is done for the same or fewer bytes, by one
  // of the steps of docs/guide/live.md. 0: nothing is given up.
  void set_effort(size_t step);

  // Writes what is left, index and footer. At least one frame was added.
  Report finish();

private:
  struct State;
  std::unique_ptr<State> state;
};

} // namespace fvv::mux
