// The lattice that fvvmux chooses, and how its options are spelled.
#include "mux_fixture.h"

#include "mux/src/options/option_values.h"

#include "fvv_mux/options.h"

using namespace fvv::mux;

namespace {

template <class Body> std::string usage_error(const Body &body) {
  try {
    body();
    return "";
  } catch (const fvv::Error &failure) {
    CHECK(failure.kind == fvv::Error::usage);
    return failure.in(fvv::Spelling::command_line);
  }
}

} // namespace

TEST_CASE("steps are rounded down to 1, 2, 5 times a power of ten, as decimals are read") {
  CHECK(geometry::round_down_125(0.0099) == 0.005);
  CHECK(geometry::round_down_125(0.005) == 0.005);
  CHECK(geometry::round_down_125(std::nextafter(0.005, 0)) == 0.002);
  CHECK(geometry::round_down_125(0.0019999) == 0.001);
  CHECK(geometry::round_down_125(1) == 1);
  CHECK(geometry::round_down_125(std::nextafter(1, 0)) == 0.5);
  CHECK(geometry::round_down_125(4999) == 2000);
  CHECK(geometry::round_down_125(1e-9) == 1e-9);
  CHECK(geometry::round_down_125(7e15) == 5e15);
}

TEST_CASE("the step follows the budget in pixels at the nearest camera") {
  const Folder folder;
  const scene::Capture capture = make_capture(folder);
  FileOptions options = options_for(folder);
  options.capture = capture.path;
  options.delta = false;
  // Camera 0 is at z = +3 (3 m along its own axis), the ball's box ends at 0.5: 2.5 m, by 70.5 px.
  const Plan whole = make_plan(options, {});
  CHECK(whole.lattice.lattice.step == 0.01); // of 2 * 0.15 * 2.5 / 70.5 = 0.01064
  CHECK(whole.lattice.pixels == Approx(0.005 * 70.5 / 2.5).epsilon(1e-3));
  CHECK(whole.lattice.reason.find("for 0.15 px at camera ") == 0);
  options.scale = 0.5; // half the pixels: twice the step
  CHECK(make_plan(options, {}).lattice.lattice.step == 0.02);
  options.scale = 1;
  options.pictures = false; // the cameras are still used
  CHECK(make_plan(options, {}).lattice.lattice.step == 0.01);
  options.step = parse_length("step", "1.5mm");
  const LatticeChoice given = make_plan(options, {}).lattice;
  CHECK(given.lattice.step == 0.0015);
  CHECK(given.pixels == Approx(0.00075 * 70.5 / 2.5).epsilon(1e-3));
}

TEST_CASE("without cameras the first mesh's size decides, without meshes nothing does") {
  const Folder folder;
  Shape shape;
  shape.sizes.clear();
  make_capture(folder, shape);
  FileOptions options = options_for(folder);
  options.delta = false;
  // Diagonal of the unit cube, sqrt(3) / 8192 = 0.000211.
  CHECK(make_plan(options, {}).lattice.lattice.step == 0.0002);
  CHECK(make_plan(options, {}).lattice.pixels == 0);
  shape.sizes = {{64, 48}};
  shape.meshes = false;
  make_capture(folder, shape);
  CHECK(make_plan(options, {}).lattice.reason == "there are no meshes");
}

TEST_CASE("the capture's lattice is kept, and packing twice gives the same lattice points") {
  const Folder folder;
  Shape shape;
  shape.pictures = false;
  scene::Capture capture = make_capture(folder, shape);
  capture.lattice = geometry::Lattice{{0.1, -0.2, 0.3}, 0.003};
  scene::write_capture(capture, capture.path);
  FileOptions options = options_for(folder);
  options.mesh_profile = FVV_MESH_RAW;
  mux_file(options);
  const std::string once = read_bytes(options.output);
  {
    Stream stream(options.output);
    const fvv_scene &scene = stream.configuration().scene;
    CHECK(memcmp(scene.lattice_origin, capture.lattice->origin, sizeof scene.lattice_origin) == 0);
    CHECK(scene.lattice_step == 0.003);
    for (size_t i = 0; i < 5; i++) {
      fvv_mesh mesh = {};
      stream.mesh(i, mesh);
      geometry::Mesh unpacked;
      unpacked.faces.assign(mesh.faces, mesh.faces + 3 * size_t(mesh.face_count));
      unpacked.positions.resize(3 * size_t(mesh.vertex_count));
      for (size_t v = 0; v < mesh.vertex_count; v++)
        fvv_lattice_to_metres(scene.lattice_origin, scene.lattice_step, mesh.lattice + 3 * v,
                              &unpacked.positions[3 * v]);
      fvv_mesh_free(&mesh);
      scene::write_mesh(unpacked, *capture.lattice, capture.mesh_path(int64_t(i)));
    }
  }
  mux_file(options);
  CHECK(read_bytes(options.output) == once);
  options.step = parse_length("step", "0.004");
  const Plan plan = make_plan(options, {});
  CHECK((plan.lattice.lattice.step == 0.004 && plan.lattice.lattice.origin[0] == 0.1));
}

TEST_CASE("units of an unknown scale are no millimetres") {
  const Folder folder;
  scene::Capture capture = make_capture(folder);
  capture.scale_unknown = true;
  scene::write_capture(capture, capture.path);
  FileOptions options = options_for(folder);
  options.pictures = false;
  options.step = parse_length("step", "2mm");
  CHECK(usage_error([&] { make_plan(options, {}); }) ==
        "--step: expected a plain number of the capture's units, because its scale is unknown");
  options.step = parse_length("step", "0.25");
  mux_file(options);
  Stream stream(options.output);
  CHECK(stream.configuration().scene.flags == FVV_SCENE_SCALE_UNKNOWN);
  CHECK(stream.configuration().scene.lattice_step == 0.25);
}

