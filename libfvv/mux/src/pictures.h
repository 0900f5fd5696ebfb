// The pictures of a frame in one video frame, and the choice of their quality. Every function may run on any
// thread.
#pragma once

#include "fvv_mux/plan.h"

namespace fvv::mux {

// Pixels of the capture's pictures around the silhouette that continue its colours. Meshes and masks are
// rarely accurate to a few pixels.
constexpr uint32_t background_margin = 8;
// How the rest is changed: never automatic.
Background background_of(const Options &options);

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

// The picture of the capture's atlas, for the same samples. frame: its number in file names.
template <class Sample> media::BasicImage<Sample> load_atlas(const Plan &plan, int64_t frame);

// For load_view, of the cameras with gains that are not 1. Not for OpenEXR.
std::shared_ptr<const GainTables> gain_tables(const MatchChoice &choice, size_t cameras);

// Encodes a sample of a video track as often as it takes to find the quality, which may take long.
VideoChoice choose_video(const Plan &plan, const VideoTrack &track);

// Encodes frames first ... first + count - 1 of a track as one group.
media::EncodedGroup encode_pictures(const Plan &plan, const VideoTrack &track, size_t first, size_t count);

} // namespace fvv::mux
