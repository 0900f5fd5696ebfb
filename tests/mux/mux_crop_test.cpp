// fvvmux: crops of what is seen of the scene, packed for each group of frames.
#include "mux_fixture.h"

#include "mux/src/options/option_values.h"

#include "mux/src/layout.h"

namespace {

bool overlap(const mux::Cell &a, const mux::Cell &b) {
  return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
}

// The disc of mask_of in frame, as columns and rows.
struct Disc {
  uint32_t left, top, right, bottom;
  explicit Disc(int64_t frame) : left(64), top(48), right(0), bottom(0) {
    for (uint32_t y = 0; y < 48; y++)
      for (uint32_t x = 0; x < 64; x++) {
        if (!inside(x, y, 64, 48, frame)) continue;
        left = std::min(left, x);
        right = std::max(right, x + 1);
        top = std::min(top, y);
        bottom = std::max(bottom, y + 1);
      }
  }
};

std::vector<fvv_tile> tiles_of(const std::string &path, size_t group) {
  const InputFile file(path);
  const fvv_input input = file.input();
  fvv_stream *stream = nullptr;
  REQUIRE(fvv_stream_open(&input, nullptr, nullptr, &stream, nullptr) == FVV_OK);
  const fvv_tile *tiles = nullptr;
  size_t count = 0;
  REQUIRE(fvv_stream_tiles(stream, group, 2, &tiles, &count, nullptr) == FVV_OK);
  const std::vector<fvv_tile> out(tiles, tiles + count);
  fvv_stream_close(stream);
  return out;
}

FileOptions cropping(const Folder &folder) {
  FileOptions options = options_for(folder);
  options.crop = mux::Crop::automatic;
  options.tile_fill = mux::TileFill::automatic;
  options.quality = {false, 20};
  options.verify = true;
  return options;
}

} // namespace

TEST_CASE("packed cells lie apart inside one frame, the same in every run") {
  uint32_t state = 3;
  const auto random = [&](uint32_t n) { return (state = state * 1664525 + 1013904223) / 65536 % n; };
  for (int round = 0; round < 20; round++) {
    std::vector<std::vector<mux::Cell>> sets(1 + random(4));
    uint64_t largest = 0;
    for (std::vector<mux::Cell> &set : sets) {
      uint64_t area = 0;
      for (uint32_t i = 0, count = 1 + random(20); i < count; i++) {
        set.push_back({1 + random(30), 1 + random(20)});
        area += set.back().width * set.back().height;
      }
      largest = std::max(largest, area);
    }
    std::vector<std::vector<mux::Cell>> again = sets;
    const mux::FrameSize size = mux::pack(sets, 4, {1024, 1024}), other = mux::pack(again, 4, {1024, 1024});
    REQUIRE(size.width > 0);
    CHECK((size.width == other.width && size.height == other.height));
    if (sets[0].size() > 6) CHECK(size.width * size.height < 1.6 * double(largest) + 200);
    for (size_t s = 0; s < sets.size(); s++)
      for (size_t i = 0; i < sets[s].size(); i++) {
        const mux::Cell &cell = sets[s][i];
        CHECK((cell.x == again[s][i].x && cell.y == again[s][i].y));
        CHECK((cell.x + cell.width <= size.width && cell.y + cell.height <= size.height));
        for (size_t k = 0; k < i; k++) CHECK(!overlap(cell, sets[s][k]));
      }
  }
  std::vector<std::vector<mux::Cell>> wide = {{{70, 2}}}, tall = {{{2, 70}}}, none = {{}};
  CHECK(mux::pack(wide, 4, {64, 64}).width == 0);
  CHECK(mux::pack(tall, 4, {64, 64}).width == 0);
  CHECK(mux::pack(none, 4, {64, 64}).width == 0);
  CHECK(mux::pack(tall, 4, {70, 70}).height == 70);
}

