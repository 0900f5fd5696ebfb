#include "fvvrender/render.h"

#include "cli/cli.h"
#include "fvv_cxx/parallel.h"
#include "fvv_render/normals.h"

#include <chrono>
#include <cmath>
#include <memory>

namespace fvv::rendering {

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
    if (!options.sources.has(id) || (options.excluded && options.excluded->has(id)) ||
        (options.leave_one_out && options.target.camera == id))
      continue;
    render::SourceView source = {picture.camera, picture.image.pixels.data()};
    if (!picture.wide.pixels.empty()) source.wide_pixels = picture.wide.pixels.data();
    if (const CameraShares *bits = frame.bits_of(id)) source.visible_vertices = bits->shares.data();
    out.push_back(source);
  }
  if (out.empty()) throw Error(options.input + ": no camera is left to take texture from");
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

// The user's wishes go before the stream's.
render::ViewOptions textured(const Options &options, const fvv_texturing &said) {
  render::ViewOptions view = options.view;
  view.threshold = options.threshold.value_or(said.threshold);
  view.best = options.best.value_or(std::min<uint32_t>(said.best, render::max_best));
  view.unseen = options.unseen.value_or(
      render::Vec3{said.unseen[0] / 255.0, said.unseen[1] / 255.0, said.unseen[2] / 255.0});
  view.depth_test.bias = said.depth_bias;
  view.depth_test.slope = said.depth_slope;
  return view;
}

// The files of one run: all of them, or none.
class Files {
public:
  Files(const Options &options) : force(options.force) {
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
    for (const auto *file : {&colour, &depth, &weights, &visibility, &mask})
      if (*file) (*file)->commit();
  }

private:
  using File = std::unique_ptr<cli::OutputFile>;
  void open(File &file, const std::string &path) const {
    if (!path.empty()) file = std::make_unique<cli::OutputFile>(path, force);
  }
  template <class Make> static void put(const File &file, const Make &make) {
    if (!file) return;
    const std::vector<uint8_t> bytes = make();
    file->write(bytes.data(), bytes.size());
  }

  bool force, exr = false;
  File colour, depth, weights, visibility, mask;
};

} // namespace

void run(const Options &options, Result &result) {
  if (options.leave_one_out && !options.target.camera)
    throw Error("--leave-one-out: expected with --camera only", Error::usage);
  Files files(options);
  Clock clock;
  Frame frame = load_frame(options.input, options.frame);
  result.losses = frame.losses;
  if (render::inside_out(frame.mesh()))
    result.warnings.push_back(options.input + ": frame " + std::to_string(options.frame) +
                              ": the faces are wound inside out: nothing is textured but what cameras see of "
                              "their insides");
  const fvv_camera target = target_camera(options.target, frame);
  const std::vector<render::SourceView> sources = sources_of(options, frame);
  for (const render::SourceView &source : sources) result.sources.push_back(source.camera.id);
  result.load = clock.lap();

  render::ViewOptions view = textured(options, frame.texturing);
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
