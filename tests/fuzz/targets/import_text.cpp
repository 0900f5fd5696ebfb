// capture.json, and the calibration files of other programs. What is read is valid, and a capture that is
// written and read again is the same.
#include "../fuzz.h"

#include "fvv_cxx/error.h"
#include "fvv_scene/import.h"

#include <cstdlib>
#include <fstream>
#include <string>
#include <string_view>
#include <unistd.h>

namespace {

// A folder of this process, in memory where there is such a place, removed at exit.
struct Folder {
  std::string path;
  Folder() {
    std::string name = access("/dev/shm", W_OK) == 0 ? "/dev/shm/fvv-fuzz-XXXXXX" : "/tmp/fvv-fuzz-XXXXXX";
    fuzz::expect(mkdtemp(name.data()) != nullptr, "a folder is made");
    path = name;
  }
  ~Folder() {
    clear();
    (void)rmdir(path.c_str());
  }
  void clear() const {
    for (const char *name : {"cameras.txt", "images.txt", "cameras.bin", "images.bin", "intri.yml",
                             "extri.yml", "file", "file.xmp"})
      (void)unlink((path + "/" + name).c_str());
  }
  std::string write(const char *name, const fuzz::Bytes &bytes) const {
    const std::string file = path + "/" + name;
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char *>(bytes.data()), std::streamsize(bytes.size()));
    return file;
  }
};

const Folder &folder() {
  static const Folder one;
  return one;
}

void expect_valid(const std::vector<fvv::scene::Camera> &cameras) {
  for (const fvv::scene::Camera &camera : cameras)
    fuzz::expect(fvv_camera_validate(&camera.calibration, nullptr) == FVV_OK,
                 "cameras that are read are valid");
}

} // namespace

FVV_FUZZ_TARGET(capture, fuzz::Form::bytes) {
  const fuzz::Bytes bytes(data, data + size);
  try {
    const fvv::scene::Capture capture = fvv::scene::parse_capture(
        std::string_view(reinterpret_cast<const char *>(bytes.data()), bytes.size()), "capture.json");
    expect_valid(capture.cameras);
    if (capture.metres_per_unit != 1) return;
    const std::string text = fvv::scene::format_capture(capture);
    fuzz::expect(fvv::scene::format_capture(fvv::scene::parse_capture(text, "capture.json")) == text,
                 "a capture that is written is read as it was");
  } catch (const fvv::Error &) {}
}

FVV_FUZZ_TARGET(calibrations, fuzz::Form::bytes) {
  fuzz::Input input(data, size);
  const uint32_t kind = input.below(15);
  folder().clear();
  fvv::import::Calibration found;
  try {
    switch (kind) {
    case 0: {
      folder().write("cameras.txt", input.part());
      folder().write("images.txt", input.rest());
      found = fvv::import::read_colmap(folder().path);
      break;
    }
    case 1:
      found = fvv::import::read_opencv({folder().write("file", input.rest())});
      break;
    case 2:
      found = fvv::import::read_nerfstudio(folder().write("file", input.rest()));
      break;
    case 3:
      found = fvv::import::read_qualisys(folder().write("file", input.rest()));
      break;
    case 4:
      found = fvv::import::read_middlebury(folder().write("file", input.rest()), 640, 480);
      break;
    case 6: {
      folder().write("cameras.bin", input.part());
      folder().write("images.bin", input.rest());
      found = fvv::import::read_colmap(folder().path);
      break;
    }
    case 7:
      found = fvv::import::read_krt({folder().write("file", input.rest())}, 640, 480);
      break;
    case 8:
      found = fvv::import::read_panoptic(folder().write("file", input.rest()));
      break;
    case 9: {
      folder().write("intri.yml", input.part());
      folder().write("extri.yml", input.rest());
      found = fvv::import::read_easymocap(folder().path, 640, 480);
      break;
    }
    case 10:
      found = fvv::import::read_toml(folder().write("file", input.rest()));
      break;
    case 11:
      found = fvv::import::read_kalibr(folder().write("file", input.rest()));
      break;
    case 12:
      found = fvv::import::read_metashape(folder().write("file", input.rest()));
      break;
    case 13:
      found = fvv::import::read_realitycapture({folder().write("file", input.rest())}, 640, 480);
      break;
    case 14:
      found = fvv::import::read_realitycapture({folder().write("file.xmp", input.rest())}, 640, 480);
      break;
    default: {
      fvv::scene::Camera camera;
      camera.calibration.width = camera.calibration.height = 100;
      camera.calibration.fx = camera.calibration.fy = 100;
      camera.calibration.r_max = 1;
      for (int i = 0; i < 9; i += 4) camera.calibration.rotation[i] = 1;
      (void)fvv::import::diagnose(
          {camera}, fvv::import::read_observations(folder().write("file", input.rest()), {camera}));
      return;
    }
    }
    expect_valid(found.cameras);
    fuzz::expect(!found.cameras.empty(), "there is a camera");
  } catch (const fvv::Error &) {}
}
