// The pictures of a configuration: every camera and the atlas that video tracks show, their place in the
// frame, and the calibration of the extracted picture.
#pragma once

#include "fvv/stream.h"
#include "fvv/video.h"
#include "fvv_cxx/rung.h"
#include "fvv_demux/selection.h"
#include "fvv_media/image.h"
#include "fvv_media/video.h"

#include <optional>
#include <string>
#include <vector>

namespace fvv::demux {

// In place of a camera identifier, as in VCFG: the view is the atlas.
constexpr uint16_t no_camera = UINT16_MAX;

struct View {
  fvv_tile tile; // a track that shows one camera or an atlas is one tile of the frame's size
  std::string folder;
  fvv_tile whole; // the whole picture, at the tile's scale, in a frame of its own
};

// The tile of a view in the frames of a group (spec/fvv.md, clause 10.11), none if its camera has no picture
// there. Throws if the stream has lost it.
fvv_status tile_in_group(fvv_stream *stream, size_t group, const fvv_video_layout &video, const View &view,
                         std::optional<fvv_tile> &tile, fvv_diagnostic &diagnostic);

struct VideoViews {
  const fvv_video_layout *video; // of the configuration
  std::vector<View> views;
};

// Of all video tracks of a rung (fvv_cxx/rung.h) in order. Of a camera or atlas that is shown twice the first
// is used; tracks with neither an atlas nor a selected camera are left out. warnings name everything else
// that is left out.
std::vector<VideoViews> views_of(const fvv_configuration &configuration, size_t rung,
                                 const Selection &cameras, std::vector<std::string> *warnings);

// The most bytes that decoding these tracks takes, all at once. Error "where: track 2: ..." at the first that
// exceeds limit.
uint64_t decoding_memory(const std::string &where, const std::vector<VideoViews> &tracks,
                         const media::MemoryLimit &limit);

// The first mesh track of a rung, NULL: none.
const fvv_track *mesh_track_of(const fvv_configuration &configuration, size_t rung,
                               std::vector<std::string> *warnings);

// frame: of the video. tile: of the group that the frame is in, NULL: the camera has none. whole: the source
// rectangle is all of the camera's picture, the destination, at (0, 0), the size to make of it. Pixels are
// copied where those of the tile are those of the picture, else interpolated between the nearest four.
template <class Sample>
media::BasicImage<Sample> whole_picture(const media::BasicImage<Sample> &frame, const fvv_tile *tile,
                                        const fvv_tile &whole);

} // namespace fvv::demux
