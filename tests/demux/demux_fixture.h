// Small streams for the tests of fvvdemux: 3 cameras of 64x48 (one shown whole, one scaled, one cropped and
// scaled), groups of 3 frames, spheres.
#pragma once

#include "cli/cli.h"
#include "fvv/stream.h"
#include "fvv_catch.h"
#include "fvv_media/frame.h"
#include "fvv_media/video.h"
#include "fvv_scene/file_io.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <unistd.h>
#include <vector>

namespace fs = std::filesystem;
using Bytes = std::vector<uint8_t>;

constexpr int frames_per_group = 3;
const double origin[3] = {0.5, -1.25, 0.125};
constexpr double lattice_step = 0.003;

struct MemoryOutput {
  Bytes bytes;
  static fvv_status write(void *user, const void *data, size_t size) {
    auto &out = static_cast<MemoryOutput *>(user)->bytes;
    out.insert(out.end(), static_cast<const uint8_t *>(data), static_cast<const uint8_t *>(data) + size);
    return FVV_OK;
  }
};

struct Mesh : fvv_mesh {
  Mesh() : fvv_mesh() {}
  Mesh(const Mesh &) = delete;
  ~Mesh() { fvv_mesh_free(this); }
};

// Latitude and longitude; another radius for each frame.
inline void make_sphere(int frame, fvv_mesh &mesh) {
  const uint32_t u = 9, v = 6;
  std::vector<double> positions;
  std::vector<uint32_t> faces;
  const auto point = [&](double a, double b) {
    const double radius = 0.4 + 0.05 * frame;
    for (const double x : {std::sin(b) * std::cos(a), std::sin(b) * std::sin(a), std::cos(b)})
      positions.push_back(radius * x + 0.01 * frame);
  };
  point(0, 0);
  point(0, M_PI);
  for (uint32_t j = 1; j < v; j++)
    for (uint32_t i = 0; i < u; i++) point(2 * M_PI * i / u, M_PI * j / v);
  const auto at = [&](uint32_t i, uint32_t j) { return 2 + (j - 1) * u + i % u; };
  for (uint32_t i = 0; i < u; i++) {
    for (const uint32_t index : {0u, at(i, 1), at(i + 1, 1)}) faces.push_back(index);
    for (const uint32_t index : {1u, at(i + 1, v - 1), at(i, v - 1)}) faces.push_back(index);
    for (uint32_t j = 1; j + 1 < v; j++)
      for (const uint32_t index :
           {at(i, j), at(i, j + 1), at(i + 1, j), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)})
        faces.push_back(index);
  }
  fvv_mesh_options options;
  fvv_mesh_options_default(&options);
  for (int i = 0; i < 3; i++) options.lattice_origin[i] = origin[i];
  options.lattice_step = lattice_step;
  const fvv_mesh_source source = {positions.data(), faces.data(), positions.size() / 3,
                                  faces.size() / 3, nullptr,      nullptr};
  REQUIRE(fvv_mesh_canonicalise(&source, &options, nullptr, &mesh, nullptr, nullptr) == FVV_OK);
}

inline fvv_camera make_camera(uint16_t id) {
  fvv_camera camera = {};
  camera.id = id;
  camera.width = 64;
  camera.height = 48;
  camera.fx = 60.5 + id % 100;
  camera.fy = 61.25;
  camera.cx = 31.75;
  camera.cy = 24.5;
  camera.skew = 0.125;
  camera.lens = FVV_LENS_RADTAN;
  camera.distortion[0] = -0.05;
  camera.distortion[2] = 0.001;
  const double angle = 0.3 * (id % 3);
  const double rotation[9] = {std::cos(angle),  0, std::sin(angle), 0, 1, 0,
                              -std::sin(angle), 0, std::cos(angle)};
  std::copy(rotation, rotation + 9, camera.rotation);
  camera.translation[2] = 3;
  camera.r_max = fvv_camera_r_max(&camera);
  static const char name[] = "../camera/\"\n";
  camera.name = name;
  camera.name_size = sizeof name - 1;
  REQUIRE(fvv_camera_validate(&camera, nullptr) == FVV_OK);
  return camera;
}

// Smooth, so that video codecs come near it; unlike for every camera and frame.
inline fvv::media::Image make_picture(uint16_t camera, int frame) {
  fvv::media::Image image = fvv::media::make_image(64, 48, 3, 0);
  for (uint32_t y = 0; y < 48; y++)
    for (uint32_t x = 0; x < 64; x++)
      for (uint32_t c = 0; c < 3; c++)
        image.pixels[(y * 64 + x) * 3 + c] =
            uint8_t(40 + 2 * x + (c ? 3 : 1) * y / 2 + 20 * camera + 6 * uint32_t(frame));
  return image;
}