TEST_CASE("every group shows its own silhouettes with a margin, and no more") {
  const Folder folder;
  Shape shape;
  shape.masks = true;
  make_capture(folder, shape);
  const FileOptions options = cropping(folder);
  const mux::Report summary = mux_file(options);
  const mux::VideoTrack track = mux::make_plan(options, {}).tracks[0];
  CHECK(summary.crop.cropped);
  CHECK(summary.crop.by_masks == 3);
  CHECK(summary.crop.reason == "to the masks");
  CHECK(summary.crop.layouts == 2); // the configuration has the first group's
  CHECK(summary.verdict->videos[0].pictures == 5);
  Stream stream(options.output);
  const std::vector<media::Image> pictures = stream.pictures();
  for (size_t group = 0; group < 3; group++) {
    const std::vector<fvv_tile> tiles = tiles_of(options.output, group);
    REQUIRE(tiles.size() == 3);
    const int64_t first = int64_t(2 * group), last = std::min<int64_t>(first + 1, 4);
    for (size_t k = 0; k < 3; k++) {
      const fvv_rect &from = tiles[k].source, &to = tiles[k].destination;
      const Disc a(first), b(last);
      CHECK(from.x == a.left - 8);
      CHECK(from.x + from.width == std::min(64u, b.right + 8));
      CHECK(from.y == a.top - 8);
      CHECK((from.width == to.width && from.height == to.height));
      // What came back is the picture, where it was.
      const media::Image shown = media::extract(pictures[size_t(first)], tiles[k]),
                         source = media::crop(picture_of(k, 64, 48, first), from.x, from.y, from.width,
                                              from.height),
                         mask = media::crop(mask_of(64, 48, first), from.x, from.y, from.width, from.height);
      CHECK(media::psnr_luma(shown, source, &mask) > 30);
    }
  }
  CHECK(track.tiling.width * track.tiling.height < 3 * 64 * 64);
}

TEST_CASE("without masks the mesh is used, and without both pictures stay whole") {
  const Folder folder;
  Shape shape;
  make_capture(folder, shape);
  FileOptions options = cropping(folder);
  const mux::Report by_mesh = mux_file(options);
  CHECK(by_mesh.crop.by_mesh == 3);
  CHECK(by_mesh.crop.reason == "to the mesh");
  // The ball of radius 0.5 in 3 m: 12 pixels around the middle, and on the move.
  const fvv_rect from = tiles_of(options.output, 0)[0].source;
  CHECK(from.x >= 32 - 12 - 10);
  CHECK(from.x <= 32 - 11 - 8);
  CHECK(from.width < 2 * 12 + 2 * 8 + 6);
  options.meshes = false;
  options.verify = false;
  const mux::Report whole = mux_file(options);
  CHECK(!whole.crop.cropped);
  CHECK(whole.crop.reason == "there are neither masks nor meshes to crop by");
  CHECK(whole.crop.layouts == 0);
  CHECK(tiles_of(options.output, 1)[0].source.width == 64);
  options = cropping(folder);
  options.crop = mux::Crop::none;
  CHECK(fvv::spell(mux_file(options).crop.reason, fvv::Spelling::command_line) == "as --crop none says");
}

TEST_CASE("scaled crops keep the scale of the whole picture exactly") {
  const Folder folder;
  Shape shape;
  shape.masks = true;
  make_capture(folder, shape);
  FileOptions options = cropping(folder);
  options.tile = mux::TileSize{48, 24};
  mux_file(options);
  for (size_t group = 0; group < 3; group++)
    for (const fvv_tile &tile : tiles_of(options.output, group)) {
      CHECK(tile.source.width * 3 == tile.destination.width * 4);
      CHECK(tile.source.height == tile.destination.height * 2);
      CHECK(tile.source.x % 4 == 0);
      CHECK(tile.source.y % 2 == 0);
    }
}

