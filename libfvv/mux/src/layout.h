// Where each camera's picture is in the video frame: whole pictures in a grid, or the visible scene of each
// group, packed into frames that decoders support.
#pragma once

#include "fvv_mux/options.h"
#include "mux/src/plan.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace fvv::mux {

// A side of a picture at a scale, at least 1.
uint16_t scaled(uint32_t size, double scale);

// A tile for every camera with pictures, of its whole picture, in the size that the options set, without a
// place. Error (usage) when a picture would have to grow.
Tiling whole_pictures(const scene::Capture &capture, const Options &options);

// How whole pictures are to be cropped, and why. The visible scene is determined here.
CropChoice choose_crop(const Plan &plan, const Tiling &tiling);

// With --video-pixels or --video-size: makes whole pictures smaller until their crops fit one frame of that
// size, and one that decoders take, each by its usefulness (tile_scale.h). Error when the smallest do
// not fit.
void bound(const Plan &plan, Tiling &tiling);

// Crops whole pictures to what is seen of the scene in each group, with a margin, and packs every group's
// crops into one frame. The crops have the scale of the whole picture. Without data to crop by: whole
// pictures in a grid, and no groups.
//
// One track for each set of neighbouring cameras by Options::video_tracks, or more if a frame would exceed
// plan.frame_limit; the cameras of a set stay in order, and its tracks have about the same number of pixels.
// A camera that exceeds it alone has a track of its own, with a warning. Error when it exceeds the format. No
// tiles: no tracks.
std::vector<VideoTrack> tile_tracks(Plan &plan, const Tiling &whole);

// Throws Error (usage) for a ladder that Options does not allow.
void check_ladder(const Options &options);

// Adds the tracks of the further rungs to a plan that has those of the first, each with the same cameras.
void add_rungs(Plan &plan);

// Of the plan's atlas: what each side needs in any frame of those that mesh files bring, else the size in the
// first frame, which the others are to have. Warns where pictures were made smaller to be packed.
scene::AtlasSize find_atlas_size(Plan &plan);

// An atlas of that size, whole, in the size of a rung.
Tiling arrange_atlas(const Plan &plan, size_t rung, uint32_t width, uint32_t height);

// Of the codec's highest level that decoders are sure to have (5.2 of H.264, HEVC, VP9 and AV1; sides alone
// for stills), at this rate of frames; each side at most what browsers upload as a texture.
FrameLimit decoder_limit(const Options &options, const fvv_rational &frame_duration);

// A seam for tests: in place of decoder_limit, for plans that this thread makes while the object lives.
class AssumedDecoder {
public:
  explicit AssumedDecoder(const FrameLimit &limit);
  ~AssumedDecoder();
  AssumedDecoder(const AssumedDecoder &) = delete;
  AssumedDecoder &operator=(const AssumedDecoder &) = delete;

private:
  const std::optional<FrameLimit> former;
};

// The same for the frames with tiles of cameras, and no more than the options ask for.
FrameLimit frame_limit(const Options &options, const fvv_rational &frame_duration);

bool fits(uint32_t width, uint32_t height, const FrameLimit &limit);

// "8192x8192 and 9437184 pixels (H.264 level 5.2)".
std::string limit_text(const FrameLimit &limit);

// In units of FVV_TILE_ALIGNMENT pixels.
struct Cell {
  uint32_t width, height;
  uint32_t x = 0, y = 0; // of the left upper corner, once it is packed
};

struct FrameSize {
  uint32_t width, height;
};
struct FrameBound {
  uint32_t width, height;
  uint64_t area = UINT64_MAX;
};

// Places the cells of every set so that all sets fit one frame, the smallest by area that was found: of all
// widths that make it at most four times as long as it is short, each set by a skyline (stb_rect_pack.h) that
// prefers the lowest place, and by one that prefers the tightest; the nearest to a square of equal ones.
// least: of the sides; most: of the frame. Without a fit, or without cells: {0, 0}, and cells are as they
// were. The same on every machine.
FrameSize pack(std::vector<std::vector<Cell>> &sets, uint32_t least, const FrameBound &most);

// Cuts weights into count runs of at least one each (1 <= count <= their number), so that the heaviest run is
// as light as it can be. Returns the ends of the runs. Of equal cuts the one whose first runs are longest.
std::vector<size_t> balanced_runs(const std::vector<uint64_t> &weights, size_t count);

// Widens the crops of all groups by an eighth of their sides: later groups, which are not known yet, may need
// it. tiling: of the cameras.
void leave_room(Plan &plan, const Tiling &tiling);

// Lays out the crops of a further group, boxes of all pictures of plan.whole, in the frames of the plan's
// tracks.
void lay_out_group(Plan &plan, const std::vector<Silhouette> &boxes);

} // namespace fvv::mux
