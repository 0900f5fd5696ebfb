#include "fvvimport/sheet_input.h"

#include "cli/cli.h"
#include "fvv_cxx/parallel.h"
#include "fvvimport/rig_hull.h"

#include <algorithm>
#include <stdexcept>

namespace fvv::fvvimport {

namespace {

// Masks for the hull are made smaller than this: a hull of some hundred cells a side shows no finer outline.
constexpr uint32_t hull_mask_side = 1280;

Loaded load(const SheetInput &input, const scene::PictureSource &source, const fvv_camera &camera,
            int channels) {
  Loaded out;
  try {
    out.image = input.videos->read(input.capture, source, input.frame, channels);
  } catch (const media::MemoryError &) {
    throw;
  } catch (const Error &error) {
    out.problem = error.what();
    return out;
  }
  if (out.image.width == camera.width && out.image.height == camera.height) return out;
  out.problem = input.capture.resolve(source.file(input.frame)) + ": expected " +
                std::to_string(camera.width) + "x" + std::to_string(camera.height) +
                " pixels, as the camera has, found " + std::to_string(out.image.width) + "x" +
                std::to_string(out.image.height);
  out.image = {};
  return out;
}

void threshold(media::Image &mask) {
  for (uint8_t &value : mask.pixels) value = value > 127 ? 255 : 0;
}

geometry::ViewedSurface mesh_of(const SheetInput &input) {
  geometry::Mesh mesh = scene::load_mesh(input.capture, input.frame);
  try {
    return geometry::ViewedSurface(mesh.positions, std::move(mesh.faces));
  } catch (const std::invalid_argument &error) {
    throw Error(input.capture.mesh_path(input.frame) + ": " + error.what());
  }
}

Subject hull_of_masks(const SheetInput &input, uint32_t threads) {
  std::vector<media::Image> images(input.cameras.size());
  fvv::parallel(threads, images.size(), [&](size_t i) {
    media::Image mask = mask_of(input, i).image;
    const uint32_t side = std::max(mask.width, mask.height);
    if (side > hull_mask_side) {
      const auto smaller = [&](uint32_t size) {
        return std::max<uint32_t>(2, uint32_t(uint64_t(size) * hull_mask_side / side));
      };
      mask = media::scale(mask, smaller(mask.width), smaller(mask.height));
      threshold(mask);
    }
    if (mask.width > 1 && mask.height > 1) images[i] = std::move(mask);
  });
  std::vector<fvv_camera> cameras;
  std::vector<std::vector<uint8_t>> masks;
  std::vector<size_t> taken;
  for (size_t i = 0; i < images.size(); i++) {
    if (images[i].pixels.empty()) continue;
    cameras.push_back(geometry::resized(input.cameras[i], images[i].width, images[i].height));
    masks.push_back(std::move(images[i].pixels));
    taken.push_back(i);
  }
  RigHull hull = hull_of(cameras, masks, threads);
  if (hull.surface.faces.empty()) return {};
  std::vector<double> positions;
  for (const hull::Vec3 &p : hull.surface.vertices) positions.insert(positions.end(), {p.x, p.y, p.z});
  Subject subject{geometry::ViewedSurface(positions, std::move(hull.surface.faces)), Outlined::hull,
                  std::nullopt};
  if (hull.excluded) subject.excluded = taken[*hull.excluded];
  return subject;
}

// Without meshes and masks there is no surface.
void leave_out_lost(scene::Capture &capture, int64_t frame, std::vector<std::string> &warnings) {
  std::vector<scene::Camera> kept;
  for (const scene::Camera &camera : capture.cameras)
    if (camera.is_calibrated(frame))
      kept.push_back(camera);
    else
      warnings.push_back(capture.path + ": left out: camera " + std::to_string(camera.calibration.id) +
                         " is not calibrated in frame " + std::to_string(frame));
  capture.cameras = std::move(kept);
  if (capture.cameras.empty())
    throw Error(capture.path + ": frame " + std::to_string(frame) +
                ": expected a camera that is calibrated, found none");
}

} // namespace

SheetInput open_capture(const SheetOptions &options) {
  SheetInput input;
  scene::Capture &capture = input.capture = scene::load_capture(scene::description_file(options.capture));
  capture.memory_limit = options.memory;
  if (options.frames) scene::restrict_frames(capture, *options.frames);
  scene::restrict_cameras(capture, options.cameras);
  if (capture.cameras.empty()) throw Error(capture.path + ": expected at least one camera, found none");
  std::stable_sort(capture.cameras.begin(), capture.cameras.end(),
                   [](const auto &a, const auto &b) { return a.calibration.id < b.calibration.id; });
  input.frame = capture.frames.number(capture.frames.count / 2);
  leave_out_lost(capture, input.frame, input.warnings);
  for (const scene::Camera &camera : capture.cameras)
    input.cameras.push_back(camera.calibration_at(input.frame));
  input.videos = std::make_shared<scene::Videos>(options.threads, options.memory);
  return input;
}

Loaded picture_of(const SheetInput &input, size_t i) {
  const scene::Camera &camera = input.capture.cameras[i];
  if (!camera.pictures) return {};
  return load(input, *camera.pictures, input.cameras[i], 3);
}

Loaded mask_of(const SheetInput &input, size_t i) {
  const scene::Camera &camera = input.capture.cameras[i];
  if (!camera.masks) return {};
  Loaded mask = load(input, *camera.masks, input.cameras[i], 1);
  threshold(mask.image);
  return mask;
}

Subject subject_of(const SheetInput &input, const SheetOptions &options) {
  if (input.capture.meshes && options.meshes) return {mesh_of(input), Outlined::mesh, std::nullopt};
  return hull_of_masks(input, options.threads);
}

} // namespace fvv::fvvimport
