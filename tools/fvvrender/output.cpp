// What fvvrender writes: pictures as PNG, floats as OpenEXR, figures as JSON.
#include "fvvrender/render.h"

#include "cli/cli.h"
#include "fvv_media/colour.h"
#include "fvv_media/exr.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

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

} // namespace

bool is_exr(const std::string &option, const std::string &path, bool png) {
  const std::string extension = std::filesystem::path(path).extension();
  if (extension != ".exr" && !(png && extension == ".png"))
    throw Error(option + ": expected a name that ends in " + (png ? ".png or " : "") + ".exr, found " + path,
                Error::usage);
  return extension == ".exr";
}

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

std::vector<uint8_t> mask_file(const render::ViewPicture &picture) {
  media::Image image = media::make_image(picture.width, picture.height, 1, 0);
  for (size_t i = 0; i < picture.coverage.size(); i++)
    if (picture.coverage[i] >= 0.5f) image.pixels[i] = 255;
  return media::encode_png(image);
}

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
      {"surface", {{"pixels", result.surface}, {"share", double(result.surface) / all}}},
      {"share_by_cameras", shares},
      {"seconds", {{"load", result.load}, {"prepare", result.prepare}, {"draw", result.draw}}},
      {"losses", result.losses},
      {"warnings", result.warnings}};
  return document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

} // namespace fvv::rendering
