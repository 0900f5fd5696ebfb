// What fvvdemux writes of whole streams.
#include "demux_fixture.h"
#include "display_codecs.h"
#include "fvv_cxx/input_file.h"
#include "fvv_demux/views.h"
#include "fvv_scene/capture.h"
#include "fvv_view/frame.h"
#include "fvvdemux/demux.h"

#include <cstdlib>

using namespace fvv;
using demux::Selection;

namespace {

demux::Result unpack(const std::string &input, const std::string &folder,
                     const demux::Options &options = {}) {
  demux::Result result;
  demux::demux(input, folder, options, result);
  return result;
}

// The lattice points of a mesh file, as a muxer would find them.
void check_mesh(const geometry::Mesh &read, int frame) {
  Mesh expected, found;
  make_sphere(frame, expected);
  REQUIRE(read.vertex_count() == expected.vertex_count);
  CHECK(read.faces == std::vector<uint32_t>(expected.faces, expected.faces + 3 * expected.face_count));
  fvv_mesh_options options;
  fvv_mesh_options_default(&options);
  std::copy(origin, origin + 3, options.lattice_origin);
  options.lattice_step = lattice_step;
  const fvv_mesh_source source = {read.positions.data(), read.faces.data(), read.vertex_count(),
                                  read.face_count(),     nullptr,           nullptr};
  REQUIRE(fvv_mesh_canonicalise(&source, &options, nullptr, &found, nullptr, nullptr) == FVV_OK);
  CHECK(std::equal(expected.lattice, expected.lattice + 3 * expected.vertex_count, found.lattice));
}

media::Image pixels(const std::string &path) {
  return media::read_image(path, 3);
}

// Camera 65534 of the fixture: 40 x 36 pixels from (8, 4) of a picture of 64 x 48, sent as 30 x 48; whole
// that is 48 x 64, where columns are those of the tile, 6 to the right, and rows lie between two of the tile,
// 5 1/3 above.
template <class Sample>
void check_pasted(const media::BasicImage<Sample> &found, const media::BasicImage<Sample> &tile) {
  REQUIRE((found.width == 48 && found.height == 64));
  const Sample grey = Sample(media::flat_grey * (sizeof(Sample) == 1 ? 1 : 257));
  size_t outside = 0, wrong = 0, between = 0;
  for (int y = 0; y < 64; y++)
    for (int x = 0; x < 48; x++)
      for (int c = 0; c < 3; c++) {
        const Sample value = found.pixels[size_t((y * 48 + x) * 3 + c)];
        if (x < 6 || x >= 36 || y < 5 || y >= 53) {
          wrong += value != grey;
          outside++;
          continue;
        }
        const auto at = [&](int row) {
          return tile.pixels[size_t((std::clamp(row, 0, 47) * 30 + x - 6) * 3 + c)];
        };
        const auto [low, high] = std::minmax({at(y - 6), at(y - 5)});
        wrong += value < low || value > high;
        between += low < value && value < high;
      }
  CHECK(outside == 3 * (48 * 64 - 30 * 48));
  CHECK(wrong == 0);
  CHECK(between > 200);
}

// PNG files of a stream with 8 bits, or 10 for uint16_t: of as many bits as Sample has, and exact.
template <class Sample> void check_pictures(const media::VideoCodec &codec) {
  const Scratch scratch;
  StreamOptions stream;
  stream.codec = codec.code;
  stream.bit_depth = sizeof(Sample) == 1 ? 8 : 10;
  stream.profile = FVV_MESH_DRACO;
  const std::string name = codec.option;
  CAPTURE(name, stream.bit_depth);
  const std::string input = scratch.file(name + ".fvv", make_stream(stream));
  const demux::Result result = unpack(input, scratch.path(name));
  CHECK((result.pictures == std::map<uint16_t, uint64_t>{{0, 6}, {7, 6}, {65534, 6}}));
  const InputFile file(input);
  const fvv_input source = file.input();
  fvv_stream *opened = nullptr;
  REQUIRE(fvv_stream_open(&source, nullptr, nullptr, &opened, nullptr) == FVV_OK);
  for (size_t g = 0; g < 2; g++) {
    const fvv_configuration *configuration = nullptr;
    REQUIRE(fvv_stream_configuration(opened, g, &configuration, nullptr) == FVV_OK);
    REQUIRE(configuration->videos[0].config.bit_depth == stream.bit_depth);
    media::Decoder decoder(configuration->videos[0].config);
    for (size_t f = 3 * g; f < 3 * g + 3; f++) {
      const uint8_t *sample;
      size_t size;
      int key;
      REQUIRE(fvv_stream_sample(opened, f, 2, &sample, &size, &key, nullptr) == FVV_OK);
      const auto frame = decoder.decode<Sample>(sample, size);
      for (size_t t = 0; t < 3; t++) {
        const fvv_tile &tile = configuration->videos[0].tiles[t];
        const auto expected = media::extract(frame, tile);
        const std::string path = scratch.path(name) + "/cam" + std::to_string(tile.camera_id) + "/000" +
                                 std::to_string(f) + ".png";
        CHECK(read(path)[24] == 8 * int(sizeof(Sample))); // the depth in IHDR
        const auto found = media::read_image<Sample>(path, 3);
        if (t == 2) {
          check_pasted(found, expected);
          continue;
        }
        CHECK((found.width == expected.width && found.height == expected.height));
        CHECK((found.pixels == expected.pixels));
      }
    }
  }
  fvv_stream_close(opened);
  const scene::Capture capture = scene::load_capture(scratch.path(name) + "/capture.json");
  CHECK(scene::check_files(capture, [](const std::string &path) {
          const media::ImageInfo info = media::probe_image(path);
          return scene::PictureSize{info.width, info.height};
        }).problems.empty());
}

int run(const std::string &arguments, const std::string &errors = "/dev/null") {
  const int status =
      std::system((std::string(FVVDEMUX) + " " + arguments + " >/dev/null 2>" + errors).c_str());
  return WEXITSTATUS(status);
}

} // namespace

