// The camera of the picture, its sources, and drawing.
#include "fvv_view/draw.h"

#include "fvv_cxx/parallel.h"
#include "fvv_render/local_origin.h"
#include "fvv_render/normals.h"
#include "fvv_render/projection.h"
#include "fvv_view/path.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace fvv::view {

namespace {

using render::Vec3;

[[noreturn]] void refuse(const std::string &line) {
  throw Error(line, Error::usage);
}

void take_size(const std::optional<Size> &size, uint32_t &width, uint32_t &height) {
  if (!size) return;
  width = size->width;
  height = size->height;
  if (width < 1 || height < 1 || width > media::max_dimension || height > media::max_dimension)
    refuse(option_name("size") + ": expected sides of 1 to " + std::to_string(media::max_dimension) +
           ", found " + std::to_string(width) + "x" + std::to_string(height));
}

const fvv_camera &of_stream(uint16_t id, const Frame &frame) {
  const fvv_camera *camera = frame.camera(id);
  if (!camera)
    refuse(option_name("camera") + ": camera " + std::to_string(id) + " is not in the stream, which has " +
           frame.camera_ids());
  return *camera;
}

fvv_camera scaled(const fvv_camera &camera, const Target &target) {
  if (camera.width > media::max_dimension || camera.height > media::max_dimension)
    refuse(option_name("camera") + ": camera " + std::to_string(camera.id) + " has sides above " +
           std::to_string(media::max_dimension));
  uint32_t width = camera.width, height = camera.height;
  take_size(target.size, width, height);
  const fvv_rect whole = {0, 0, uint16_t(camera.width), uint16_t(camera.height)};
  const fvv_tile tile = {camera.id, whole, {0, 0, uint16_t(width), uint16_t(height)}};
  return fvv_camera_of_tile(&camera, &tile);
}

fvv_camera of_pose(const Target &target, const Frame &frame) {
  const std::vector<double> &p = target.pose;
  if (p.size() != 6 && p.size() != 9)
    refuse(option_name("pose") + ": expected 6 numbers, eye and target, or 9 with up, found " +
           std::to_string(p.size()));
  for (const double value : p)
    if (!(std::abs(value) <= 1e9)) refuse(option_name("pose") + ": expected numbers within 1e9");
  const Vec3 eye = {p[0], p[1], p[2]}, at = {p[3], p[4], p[5]};
  const Vec3 up = p.size() == 9 ? Vec3{p[6], p[7], p[8]} : render::up_vector(frame.up);
  const Vec3 z = render::normalised(at - eye), side = render::cross(z, render::normalised(up));
  if (!(render::length(z) > 0)) refuse(option_name("pose") + ": eye and target are the same point");
  if (!(render::length(side) > 1e-6)) refuse(option_name("pose") + ": up points along the line of sight");
  const Vec3 x = render::normalised(side), y = render::cross(z, x);
  fvv_camera camera = {};
  camera.lens = FVV_LENS_NONE;
  camera.r_max = std::numeric_limits<double>::infinity();
  camera.width = default_width;
  camera.height = default_height;
  take_size(target.size, camera.width, camera.height);
  camera.fx = camera.fy = target.focal.value_or(camera.width);
  camera.cx = camera.width / 2.0;
  camera.cy = camera.height / 2.0;
  const Vec3 rows[3] = {x, y, z};
  for (int i = 0; i < 3; i++) {
    camera.rotation[3 * i] = rows[i].x;
    camera.rotation[3 * i + 1] = rows[i].y;
    camera.rotation[3 * i + 2] = rows[i].z;
    camera.translation[i] = -render::dot(rows[i], eye - frame.origin);
  }
  return camera;
}

// Error (usage) for a camera that is not there, sizes out of range, and poses without direction.
fvv_camera target_camera(const Target &target, const Frame &frame) {
  const size_t given = target.camera.has_value() + target.calibration.has_value() + !target.pose.empty();
  if (given != 1)
    refuse("expected one of " + option_name("camera") + " and " + option_name("pose") + ", found " +
           std::string(given ? "both" : "neither"));
  if (!target.pose.empty()) return of_pose(target, frame);
  if (target.focal) refuse(option_name("focal") + ": expected with " + option_name("pose") + " only");
  return scaled(target.calibration ? render::camera_from(frame.origin, *target.calibration)
                                   : of_stream(*target.camera, frame),
                target);
}

class Clock {
public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - last).count();
    last = now;
    return seconds;
  }

private:
  std::chrono::steady_clock::time_point last = std::chrono::steady_clock::now();
};

void check_ids(const char *option, const demux::Selection &selection, const Frame &frame) {
  if (selection.everything()) return;
  for (const auto &range : selection.within(0, INT32_MAX))
    for (int64_t id = range.first; id <= range.last; id++)
      if (id > UINT16_MAX || !frame.camera(uint16_t(id)))
        refuse_option(option, "camera " + std::to_string(id) + " is not in the stream, which has " +
                                  frame.camera_ids());
}

