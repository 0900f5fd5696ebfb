// Cameras, the inversion of their lenses, and calibrations of cameras that move.
#include "../fuzz.h"

#include "fvv/calibration.h"

#include <cmath>

namespace {

void use(const fvv_camera &camera) {
  fuzz::expect(fvv_camera_r_max(&camera) >= 0, "a radius is not negative");
  const double points[2][3] = {{0.1, 0.2, 3.0}, {-2.0, 1.0, 0.5}};
  for (const double *point : points) {
    double pixel[2], depth, ray[3];
    if (!fvv_camera_project(&camera, point, pixel, &depth)) continue;
    fuzz::expect(std::isfinite(pixel[0]) && std::isfinite(pixel[1]), "pixels are finite");
    (void)fvv_camera_unproject(&camera, pixel, ray);
  }
  const double corner[2] = {0, 0};
  double ray[3];
  if (fvv_camera_unproject(&camera, corner, ray)) fuzz::expect(ray[2] == 1, "rays have z = 1");
}

} // namespace

FVV_FUZZ_TARGET(calibration, fuzz::Form::bytes) {
  fuzz::Input input(data, size);
  std::vector<fuzz::Bytes> records;
  std::vector<fvv_camera> cameras;
  for (uint32_t count = 1 + input.below(4); count; count--) records.push_back(input.part());
  for (const fuzz::Bytes &record : records) {
    fvv_camera camera;
    const fvv_status status = fvv_camera_decode(&camera, record.data(), record.size(), nullptr, nullptr);
    fuzz::expect_status(status);
    if (status != FVV_OK) continue;
    fuzz::Bytes again(record.size());
    size_t written = 0;
    fuzz::expect(fvv_camera_encode(&camera, again.data(), again.size(), &written, nullptr) == FVV_OK &&
                     again == record,
                 "cameras that are read are written as they were");
    use(camera);
    cameras.push_back(camera);
  }
  fvv_calibration *calibration = nullptr;
  fuzz::expect(fvv_calibration_create(cameras.data(), cameras.size(), nullptr, &calibration) == FVV_OK,
               "a calibration is created");
  while (input.left()) {
    const int key = input.u8() & 1;
    const fuzz::Bytes payload = input.part();
    fuzz::expect_status(fvv_calibration_decode(calibration, payload.data(), payload.size(), key, nullptr));
    for (const fvv_camera &camera : cameras) {
      fvv_camera now;
      if (fvv_calibration_camera(calibration, camera.id, &now) == FVV_OK) use(now);
    }
  }
  fvv_calibration_destroy(calibration);
}