inline std::vector<fvv::media::DeepImage> widened(const std::vector<fvv::media::Image> &pictures) {
  std::vector<fvv::media::DeepImage> out;
  for (const fvv::media::Image &picture : pictures) {
    out.push_back(fvv::media::make_image<uint16_t>(picture.width, picture.height, picture.channels, 0));
    for (size_t i = 0; i < picture.pixels.size(); i++)
      out.back().pixels[i] = uint16_t(257 * picture.pixels[i] + i % 257);
  }
  return out;
}

struct StreamOptions {
  int groups = 2;
  uint32_t codec = FVV_CODEC_JPEG;
  int bit_depth = 8; // or 10
  uint8_t profile = FVV_MESH_RAW;
  std::string metadata;
  bool finish = true;
  int without_mesh = -1;           // a frame that has no mesh
  int repeat_before = -1;          // writes the configuration again before this group
  std::vector<Bytes> environments; // payloads of BACK, on tracks 11, 12 ... in the first group
  std::vector<uint16_t> cameras = {7, 0, 65534};
};

inline std::vector<fvv_tile> make_tiles(const StreamOptions &options, uint32_t &width, uint32_t &height) {
  std::vector<fvv_tile> tiles = {{options.cameras[0], {0, 0, 64, 48}, {0, 0, 64, 48}},
                                 {options.cameras[1], {0, 0, 64, 48}, {0, 0, 32, 24}},
                                 {options.cameras[2], {8, 4, 40, 36}, {0, 0, 30, 48}}};
  REQUIRE(fvv_tiles_arrange(tiles.data(), tiles.size(), 4096, &width, &height, nullptr) == FVV_OK);
  return tiles;
}

template <class Encode> Bytes record(const Encode &encode) {
  size_t size = 0;
  (void)!encode(nullptr, 0, &size);
  Bytes out(size);
  REQUIRE(encode(out.data(), out.size(), &size) == FVV_OK);
  return out;
}

