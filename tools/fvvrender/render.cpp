// The camera of the picture, drawing, and the files: pictures as PNG, floats as OpenEXR, figures as JSON.
#include "fvvrender/render.h"

#include "cli/cli.h"
#include "cli/output.h"
#include "fvv_cxx/parallel.h"
#include "fvv_demux/views.h"
#include "fvv_media/colour.h"
#include "fvv_media/exr.h"
#include "fvv_render/normals.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>

namespace fvv::rendering {

namespace {

using render::Vec3;

[[noreturn]] void refuse(const std::string &line) {
  throw Error(line, Error::usage);
}

void take_size(const std::string &text, uint32_t &width, uint32_t &height) {
  if (text.empty()) return;
  cli::parse_size("--size", text, width, height);
  if (width < 1 || height < 1 || width > media::max_dimension || height > media::max_dimension)
    refuse("--size: expected sides of 1 to " + std::to_string(media::max_dimension) + ", found " + text);
}

fvv_camera of_stream(const Target &target, const Frame &frame) {
  const fvv_camera *camera = frame.camera(*target.camera);
  if (!camera)
    refuse("--camera: camera " + std::to_string(*target.camera) + " is not in the stream, which has " +
           frame.camera_ids());
  if (camera->width > media::max_dimension || camera->height > media::max_dimension)
    refuse("--camera: camera " + std::to_string(camera->id) + " has sides above " +
           std::to_string(media::max_dimension));
  uint32_t width = camera->width, height = camera->height;
  take_size(target.size, width, height);
  const fvv_rect whole = {0, 0, uint16_t(camera->width), uint16_t(camera->height)};
  const fvv_tile tile = {camera->id, whole, {0, 0, uint16_t(width), uint16_t(height)}};
  return fvv_camera_of_tile(camera, &tile);
}

Vec3 up_of(uint8_t axis) {
  switch (axis) {
  case FVV_UP_X:
    return {1, 0, 0};
  case FVV_UP_Z:
    return {0, 0, 1};
  case FVV_UP_MINUS_X:
    return {-1, 0, 0};
  case FVV_UP_MINUS_Y:
    return {0, -1, 0};
  case FVV_UP_MINUS_Z:
    return {0, 0, -1};
  default:
    return {0, 1, 0};
  }
}

fvv_camera of_pose(const Target &target, const Frame &frame) {
  const std::vector<double> &p = target.pose;
  if (p.size() != 6 && p.size() != 9)
    refuse("--pose: expected 6 numbers, eye and target, or 9 with up, found " + std::to_string(p.size()));
  for (const double value : p)
    if (!(std::abs(value) <= 1e9)) refuse("--pose: expected numbers within 1e9");
  const Vec3 eye = {p[0], p[1], p[2]}, at = {p[3], p[4], p[5]};
  const Vec3 up = p.size() == 9 ? Vec3{p[6], p[7], p[8]} : up_of(frame.up);
  const Vec3 z = render::normalised(at - eye), side = render::cross(z, render::normalised(up));
  if (!(render::length(z) > 0)) refuse("--pose: eye and target are the same point");
  if (!(render::length(side) > 1e-6)) refuse("--pose: up points along the line of sight");
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
    camera.translation[i] = -render::dot(rows[i], eye);
  }
  return camera;
}

// The camera of the picture. A camera of the stream is scaled to size. Error (usage) for a camera that is not
// there, sizes out of range, and poses without direction.
fvv_camera target_camera(const Target &target, const Frame &frame) {
  if (target.camera && target.focal) refuse("--focal: expected with --pose only");
  if (target.camera.has_value() == !target.pose.empty())
    refuse("expected one of --camera and --pose, found " + std::string(target.camera ? "both" : "neither"));
  return target.camera ? of_stream(target, frame) : of_pose(target, frame);
}

media::FloatImage float_image(const render::ViewPicture &picture, std::vector<std::string> channels) {
  media::FloatImage out;
  out.width = picture.width;
  out.height = picture.height;
  out.channels = std::move(channels);
  out.samples.resize(size_t(out.width) * out.height * out.channels.size());
  return out;
}

std::vector<std::string> channels_of(const std::vector<uint16_t> &sources) {
  std::vector<std::string> out;
  for (const uint16_t id : sources) out.push_back("camera." + std::to_string(id));
  return out;
}

// Whether the name asks for OpenEXR; Error (usage) for an extension that is neither png
// nor exr, or, without png, not exr. The option is named in the message.
bool is_exr(const std::string &option, const std::string &path, bool png) {
  const std::string extension = std::filesystem::path(path).extension();
  if (extension != ".exr" && !(png && extension == ".png"))
    throw Error(option + ": expected a name that ends in " + (png ? ".png or " : "") + ".exr, found " + path,
                Error::usage);
  return extension == ".exr";
}

// Colour as display values, rounded to 8 bits, or as linear light in R G B, with 1 for white.
std::vector<uint8_t> colour_file(const render::ViewPicture &picture, bool exr) {
  if (exr) {
    media::FloatImage image = float_image(picture, {"R", "G", "B"});
    for (size_t i = 0; i < picture.rgb.size(); i++)
      image.samples[i] = float(media::linear_of_srgb(double(picture.rgb[i])));
    return media::encode_exr(image);
  }
  media::Image image = media::make_image(picture.width, picture.height, 3, 0);
  for (size_t i = 0; i < picture.rgb.size(); i++)
    image.pixels[i] = uint8_t(std::floor(std::clamp(double(picture.rgb[i]), 0.0, 1.0) * 255 + 0.5));
  return media::encode_png(image);
}

std::vector<uint8_t> depth_file(const render::ViewPicture &picture) {
  media::FloatImage image = float_image(picture, {"Z"});
  image.samples = picture.depth;
  return media::encode_exr(image);
}

// Grey: 255 where at least half of the samples show the mesh.
std::vector<uint8_t> mask_file(const render::ViewPicture &picture) {
  media::Image image = media::make_image(picture.width, picture.height, 1, 0);
  for (size_t i = 0; i < picture.coverage.size(); i++)
    if (picture.coverage[i] >= 0.5f) image.pixels[i] = 255;
  return media::encode_png(image);
}

// A channel for each source, "camera.ID".
std::vector<uint8_t> weights_file(const render::ViewPicture &picture, const std::vector<uint16_t> &sources) {
  media::FloatImage image = float_image(picture, channels_of(sources));
  for (size_t i = 0; i < picture.contributions.size(); i++) {
    const render::Contribution &one = picture.contributions[i];
    if (one.source != render::no_source)
      image.samples[i / picture.best * sources.size() + one.source] = one.weight;
  }
  return media::encode_exr(image);
}

std::vector<uint8_t> visibility_file(const render::ViewPicture &picture,
                                     const std::vector<uint16_t> &sources) {
  media::FloatImage image = float_image(picture, channels_of(sources));
  for (size_t i = 0; i < picture.visible.size(); i++) image.samples[i] = picture.visible[i];
  return media::encode_exr(image);
}

} // namespace