TEST_CASE("meshes come back exactly in every format") {
  const Scratch scratch;
  const std::string input = scratch.file("in.fvv", make_stream());
  for (const auto &[format, extension] :
       {std::pair(demux::Meshes::ply, "ply"), {demux::Meshes::obj, "obj"}, {demux::Meshes::drc, "drc"}}) {
    demux::Options options;
    options.meshes = format;
    options.pictures = demux::Pictures::none;
    const std::string folder = scratch.path(extension);
    const demux::Result result = unpack(input, folder, options);
    CHECK(
        (result.frames_in_stream == 6 && result.frames_written == 6 && result.meshes == 6 && result.capture));
    CHECK((result.losses.empty() && result.warnings.empty() && result.pictures.empty()));
    CHECK(files_of(folder).size() == 7);
    const scene::Capture capture = scene::load_capture(folder + "/capture.json");
    CHECK((capture.frames.first == 0 && capture.frames.count == 6 && capture.frames.step == 1));
    CHECK((capture.frame_duration.numerator == 1 && capture.frame_duration.denominator == 25));
    CHECK(capture.up == FVV_UP_Z);
    REQUIRE(capture.lattice);
    CHECK((capture.lattice->step == lattice_step && std::equal(origin, origin + 3, capture.lattice->origin)));
    // Without pictures cameras are those of the source.
    REQUIRE(capture.cameras.size() == 3);
    CHECK((capture.cameras[1].calibration.width == 64 && !capture.cameras[1].pictures));
    CHECK(*capture.cameras[1].name == "../camera/\"\n");
    for (int frame = 0; frame < 6; frame++) check_mesh(scene::load_mesh(capture, frame), frame);
  }
}

TEST_CASE("pictures are what decoding and cutting out gives") {
  for (const media::VideoCodec &codec : display_codecs()) {
    check_pictures<uint8_t>(codec);
    if (codec.deepest > 8) check_pictures<uint16_t>(codec);
  }
}