TEST_CASE("a camera that sees nothing in a group has a small tile") {
  const Folder folder;
  Shape shape;
  shape.masks = true;
  const scene::Capture capture = make_capture(folder, shape);
  for (const int64_t frame : {2, 3})
    write_png(capture.mask_path(capture.cameras[1], frame), media::make_image(64, 48, 1, 0));
  const FileOptions options = cropping(folder);
  mux_file(options);
  CHECK(tiles_of(options.output, 0)[1].destination.width > 20);
  const fvv_rect empty = tiles_of(options.output, 1)[1].destination;
  CHECK((empty.width <= 20 && empty.height <= 20));
  CHECK(tiles_of(options.output, 2)[1].destination.width > 20);
}

TEST_CASE("the background of cameras with masks is flat or smooth, as the codec likes it") {
  const Folder folder;
  Shape shape;
  shape.masks = true;
  shape.count = 2;
  make_capture(folder, shape);
  FileOptions options = cropping(folder);
  options.crop = mux::Crop::none;
  options.quality = {false, 10};
  const auto corner = [&](uint32_t codec, mux::TileFill fill) {
    options.codec = codec;
    options.tile_fill = fill;
    if (codec == FVV_CODEC_JPEG) options.quality = {false, 95};
    mux_file(options);
    Stream stream(options.output);
    const media::Image tile = media::extract(stream.pictures()[0], stream.configuration().videos[0].tiles[2]);
    return int(tile.pixels[3 * (4 * 64 + 4) + 2]);
  };
  // Blue is 40 + 50 k everywhere: 140 in camera 2.
  CHECK(std::abs(corner(FVV_CODEC_AVC1, mux::TileFill::automatic) - 128) < 5);
  CHECK(std::abs(corner(FVV_CODEC_AVC1, mux::TileFill::keep) - 140) < 8);
  // What is smooth runs from one camera to the next.
  CHECK(std::abs(corner(FVV_CODEC_AV01, mux::TileFill::automatic) - 97) < 8);
  CHECK(std::abs(corner(FVV_CODEC_JPEG, mux::TileFill::automatic) - 128) < 5);
  CHECK(std::abs(corner(FVV_CODEC_JPEG, mux::TileFill::smooth) - 97) < 8);
}

TEST_CASE("what is sent around a silhouette has its colours") {
  const Folder folder;
  Shape shape;
  shape.masks = true;
  shape.count = 1;
  const scene::Capture capture = make_capture(folder, shape);
  const scene::Camera &camera = capture.cameras[2];
  media::Image picture = media::make_image(64, 48, 3, 20), mask = media::make_image(64, 48, 1, 0);
  for (size_t i = 0; i < mask.pixels.size(); i++)
    if (i % 64 < 32) mask.pixels[i] = picture.pixels[3 * i] = 220;
  const int64_t frame = capture.frames.numbers().front();
  write_png(capture.picture_path(camera, frame), picture);
  write_png(capture.mask_path(camera, frame), mask);
  FileOptions options = cropping(folder);
  options.crop = mux::Crop::none;
  options.codec = FVV_CODEC_JPEG;
  options.quality = {false, 95};
  const auto red = [&](mux::TileFill fill, size_t x) {
    options.tile_fill = fill;
    mux_file(options);
    Stream stream(options.output);
    const media::Image tile = media::extract(stream.pictures()[0], stream.configuration().videos[0].tiles[2]);
    return int(tile.pixels[3 * (24 * 64 + x)]);
  };
  for (const size_t x : {33u, 37u}) {
    CHECK(red(mux::TileFill::keep, x) < 40);
    CHECK(red(mux::TileFill::flat, x) > 190);
    CHECK(red(mux::TileFill::smooth, x) > 150);
  }
  CHECK(std::abs(red(mux::TileFill::flat, 50) - 128) < 10);
}

