#include "mux/src/layout.h"
#include "fvv_cxx/error.h"
#include "fvv_cxx/format.h"
#include "fvv_cxx/parallel.h"
#include "fvv_geometry/rect_pack.h"
#include "fvv_media/frame.h"
#include "fvv_scene/capture.h"
#include "mux/src/crop.h"
#include "mux/src/meshes/meshes.h"
#include "mux/src/pictures.h"
#include "mux/src/plan.h"
#include "mux/src/stream_writer.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

namespace fvv::mux {

uint16_t scaled(uint32_t size, double scale) {
  return uint16_t(std::max(1.0, std::round(size * scale)));
}

namespace {

constexpr uint32_t texture_side = 8192; // WebGL 2 in the browsers of today
constexpr uint32_t macroblock = 256;    // pixels

// Of level 5.2. pixels of a frame, and of all frames of a second.
struct Level {
  uint32_t codec;
  const char *name;
  uint32_t width, height;
  uint64_t pixels, per_second;
};
constexpr Level levels[] = {
    // ITU-T H.264 table A-1: MaxFS, MaxMBPS.
    {FVV_CODEC_AVC1, "H.264 level 5.2", texture_side, texture_side, 36864 * macroblock, 2073600 * macroblock},
    // ITU-T H.265 table A.8, A.9: MaxLumaPs, MaxLumaSr.
    {FVV_CODEC_HVC1, "HEVC level 5.2", texture_side, texture_side, 8912896, 1069547520},
    // VP9 bitstream specification, annex A.
    {FVV_CODEC_VP09, "VP9 level 5.2", texture_side, texture_side, 8912896, 1176502272},
    // AV1 bitstream specification, A.3: MaxPicSize, MaxHSize, MaxVSize, MaxDisplayRate.
    {FVV_CODEC_AV01, "AV1 level 5.2", texture_side, 4352, 8912896, 1069547520}};

} // namespace

namespace {

thread_local std::optional<FrameLimit> assumed_limit;

} // namespace

AssumedDecoder::AssumedDecoder(const FrameLimit &limit) : former(assumed_limit) {
  assumed_limit = limit;
}
AssumedDecoder::~AssumedDecoder() {
  assumed_limit = former;
}

FrameLimit decoder_limit(const Options &options, const fvv_rational &frame_duration) {
  if (assumed_limit) return *assumed_limit;
  for (const Level &level : levels) {
    if (level.codec != options.codec) continue;
    const double rate = double(level.per_second) * frame_duration.numerator / frame_duration.denominator;
    return {level.width, level.height, uint64_t(std::min(double(level.pixels), rate)), level.name};
  }
  return {texture_side, texture_side, uint64_t(texture_side) * texture_side, "textures of browsers"};
}

FrameLimit frame_limit(const Options &options, const fvv_rational &frame_duration) {
  FrameLimit limit = decoder_limit(options, frame_duration);
  if (options.video_pixels) limit.pixels = std::min(limit.pixels, options.video_pixels);
  if (options.video_size) {
    limit.width = std::min<uint32_t>(limit.width, options.video_size->width);
    limit.height = std::min<uint32_t>(limit.height, options.video_size->height);
  }
  return limit;
}

bool fits(uint32_t width, uint32_t height, const FrameLimit &limit) {
  return width <= limit.width && height <= limit.height && uint64_t(width) * height <= limit.pixels;
}

std::string limit_text(const FrameLimit &limit) {
  return std::to_string(limit.width) + "x" + std::to_string(limit.height) + " and " +
         std::to_string(limit.pixels) + " pixels (" + limit.name + ")";
}

namespace {

// Runs filled up to most in order, each leaving at least one weight for every later run; the last one takes
// the rest.
std::vector<size_t> filled(const std::vector<uint64_t> &weights, size_t count, uint64_t most) {
  std::vector<size_t> ends;
  size_t at = 0;
  for (size_t run = 0; run < count; run++) {
    const size_t last = weights.size() - (count - 1 - run); // one past what it may take
    uint64_t sum = weights[at++];
    while (at < last && sum + weights[at] <= most) sum += weights[at++];
    ends.push_back(at);
  }
  return ends;
}

} // namespace

std::vector<size_t> balanced_runs(const std::vector<uint64_t> &weights, size_t count) {
  uint64_t low = *std::max_element(weights.begin(), weights.end()), high = 0;
  for (const uint64_t weight : weights) high += weight;
  while (low < high) {
    const uint64_t middle = low + (high - low) / 2;
    if (filled(weights, count, middle).back() == weights.size())
      high = middle;
    else
      low = middle + 1;
  }
  return filled(weights, count, high);
}

namespace {

constexpr double same = 1e-6; // cosines, and distances by their ratio: the accuracy of calibrations

// How far apart two cameras, or the most distant of two sets, are.
struct CameraDistance {
  double turned = 0, distance = 0; // 1 - cosine between the optical axes; between the centres, metres