TEST_CASE("as JPEG pictures have 8 bits, for any depth of the video") {
  const Scratch scratch;
  StreamOptions stream;
  stream.codec = FVV_CODEC_VP09;
  stream.bit_depth = 10;
  demux::Options options;
  options.pictures = demux::Pictures::jpg;
  const demux::Result result =
      unpack(scratch.file("in.fvv", make_stream(stream)), scratch.path("out"), options);
  CHECK(result.pictures.at(7) == 6);
  // The tile of camera 7 is the whole of picture 0.
  CHECK(media::psnr_luma(pixels(scratch.path("out") + "/cam7/0002.jpg"), make_picture(0, 2)) > 35);
}

TEST_CASE("a picture's camera projects as the tile maps") {
  StreamOptions stream;
  uint32_t width, height;
  const Scratch scratch;
  unpack(scratch.file("in.fvv", make_stream(stream)), scratch.path("out"));
  const scene::Capture capture = scene::load_capture(scratch.path("out") + "/capture.json");
  for (const fvv_tile &tile : make_tiles(stream, width, height)) {
    const fvv_camera original = make_camera(tile.camera_id);
    const fvv_camera *written = nullptr;
    for (const scene::Camera &camera : capture.cameras)
      if (camera.calibration.id == tile.camera_id) written = &camera.calibration;
    REQUIRE(written);
    const double scale[2] = {double(tile.destination.width) / tile.source.width,
                             double(tile.destination.height) / tile.source.height};
    CHECK((written->width == original.width * scale[0] && written->height == original.height * scale[1]));
    for (int i = 0; i < 50; i++) {
      const double world[3] = {0.02 * i - 0.5, 0.3 - 0.013 * i, 0.01 * i};
      double before[2], after[2];
      REQUIRE(fvv_camera_project(&original, world, before, nullptr) == 1);
      REQUIRE(fvv_camera_project(written, world, after, nullptr) == 1);
      // The whole picture begins where the source rectangle would begin at (0, 0).
      CHECK(std::abs(after[0] - before[0] * scale[0]) < 1e-9);
      CHECK(std::abs(after[1] - before[1] * scale[1]) < 1e-9);
    }
  }
}

TEST_CASE("chosen frames and cameras are the same files as of a full run") {
  const Scratch scratch;
  StreamOptions stream;
  stream.codec = FVV_CODEC_AVC1;
  const std::string input = scratch.file("in.fvv", make_stream(stream));
  unpack(input, scratch.path("all"));
  const auto all = files_of(scratch.path("all"));
  struct Case {
    const char *frames;
    bool capture;
    int64_t first, count, step;
  };
  int number = 0;
  for (const Case &c : {Case{"2", true, 2, 1, 1},
                        {"1-2", true, 1, 2, 1},
                        {"5,1,3", true, 1, 3, 2},
                        {"0,1,5", false, 0, 3, 0},
                        {"0-5,2-3", true, 0, 6, 1}}) {
    demux::Options options;
    options.frames = Selection::parse("frames", c.frames);
    options.cameras = Selection::parse("cameras", "0,7");
    const std::string folder = scratch.path(std::to_string(number++));
    const demux::Result result = unpack(input, folder, options);
    INFO(c.frames);
    CHECK((result.frames_written == c.count && result.losses.empty() && result.capture == c.capture));
    CHECK(result.warnings.size() == (c.capture ? 0 : 1));
    auto files = files_of(folder);
    if (c.capture) {
      const scene::Capture capture = scene::load_capture(folder + "/capture.json");
      CHECK((capture.frames.first == c.first && capture.frames.count == c.count &&
             capture.frames.step == c.step));
      CHECK(capture.frame_duration.numerator == uint32_t(c.step));
      CHECK(capture.cameras.size() == 2);
      CHECK(files.erase("capture.json") == 1);
    }
    CHECK(files.size() == size_t(c.count) * 3);
    for (const auto &[name, bytes] : files) CHECK((all.at(name) == bytes));
  }
}