TEST_CASE("a bound of the frame's pixels is kept, and the useful cameras get more of them") {
  const Folder folder;
  Shape shape;
  shape.masks = true;
  shape.sizes = {{160, 120}, {160, 120}, {160, 120}};
  const scene::Capture capture = make_capture(folder, shape);
  // Camera 2 sees a small part only.
  for (const int64_t frame : capture.frames.numbers()) {
    media::Image mask = media::make_image(160, 120, 1, 0);
    for (size_t y = 0; y < 120; y++)
      for (size_t x = 0; x < 160; x++) mask.pixels[y * 160 + x] = x < 100 && y < 90 ? 255 : 0;
    for (const size_t k : {0u, 1u}) write_png(capture.mask_path(capture.cameras[k], frame), mask);
  }
  FileOptions options = cropping(folder);
  uint64_t before = UINT64_MAX;
  for (const uint64_t bound : {1000000u, 20000u, 9000u}) {
    options.video_pixels = bound;
    const mux::Tiling tiling = mux::make_plan(options, {}).tracks[0].tiling;
    const uint64_t pixels = uint64_t(tiling.width) * tiling.height;
    CHECK(pixels <= bound);
    CHECK(pixels < before);
    before = pixels;
    const auto scale = [&](size_t k) {
      return double(tiling.tiles[k].destination.width) / tiling.tiles[k].source.width;
    };
    if (bound == 1000000) CHECK((scale(0) == 1 && scale(2) == 1));
    if (bound == 20000) CHECK(scale(0) < 1);
    if (bound == 9000) CHECK(scale(0) < 0.7);
    CHECK(std::abs(scale(0) - scale(1)) < 0.03);
  }
  options.video_pixels = 4096;
  options.cameras = {"3"};
  CHECK(mux_file(options).videos[0].cameras.size() == 1);
  options.crop = mux::Crop::none;
  CHECK_THROWS_WITH(mux_file(options), "video-pixels: expected pictures that are cropped: as crop=none says");
}

TEST_CASE("a bound of the frame's sides is kept") {
  const Folder folder;
  Shape shape;
  shape.masks = true;
  shape.sizes = {{160, 120}, {160, 120}, {160, 120}};
  make_capture(folder, shape);
  FileOptions options = cropping(folder);
  const mux::Tiling full = mux::make_plan(options, {}).tracks[0].tiling;
  for (const mux::TileSize bound : {mux::TileSize{1920, 1080}, {128, 72}, {64, 192}}) {
    options.video_size = bound;
    const mux::Plan plan = mux::make_plan(options, {});
    REQUIRE(plan.tracks.size() == 1);
    const mux::Tiling &tiling = plan.tracks[0].tiling;
    CHECK((tiling.width <= bound.width && tiling.height <= bound.height));
    const bool same = tiling.width == full.width && tiling.height == full.height;
    CHECK(same == (bound.width == 1920));
  }
  // What decoders take bounds it too: no second track.
  options.video_size = mux::TileSize{1920, 1080};
  {
    const mux::AssumedDecoder decoder({64, 192, 100000, "a test"});
    CHECK(mux::make_plan(options, {}).tracks.size() == 1);
  }
  options.video_size = mux::TileSize{64, 64};
  const mux::AssumedDecoder decoder({32, 192, 100000, "a test"}); // less than any frame has
  CHECK_THROWS_WITH(mux::make_plan(options, {}), "video-size: expected more for 3 cameras: margins and guard "
                                                 "bands alone take more than 64x64");
  CHECK(mux::parse_video_size("video-size", "1920x1080").height == 1080);
  for (const char *wrong : {"1920", "1920x", "63x64", "64x8193", "-1x64", "64x64x64"})
    CHECK_THROWS_AS(mux::parse_video_size("video-size", wrong), fvv::Error);
  CHECK(run_tool({options.capture, "-o", options.output, "--video-size", "64x64", "--video-pixels", "9k"})
            .exit == cli::usage);
}

TEST_CASE("cropped streams are the same for any number of threads") {
  const Folder folder;
  Shape shape;
  shape.masks = true;
  make_capture(folder, shape);
  FileOptions options = cropping(folder);
  options.codec = FVV_CODEC_HVC1;
  options.threads = 1;
  mux_file(options);
  const std::string one = read_bytes(options.output);
  options.threads = 3;
  mux_file(options);
  CHECK(read_bytes(options.output) == one);
}
