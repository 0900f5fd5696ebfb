// The encoder of whole streams: frames with any meshes, pictures and masks. What it writes, the checker
// accepts with every frame whole, or the encoder throws Error.
#include "../fuzz.h"

#include "fvv/stream.h"
#include "fvv_media/image.h"
#include "fvv_mux/encoder.h"

#include <algorithm>

namespace {

fvv::geometry::Mesh mesh_of(fuzz::Input &input, uint32_t vertices, uint32_t faces) {
  fvv::geometry::Mesh mesh;
  for (uint32_t i = 0; i < 3 * vertices; i++) mesh.positions.push_back(double(input.number<int8_t>()) / 100);
  fuzz::Random random(vertices * 100 + faces);
  for (uint32_t i = 0; i < 3 * faces; i++) mesh.faces.push_back(random.below(vertices));
  return mesh;
}

fvv::mux::CameraInput camera_of(fuzz::Input &input, uint16_t id) {
  fvv::mux::CameraInput camera;
  fvv_camera &c = camera.calibration;
  c.id = id;
  c.width = 16 + 2 * input.below(9);
  c.height = 16 + 2 * input.below(9);
  c.fx = c.fy = 10 + input.below(50);
  c.cx = c.width / 2.0;
  c.cy = c.height / 2.0;
  for (int i = 0; i < 9; i += 4) c.rotation[i] = 1;
  c.translation[0] = input.number<int8_t>() / 50.0;
  c.translation[2] = input.number<int8_t>() / 20.0;
  c.r_max = fvv_camera_r_max(&c);
  camera.masks = input.below(2);
  camera.moves = !input.below(4);
  return camera;
}

fvv::media::Image picture_of(fuzz::Input &input, const fvv_camera &camera, int channels) {
  fvv::media::Image image = fvv::media::make_image(camera.width, camera.height, channels, input.u8());
  for (uint8_t *at = image.pixels.data(), *end = at + image.pixels.size(); at < end;) {
    const size_t run = std::min<size_t>(size_t(end - at), 1 + input.u8());
    std::fill_n(at, run, input.u8());
    at += run;
  }
  return image;
}

void expect_whole(const fuzz::Bytes &stream, size_t frames) {
  fvv_check_options options;
  fvv_check_options_default(&options);
  options.decode = 1;
  fvv_checker *checker = nullptr;
  fuzz::expect(fvv_checker_create(&options, nullptr, nullptr, &checker) == FVV_OK, "a checker is created");
  fuzz::expect(fvv_checker_push(checker, stream.data(), stream.size()) == FVV_OK &&
                   fvv_checker_finish(checker) == FVV_OK,
               "what is written can be read");
  const fvv_check_summary *summary = fvv_checker_summary(checker);
  if (summary->problems) std::fprintf(stderr, "%s\n", fvv_checker_problem(checker, 0)->message);
  fuzz::expect(summary->problems == 0 && summary->has_footer, "what is written has no problem");
  fuzz::expect(summary->frames == summary->whole_frames && summary->frames <= frames, "every frame is whole");
  fvv_checker_destroy(checker);
}

} // namespace

FVV_FUZZ_TARGET(encoder, fuzz::Form::bytes) {
  fuzz::Input input(data, size);
  fvv::mux::Configuration scene;
  for (uint32_t i = 0, count = input.below(4); i < count; i++)
    scene.cameras.push_back(camera_of(input, uint16_t(i)));
  scene.meshes = scene.cameras.empty() || input.below(8);
  fvv::mux::Options options;
  options.codec = FVV_CODEC_JPEG;
  options.quality = {false, double(50 + input.below(50))};
  options.group = 1 + input.below(3);
  options.keep_geometry = input.below(8); // decimation takes most of the time
  options.delta = input.below(4);
  options.live = !input.below(4);
  options.repeat_configuration = !input.below(4);
  options.mesh_profile = input.below(4) ? FVV_MESH_DRACO : FVV_MESH_FAST;
  if (input.below(4)) options.colours = fvv::mux::Colours::off;
  if (input.below(4)) options.match_colours = fvv::mux::MatchColours::off;
  if (input.below(4)) options.visibility = fvv::mux::Visibility::none;
  if (input.below(4)) options.texture_inset = 0;
  fuzz::Bytes stream;
  const uint32_t vertices = 4 + input.below(30), faces = 4 + input.below(40);
  const size_t frames = 1 + input.below(4);
  try {
    fvv::mux::Encoder encoder(scene, options,
                              [&](const void *bytes, size_t count) { fuzz::append(&stream, bytes, count); });
    for (size_t i = 0; i < frames; i++) {
      fvv::mux::Frame frame;
      if (scene.meshes && input.below(8)) frame.mesh = mesh_of(input, vertices, faces);
      for (const fvv::mux::CameraInput &camera : scene.cameras) {
        frame.pictures.push_back(picture_of(input, camera.calibration, 3));
        frame.masks.push_back(camera.masks ? picture_of(input, camera.calibration, 1) : fvv::media::Image());
        fvv_camera moved = camera.calibration;
        moved.translation[1] += input.number<int8_t>() / 200.0;
        frame.calibrations.push_back(moved);
      }
      encoder.add(std::move(frame));
    }
    (void)encoder.finish();
  } catch (const fvv::Error &) {
    return;
  }
  if (!options.live) expect_whole(stream, frames);
}
