// fvvmux: cameras spread over several video tracks when one frame would be more than decoders take.
#include "mux_fixture.h"

#include "mux/src/options/option_values.h"

#include "fvv_cxx/parallel.h"
#include "fvv_mux/report.h"
#include "fvvdemux/demux.h"
#include "mux/src/layout.h"
#include "mux/src/pictures.h"
#include "mux/src/stream_writer.h"

#include <atomic>
#include <thread>

namespace {

// A decoder for which four pictures of 64x48 fill a frame.
mux::FrameLimit limit_of(uint64_t pixels = 4 * 64 * 48) {
  return {8192, 8192, pixels, "a test"};
}

// Five cameras with pictures of 64x48, whole: four of them fill a frame of 128x96, and three need one too.
FileOptions spread(const Folder &folder, Shape shape = {}) {
  shape.sizes.assign(5, {64, 48});
  make_capture(folder, shape);
  FileOptions options = options_for(folder);
  options.quality = {false, 10};
  return options;
}

std::vector<std::vector<size_t>> cameras_of(const mux::Plan &plan) {
  std::vector<std::vector<size_t>> out;
  for (const mux::VideoTrack &track : plan.tracks) out.push_back(track.tiling.cameras);
  return out;
}

// Luma PSNR of what a camera's picture became in its own track, worst of all frames.
double worst_psnr(const std::string &path, size_t camera) {
  const InputFile file(path);
  const fvv_input input = file.input();
  fvv_stream *stream = nullptr;
  REQUIRE(fvv_stream_open(&input, nullptr, nullptr, &stream, nullptr) == FVV_OK);
  const fvv_configuration *configuration = nullptr;
  REQUIRE(fvv_stream_configuration(stream, 0, &configuration, nullptr) == FVV_OK);
  double worst = INFINITY;
  size_t shown = 0;
  for (size_t v = 0; v < configuration->video_count; v++) {
    const fvv_video_layout &video = configuration->videos[v];
    for (size_t t = 0; t < video.tile_count; t++) {
      if (video.tiles[t].camera_id != 10 * camera + 3) continue;
      shown++;
      media::Decoder decoder(video.config);
      for (size_t i = 0; i < fvv_stream_frame_count(stream); i++) {
        const uint8_t *bytes = nullptr;
        size_t size = 0;
        int key = 0;
        REQUIRE(fvv_stream_sample(stream, i, video.track, &bytes, &size, &key, nullptr) == FVV_OK);
        const media::Image tile = media::extract(decoder.decode(bytes, size), video.tiles[t]);
        worst = std::min(worst, media::psnr_luma(tile, picture_of(camera, 64, 48, int64_t(i))));
      }
    }
  }
  fvv_stream_close(stream);
  CHECK(shown == 1);
  return worst;
}

} // namespace

TEST_CASE("runs are balanced, in order, and none is empty") {
  using Ends = std::vector<size_t>;
  CHECK(mux::balanced_runs({1, 1, 1, 1, 1}, 1) == Ends{5});
  CHECK(mux::balanced_runs({1, 1, 1, 1, 1}, 2) == Ends{3, 5});
  CHECK(mux::balanced_runs({1, 1, 1, 1, 1, 1, 1}, 3) == Ends{3, 6, 7});
  CHECK(mux::balanced_runs({9, 1, 1, 1, 1}, 2) == Ends{1, 5});
  CHECK(mux::balanced_runs({1, 1, 9, 1, 1}, 3) == Ends{2, 3, 5});
  CHECK(mux::balanced_runs({1, 1, 1, 9}, 4) == Ends{1, 2, 3, 4});
  CHECK(mux::balanced_runs({7}, 1) == Ends{1});
}

TEST_CASE("the limit of a frame is that of the codec's level, of its rate, and of textures") {
  FileOptions options;
  const auto limit = [&](uint32_t codec, int32_t rate) {
    options.codec = codec;
    return mux::frame_limit(options, {1, uint32_t(rate)});
  };
  CHECK(limit(FVV_CODEC_AVC1, 25).pixels == 36864 * 256);
  CHECK(limit(FVV_CODEC_AVC1, 60).pixels == 34560 * 256);
  CHECK(limit(FVV_CODEC_HVC1, 60).pixels == 8912896);
  CHECK(limit(FVV_CODEC_HVC1, 240).pixels == 4456448);
  CHECK(limit(FVV_CODEC_VP09, 25).pixels == 8912896);
  CHECK(limit(FVV_CODEC_AV01, 25).height == 4352);
  CHECK(limit(FVV_CODEC_JPEG, 1000).pixels == 8192 * 8192);
  CHECK(limit(FVV_CODEC_OEXR, 25).width == 8192);
}

