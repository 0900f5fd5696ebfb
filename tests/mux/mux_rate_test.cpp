// fvvmux --bitrate: every codec reaches the target bit rate, with any number of threads.
#include "display_codecs.h"
#include "fvv_mux/report.h"
#include "mux_fixture.h"

#include "mux/src/options/option_values.h"

namespace {

// Three groups of 8 frames, three cameras of 128x96.
FileOptions options_of(const Folder &folder, const media::VideoCodec &codec) {
  FileOptions options = options_for(folder);
  options.codec = codec.code;
  options.group = 8;
  options.meshes = false;
  return options;
}

Shape shape_of_clip() {
  Shape shape;
  shape.count = 24;
  shape.meshes = false;
  shape.sizes = {{128, 96}, {128, 96}, {128, 96}};
  return shape;
}

// Of the payload of samples alone, at 25 frames a second.
double rate_in(const std::string &path) {
  Stream stream(path);
  double bytes = 0;
  int key = 0;
  for (size_t i = 0; i < stream.frames(); i++) bytes += double(stream.sample(i, key).size());
  return bytes * 8 * 25 / double(stream.frames());
}

} // namespace

TEST_CASE("a bit rate is kept over a clip by every codec, and reported", "[slow][long]") {
  const Folder folder;
  make_capture(folder, shape_of_clip());
  for (const media::VideoCodec &codec : display_codecs()) {
    FileOptions options = options_of(folder, codec);
    options.quality = {false, codec.code == FVV_CODEC_JPEG ? 70.0 : 30.0};
    mux_file(options);
    const double target = std::floor(rate_in(options.output) * 1.02);
    CAPTURE(codec.name, target);
    options.bit_rate = uint64_t(target);
    const mux::Report summary = mux_file(options);
    CHECK(!summary.warned);
    const double reached = rate_in(options.output);
    CHECK(reached <= target);
    CHECK(reached > 0.92 * target);
    const nlohmann::ordered_json rate = json_of(summary)["video"]["bit_rate"];
    CHECK(rate["target"] == uint64_t(target));
    CHECK(rate["reached"].get<double>() == Approx(reached));
    CHECK(rate["groups_over"] == 0);
    CHECK(text_of(summary).find(" (target ") != std::string::npos);
  }
}

TEST_CASE("a bit rate gives the same bytes for any number of threads", "[slow][long]") {
  const Folder folder;
  make_capture(folder, shape_of_clip());
  for (const media::VideoCodec &codec : display_codecs()) {
    FileOptions options = options_of(folder, codec);
    options.bit_rate = codec.code == FVV_CODEC_JPEG ? 4000000 : 400000;
    std::string first;
    for (const uint32_t threads : {1u, 2u, 5u}) {
      CAPTURE(codec.name, threads);
      options.threads = threads;
      mux_file(options);
      const std::string bytes = read_bytes(options.output);
      if (first.empty()) first = bytes;
      CHECK((bytes == first));
    }
  }
}

TEST_CASE("a bit rate that cannot be reached is a warning that names what was reached") {
  const Folder folder;
  make_capture(folder);
  const ToolResult run = run_tool(
      {folder.path("in"), "-o", folder.path("out.fvv"), "--bitrate", "1k", "--group", "2", "--json"});
  CHECK(run.exit == 3);
  CHECK(run.err.find("warning: ") != std::string::npos);
  CHECK(
      run.err.find("--bitrate: 3 of 3 groups of the video take more than 1 kbit/s even at CRF 51; in all it "
                   "is ") != std::string::npos);
  const auto json = nlohmann::json::parse(run.out);
  CHECK(json["video"]["bit_rate"]["groups_over"] == 3);
  CHECK(json["video"]["bit_rate"]["coarsest"] == 51);
  CHECK(json["video"]["bit_rate"]["reached"].get<double>() == Approx(rate_in(folder.path("out.fvv"))));
}

TEST_CASE("wrong bit rates are refused, and one beside a quality") {
  const Folder folder;
  make_capture(folder);
  const std::string out = folder.path("out.fvv");
  for (const char *wrong : {"M", "4x", "0", "-1M", "999", "11G", "4MB", "nan", "1e400"}) {
    CAPTURE(wrong);
    const ToolResult run = run_tool({folder.path("in"), "-o", out, "--bitrate", wrong});
    CHECK(run.exit == 2);
    CHECK(run.err.find("--bitrate") != std::string::npos);
  }
  const ToolResult both = run_tool({folder.path("in"), "-o", out, "--bitrate", "1M", "--quality", "42dB"});
  CHECK(both.exit == 2);
  CHECK(both.err.find("--quality") != std::string::npos);
  CHECK(!fs::exists(out));
  CHECK(mux::parse_bit_rate("bitrate", "4M") == 4000000);
  CHECK(mux::parse_bit_rate("bitrate", "1.5M") == 1500000);
  CHECK(mux::parse_bit_rate("bitrate", "800k") == 800000);
  CHECK(mux::parse_bit_rate("bitrate", "64000") == 64000);
}