TEST_CASE("a frame without a mesh leaves no capture.json") {
  const Scratch scratch;
  StreamOptions stream;
  stream.without_mesh = 4;
  const demux::Result result = unpack(scratch.file("in.fvv", make_stream(stream)), scratch.path("out"));
  CHECK((result.frames_written == 6 && result.meshes == 5 && result.losses.empty() && !result.capture));
  REQUIRE(result.warnings.size() == 1);
  CHECK(result.warnings[0] == "no capture.json: frame 4 has not all files that other frames have");
  CHECK(files_of(scratch.path("out")).size() == 5 + 18);
}

TEST_CASE("file numbers follow the metadata as far as it is sane") {
  const Scratch scratch;
  struct Case {
    std::string metadata;
    int64_t first, step;
    bool warned;
  };
  const std::string deep = "{\"frame_numbers\": " + std::string(100000, '[') + std::string(100000, ']') + "}";
  int number = 0;
  for (const Case &c : {Case{R"({"frame_numbers": {"first": 100, "step": 5}})", 100, 5, false},
                        {R"({"name": "a"})", 0, 1, false},
                        {"not JSON", 0, 1, false},
                        {"[]", 0, 1, false},
                        {R"({"frame_numbers": {"first": 2147483642, "step": 1}})", 2147483642, 1, false},
                        {R"({"frame_numbers": {"first": 2147483643, "step": 1}})", 0, 1, true},
                        {R"({"frame_numbers": {"first": -1, "step": 1}})", 0, 1, true},
                        {R"({"frame_numbers": {"first": 0, "step": 0}})", 0, 1, true},
                        {R"({"frame_numbers": {"first": 0, "step": -9223372036854775808}})", 0, 1, true},
                        {R"({"frame_numbers": {"first": 18446744073709551615, "step": 1}})", 0, 1, true},
                        {R"({"frame_numbers": {"first": 0, "step": 2147483647}})", 0, 1, true},
                        {R"({"frame_numbers": {"first": 1.0, "step": 1}})", 0, 1, true},
                        {R"({"frame_numbers": {"first": "../7", "step": 1}})", 0, 1, true},
                        {R"({"frame_numbers": {"first": 1}})", 0, 1, true},
                        {R"({"frame_numbers": null})", 0, 1, true},
                        {deep, 0, 1, true}}) {
    StreamOptions stream;
    stream.metadata = c.metadata;
    demux::Options options;
    options.pictures = demux::Pictures::none;
    const std::string folder = scratch.path(std::to_string(number++));
    const demux::Result result = unpack(scratch.file("in.fvv", make_stream(stream)), folder, options);
    INFO(c.metadata.substr(0, 80));
    CHECK(result.warnings.size() == (c.warned ? 1 : 0));
    const scene::Capture capture = scene::load_capture(folder + "/capture.json");
    CHECK((capture.frames.first == c.first && capture.frames.step == c.step && capture.frames.count == 6));
    CHECK((capture.frame_duration.numerator == 1 && capture.frame_duration.denominator == 25));
    for (int frame = 0; frame < 6; frame++)
      check_mesh(scene::load_mesh(capture, capture.frames.number(frame)), frame);
  }
}

TEST_CASE("any number of threads gives the same files") {
  const Scratch scratch;
  StreamOptions stream;
  stream.groups = 5;
  stream.codec = FVV_CODEC_AVC1;
  stream.repeat_before = 3;
  const std::string input = scratch.file("in.fvv", make_stream(stream));
  demux::Options options;
  unpack(input, scratch.path("1"), options);
  options.threads = 4;
  unpack(input, scratch.path("4"), options);
  const auto one = files_of(scratch.path("1"));
  CHECK(one.size() == 15 * 4 + 1);
  CHECK((one == files_of(scratch.path("4"))));
}