  bool operator<(const CameraDistance &other) const {
    return std::abs(turned - other.turned) > same ? turned < other.turned
                                                  : distance < (1 - same) * other.distance;
  }
};

CameraDistance distance_of(const fvv_camera &a, const fvv_camera &b) {
  double cosine = 0, squares = 0;
  for (int i = 0; i < 3; i++) {
    double gap = 0; // of the centres: -R^T t
    for (int k = 0; k < 3; k++)
      gap += b.rotation[3 * k + i] * b.translation[k] - a.rotation[3 * k + i] * a.translation[k];
    cosine += a.rotation[6 + i] * b.rotation[6 + i]; // the third rows: the optical axes
    squares += gap * gap;
  }
  return {1 - cosine, std::sqrt(squares)};
}

// Cameras (indices in Capture::cameras) in count sets, at most one for each camera: as places in that list,
// rising, the sets by their first. Begins with each camera alone, and again and again joins the two sets
// whose most different viewing directions are nearest; at equal angles (cameras side by side) those whose
// farthest cameras are nearest, then the first. Cameras that move count as they are in the first frame in
// which they are calibrated.
std::vector<std::vector<size_t>> neighbours(const scene::Capture &capture, const std::vector<size_t> &cameras,
                                            size_t count) {
  std::vector<fvv_camera> seen;
  std::vector<std::vector<size_t>> sets;
  for (const size_t index : cameras) {
    sets.push_back({seen.size()});
    seen.push_back(described(capture, capture.cameras[index]));
  }
  const auto between = [&](const std::vector<size_t> &a, const std::vector<size_t> &b) {
    CameraDistance most;
    for (const size_t i : a)
      for (const size_t k : b) most = std::max(most, distance_of(seen[i], seen[k]));
    return most;
  };
  while (sets.size() > std::max<size_t>(count, 1)) {
    std::pair<size_t, size_t> nearest = {0, 1};
    CameraDistance least = between(sets[0], sets[1]);
    for (size_t i = 0; i < sets.size(); i++)
      for (size_t k = i + 1; k < sets.size(); k++) {
        const CameraDistance found = between(sets[i], sets[k]);
        if (found < least) std::tie(least, nearest) = std::make_tuple(found, std::make_pair(i, k));
      }
    std::vector<size_t> &set = sets[nearest.first], &other = sets[nearest.second];
    set.insert(set.end(), other.begin(), other.end());
    std::sort(set.begin(), set.end());
    sets.erase(sets.begin() + std::ptrdiff_t(nearest.second));
  }
  return sets;
}

constexpr uint32_t longest = 4; // times the other side

uint64_t area_of(const std::vector<Cell> &cells) {
  uint64_t area = 0;
  for (const Cell &cell : cells) area += uint64_t(cell.width) * cell.height;
  return area;
}

// The height that a set takes in a width, 0 when it is more than most; places: where cells go.
uint32_t height_in(const std::vector<Cell> &cells, uint32_t width, uint32_t most, std::vector<Cell> &places) {
  uint32_t best = 0;
  for (const int heuristic : {STBRP_HEURISTIC_Skyline_BL_sortHeight, STBRP_HEURISTIC_Skyline_BF_sortHeight}) {
    std::vector<stbrp_node> nodes(width);
    std::vector<stbrp_rect> rectangles(cells.size());
    for (size_t i = 0; i < cells.size(); i++)
      rectangles[i] = {int(i), int(cells[i].width), int(cells[i].height), 0, 0, 0};
    stbrp_context context;
    stbrp_init_target(&context, int(width), int(most), nodes.data(), int(width));
    stbrp_setup_heuristic(&context, heuristic);
    if (!stbrp_pack_rects(&context, rectangles.data(), int(rectangles.size()))) continue;
    uint32_t height = 0;
    for (const stbrp_rect &r : rectangles) height = std::max(height, uint32_t(r.y + r.h));
    if (best && height >= best) continue;
    best = height;
    places = cells;
    for (size_t i = 0; i < places.size(); i++) {
      places[i].x = uint32_t(rectangles[i].x);
      places[i].y = uint32_t(rectangles[i].y);
    }
  }
  return best;
}

bool better(const FrameSize &a, const FrameSize &b) {
  const uint64_t area = uint64_t(a.width) * a.height, other = uint64_t(b.width) * b.height;
  if (!other || area != other) return !other || area < other;
  return std::max(a.width, a.height) < std::max(b.width, b.height);
}

} // namespace

FrameSize pack(std::vector<std::vector<Cell>> &sets, uint32_t least, const FrameBound &most) {
  uint64_t area = 0;
  uint32_t widest = least, tallest = least;
  // The largest set first: most widths end there.
  std::vector<size_t> order;
  for (size_t i = 0; i < sets.size(); i++) {
    order.push_back(i);
    area = std::max(area, area_of(sets[i]));
    for (const Cell &cell : sets[i]) {
      widest = std::max(widest, cell.width);
      tallest = std::max(tallest, cell.height);
    }
  }
  if (!area || area > most.area) return {0, 0};
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return area_of(sets[a]) > area_of(sets[b]); });
  FrameSize best = {0, 0};
  std::vector<std::vector<Cell>> placed, trial(sets.size());
  // No frame that is smaller than twice the cells needs more: the skyline wastes less than a half.
  const uint32_t last = std::max(
      widest, uint32_t(std::min<double>(most.width, std::ceil(std::sqrt(2.0 * longest * double(area))))));
  for (uint32_t width = widest; width <= std::min(last, most.width); width++) {
    uint64_t limit = std::min<uint64_t>(most.height, std::max(longest * width, tallest));
    limit = std::min(limit, most.area / width);
    if (best.height) limit = std::min<uint64_t>(limit, uint64_t(best.width) * best.height / width);
    uint32_t height = least;
    for (const size_t i : order) {
      const uint32_t own = limit ? height_in(sets[i], width, uint32_t(limit), trial[i]) : 0;
      height = own ? std::max(height, own) : 0;
      if (!height) break;
    }
    if (!height || !better({width, height}, best)) continue;
    best = {width, height};
    placed = trial;
  }
  if (best.height) sets = std::move(placed);
  return best;
}