TEST_CASE("cameras that one frame cannot hold are spread over tracks, and come back") {
  const Folder folder;
  const mux::AssumedDecoder decoder(limit_of());
  FileOptions options = spread(folder);
  options.verify = true;
  const mux::Report summary = mux_file(options);
  CHECK(cameras_of(mux::make_plan(options, {})) == std::vector<std::vector<size_t>>{{0, 1, 2}, {3, 4}});
  for (const mux::VideoTrackReport &track : summary.videos)
    CHECK(track.width * track.height <= limit_of().pixels);
  CHECK(!summary.warned);
  Stream stream(options.output);
  REQUIRE(stream.configuration().video_count == 2);
  CHECK(stream.configuration().videos[0].track == 2);
  CHECK(stream.configuration().videos[1].track == 8);
  for (size_t camera = 0; camera < 5; camera++) CHECK(worst_psnr(options.output, camera) > 35);
  CHECK(summary.verdict->videos[0].pictures == 5);
  CHECK(summary.verdict->videos[1].pictures == 5);

  const nlohmann::ordered_json json = json_of(summary);
  REQUIRE(json["video"].is_array());
  CHECK(json["video"][0]["camera_ids"] == std::vector<int>{3, 13, 23});
  CHECK(json["video"][1]["camera_ids"] == std::vector<int>{33, 43});
  CHECK(json["video"][1]["track"] == 8);
  CHECK(json["verified"]["pictures"] == 10);
  CHECK(json["verified"]["psnr"] > 35);
  const std::string text = text_of(summary);
  CHECK(text.find("  video 2  ") != std::string::npos);
  CHECK(text.find("in 2 video tracks: at 25 frames/s a frame may have 8192x8192 and 12288 pixels (a test)") !=
        std::string::npos);

  const mux::AssumedDecoder larger(limit_of(1000000));
  const nlohmann::ordered_json one = json_of(mux_file(options));
  CHECK(one["video"]["cameras"] == 5);
  CHECK(!one["video"].contains("track"));
}

TEST_CASE("the sides of a frame are a limit too") {
  const Folder folder;
  const mux::AssumedDecoder decoder({64, 96, 1000000, "a test"});
  const FileOptions options = spread(folder);
  CHECK(cameras_of(mux::make_plan(options, {})) == std::vector<std::vector<size_t>>{{0, 1}, {2, 3}, {4}});
}

TEST_CASE("crops are spread the same way, each group with a layout of every track") {
  const Folder folder;
  const mux::AssumedDecoder decoder(limit_of(3 * 48 * 48));
  FileOptions options = spread(folder, with_masks());
  options.crop = mux::Crop::automatic;
  options.tile_fill = mux::TileFill::flat;
  options.verify = true;
  const mux::Report summary = mux_file(options);
  CHECK(summary.videos.size() == 2);
  CHECK(summary.crop.layouts == 2); // groups, not layouts of tracks
  CHECK(summary.verdict->videos[1].psnr() > 35);
  // The same bytes for any number of threads.
  const std::string two = read_bytes(options.output);
  for (const uint32_t threads : {1u, 5u}) {
    options.threads = threads;
    mux_file(options);
    CHECK(read_bytes(options.output) == two);
  }
}

TEST_CASE("a camera that exceeds the limit alone has a track of its own, and a warning") {
  const Folder folder;
  const mux::AssumedDecoder decoder(limit_of(64 * 48 - 1));
  const FileOptions options = spread(folder);
  const mux::Report summary = mux_file(options);
  CHECK(summary.videos.size() == 5);
  CHECK(summary.warned);
}

TEST_CASE("neighbours share a track, on request") {
  // At 0, 90, 180, 270 and 360 degrees around the scene.
  const Folder folder;
  FileOptions options = spread(folder);
  using Sets = std::vector<std::vector<size_t>>;
  const auto sets = [&](const std::string &text) {
    options.video_tracks = mux::parse_video_tracks("video-tracks", text);
    return cameras_of(mux::make_plan(options, {}));
  };
  CHECK(sets("1") == Sets{{0, 1, 2, 3, 4}});
  CHECK(sets("camera") == Sets{{0}, {1}, {2}, {3}, {4}});
  CHECK(sets("5") == sets("camera"));
  CHECK(sets("4") == Sets{{0, 4}, {1}, {2}, {3}});
  CHECK(sets("2") == Sets{{0, 1, 4}, {2, 3}});
  options.verify = true;
  const mux::Report summary = mux_file(options);
  CHECK(!summary.warned);
  CHECK(summary.verdict->videos[1].pictures == 5);
  CHECK(text_of(summary).find("in 2 video tracks (--video-tracks)") != std::string::npos);
  const nlohmann::ordered_json json = json_of(summary);
  CHECK(json["video"][0]["camera_ids"] == std::vector<int>{3, 13, 43});
  for (size_t camera = 0; camera < 5; camera++) CHECK(worst_psnr(options.output, camera) > 35);
  for (const char *wrong : {"0", "-1", "cameras", "", "1001"})
    CHECK_THROWS_AS(mux::parse_video_tracks("video-tracks", wrong), fvv::Error);
}

