#include "fvvmux/layout.h"

#include "cli/cli.h"
#include "fvv_media/frame.h"
#include "fvvmux/crop.h"
#include "fvvmux/frame_limit.h"
#include "fvvmux/frames.h"
#include "fvvmux/neighbours.h"
#include "fvvmux/packing.h"
#include "fvvmux/runs.h"
#include "fvvmux/select.h"
#include "fvvmux/tile_scale.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

namespace fvv::mux {

namespace {

constexpr uint32_t max_frame_side = 16384;
constexpr uint32_t min_frame_side = 64; // AV1's encoder takes no less
constexpr uint32_t margin = 4;          // pixels of the transmitted picture around what is seen of the scene
// A step of the crop in transmitted pixels, so that the crop has exactly the scale of the whole picture.
// Where the ratio of the sizes needs a longer one, the scale is rounded to whole pixels.
constexpr uint32_t longest_step = 16;

uint16_t scaled(uint32_t size, double scale) {
  return uint16_t(std::max(1.0, std::round(size * scale)));
}

// One axis: part of a picture and the pixels that it becomes.
struct Span {
  uint16_t source, source_size, destination_size;
};

// Of a picture of size source pixels that is sent in size whole: low ... high - 1 with the margin.
Span span_of(uint32_t low, uint32_t high, uint32_t source, uint32_t whole) {
  const uint32_t common = std::gcd(source, whole);
  const bool exact = whole / common <= longest_step;
  const uint32_t step = exact ? source / common : 1, becomes = exact ? whole / common : 0;
  // What flatten keeps is kept in whole.
  const uint32_t border = std::max(background_margin, (margin * source + whole - 1) / whole);
  low = low > border ? (low - border) / step * step : 0;
  high = std::min(source, (std::min(source, high + border) + step - 1) / step * step);
  const uint32_t size = high - low;
  const uint32_t destination =
      exact ? size / step * becomes : uint32_t(std::max(1.0, std::round(double(size) * whole / source)));
  return {uint16_t(low), uint16_t(size), uint16_t(destination)};
}

fvv_tile cropped(const fvv_tile &whole, const Silhouette &box) {
  const uint32_t width = whole.source.width, height = whole.source.height;
  // Nothing to be seen: a small tile, so that every group shows every camera.
  const Silhouette shown =
      box.empty() ? Silhouette{width / 2, height / 2, width / 2 + 1, height / 2 + 1} : box;
  const Span x = span_of(shown.left, shown.right, width, whole.destination.width),
             y = span_of(shown.top, shown.bottom, height, whole.destination.height);
  return {whole.camera_id,
          {x.source, y.source, x.source_size, y.source_size},
          {0, 0, x.destination_size, y.destination_size}};
}

uint32_t units(uint32_t pixels) {
  return (pixels + FVV_TILE_ALIGNMENT - 1) / FVV_TILE_ALIGNMENT;
}

// Tiles in one frame. groups: as in VideoTrack.
struct Layout {
  Tiling tiling;
  std::vector<std::vector<fvv_tile>> groups;
};
using MaybeLayout = std::optional<Layout>; // nothing: they do not fit

// The crops of every group. whole: pictures without a place.
MaybeLayout pack_crops(const std::vector<std::vector<Silhouette>> &boxes, const Tiling &whole,
                       const FrameLimit &limit) {
  Layout layout = {whole, {}};
  std::vector<std::vector<Cell>> cells;
  for (const std::vector<Silhouette> &group : boxes) {
    layout.groups.emplace_back();
    cells.emplace_back();
    for (size_t k = 0; k < group.size(); k++) {
      const fvv_tile tile = cropped(whole.tiles[k], group[k]);
      layout.groups.back().push_back(tile);
      cells.back().push_back({units(tile.destination.width + media::guard_band),
                              units(tile.destination.height + media::guard_band)});
    }
  }
  const FrameBound most = {limit.width / FVV_TILE_ALIGNMENT, limit.height / FVV_TILE_ALIGNMENT,
                           limit.pixels / (FVV_TILE_ALIGNMENT * FVV_TILE_ALIGNMENT)};
  const FrameSize size = pack(cells, units(min_frame_side), most);
  if (!size.width) return {};
  layout.tiling.width = size.width * FVV_TILE_ALIGNMENT;
  layout.tiling.height = size.height * FVV_TILE_ALIGNMENT;
  for (size_t g = 0; g < cells.size(); g++)
    for (size_t k = 0; k < cells[g].size(); k++) {
      layout.groups[g][k].destination.x = uint16_t(cells[g][k].x * FVV_TILE_ALIGNMENT);
      layout.groups[g][k].destination.y = uint16_t(cells[g][k].y * FVV_TILE_ALIGNMENT);
    }
  layout.tiling.tiles = layout.groups[0];
  return layout;
}

// Whole pictures in a grid.
MaybeLayout arrange(const Tiling &whole, const FrameLimit &limit) {
  Layout layout = {whole, {}};
  Tiling &tiling = layout.tiling;
  const fvv_status status =
      fvv_tiles_arrange(tiling.tiles.data(), tiling.tiles.size(), std::max(limit.width, limit.height),
                        &tiling.width, &tiling.height, nullptr);
  const bool good = status == FVV_OK && fits(tiling.width, tiling.height, limit);
  return good ? MaybeLayout(layout) : MaybeLayout();
}

// Pictures without a place, and what to crop them to: of each group and picture; no groups: they stay whole.
struct Pictures {
  Tiling tiling;
  std::vector<std::vector<Silhouette>> boxes;
};

Pictures pictures_of(const Plan &plan, const Tiling &whole, const std::vector<size_t> &places) {
  Pictures out;
  for (const size_t k : places) {
    out.tiling.cameras.push_back(whole.cameras[k]);
    out.tiling.tiles.push_back(whole.tiles[k]);
  }
  for (const std::vector<Silhouette> &group : plan.crop.boxes) {
    out.boxes.emplace_back();
    for (const size_t k : places) out.boxes.back().push_back(group[k]);
  }
  return out;
}

// Of the pictures first ... end - 1.
MaybeLayout lay_out(const Pictures &all, size_t first, size_t end, const FrameLimit &limit) {
  const auto part = [&](const auto &list) {
    return std::decay_t<decltype(list)>(list.begin() + std::ptrdiff_t(first),
                                        list.begin() + std::ptrdiff_t(end));
  };
  const Tiling tiling = {part(all.tiling.cameras), part(all.tiling.tiles)};
  if (all.boxes.empty()) return arrange(tiling, limit);
  std::vector<std::vector<Silhouette>> boxes;
  for (const std::vector<Silhouette> &group : all.boxes) boxes.push_back(part(group));
  return pack_crops(boxes, tiling, limit);
}

// Pixels of each picture, those of the group that shows most of it.
std::vector<uint64_t> weights_of(const Pictures &all) {
  std::vector<uint64_t> weights;
  for (size_t k = 0; k < all.tiling.tiles.size(); k++) {
    const auto pixels = [](const fvv_tile &tile) {
      return uint64_t(tile.destination.width) * tile.destination.height;
    };
    uint64_t most = all.boxes.empty() ? pixels(all.tiling.tiles[k]) : 1;
    for (const std::vector<Silhouette> &group : all.boxes)
      most = std::max(most, pixels(cropped(all.tiling.tiles[k], group[k])));
    weights.push_back(most);
  }
  return weights;
}

// A picture that no level of the codec takes is sent as it is, in a frame of its own.
Layout lay_out_alone(Plan &plan, const Pictures &all, size_t k, const FrameLimit &limit) {
  const std::string camera = describe(plan.capture.cameras[all.tiling.cameras[k]]);
  const MaybeLayout layout =
      lay_out(all, k, k + 1,
              {max_frame_side, max_frame_side, uint64_t(max_frame_side) * max_frame_side, "the format"});
  if (!layout)
    throw cli::Failure(plan.capture.path + ": the picture of " + camera + " does not fit a frame of " +
                       std::to_string(max_frame_side) + " x " + std::to_string(max_frame_side) +
                       ": make it smaller (--scale, --video-size)");
  cli::warn(plan.capture.path + ": the picture of " + camera + " takes a frame of " +
            std::to_string(layout->tiling.width) + " x " + std::to_string(layout->tiling.height) +
            " pixels; decoders are sure to take " + limit_text(limit));
  plan.warned = true;
  return *layout;
}

// In so many tracks; none: that is too few of them.
std::vector<Layout> lay_out_tracks(Plan &plan, const Pictures &all, const std::vector<size_t> &ends) {
  std::vector<MaybeLayout> found;
  size_t first = 0;
  for (const size_t end : ends) {
    found.push_back(lay_out(all, first, end, plan.frame_limit));
    if (!found.back() && end - first > 1) return {};
    first = end;
  }
  std::vector<Layout> layouts;
  for (size_t i = 0; i < found.size(); i++)
    layouts.push_back(found[i] ? std::move(*found[i])
                               : lay_out_alone(plan, all, ends[i] - 1, plan.frame_limit));
  return layouts;
}

std::string reason_of(const Plan &plan, const Tiling &tiling, const CropChoice &choice) {
  if (!choice.on)
    return plan.options.crop == Crop::none ? "as --crop none says"
                                           : "there are neither masks nor meshes to crop by";
  std::string out;
  const auto add = [&](size_t count, const char *what) {
    if (!count) return;
    if (!out.empty()) out += ", ";
    if (count < tiling.tiles.size()) out += std::to_string(count) + " cameras ";
    out += what;
  };
  add(choice.by_masks, "to the masks");
  add(choice.by_mesh, "to the mesh");
  return out;
}

} // namespace

Tiling whole_pictures(const capture::Capture &capture, const Options &options) {
  Tiling tiling;
  for (size_t i = 0; i < capture.cameras.size(); i++) {
    const fvv_camera &camera = capture.cameras[i].calibration;
    if (!capture.cameras[i].pictures) continue;
    // check_files has found the files to be of this size, and no picture file that is read is larger.
    fvv_tile tile = {camera.id, {0, 0, uint16_t(camera.width), uint16_t(camera.height)}, {}};
    tile.destination.width = options.tile ? options.tile->width : scaled(camera.width, options.scale);
    tile.destination.height = options.tile ? options.tile->height : scaled(camera.height, options.scale);
    if (tile.destination.width > camera.width || tile.destination.height > camera.height)
      throw cli::Failure("--tile: expected at most the size of every picture, found " +
                             std::to_string(tile.destination.width) + "x" +
                             std::to_string(tile.destination.height) + " for camera " +
                             std::to_string(camera.id) + " with " + std::to_string(camera.width) + "x" +
                             std::to_string(camera.height),
                         cli::usage);
    tiling.cameras.push_back(i);
    tiling.tiles.push_back(tile);
  }
  return tiling;
}

CropChoice choose_crop(const Plan &plan, const Tiling &tiling) {
  CropChoice choice;
  for (const fvv_tile &tile : tiling.tiles)
    choice.whole_pixels += uint64_t(tile.destination.width) * tile.destination.height;
  if (plan.options.crop == Crop::automatic)
    for (const size_t index : tiling.cameras) {
      const CropBy by = crop_by(plan.capture, plan.capture.cameras[index]);
      choice.by_masks += by == CropBy::masks;
      choice.by_mesh += by == CropBy::mesh;
    }
  choice.on = choice.by_masks || choice.by_mesh;
  choice.reason = reason_of(plan, tiling, choice);
  if (choice.on) choice.boxes = silhouettes(plan, tiling.cameras);
  return choice;
}

void bound(const Plan &plan, Tiling &tiling) {
  const Options &options = plan.options;
  if ((!options.video_pixels && !options.video_size) || tiling.tiles.empty()) return;
  const char *option = options.video_pixels ? "--video-pixels" : "--video-size";
  if (!plan.crop.on)
    throw cli::Failure(std::string(option) + ": expected pictures that are cropped: " + plan.crop.reason,
                       cli::usage);
  const std::vector<fvv_tile> full = tiling.tiles;
  const std::vector<double> useful = usefulness(plan.capture, tiling.cameras, plan.crop.boxes);
  const auto fits = [&](double amount) {
    tiling.tiles = scaled_by_use(full, plan.crop.boxes, useful, amount);
    return lay_out({tiling, plan.crop.boxes}, 0, full.size(), plan.frame_limit).has_value();
  };
  if (fits(1)) return;
  // What a share is worth is found by halves; the frame's size rises with it but for the packing's luck.
  double low = 0, high = 1;
  for (int i = 0; i < 24; i++) (fits((low + high) / 2) ? low : high) = (low + high) / 2;
  if (!fits(low))
    throw cli::Failure(std::string(option) + ": expected more for " + std::to_string(full.size()) +
                           " cameras: margins and guard bands alone take more than " +
                           (options.video_pixels ? std::to_string(options.video_pixels)
                                                 : std::to_string(options.video_size->width) + "x" +
                                                       std::to_string(options.video_size->height)),
                       cli::usage);
}

std::vector<VideoTrack> tile_tracks(Plan &plan, const Tiling &whole) {
  std::vector<VideoTrack> tracks;
  if (whole.tiles.empty()) return tracks;
  for (const std::vector<size_t> &set : neighbours(plan.capture, whole.cameras, plan.options.video_tracks)) {
    const Pictures all = pictures_of(plan, whole, set);
    const std::vector<uint64_t> weights = weights_of(all);
    std::vector<Layout> layouts;
    for (size_t count = 1; layouts.empty(); count++) // one for each camera is an answer, or throws
      layouts = lay_out_tracks(plan, all, balanced_runs(weights, count));
    for (Layout &layout : layouts) {
      tracks.push_back({FVV_SHOWS_TILES, std::move(layout.tiling), {}, std::move(layout.groups)});
      tracks.back().part = tracks.size() - 1;
    }
  }
  return tracks;
}

} // namespace fvv::mux