namespace {

constexpr int steps = 16; // of the scale

// Pixels of the capture's picture, mean over the groups.
double mean_area(const std::vector<std::vector<Silhouette>> &boxes, size_t camera) {
  double sum = 0;
  for (const std::vector<Silhouette> &group : boxes)
    sum += double(group[camera].right - group[camera].left) * (group[camera].bottom - group[camera].top);
  return std::max(1.0, sum / double(boxes.size()));
}

// Of each camera (indices in Capture::cameras), in shares of 1: the solid angle of what it sees of the scene,
// mean over the groups, divided by how many cameras look from where it does. That is the sum, over all
// cameras, itself included, of the squared cosine of the angle between the directions in which they look, or
// 0 beyond a right angle. A camera that is farther away, or one of three side by side, is worth less. Cameras
// that move count as they are in the first frame in which they are calibrated.
std::vector<double> usefulness(const scene::Capture &capture, const std::vector<size_t> &cameras,
                               const std::vector<std::vector<Silhouette>> &boxes) {
  std::vector<fvv_camera> seen;
  for (const size_t index : cameras) seen.push_back(described(capture, capture.cameras[index]));
  std::vector<double> out;
  double sum = 0;
  for (size_t k = 0; k < seen.size(); k++) {
    double together = 0;
    for (const fvv_camera &other : seen) {
      double cosine = 0; // of the third rows: the optical axes
      for (int i = 6; i < 9; i++) cosine += seen[k].rotation[i] * other.rotation[i];
      together += cosine > 0 ? cosine * cosine : 0;
    }
    out.push_back(mean_area(boxes, k) / (seen[k].fx * seen[k].fy) / std::max(together, 1.0));
    sum += out.back();
  }
  for (double &value : out) value /= sum;
  return out;
}

// Whole pictures of the size at which what is seen of the scene (mean over the groups) has amount, 0 to 1,
// times all pixels that it has in full, shared out by usefulness: never larger than in full, nor smaller than
// 1/16 of it on each side. Sizes are multiples of 1/16 of full, as near as whole pixels come.
std::vector<fvv_tile> scaled_by_use(const std::vector<fvv_tile> &full,
                                    const std::vector<std::vector<Silhouette>> &boxes,
                                    const std::vector<double> &usefulness, double amount) {
  std::vector<double> pixels; // in full
  double all = 0;
  for (size_t k = 0; k < full.size(); k++) {
    pixels.push_back(mean_area(boxes, k) * full[k].destination.width * full[k].destination.height /
                     (double(full[k].source.width) * full[k].source.height));
    all += pixels.back();
  }
  // What a camera cannot use is distributed among the others: the water level that gives amount * all.
  const auto total = [&](double level) {
    double sum = 0;
    for (size_t k = 0; k < full.size(); k++) sum += std::min(pixels[k], level * usefulness[k]);
    return sum;
  };
  double low = 0, high = 1;
  for (size_t k = 0; k < full.size(); k++) high = std::max(high, pixels[k] / usefulness[k]);
  for (int i = 0; i < 60; i++) (total((low + high) / 2) < amount * all ? low : high) = (low + high) / 2;
  std::vector<fvv_tile> out = full;
  for (size_t k = 0; k < full.size(); k++) {
    const double scale = std::sqrt(std::min(1.0, high * usefulness[k] / pixels[k]));
    const double part = std::clamp(std::floor(scale * steps + 1e-6), 1.0, double(steps)) / steps;
    const auto side = [&](uint16_t size) { return uint16_t(std::max(1.0, std::round(size * part))); };
    out[k].destination.width = side(full[k].destination.width);
    out[k].destination.height = side(full[k].destination.height);
  }
  return out;
}

constexpr uint32_t max_frame_side = 16384;
constexpr uint32_t min_frame_side = 64; // minimum of AV1's encoder
constexpr uint32_t margin = 4;          // pixels of the transmitted picture around the visible scene
// A step of the crop in transmitted pixels, so that the crop has exactly the scale of the whole picture.
// Where the ratio of the sizes needs a longer one, the scale is rounded to whole pixels.
constexpr uint32_t longest_step = 16;

// One axis: part of a picture and the pixels that it becomes.
struct Span {
  uint16_t source, source_size, destination_size;
};

// Of a picture of size source pixels that is sent in size whole: low ... high - 1 with the margin.
Span span_of(uint32_t low, uint32_t high, uint32_t source, uint32_t whole) {
  const uint32_t common = std::gcd(source, whole);
  const bool exact = whole / common <= longest_step;
  const uint32_t step = exact ? source / common : 1, becomes = exact ? whole / common : 0;
  // Everything that flatten keeps is inside.
  const uint32_t border = std::max(tile_fill_margin, (margin * source + whole - 1) / whole);
  low = low > border ? (low - border) / step * step : 0;
  high = std::min(source, (std::min(source, high + border) + step - 1) / step * step);
  const uint32_t size = high - low;
  const uint32_t destination =
      exact ? size / step * becomes : uint32_t(std::max(1.0, std::round(double(size) * whole / source)));
  return {uint16_t(low), uint16_t(size), uint16_t(destination)};
}

fvv_tile cropped(const fvv_tile &whole, const Silhouette &box) {
  const uint32_t width = whole.source.width, height = whole.source.height;
  // Nothing is visible: a small tile, so that every group shows every camera.
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
using MaybeLayout = std::optional<Layout>; // empty: they do not fit

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

// Pictures without a place, and what to crop them to: of each group and picture; no groups: they stay
// whole.
struct UnplacedPictures {
  Tiling tiling;
  std::vector<std::vector<Silhouette>> boxes;
};

UnplacedPictures pictures_of(const Plan &plan, const Tiling &whole, const std::vector<size_t> &places) {
  UnplacedPictures out;
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
MaybeLayout lay_out(const UnplacedPictures &all, size_t first, size_t end, const FrameLimit &limit) {
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
std::vector<uint64_t> weights_of(const UnplacedPictures &all) {
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

// A picture beyond every level of the codec is sent unchanged, in a frame of its own.
Layout lay_out_alone(Plan &plan, const UnplacedPictures &all, size_t k, const FrameLimit &limit) {
  const std::string camera = scene::describe(plan.capture.cameras[all.tiling.cameras[k]]);
  const MaybeLayout layout =
      lay_out(all, k, k + 1,
              {max_frame_side, max_frame_side, uint64_t(max_frame_side) * max_frame_side, "the format"});
  if (!layout)
    throw Error(plan.capture.path + ": the picture of " + camera + " does not fit a frame of " +
                std::to_string(max_frame_side) + " x " + std::to_string(max_frame_side) +
                ": make it smaller (" + option_name("scale") + ", " + option_name("video-size") + ")");
  plan.observer.warn(plan.capture.path + ": the picture of " + camera + " takes a frame of " +
                     std::to_string(layout->tiling.width) + " x " + std::to_string(layout->tiling.height) +
                     " pixels; decoders are sure to take " + limit_text(limit));
  plan.warned = true;
  return *layout;
}

// In that number of tracks; none if these are too few.
std::vector<Layout> lay_out_tracks(Plan &plan, const UnplacedPictures &all, const std::vector<size_t> &ends) {
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
    return plan.options.crop == Crop::none ? "as " + option_name("crop", "none") + " says"
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

Tiling whole_pictures(const scene::Capture &capture, const Options &options) {
  Tiling tiling;
  for (size_t i = 0; i < capture.cameras.size(); i++) {
    const fvv_camera &camera = capture.cameras[i].calibration;
    if (!capture.cameras[i].pictures) continue;
    // check_files has found the files to be of this size, and no picture file that is read is larger.
    fvv_tile tile = {camera.id, {0, 0, uint16_t(camera.width), uint16_t(camera.height)}, {}};
    const double rung = options.ladder.empty() ? 1 : options.ladder[0].scale;
    tile.destination.width =
        options.tile ? scaled(options.tile->width, rung) : scaled(camera.width, options.scale * rung);
    tile.destination.height =
        options.tile ? scaled(options.tile->height, rung) : scaled(camera.height, options.scale * rung);
    if (tile.destination.width > camera.width || tile.destination.height > camera.height)
      throw Error(option_name("tile") + ": expected at most the size of every picture, found " +
                      std::to_string(tile.destination.width) + "x" + std::to_string(tile.destination.height) +
                      " for camera " + std::to_string(camera.id) + " with " + std::to_string(camera.width) +
                      "x" + std::to_string(camera.height),
                  Error::usage);
    tiling.cameras.push_back(i);
    tiling.tiles.push_back(tile);
  }
  return tiling;
}

scene::AtlasSize find_atlas_size(Plan &plan) {
  const scene::Capture &capture = plan.capture;
  if (capture.atlas->pictures) {
    const media::Image picture = load_atlas<uint8_t>(plan, capture.frames.number(0));
    return {picture.width, picture.height, 1};
  }
  std::vector<int64_t> numbers = capture.mesh_frames();
  if (capture.animation || !capture.meshes->is_numbered()) numbers.resize(1); // one file
  scene::AtlasSize largest;
  int64_t reduced = 0;
  std::mutex mutex;
  fvv::parallel(plan.options.threads, numbers.size(), [&](size_t i) {
    plan.observer.check_cancelled();
    const scene::AtlasSize own =
        about_frame(capture, numbers[i], [&] { return scene::embedded_atlas_size(capture, numbers[i]); });
    const std::lock_guard<std::mutex> lock(mutex);
    largest.width = std::max(largest.width, own.width);
    largest.height = std::max(largest.height, own.height);
    if (own.scale < largest.scale || (own.scale == largest.scale && own.scale < 1 && numbers[i] < reduced))
      reduced = numbers[i];
    largest.scale = std::min(largest.scale, own.scale);
  });
  if (largest.scale < 1) {
    plan.observer.warn(capture.mesh_path(reduced) + ": its pictures are packed into one atlas with " +
                       fvv::format("%g", largest.scale) +
                       " of their width and height: they are too large together");
    plan.warned = true;
  }
  return largest;
}

// Chroma of two pixels a side needs even sides, which scaling gives: texture coordinates are fractions of the
// picture.
Tiling arrange_atlas(const Plan &plan, size_t rung, uint32_t width, uint32_t height) {
  const Options &options = plan.options;
  const double scale = options.atlas_scale * (options.ladder.empty() ? 1 : options.ladder[rung].scale);
  const auto side = [&](uint32_t size) {
    const uint16_t wanted = scaled(size, scale);
    return media::find_video_codec(options.codec)->is_stills() ? wanted : uint16_t(std::max(2, wanted & ~1));
  };
  Tiling tiling;
  tiling.width = side(width);
  tiling.height = side(height);
  tiling.tiles = {{UINT16_MAX,
                   {0, 0, uint16_t(width), uint16_t(height)},
                   {0, 0, uint16_t(tiling.width), uint16_t(tiling.height)}}};
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
  const char *option = options.video_pixels ? "video-pixels" : "video-size";
  if (!plan.crop.on) refuse_option(option, "expected pictures that are cropped: " + plan.crop.reason);
  const std::vector<fvv_tile> full = tiling.tiles;
  const std::vector<double> useful = usefulness(plan.capture, tiling.cameras, plan.crop.boxes);
  const auto fits = [&](double amount) {
    tiling.tiles = scaled_by_use(full, plan.crop.boxes, useful, amount);
    return lay_out({tiling, plan.crop.boxes}, 0, full.size(), plan.frame_limit).has_value();
  };
  if (fits(1)) return;
  // Found by bisection; the frame's size rises with the amount, except for variations of the packing.
  double low = 0, high = 1;
  for (int i = 0; i < 24; i++) (fits((low + high) / 2) ? low : high) = (low + high) / 2;
  if (!fits(low))
    throw Error(option_name(option) + ": expected more for " + std::to_string(full.size()) +
                    " cameras: margins and guard bands alone take more than " +
                    (options.video_pixels ? std::to_string(options.video_pixels)
                                          : std::to_string(options.video_size->width) + "x" +
                                                std::to_string(options.video_size->height)),
                Error::usage);
}

std::vector<VideoTrack> tile_tracks(Plan &plan, const Tiling &whole) {
  std::vector<VideoTrack> tracks;
  if (whole.tiles.empty()) return tracks;
  for (const std::vector<size_t> &set : neighbours(plan.capture, whole.cameras, plan.options.video_tracks)) {
    const UnplacedPictures all = pictures_of(plan, whole, set);
    const std::vector<uint64_t> weights = weights_of(all);
    std::vector<Layout> layouts;
    for (size_t count = 1; layouts.empty();
         count++) // with one for each camera there is a result, or an exception
      layouts = lay_out_tracks(plan, all, balanced_runs(weights, count));
    for (Layout &layout : layouts) {
      tracks.push_back({FVV_SHOWS_TILES, std::move(layout.tiling), std::move(layout.groups)});
      tracks.back().part = tracks.size() - 1;
    }
  }
  return tracks;
}

std::vector<Rung> ladder_of_rates(const std::vector<uint64_t> &rates) {
  std::vector<Rung> ladder;
  for (const uint64_t rate : rates)
    ladder.push_back({std::pow(double(rate) / double(rates[0]), 1 / rate_of_scale), rate});
  return ladder;
}

void check_ladder(const Options &options) {
  const std::vector<Rung> &ladder = options.ladder;
  const auto refuse = [](const std::string &expected, const std::string &found) {
    throw Error(option_name("ladder") + ": expected " + expected + ", found " + found, Error::usage);
  };
  if (ladder.empty()) return;
  if (ladder.size() < 2 || ladder.size() > most_rungs)
    refuse("2 to " + std::to_string(most_rungs) + " rungs", std::to_string(ladder.size()));
  for (size_t i = 0; i < ladder.size(); i++) {
    if (!(ladder[i].scale > 0 && ladder[i].scale <= 1))
      refuse("scales above 0 and at most 1", fvv::format("%g", ladder[i].scale));
    if (ladder[i].psnr) {
      if (ladder[i].scale != 1) refuse("the scale 1 with a PSNR", fvv::format("%g", ladder[i].scale));
      if (i && !(ladder[i].psnr < ladder[i - 1].psnr))
        refuse("falling PSNR", fvv::format("%g after %g", ladder[i].psnr, ladder[i - 1].psnr));
    } else if (i && !(ladder[i].scale < ladder[i - 1].scale))
      refuse("every rung lower than the one before",
             fvv::format("%g after %g", ladder[i].scale, ladder[i - 1].scale));
    if (!ladder[i].bit_rate != !ladder[0].bit_rate) refuse("bit rates of all rungs or of none", "both");
    if (!ladder[i].psnr != !ladder[0].psnr) refuse("a PSNR of all rungs or of none", "both");
    if (ladder[i].psnr && options.bit_rate) refuse("a PSNR of each rung without bits a second", "both");
    if (ladder[i].psnr && options.codec == FVV_CODEC_OEXR)
      refuse("scales with pictures that are lossless", fvv::format("%g dB", ladder[i].psnr));
  }
}

namespace {

// Pictures without a place in the size of a rung.
std::vector<fvv_tile> at_scale(std::vector<fvv_tile> tiles, double scale) {
  for (fvv_tile &tile : tiles) {
    tile.destination.width = scaled(tile.destination.width, scale);
    tile.destination.height = scaled(tile.destination.height, scale);
  }
  return tiles;
}

// Places in plan.whole.
std::vector<size_t> places_of(const Plan &plan, const std::vector<size_t> &cameras) {
  std::vector<size_t> out;
  for (const size_t camera : cameras)
    out.push_back(size_t(std::find(plan.whole.cameras.begin(), plan.whole.cameras.end(), camera) -
                         plan.whole.cameras.begin()));
  return out;
}

VideoTrack lower_track(Plan &plan, const VideoTrack &best, size_t rung) {
  VideoTrack track = {best.shows, {}, {}};
  if (best.is_atlas()) {
    const fvv_rect &whole = best.tiling.tiles[0].source;
    track.tiling = arrange_atlas(plan, rung, whole.width, whole.height);
  } else {
    UnplacedPictures all = pictures_of(plan, plan.whole, places_of(plan, best.tiling.cameras));
    all.tiling.tiles = at_scale(all.tiling.tiles, plan.rung_scale(rung));
    std::vector<Layout> layouts = lay_out_tracks(plan, all, {all.tiling.tiles.size()});
    if (layouts.empty())
      throw Error(plan.capture.path + ": the cameras of a track do not fit one frame at rung " +
                  std::to_string(rung));
    track.tiling = std::move(layouts[0].tiling);
    track.groups = std::move(layouts[0].groups);
  }
  track.part = best.part;
  return track;
}

} // namespace

void add_rungs(Plan &plan) {
  const size_t first = plan.tracks.size();
  uint16_t next = 0; // identifier
  for (size_t i = 0; i < first; i++) {
    VideoTrack &track = plan.tracks[i];
    track.best = i;
    track.id = track.is_atlas() ? atlas_track : track.part ? uint16_t(last_track + track.part) : camera_track;
    next = std::max<uint16_t>({next, uint16_t(track.id + 1), last_track + 1});
  }
  bool any = false;
  for (size_t rung = 1; rung < plan.rung_count(); rung++)
    for (size_t i = 0; i < first; i++) {
      if (plan.tracks[i].encoded) continue;
      any = true;
      plan.tracks[i].alternate_group = uint16_t(i + 1);
      VideoTrack track = lower_track(plan, plan.tracks[i], rung);
      track.rung = rung;
      track.best = i;
      track.id = next++;
      track.alternate_group = uint16_t(i + 1);
      plan.tracks.push_back(std::move(track));
    }
  if (plan.rung_count() > 1 && !any)
    throw Error(plan.capture.path + ": " + option_name("ladder") + ": there are no pictures to encode",
                Error::usage);
}

void leave_room(Plan &plan, const Tiling &tiling) {
  for (std::vector<Silhouette> &group : plan.crop.boxes)
    for (size_t k = 0; k < group.size(); k++) {
      Silhouette &box = group[k];
      if (box.empty()) continue;
      const fvv_camera &camera = plan.capture.cameras[tiling.cameras[k]].calibration;
      const uint32_t x = (box.right - box.left) / 8, y = (box.bottom - box.top) / 8;
      box = {box.left - std::min(box.left, x), box.top - std::min(box.top, y),
             std::min(camera.width, box.right + x), std::min(camera.height, box.bottom + y)};
    }
}

void lay_out_group(Plan &plan, const std::vector<Silhouette> &boxes) {
  constexpr double smaller = 0.9, smallest = 0.01;
  for (VideoTrack &track : plan.tracks) {
    if (track.groups.empty()) continue;
    std::vector<fvv_tile> full;
    std::vector<Silhouette> own;
    for (const size_t k : places_of(plan, track.tiling.cameras)) {
      full.push_back(plan.whole.tiles[k]);
      own.push_back(boxes[k]);
    }
    full = at_scale(std::move(full), plan.rung_scale(track.rung));
    const FrameLimit frame = {track.tiling.width, track.tiling.height,
                              uint64_t(track.tiling.width) * track.tiling.height, "the stream's video frame"};
    Tiling whole = {track.tiling.cameras, full};
    MaybeLayout layout;
    for (double scale = 1; !(layout = pack_crops({own}, whole, frame));) {
      scale *= smaller;
      if (scale < smallest)
        throw Error("frames in memory: the pictures of a group do not fit the video frame");
      whole.tiles = at_scale(full, scale);
    }
    track.groups.push_back(std::move(layout->groups[0]));
  }
}

} // namespace fvv::mux