std::vector<render::SourceView> sources_of(const Options &options, const Frame &frame) {
  check_ids("sources", options.sources, frame);
  if (options.excluded) check_ids("exclude", *options.excluded, frame);
  std::vector<render::SourceView> out;
  for (const Picture &picture : frame.pictures) {
    const uint16_t id = picture.camera.id;
    if (!options.pictures || !options.sources.has(id) || (options.excluded && options.excluded->has(id)) ||
        (options.leave_one_out && options.target.camera == id))
      continue;
    render::SourceView source = {picture.camera, picture.image.pixels.data()};
    if (!picture.wide.pixels.empty()) source.wide_pixels = picture.wide.pixels.data();
    if (const CameraWeights *bits = frame.bits_of(id)) source.visible_vertices = bits->weights.data();
    out.push_back(source);
  }
  // Where all pictures are lost, the colours of vertices are left.
  if (out.empty() && options.pictures && (frame.colours.empty() || !frame.pictures.empty()))
    throw Error(frame.file + ": no camera is left to take texture from");
  return out;
}

// Bits by default where there are some; other sources have depth maps.
render::Visibility visibility_of(const Options &options, const Frame &frame,
                                 const std::vector<render::SourceView> &sources, Result &result) {
  for (const render::SourceView &source : sources)
    if (source.visible_vertices) result.with_bits.push_back(source.camera.id);
  if (options.visible_by_default)
    return result.with_bits.empty() ? render::Visibility::depth_map : render::Visibility::given;
  if (options.view.visibility == render::Visibility::given && result.with_bits.empty())
    throw Error(frame.file + ": frame " + std::to_string(frame.number) +
                ": there are no bits of these cameras (" + option_name("visible-by", "bits") + ")");
  return options.view.visibility;
}

// Options of the user override those of the stream.
render::ViewOptions textured(const Options &options, const fvv_texturing &said) {
  render::ViewOptions view = options.view;
  const auto theirs = render::Blend(said.blend);
  view.blend = options.blend.value_or(theirs);
  view.threshold = options.threshold.value_or(
      view.blend == theirs ? said.threshold : fvv_texturing_threshold(uint8_t(view.blend)));
  view.best = options.best.value_or(std::min<uint32_t>(said.best, render::max_best));
  view.unseen = options.unseen.value_or(
      render::Vec3{said.unseen[0] / 255.0, said.unseen[1] / 255.0, said.unseen[2] / 255.0});
  view.depth_test.bias = said.depth_bias;
  view.depth_test.slope = said.depth_slope;
  view.inset = options.inset.value_or(said.inset);
  return view;
}

} // namespace

render::ViewPicture draw(const Frame &frame, const Options &options, Result &result) {
  Clock clock;
  result.losses = frame.losses;
  if (render::inside_out(frame.mesh()))
    result.warnings.push_back(frame.file + ": frame " + std::to_string(frame.number) +
                              ": the faces are wound inside out: nothing is textured but what cameras see of "
                              "their insides");
  if (options.leave_one_out && !options.target.camera)
    throw Error(option_name("leave-one-out") + ": expected with " + option_name("camera") + " only",
                Error::usage);
  const fvv_camera target = target_camera(options.target, frame);
  const std::vector<render::SourceView> sources = sources_of(options, frame);
  for (const render::SourceView &source : sources) result.sources.push_back(source.camera.id);
  result.vertex_colours = !options.unseen && !frame.colours.empty();

  render::ViewOptions view = textured(options, frame.texturing);
  result.blend = view.blend;
  if (result.vertex_colours) view.vertex_colours = frame.colours.data();
  view.visibility = result.visibility = visibility_of(options, frame, sources, result);
  if (view.visibility != render::Visibility::given) result.with_bits.clear();
  view.executor = [&](size_t count, const std::function<void(size_t)> &work) {
    fvv::parallel(options.threads, count, work);
  };
  const render::Environment environment(options.environment ? frame.environment
                                                            : std::vector<render::EnvironmentPart>());
  view.environment = &environment;
  const render::ViewRenderer renderer(frame.mesh(), frame.normals, sources, view);
  result.prepare = clock.lap();
  render::ViewPicture picture = renderer.render(target);
  result.draw = clock.lap();

  result.width = picture.width;
  result.height = picture.height;
  result.by_cameras.resize(size_t(picture.best) + 1);
  for (size_t pixel = 0; pixel < picture.face.size(); pixel++) {
    if (picture.face[pixel] == render::no_face) continue;
    size_t cameras = 0;
    while (cameras < picture.best &&
           picture.contributions[pixel * picture.best + cameras].source != render::no_source)
      cameras++;
    result.surface++;
    result.by_cameras[cameras]++;
  }
  return picture;
}

std::vector<uint8_t> eight_bits(const render::ViewPicture &picture) {
  std::vector<uint8_t> out(picture.rgb.size());
  for (size_t i = 0; i < out.size(); i++)
    out[i] = uint8_t(std::floor(std::clamp(double(picture.rgb[i]), 0.0, 1.0) * 255 + 0.5));
  return out;
}

} // namespace fvv::view
