// Which picture of a video belongs to which frame of a capture, by times alone, exactly; and warnings for the
// user.
#pragma once

#include "fvv_scene/capture.h"

namespace fvv::scene {

// The frames of a capture on the time line of a video: frame i (counted from 0 at VideoSource::first, at most
// 10^7) is at start + i * duration * clock.
class FrameClock {
public:
  FrameClock(const Capture &capture, const VideoSource &video);

  // Index of the picture nearest to a frame number; of two that are equally near the earlier one.
  size_t nearest(const PictureTimes &pictures, int64_t frame) const;
  // Whether a picture is at most half a frame duration away from a frame number.
  bool meets(const PictureTimes &pictures, size_t picture, int64_t frame) const;
  // Seconds from the frame to the picture.
  double offset(const PictureTimes &pictures, size_t picture, int64_t frame) const;
  // The start that would align a frame number with a picture, rounded to microseconds where its numbers do
  // not fit; none if they do not fit then.
  std::optional<Seconds> start_for(const PictureTimes &pictures, size_t picture, int64_t frame) const;

private:
  const Seconds start;
  const fvv_rational duration; // of a frame, in seconds of the video
  const int64_t first, step;
};

// capture.frames are those that count; of a camera, those at which it is calibrated need a picture of their
// own.
VideoReport match_video(const Capture &capture, const VideoSource &video, const PictureTimes &pictures,
                        const Camera *camera);

} // namespace fvv::scene