TEST_CASE("a range of frames is a capture of its own") {
  const Folder folder;
  Shape shape;
  shape.first = 10;
  shape.step = 2;
  make_capture(folder, shape); // 10 12 14 16 18
  FileOptions options = options_for(folder);
  options.frames = fvv::parse_range("frames", "12-16");
  const Report summary = mux_file(options);
  CHECK(!summary.warned);
  Stream stream(options.output);
  CHECK(stream.frames() == 3);
  const fvv_text &text = stream.configuration().metadata[0];
  CHECK(std::string(text.text, text.size).find(R"("frame_numbers":{"first":12,"step":2})") !=
        std::string::npos);
  options.frames = fvv::parse_range("frames", "11..16");
  CHECK(usage_error([&] { make_plan(options, {}); }) ==
        "--frames: expected frame numbers of the capture, 10 to 18 in steps of 2, found 11");
  options.frames = fvv::parse_range("frames", "12..20");
  CHECK(usage_error([&] { make_plan(options, {}); }) ==
        "--frames: expected frame numbers of the capture, 10 to 18 in steps of 2, found 20");
}

TEST_CASE("options in all their spellings") {
  CHECK(parse_length("step", "1.5mm").value == 0.0015);
  CHECK(parse_length("step", "0.2cm").value == 0.002);
  CHECK(parse_length("step", "0.002m").value == 0.002);
  CHECK(parse_length("step", "0.002m").metric);
  CHECK(!parse_length("step", "0.002").metric);
  for (const char *wrong : {"", "mm", "0", "-1mm", "1 mm", "1km", "nan", "infm", "1e999"})
    CHECK(usage_error([&] { parse_length("step", wrong); }) ==
          std::string("--step: expected a length above 0 such as 1.5mm, 0.2cm, 0.002m or 0.002, "
                      "found \"") +
              wrong + "\"");
  const auto quality = [](const std::string &text, const char *codec) {
    Options options;
    set_option(options, "quality", text);
    set_option(options, "codec", codec);
    return settled(options).quality;
  };
  CHECK(quality("36.5dB", "jpeg").value == 36.5);
  CHECK(quality("42dB", "h264").is_psnr);
  CHECK(quality("100", "jpeg").value == 100);
  CHECK(!quality("51", "h264").is_psnr);
  CHECK(quality("63", "av1").value == 63);
  CHECK(usage_error([&] { quality("64", "vp9"); }) ==
        "--quality: expected a PSNR such as 42dB, or a CRF from 1 to 63, found \"64\"");
  const std::pair<const char *, uint32_t> names[] = {{"jpeg", FVV_CODEC_JPEG},
                                                     {"h264", FVV_CODEC_AVC1},
                                                     {"hevc", FVV_CODEC_HVC1},
                                                     {"vp9", FVV_CODEC_VP09},
                                                     {"av1", FVV_CODEC_AV01}};
  for (const auto &[name, code] : names) CHECK(parse_codec("codec", name) == code);
  for (const char *wrong : {"", "dB", "0", "101", "0.5", "+23", "0dB", "101dB", "-1dB", "42 dBx"})
    CHECK(
        usage_error([&] { quality(wrong, "h264"); }) ==
        std::string("--quality: expected a PSNR such as 42dB, libjpeg's quality from 1 to 100, a CRF from 1 "
                    "to 51 or 63, or lossless, found \"") +
            wrong + "\"");
  CHECK(quality("23.625", "h264").value == 23.625);
  CHECK(usage_error([&] { quality("23.3", "hevc"); }) ==
        "--quality: expected a PSNR such as 42dB, or a CRF from 1 to 51, in parts of 1/8, found \"23.3\"");
  CHECK(usage_error([&] { quality("23.5", "vp9"); }) ==
        "--quality: expected a PSNR such as 42dB, or a CRF from 1 to 63, a whole number, found \"23.5\"");
  CHECK(usage_error([&] { quality("52", "h264"); }) ==
        "--quality: expected a PSNR such as 42dB, or a CRF from 1 to 51, found \"52\"");
  CHECK(usage_error([&] { quality("42dB", "exr"); }) ==
        "--quality: expected lossless, the only quality of OpenEXR, found \"42dB\"");
  CHECK(parse_tile("tile", "480x270").width == 480);
  for (const char *wrong : {"480", "480x", "x270", "0x270", "480x16385", "480X270", "480x270x3", "-1x2"})
    CHECK(!usage_error([&] { parse_tile("tile", wrong); }).empty());
  CHECK(parse_scale("scale", "0.5") == 0.5);
  for (const char *wrong : {"0", "1.01", "-0.5", "half", ""})
    CHECK(!usage_error([&] { parse_scale("scale", wrong); }).empty());
  Options options;
  set_option(options, "mesh-profile", "fast");
  CHECK(options.mesh_profile == FVV_MESH_FAST);
  CHECK(usage_error([&] { set_option(options, "mesh-profile", "delta"); }) ==
        "--mesh-profile: expected draco, raw or fast, found \"delta\"");
  CHECK(fvv::parse_range("frames", "3-3").last == 3);
  CHECK(fvv::parse_range("frames", "3..7").last == 7);
  CHECK(fvv::parse_range("frames", "3").last == 3);
  for (const char *wrong : {"", "7-3", "-3", "3-", "..", "3...7", "a-b", "1-9999999999"})
    CHECK(!usage_error([&] { fvv::parse_range("frames", wrong); }).empty());
}