std::string json(const Options &options, const Result &result) {
  nlohmann::ordered_json target;
  if (options.target.camera)
    target = {{"camera", *options.target.camera}};
  else
    target = {{"pose", options.target.pose}};
  const auto share = [&](uint64_t pixels) {
    return result.surface ? double(pixels) / double(result.surface) : 0.0;
  };
  nlohmann::ordered_json shares = nlohmann::ordered_json::array();
  for (const uint64_t pixels : result.by_cameras) shares.push_back(share(pixels));
  const double all = double(result.width) * result.height;
  const nlohmann::ordered_json document = {
      {"fvvrender", 1},
      {"file", options.input},
      {"frame", options.frame},
      {"target", target},
      {"width", result.width},
      {"height", result.height},
      {"sources", result.sources},
      {"visible_by", result.visibility == render::Visibility::given  ? "bits"
                     : result.visibility == render::Visibility::rays ? "rays"
                                                                     : "depth"},
      {"with_bits", result.with_bits},
      {"blend", result.blend == render::Blend::viewer ? "viewer" : "paper"},
      {"vertex_colours", result.vertex_colours},
      {"surface", {{"pixels", result.surface}, {"share", double(result.surface) / all}}},
      {"share_by_cameras", shares},
      {"seconds", {{"load", result.load}, {"prepare", result.prepare}, {"draw", result.draw}}},
      {"losses", result.losses},
      {"warnings", result.warnings}};
  return document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

namespace {

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
        throw Error(std::string(option) + ": camera " + std::to_string(id) +
                        " is not in the stream, which has " + frame.camera_ids(),
                    Error::usage);
}

std::vector<render::SourceView> sources_of(const Options &options, const Frame &frame) {
  check_ids("--sources", options.sources, frame);
  if (options.excluded) check_ids("--exclude", *options.excluded, frame);
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
    throw Error(options.input + ": no camera is left to take texture from");
  return out;
}

// Bits by default where there are some; other sources have depth maps.
render::Visibility visibility_of(const Options &options, const std::vector<render::SourceView> &sources,
                                 Result &result) {
  for (const render::SourceView &source : sources)
    if (source.visible_vertices) result.with_bits.push_back(source.camera.id);
  if (options.visible_by_default)
    return result.with_bits.empty() ? render::Visibility::depth_map : render::Visibility::given;
  if (options.view.visibility == render::Visibility::given && result.with_bits.empty())
    throw Error(options.input + ": frame " + std::to_string(options.frame) +
                ": there are no bits of these cameras (--visible-by bits)");
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

// The files of one run: all of them, or none.
class Files {
public:
  Files(const Options &options) : force(options.force), input(options.input) {
    exr = is_exr("--output", options.output, true);
    open(colour, options.output);
    for (const auto &[option, path] : {std::pair{"--depth", options.depth},
                                       {"--weights", options.weights},
                                       {"--visibility", options.visibility}})
      if (!path.empty()) (void)is_exr(option, path, false);
    if (!options.mask.empty() && is_exr("--mask", options.mask, true))
      throw Error("--mask: expected a name that ends in .png, found " + options.mask, Error::usage);
    open(depth, options.depth);
    open(weights, options.weights);
    open(visibility, options.visibility);
    open(mask, options.mask);
  }
  void write(const render::ViewPicture &picture, const std::vector<uint16_t> &sources) {
    put(colour, [&] { return colour_file(picture, exr); });
    put(depth, [&] { return depth_file(picture); });
    put(weights, [&] { return weights_file(picture, sources); });
    put(visibility, [&] { return visibility_file(picture, sources); });
    put(mask, [&] { return mask_file(picture); });
    std::vector<cli::Output *> all;
    for (const auto *file : {&colour, &depth, &weights, &visibility, &mask})
      if (*file) all.push_back(file->get());
    cli::commit(all);
  }

private:
  using File = std::unique_ptr<cli::OutputFile>;
  void open(File &file, const std::string &path) const {
    if (!path.empty()) file = std::make_unique<cli::OutputFile>(path, force, cli::inputs({input}));
  }
  template <class Make> static void put(const File &file, const Make &make) {
    if (!file) return;
    const std::vector<uint8_t> bytes = make();
    file->write(bytes.data(), bytes.size());
  }

  const bool force;
  const std::string input;
  bool exr = false;
  File colour, depth, weights, visibility, mask;
};

} // namespace

void run(const Options &options, Result &result) {
  if (options.leave_one_out && !options.target.camera)
    throw Error("--leave-one-out: expected with --camera only", Error::usage);
  Files files(options);
  Clock clock;
  Frame frame = load_frame(options.input, options.frame, options.memory, options.pictures, options.rung);
  result.losses = frame.losses;
  if (render::inside_out(frame.mesh()))
    result.warnings.push_back(options.input + ": frame " + std::to_string(options.frame) +
                              ": the faces are wound inside out: nothing is textured but what cameras see of "
                              "their insides");
  const fvv_camera target = target_camera(options.target, frame);
  const std::vector<render::SourceView> sources = sources_of(options, frame);
  for (const render::SourceView &source : sources) result.sources.push_back(source.camera.id);
  result.vertex_colours = !options.unseen && !frame.colours.empty();
  result.load = clock.lap();

  render::ViewOptions view = textured(options, frame.texturing);
  result.blend = view.blend;
  if (result.vertex_colours) view.vertex_colours = frame.colours.data();
  view.visibility = result.visibility = visibility_of(options, sources, result);
  if (view.visibility != render::Visibility::given) result.with_bits.clear();
  view.keep_visibility = !options.visibility.empty();
  view.executor = [&](size_t count, const std::function<void(size_t)> &work) {
    fvv::parallel(options.threads, count, work);
  };
  const render::Environment environment(options.environment ? std::move(frame.environment)
                                                            : std::vector<render::EnvironmentPart>());
  view.environment = &environment;
  const render::ViewRenderer renderer(frame.mesh(), frame.normals, sources, view);
  result.prepare = clock.lap();
  const render::ViewPicture picture = renderer.render(target);
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
  files.write(picture, result.sources);
}

} // namespace fvv::rendering
