// Writing a capture folder.
#include "fvvsynth/capture_writer.h"

#include "cli/parallel.h"
#include "fvv_media/image.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <numeric>

namespace fvv::synth {

namespace {

constexpr uint32_t samples = 3;
using Json = nlohmann::ordered_json;

std::string numbered(const char *before, size_t number, const char *after) {
  char digits[24];
  std::snprintf(digits, sizeof digits, "%04zu", number);
  return std::string(before) + digits + after;
}

// A plain write: the folder around it is what appears as a whole or not at all.
void write_file(const std::string &path, const void *bytes, size_t size) {
  std::FILE *file = std::fopen(path.c_str(), "wb");
  const bool whole = file && std::fwrite(bytes, 1, size, file) == size;
  const int reason = errno;
  const bool closed = file && std::fclose(file) == 0;
  if (!whole || !closed)
    throw cli::Failure(path + ": cannot write: " + std::strerror(whole ? errno : reason));
}

void append(std::vector<uint8_t> &out, uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) out.push_back(uint8_t(value >> shift));
}

std::vector<uint8_t> ply(const std::vector<float> &positions, const std::vector<uint32_t> &faces) {
  const std::string header =
      "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(positions.size() / 3) +
      "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
      std::to_string(faces.size() / 3) + "\nproperty list uchar int vertex_indices\nend_header\n";
  std::vector<uint8_t> out(header.begin(), header.end());
  out.reserve(out.size() + positions.size() * 4 + faces.size() / 3 * 13);
  for (const float value : positions) {
    uint32_t bits;
    std::memcpy(&bits, &value, sizeof bits);
    append(out, bits);
  }
  for (size_t i = 0; i < faces.size(); i += 3) {
    out.push_back(3);
    for (size_t c = 0; c < 3; c++) append(out, faces[i + c]);
  }
  return out;
}

std::string rate_text(FrameRate rate) {
  const std::string numerator = std::to_string(rate.numerator);
  return rate.denominator == 1 ? numerator : numerator + "/" + std::to_string(rate.denominator);
}

Json description(const Scene &scene, uint32_t count, FrameRate rate) {
  Json cameras = Json::array();
  for (const fvv_camera &camera : scene.cameras()) {
    const std::string name(camera.name, camera.name_size);
    const double *r = camera.rotation, *t = camera.translation;
    cameras.push_back({{"id", camera.id},
                       {"name", name},
                       {"width", camera.width},
                       {"height", camera.height},
                       {"intrinsics",
                        {{"fx", camera.fx},
                         {"fy", camera.fy},
                         {"cx", camera.cx},
                         {"cy", camera.cy},
                         {"skew", camera.skew}}},
                       {"lens", {{"model", "none"}, {"coefficients", Json::array()}}},
                       {"rotation", {{r[0], r[1], r[2]}, {r[3], r[4], r[5]}, {r[6], r[7], r[8]}}},
                       {"translation", {t[0], t[1], t[2]}},
                       {"pictures", name + "/%04d.png"},
                       {"masks", name + "/mask_%04d.png"}});
  }
  return {{"fvv_capture", 1},
          {"name", "players"},
          {"frame_rate", rate_text(rate)},
          {"frames", {{"first", 0}, {"count", count}}},
          {"units", "metres"},
          {"up", "+y"},
          {"conventions", {{"pixel_centre", 0.5}}},
          {"meshes", {{"pattern", "meshes/%04d.ply"}}},
          {"cameras", cameras}};
}

void write_png(const std::string &path, const render::Picture &picture, int channels,
               const std::vector<uint8_t> &pixels) {
  media::Image image;
  image.width = picture.width;
  image.height = picture.height;
  image.channels = channels;
  image.pixels = pixels;
  const std::vector<uint8_t> bytes = media::encode_png(image);
  write_file(path, bytes.data(), bytes.size());
}

} // namespace

FrameRate parse_frame_rate(const std::string &text) {
  unsigned long long parts[2] = {0, 1};
  size_t part = 0;
  bool digit = false, good = true;
  for (const char c : text) {
    if (c >= '0' && c <= '9') {
      if (!digit) parts[part] = 0;
      digit = true;
      parts[part] = std::min(parts[part] * 10 + unsigned(c - '0'), 1ull << 32);
    } else {
      good = good && c == '/' && digit && part == 0;
      digit = false;
      part = 1;
    }
  }
  const unsigned long long common = std::gcd(parts[0], parts[1]);
  if (!good || !digit || parts[0] == 0 || parts[1] == 0 || std::max(parts[0], parts[1]) > UINT32_MAX)
    throw cli::Failure(
        "--fps: expected a number like 25 or a fraction like 30000/1001, found \"" + text + "\"", cli::usage);
  return {uint32_t(parts[0] / common), uint32_t(parts[1] / common)};
}

void write_capture(const Scene &scene, uint32_t count, FrameRate rate, uint32_t threads,
                   const cli::OutputFolder &folder) {
  cli::Progress progress("frames", count);
  const auto frame = [&](size_t number) {
    const Moment moment = scene.at(double(number) * rate.denominator / rate.numerator);
    const std::vector<uint8_t> mesh = ply(moment.positions, scene.faces());
    write_file(folder.file(numbered("meshes/", number, ".ply")), mesh.data(), mesh.size());
    render::SampleBuffer buffer(scene.cameras()[0].width, scene.cameras()[0].height, samples);
    for (size_t i = 0; i < scene.cameras().size(); i++) {
      const render::Picture picture = scene.picture(i, moment, buffer);
      const fvv_camera &camera = scene.cameras()[i];
      const std::string name = std::string(camera.name, camera.name_size) + "/";
      write_png(folder.file(numbered(name.c_str(), number, ".png")), picture, 3, picture.rgb);
      write_png(folder.file(numbered((name + "mask_").c_str(), number, ".png")), picture, 1, picture.mask);
    }
  };
  cli::parallel(threads, count, frame, [&] { progress.step(); });
  const std::string text = description(scene, count, rate).dump(2) + "\n";
  write_file(folder.file("capture.json"), text.data(), text.size());
}

} // namespace fvv::synth
