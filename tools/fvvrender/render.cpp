// The files: pictures as PNG, floats as OpenEXR, figures as JSON.
#include "fvvrender/render.h"

#include "cli/cli.h"
#include "cli/output.h"
#include "fvv_media/colour.h"
#include "fvv_media/exr.h"

#include <nlohmann/json.hpp>

#include <chrono>
#include <filesystem>
#include <memory>

namespace fvv::rendering {

namespace {

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
    throw Error(option + ": expected a name that ends in " + (png ? ".png or " : "") + ".exr" +
                    (option == "--output" ? ", of films in .mp4 or /%04d.png" : "") + ", found " + path,
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
  image.pixels = view::eight_bits(picture);
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
  if (options.film.orbit)
    target = {{"orbit", *options.film.orbit}};
  else if (!options.film.path.empty())
    target = {{"path", options.film.path}};
  else if (options.draw.target.camera)
    target = {{"camera", *options.draw.target.camera}};
  else
    target = {{"pose", options.draw.target.pose}};
  const auto share = [&](uint64_t pixels) {
    return result.surface ? double(pixels) / double(result.surface) : 0.0;
  };
  nlohmann::ordered_json shares = nlohmann::ordered_json::array();
  for (const uint64_t pixels : result.by_cameras) shares.push_back(share(pixels));
  const double all = double(result.width) * result.height * double(result.film ? result.film->pictures : 1);
  nlohmann::ordered_json document = {
      {"fvvrender", 1},
      {"file", options.input},
      {"frame", result.film ? result.film->first : options.frame},
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
  if (result.film)
    document["film"] = {{"pictures", result.film->pictures},
                        {"rate", {result.film->duration.denominator, result.film->duration.numerator}},
                        {"last_frame", result.film->last}};
  return document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

namespace {

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
  Files files(options);
  const auto begin = std::chrono::steady_clock::now();
  const view::Frame frame = view::load_frame(InputFile(options.input), options.frame, options.load);
  result.load = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const render::ViewPicture picture = view::draw(frame, options.draw, result);
  files.write(picture, result.sources);
}

} // namespace fvv::rendering