TEST_CASE("a stream whose pictures take more memory than allowed is refused before it is decoded") {
  const Scratch scratch;
  const std::string input = scratch.file("in.fvv", make_stream());
  demux::Options options;
  options.memory = {10'000, "--max-memory"};
  const auto refusal = [&](const auto &work) {
    try {
      work();
      return std::string();
    } catch (const Error &error) {
      return std::string(error.what());
    }
  };
  const auto has = [](const std::string &text, const std::string &part) { return text.find(part) == 0; };
  CHECK(has(refusal([&] { unpack(input, scratch.path("out"), options); }), input + ": track 2: decoding "));
  CHECK(!fs::exists(scratch.path("out")));
  CHECK(has(refusal([&] { view::load_frame(InputFile(input), 0, {options.memory}); }),
            input + ": frame 0: track 2: decoding "));
  options.pictures = demux::Pictures::none;
  CHECK(refusal([&] { unpack(input, scratch.path("meshes"), options); }).empty());
  // Enough for one group at a time: fewer threads, the same files.
  options.pictures = demux::Pictures::automatic;
  options.memory.bytes = 16 << 20;
  options.threads = 64;
  CHECK(refusal([&] { unpack(input, scratch.path("slowly"), options); }).empty());
}

TEST_CASE("lists of numbers") {
  for (const char *wrong :
       {"", ",", "1,", "-1", "1-", "3-2", "a", "1 ", "1,,2", "2147483648", "1-2-3", "0x1", "1--2"})
    CHECK_THROWS_AS(Selection::parse("frames", wrong), fvv::Error);
  const Selection some = Selection::parse("frames", "7-9,2,3,8-12,2147483647");
  CHECK((some.has(2) && some.has(3) && !some.has(4) && !some.has(6) && some.has(12) && !some.has(13)));
  CHECK((some.largest() == 2147483647 && some.within(4, 6).empty() && some.within(3, 8).size() == 2));
  CHECK((Selection().everything() && Selection().has(5) && Selection().within(1, 0).empty()));
}

TEST_CASE("the command line") {
  const Scratch scratch;
  const std::string input = scratch.file("in.fvv", make_stream()), errors = scratch.path("errors");
  const std::string out = scratch.path("out");
  const auto message = [&] {
    const Bytes bytes = read(errors);
    return std::string(bytes.begin(), bytes.end());
  };
  for (const char *wrong :
       {"--meshes stl", "--pictures gif", "--quality 0", "--quality 101", "--threads 0", "--frames x",
        "--frames ''", "--frames 6", "--cameras 1", "--cameras 70000", "--nonsense", "--max-memory -1",
        "--max-memory 5x", "--max-memory M", "--meshes none --pictures none", "second.fvv"}) {
    INFO(wrong);
    CHECK(run(input + " -o " + out + " " + wrong, errors) == 2);
    CHECK(!message().empty());
    CHECK(!fs::exists(out));
  }
  CHECK(run(input, errors) == 2);
  CHECK(run("-o " + out, errors) == 2);
  CHECK(run("--version") == 0);
  CHECK(run(scratch.path("absent.fvv") + " -o " + out, errors) == 1);
  CHECK(run(scratch.file("no.fvv", Bytes(100, 'x')) + " -o " + out, errors) == 1);
  CHECK(!fs::exists(out));

  CHECK(run(input + " -o " + out + " --max-memory 10K", errors) == 1);
  CHECK(message().find("fvvdemux: " + input + ": track 2: decoding ") == 0);
  CHECK(message().find(" KiB, --max-memory allows 10 KiB\n") != std::string::npos);
  CHECK(!fs::exists(out));

  CHECK(run(input + " -o " + out + " --pictures jpg --quality 60 --frames 0 --max-memory 1G", errors) == 0);
  CHECK(message().empty());
  CHECK(media::read_image(out + "/cam0/0000.jpg", 3).width == 32);
  CHECK(run(input + " -o " + out, errors) == 1);
  CHECK(message() == "fvvdemux: " + out + ": already exists; --force replaces it\n");
  CHECK(run(input + " -o " + out + " --force --pictures none", errors) == 0);
  CHECK((fs::exists(out + "/meshes/0005.ply") && !fs::exists(out + "/cam0")));
  CHECK(run(input + " -o " + out + "/new/folder --frames 1 --json", errors) == 0);
}
