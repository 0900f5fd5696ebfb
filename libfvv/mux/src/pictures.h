// The pictures of a frame in one video frame, and the choice of their quality. Every function may run on any
// thread.
#pragma once

#include "mux/src/choose/decisions.h"
#include "mux/src/plan.h"

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

namespace fvv::mux {

// Pixels of the capture's pictures around the silhouette that continue its colours. Meshes and masks are
// rarely accurate to a few pixels.
constexpr uint32_t tile_fill_margin = 8;
// How the rest is changed: never automatic.
TileFill tile_fill_of(const Options &options);

// The video frame of frame i, for samples of media::with_sample_type; mask only if requested and if a camera
// has masks.
template <class Sample> struct Picture {
  media::BasicImage<Sample> image;
  media::Image mask;
};
template <class Sample>
Picture<Sample> load_picture(const Plan &plan, const VideoTrack &track, size_t i, bool with_mask);

// A picture or mask of a camera, for the plan's cameras: without lens distortion and with the colours of
// the other cameras if so planned. camera: index in the capture; frame: its number in file names.
template <class Sample>
media::BasicImage<Sample> load_view(const Plan &plan, size_t camera, const scene::PictureSource &source,
                                    int64_t frame, int channels);

// The picture of a camera in 8 bits, as display values.
media::Image load_display(const Plan &plan, size_t camera, int64_t frame);

// The plan's gains, if there are any by now, for display values of a camera.
void apply_gains(const Plan &plan, size_t camera, media::Image &picture);

// The picture of the capture's atlas, for the same samples. frame: its number in file names.
template <class Sample> media::BasicImage<Sample> load_atlas(const Plan &plan, int64_t frame);

// For load_view, of the cameras with gains that are not 1. Not for OpenEXR.
std::shared_ptr<const GainTables> gain_tables(const MatchChoice &choice, size_t cameras);

// The memory for encoders that run at once. Encoders of large frames take most of it: few run, and threads
// that wait for room load the next frames for all. Every function may be called by several threads at once.
class EncoderRoom {
public:
  // For each thread: two threads encode and load 20 Full HD cameras in less than 1 GiB.
  static constexpr uint64_t bytes_per_thread = uint64_t(320) << 20;
  // Of these for frames that are loaded before they are needed.
  static constexpr uint64_t ahead_per_thread = uint64_t(48) << 20;

  explicit EncoderRoom(unsigned count) : threads(count) {}

  // Waits until there is room for that many bytes, or until no other encoder has any. The room is taken
  // until the last copy of the result is gone.
  std::shared_ptr<void> reserve(uint64_t bytes);

  // Loads frames for encoders on other threads; returns when there are no groups.
  void help();

  // The frames of a group that is encoded, each loaded once and in order, on any thread.
  class Group {
  public:
    // load: keeps a frame and returns its bytes, about most_bytes or less; must not throw.
    Group(EncoderRoom &room, size_t count, uint64_t most_bytes, std::function<uint64_t(size_t frame)> load);
    ~Group();
    Group(const Group &) = delete;

    // Returns when the frame is loaded, which counts no longer as kept.
    void await(size_t frame);

  private:
    friend EncoderRoom;
    EncoderRoom &room;
    const uint64_t most_bytes;
    const std::function<uint64_t(size_t frame)> load;
    size_t begun = 0;     // frames
    size_t loading = 0;   // frames, now
    bool running = false; // a frame was awaited
    struct Frame {
      bool loaded = false;
      uint64_t bytes = 0;
    };
    std::vector<Frame> frames;
  };

private:
  void load_next(Group &group, std::unique_lock<std::mutex> &lock); // lock: of mutex, released meanwhile
  bool load_any(std::unique_lock<std::mutex> &lock);                // false if nothing may be loaded now

  const unsigned threads;
  std::mutex mutex; // of all below and of groups
  std::condition_variable changed;
  uint64_t used = 0; // by encoders
  uint64_t kept = 0; // of frames that are loaded and not needed yet
  std::vector<Group *> groups;
};

// The middle group, or the nearest one that is not short and in which something is on stage. A codec spends
// more on the only frame of a group than on the frames of a long one: the last group of a few frames would
// promise a quality, by AV1 of 5 dB more, that the others do not have.
size_t middle_group(const Plan &plan);

class SampleFrames; // pictures.cpp

// The quality of a track, and what finding it has encoded already.
struct VideoChoice {
  VideoDecision decision;
  std::shared_ptr<SampleFrames> frames; // of the sample, or the resulting ones; each once; may be NULL
};

// What pictures of a rung are to have, in their own size, where those of the first have that. dB.
double target_psnr_of(const Plan &plan, size_t rung, double first);

// Encodes a sample of a video track as often as it takes to find the quality, which may take long. best: of
// the track that shows the same at rung 0; NULL: this is one.
VideoChoice choose_video(const Plan &plan, const VideoTrack &track, const VideoDecision *best,
                         EncoderRoom &room);

// Encodes frames first ... first + count - 1 of a track as one group.
media::EncodedGroup encode_pictures(const Plan &plan, const VideoTrack &track, const VideoChoice &choice,
                                    size_t first, size_t count, EncoderRoom &room);

} // namespace fvv::mux
