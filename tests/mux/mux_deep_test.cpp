// fvvmux --bit-depth: from pictures of 16 bits to a stream of 10.
#include "fvv_media/frame.h"
#include "fvv_mux/report.h"
#include "mux_fixture.h"

#include <set>

namespace {

// The fixture's disc over a wall whose grey rises by 3 codes of 8 bits from left to right.
media::DeepImage deep_picture_of(size_t k, int64_t frame) {
  const media::Image flat = picture_of(k, 64, 48, frame);
  media::DeepImage image = media::make_image<uint16_t>(64, 48, 3, 0);
  for (uint32_t y = 0; y < 48; y++)
    for (uint32_t x = 0; x < 64; x++)
      for (size_t c = 0; c < 3; c++) {
        const size_t at = 3 * (size_t(y) * 64 + x) + c;
        image.pixels[at] = uint16_t(inside(x, y, 64, 48, frame) ? 257 * flat.pixels[at] : 257 * 50 + 12 * x);
      }
  return image;
}

scene::Capture make_deep_capture(const Folder &folder, const Shape &shape = {}) {
  const scene::Capture capture = make_capture(folder, shape);
  for (const int64_t number : capture.frames.numbers())
    for (size_t k = 0; k < capture.cameras.size(); k++) {
      const std::vector<uint8_t> bytes = media::encode_png(deep_picture_of(k, number));
      write_bytes(capture.picture_path(capture.cameras[k], number), bytes.data(), bytes.size());
    }
  return capture;
}

// Different reds of camera 0 in the top row of frame 0, where the wall is, in a stream of any depth.
size_t shades(const std::string &path, media::DeepImage *tile = nullptr) {
  Stream stream(path);
  const fvv_video_layout &video = stream.configuration().videos[0];
  int key = 0;
  const std::vector<uint8_t> bytes = stream.sample(0, key);
  const media::DeepImage picture = media::extract(
      media::Decoder(video.config).decode<uint16_t>(bytes.data(), bytes.size()), video.tiles[0]);
  std::set<uint16_t> reds;
  for (size_t x = 0; x < 64; x++) reds.insert(picture.pixels[3 * x]);
  if (tile) *tile = picture;
  return reds.size();
}

} // namespace

TEST_CASE("10 bits keep what pictures of 16 bits have between the codes of 8") {
  const Folder folder;
  make_deep_capture(folder);
  for (const auto &[codec, text] :
       {std::pair{FVV_CODEC_HVC1, "hvc1.2."}, {FVV_CODEC_VP09, "vp09.02."}, {FVV_CODEC_AV01, "av01.0."}}) {
    CAPTURE(text);
    FileOptions options = options_for(folder);
    options.codec = codec;
    options.quality = {false, 4};
    mux_file(options);
    CHECK(shades(options.output) <= 5);
    options.bit_depth = 10;
    options.verify = true;
    const mux::Report summary = mux_file(options);
    media::DeepImage tile;
    CHECK(shades(options.output, &tile) >= 8);
    {
      Stream stream(options.output);
      const fvv_video_config &config = stream.configuration().videos[0].config;
      CHECK(config.bit_depth == 10);
      CHECK(std::string(config.codec_string, config.codec_string_size).find(text) == 0);
    }
    // The summary's figures are those of the picture, at a peak of white.
    REQUIRE(summary.verdict);
    CHECK(summary.verdict->videos[0].pictures == 5);
    CHECK(std::abs(summary.verdict->videos[0].psnr() - summary.videos[0].sample_psnr) < 4);
    CHECK(std::abs(media::psnr_luma(tile, deep_picture_of(0, 0)) - summary.videos[0].sample_psnr) < 6);
  }
}

TEST_CASE("a target PSNR is reached and verified with 10 bits as with 8", "[long]") {
  const Folder folder;
  Shape shape;
  shape.masks = true;
  make_deep_capture(folder, shape);
  for (const int bits : {8, 10}) {
    FileOptions options = options_for(folder);
    options.codec = FVV_CODEC_VP09;
    options.quality = {true, 40};
    options.bit_depth = bits;
    options.tile_fill = mux::TileFill::flat;
    options.verify = true;
    const mux::Report summary = mux_file(options);
    CHECK(summary.videos[0].sample_foreground);
    CHECK(summary.videos[0].sample_psnr >= 40);
    CHECK(summary.videos[0].sample_psnr < 43);
    CHECK(json_of(summary).at("video").at("bit_depth") == bits);
    CHECK(text_of(summary).find(", " + std::to_string(bits) + " bits, 3 tiles") != std::string::npos);
    // The same for any number of threads.
    const std::string bytes = read_bytes(options.output);
    options.threads = 1;
    mux_file(options);
    CHECK(read_bytes(options.output) == bytes);
  }
}

TEST_CASE("pictures of 8 bits may go into 10") {
  const Folder folder;
  make_capture(folder);
  FileOptions options = options_for(folder);
  options.codec = FVV_CODEC_AV01;
  options.bit_depth = 10;
  options.verify = true;
  const mux::Report summary = mux_file(options);
  CAPTURE(text_of(summary));
  CHECK(summary.verdict->videos[0].psnr() > 40);
}

TEST_CASE("a bit depth is refused where a codec does not have it, before any work") {
  const Folder folder;
  make_capture(folder);
  const auto message = [&](std::vector<std::string> more) {
    std::vector<std::string> words = {folder.path("in"), "-o", folder.path("out.fvv")};
    words.insert(words.end(), more.begin(), more.end());
    const ToolResult run = run_tool(words);
    CHECK(run.exit == 2);
    CHECK(folder.entries() == 1);
    return run.err;
  };
  CHECK(message({"--bit-depth", "10"}) == "fvvmux: --bit-depth: the video has 10 bits a sample, expected 8 "
                                          "for H.264: browsers do not decode High "
                                          "10; HEVC, VP9 and AV1 have 10 bits\n");
  CHECK(message({"--bit-depth", "10", "--codec", "jpeg"}) ==
        "fvvmux: --bit-depth: the video has 10 bits a sample, expected 8 for JPEG: a baseline file has no "
        "more\n");
  CHECK(message({"--bit-depth", "12", "--codec", "av1"}) ==
        "fvvmux: --bit-depth: the video has 12 bits a sample, expected 8 or 10 for AV1\n");
}