inline Bytes make_stream(const StreamOptions &options = {}) {
  MemoryOutput memory;
  const fvv_output output = {MemoryOutput::write, &memory};
  fvv_writer *writer = nullptr;
  REQUIRE(fvv_writer_create(&output, nullptr, &writer, nullptr) == FVV_OK);
  const auto configure = [&](uint32_t type, uint16_t track, const Bytes &payload) {
    const uint8_t flags = type == FVV_CHUNK_METADATA ? 0 : FVV_FLAG_CRITICAL;
    REQUIRE(fvv_writer_configuration(writer, type, track, flags, payload.data(), payload.size(), nullptr) ==
            FVV_OK);
  };
  uint32_t width, height;
  const std::vector<fvv_tile> tiles = make_tiles(options, width, height);
  const fvv::media::VideoSettings settings = {
      options.codec, width, height, options.codec == FVV_CODEC_JPEG ? 90 : 20, {1, 25}, options.bit_depth};
  std::vector<fvv::media::EncodedGroup> videos;
  for (int g = 0; g < options.groups; g++) {
    std::vector<fvv::media::Image> pictures;
    for (int f = g * frames_per_group; f < (g + 1) * frames_per_group; f++)
      pictures.push_back(fvv::media::compose(
          tiles, {make_picture(0, f), make_picture(1, f), make_picture(2, f)}, width, height));
    videos.push_back(options.bit_depth > 8 ? fvv::media::encode_group(settings, widened(pictures))
                                           : fvv::media::encode_group(settings, pictures));
  }
  const fvv_scene scene = {{1, 25}, 1, {origin[0], origin[1], origin[2]}, lattice_step, FVV_UP_Z, 0};
  configure(FVV_CHUNK_SCENE, 0, record([&](uint8_t *out, size_t n, size_t *size) {
              return fvv_scene_encode(&scene, out, n, size, nullptr);
            }));
  std::vector<std::pair<uint16_t, uint8_t>> tracks = {{1, FVV_TRACK_MESH}, {2, FVV_TRACK_VIDEO}};
  for (size_t i = 0; i < options.environments.size(); i++)
    tracks.push_back({uint16_t(11 + i), FVV_TRACK_ENVIRONMENT});
  for (const auto &[id, kind] : tracks) {
    fvv_track track = {};
    track.id = id;
    track.kind = kind;
    track.name = "../x";
    track.name_size = 4;
    configure(FVV_CHUNK_TRACK, id, record([&](uint8_t *out, size_t n, size_t *size) {
                return fvv_track_encode(&track, out, n, size, nullptr);
              }));
  }
  for (const uint16_t id : options.cameras) {
    const fvv_camera camera = make_camera(id);
    configure(FVV_CHUNK_CAMERA, 0, record([&](uint8_t *out, size_t n, size_t *size) {
                return fvv_camera_encode(&camera, out, n, size, nullptr);
              }));
  }
  const fvv_video_config config = fvv::media::config_of(settings, videos[0]);
  configure(FVV_CHUNK_VIDEO_CONFIG, 2, record([&](uint8_t *out, size_t n, size_t *size) {
              return fvv_video_config_encode(&config, out, n, size, nullptr);
            }));
  configure(FVV_CHUNK_TILES, 2, record([&](uint8_t *out, size_t n, size_t *size) {
              return fvv_tiles_encode(tiles.data(), tiles.size(), out, n, size, nullptr);
            }));
  if (!options.metadata.empty())
    configure(FVV_CHUNK_METADATA, 0, Bytes(options.metadata.begin(), options.metadata.end()));
  for (int g = 0; g < options.groups; g++) {
    const int first = g * frames_per_group;
    if (g == options.repeat_before) REQUIRE(fvv_writer_repeat_configuration(writer, nullptr) == FVV_OK);
    REQUIRE(fvv_writer_begin_group(writer, first, first + frames_per_group, nullptr) == FVV_OK);
    for (int f = first; f < first + frames_per_group; f++) {
      if (f != options.without_mesh) {
        Mesh mesh;
        make_sphere(f, mesh);
        fvv_bytes payload = {};
        REQUIRE(fvv_mesh_encode(&mesh, options.profile, 7, nullptr, &payload, nullptr) == FVV_OK);
        REQUIRE(fvv_writer_chunk(writer, FVV_CHUNK_MESH, 1, FVV_FLAG_CRITICAL | FVV_FLAG_KEY, f, payload.data,
                                 payload.size, nullptr) == FVV_OK);
        fvv_bytes_free(&payload);
      }
      const fvv::media::Sample &sample = videos[size_t(g)].samples[size_t(f - first)];
      const uint8_t flags = FVV_FLAG_CRITICAL | (sample.key ? FVV_FLAG_KEY : 0);
      REQUIRE(fvv_writer_chunk(writer, FVV_CHUNK_VIDEO_PACKET, 2, flags, f, sample.bytes.data(),
                               sample.bytes.size(), nullptr) == FVV_OK);
      for (size_t i = 0; f == 1 && i < options.environments.size(); i++)
        REQUIRE(fvv_writer_chunk(writer, FVV_CHUNK_ENVIRONMENT, uint16_t(11 + i), FVV_FLAG_KEY, f,
                                 options.environments[i].data(), options.environments[i].size(),
                                 nullptr) == FVV_OK);
    }
    REQUIRE(fvv_writer_end_group(writer, nullptr) == FVV_OK);
  }
  if (options.finish) REQUIRE(fvv_writer_finish(writer, nullptr) == FVV_OK);
  fvv_writer_destroy(writer);
  return memory.bytes;
}

// A temporary folder for each test.
class Scratch {
public:
  Scratch() {
    static int counter = 0;
    root = fs::temp_directory_path() /
           ("fvv_demux_test." + std::to_string(::getpid()) + "." + std::to_string(counter++));
    fs::create_directories(root);
  }
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(root, ignored);
  }
  std::string path(const std::string &name) const { return (root / name).string(); }
  std::string file(const std::string &name, const Bytes &bytes) const {
    std::ofstream(path(name), std::ios::binary)
        .write(reinterpret_cast<const char *>(bytes.data()), std::streamsize(bytes.size()));
    return path(name);
  }

private:
  fs::path root;
};

inline Bytes read(const std::string &path) {
  const std::string bytes = fvv::scene::read_file(path, uint64_t(1) << 30);
  return Bytes(bytes.begin(), bytes.end());
}

// All files below a folder by their names relative to it, without the list of them (docs/tools/outputs.md).
inline std::map<std::string, Bytes> files_of(const std::string &folder) {
  std::map<std::string, Bytes> out;
  for (const auto &entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && entry.path().filename() != ".fvv-output")
      out[fs::relative(entry.path(), folder).string()] = read(entry.path().string());
  return out;
}
