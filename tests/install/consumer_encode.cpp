/* Encodes ten frames of a turning square pyramid, seen by one camera, from arrays in memory to a file. */
#include <fvv_cxx/error.h>
#include <fvv_mux/encoder.h>

#include <cmath>
#include <cstdio>

int main(int argc, char **argv) {
  std::FILE *file = argc == 2 ? std::fopen(argv[1], "wb") : nullptr;
  if (!file) return 2;
  fvv::mux::CameraInput camera;
  camera.calibration.width = 64, camera.calibration.height = 48;
  camera.calibration.fx = camera.calibration.fy = 60, camera.calibration.cx = 32, camera.calibration.cy = 24;
  for (int i = 0; i < 9; i += 4) camera.calibration.rotation[i] = 1;
  camera.calibration.translation[2] = 3; // metres in front of the camera
  camera.calibration.r_max = fvv_camera_r_max(&camera.calibration);
  fvv::mux::Configuration scene;
  scene.cameras = {camera};
  fvv::mux::Options options;
  options.codec = FVV_CODEC_JPEG;
  options.group = 5;
  try {
    fvv::mux::Encoder encoder(scene, options,
                              [&](const void *bytes, size_t size) { std::fwrite(bytes, 1, size, file); });
    for (int i = 0; i < 10; i++) {
      const double x = std::cos(i / 10.0), y = std::sin(i / 10.0);
      fvv::mux::Frame frame;
      frame.mesh.positions = {x, y, 0, -y, x, 0, -x, -y, 0, y, -x, 0, 0, 0, -1};
      frame.mesh.faces = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4, 0, 2, 1, 0, 3, 2};
      frame.pictures = {fvv::media::Image{64, 48, 3, std::vector<uint8_t>(64 * 48 * 3, uint8_t(20 * i))}};
      encoder.add(std::move(frame));
    }
    std::printf("%zu frames\n", encoder.finish().frames);
  } catch (const fvv::Error &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return std::fclose(file) ? 1 : 0;
}