TEST_CASE("a set of neighbours that exceeds a frame is spread once more") {
  const Folder folder;
  const mux::AssumedDecoder decoder(limit_of(2 * 64 * 48));
  FileOptions options = spread(folder);
  options.video_tracks = 2;
  CHECK(cameras_of(mux::make_plan(options, {})) == std::vector<std::vector<size_t>>{{0, 1}, {4}, {2, 3}});
}

TEST_CASE("tracks share a bit rate by their pixels") {
  const Folder folder;
  const mux::AssumedDecoder decoder(limit_of());
  FileOptions options = spread(folder);
  options.bit_rate = 1000000;
  const mux::Report summary = mux_file(options);
  REQUIRE(summary.videos.size() == 2);
  const auto rate = [&](size_t k) { return double(summary.videos[k].target_rate); };
  CHECK(rate(0) + rate(1) == Approx(1e6).margin(2));
  const auto pixels = [&](size_t k) { return double(summary.videos[k].width) * summary.videos[k].height; };
  CHECK(rate(0) / rate(1) == Approx(pixels(0) / pixels(1)).epsilon(0.001));
}

TEST_CASE("fvvdemux writes the cameras of all tracks") {
  const Folder folder;
  const mux::AssumedDecoder decoder(limit_of());
  const FileOptions options = spread(folder);
  mux_file(options);
  demux::Result result;
  demux::demux(options.output, folder.path("back"), {}, result);
  CHECK(result.warnings.empty());
  CHECK(result.pictures.size() == 5);
  for (size_t camera = 0; camera < 5; camera++)
    for (const int64_t frame : {0, 4}) {
      char leaf[64];
      std::snprintf(leaf, sizeof leaf, "back/cam%zu/%04d.png", 10 * camera + 3, int(frame));
      const media::Image picture = media::read_image<uint8_t>(folder.path(leaf), 3);
      CHECK(media::psnr_luma(picture, picture_of(camera, 64, 48, frame)) > 35);
    }
}

TEST_CASE("encoders that take more than their room run one by one, and other threads load for them") {
  constexpr unsigned threads = 3;
  constexpr size_t groups = 4, frames = 30, fit = 5;
  const uint64_t frame_bytes = threads * mux::EncoderRoom::ahead_per_thread / fit;
  const auto run = [&](uint64_t encoder_bytes, size_t &most_running, size_t &most_kept) {
    mux::EncoderRoom room(threads);
    std::atomic<size_t> running{0}, peak{0}, kept{0}, kept_peak{0}, helped{0};
    const auto raise = [](std::atomic<size_t> &largest, size_t value) {
      for (size_t seen = largest; value > seen && !largest.compare_exchange_weak(seen, value);) continue;
    };
    run_ordered(
        threads, {0, 0, 0, 0},
        [&](size_t) {
          const std::thread::id owner = std::this_thread::get_id();
          std::vector<std::atomic<int>> loads(frames);
          mux::EncoderRoom::Group group(room, frames, frame_bytes, [&](size_t frame) {
            helped += std::this_thread::get_id() != owner;
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
            loads[frame]++;
            raise(kept_peak, ++kept);
            return frame_bytes;
          });
          const std::shared_ptr<void> taken = room.reserve(encoder_bytes);
          raise(peak, ++running);
          for (size_t frame = 0; frame < frames; frame++) {
            group.await(frame);
            kept--;
            if (loads[frame] != 1) throw std::runtime_error("expected each frame to be loaded once");
          }
          running--;
        },
        [](size_t) {}, [&] { room.help(); });
    most_running = peak;
    most_kept = kept_peak;
    return size_t(helped);
  };
  const uint64_t all = threads * mux::EncoderRoom::bytes_per_thread;
  size_t running, kept;
  for (const uint64_t bytes : {all, 2 * all, all / 2 + 1}) {
    CHECK(run(bytes, running, kept) > groups * frames / 4);
    CHECK(running == 1);
    CHECK(kept <= fit + 1); // one more is the frame that the encoder needs now
  }
  run(all / 2, running, kept);
  CHECK(running <= 2);
  CHECK(kept <= fit + 2);
}

TEST_CASE("a group that ends early leaves its room") {
  mux::EncoderRoom room(1);
  for (int round = 0; round < 3; round++) {
    mux::EncoderRoom::Group group(room, 9, mux::EncoderRoom::ahead_per_thread,
                                  [](size_t) { return mux::EncoderRoom::ahead_per_thread; });
    const std::shared_ptr<void> taken = room.reserve(2 * mux::EncoderRoom::bytes_per_thread);
    group.await(0);
  }
  room.help(); // returns, as there are no groups
}
