#include "fvvmux/layout.h"

#include "cli/cli.h"
#include "fvv_media/frame.h"
#include "fvvmux/crop.h"
#include "fvvmux/frames.h"
#include "fvvmux/packing.h"
#include "fvvmux/tile_scale.h"

#include <algorithm>
#include <cmath>
#include <numeric>

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

// The crops of every group in one frame; no size: they do not fit any.
struct Layout {
  FrameSize size;
  std::vector<std::vector<fvv_tile>> groups;
};

uint64_t pixels_of(const FrameSize &size) {
  return uint64_t(size.width) * size.height * FVV_TILE_ALIGNMENT * FVV_TILE_ALIGNMENT;
}

Layout lay_out(const std::vector<std::vector<Silhouette>> &boxes, const Tiling &tiling) {
  Layout layout;
  std::vector<std::vector<Cell>> cells;
  for (const std::vector<Silhouette> &group : boxes) {
    layout.groups.emplace_back();
    cells.emplace_back();
    for (size_t k = 0; k < group.size(); k++) {
      const fvv_tile tile = cropped(tiling.tiles[k], group[k]);
      layout.groups.back().push_back(tile);
      cells.back().push_back({units(tile.destination.width + media::guard_band),
                              units(tile.destination.height + media::guard_band)});
    }
  }
  layout.size = pack(cells, units(min_frame_side), units(max_frame_side));
  for (size_t g = 0; g < cells.size(); g++)
    for (size_t k = 0; k < cells[g].size(); k++) {
      layout.groups[g][k].destination.x = uint16_t(cells[g][k].x * FVV_TILE_ALIGNMENT);
      layout.groups[g][k].destination.y = uint16_t(cells[g][k].y * FVV_TILE_ALIGNMENT);
    }
  return layout;
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

void arrange(const capture::Capture &capture, Tiling &tiling) {
  fvv_diagnostic diagnostic = {};
  cli::check(fvv_tiles_arrange(tiling.tiles.data(), tiling.tiles.size(), max_frame_side, &tiling.width,
                               &tiling.height, &diagnostic),
             capture.path, diagnostic);
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
  const uint64_t most = plan.options.video_pixels;
  if (!most || tiling.tiles.empty()) return;
  if (!plan.crop.on)
    throw cli::Failure("--video-pixels: expected pictures that are cropped: " + plan.crop.reason, cli::usage);
  const std::vector<fvv_tile> full = tiling.tiles;
  const std::vector<double> useful = usefulness(plan.capture, tiling.cameras, plan.crop.boxes);
  const auto fits = [&](double amount) {
    tiling.tiles = scaled_by_use(full, plan.crop.boxes, useful, amount);
    const Layout layout = lay_out(plan.crop.boxes, tiling);
    return layout.size.width && pixels_of(layout.size) <= most;
  };
  if (fits(1)) return;
  // What a share is worth is found by halves; the frame's size rises with it but for the packing's luck.
  double low = 0, high = 1;
  for (int i = 0; i < 24; i++) (fits((low + high) / 2) ? low : high) = (low + high) / 2;
  if (!fits(low))
    throw cli::Failure("--video-pixels: expected more for " + std::to_string(full.size()) +
                           " cameras: margins and guard bands alone take more than " + std::to_string(most),
                       cli::usage);
}

std::vector<std::vector<fvv_tile>> crop(const Plan &plan, Tiling &tiling) {
  if (!plan.crop.on) {
    arrange(plan.capture, tiling);
    return {};
  }
  Layout layout = lay_out(plan.crop.boxes, tiling);
  if (!layout.size.width)
    throw cli::Failure(plan.capture.path + ": " + std::to_string(tiling.tiles.size()) +
                       " cropped pictures do not fit a frame of " + std::to_string(max_frame_side) + " x " +
                       std::to_string(max_frame_side) + ": make them smaller (--scale, --video-pixels)");
  tiling.width = layout.size.width * FVV_TILE_ALIGNMENT;
  tiling.height = layout.size.height * FVV_TILE_ALIGNMENT;
  tiling.tiles = layout.groups[0];
  return std::move(layout.groups);
}

} // namespace fvv::mux
