// A small capture on disk, the tool as a child process, and a stream read back: shared by the tests of
// fvvmux.
#pragma once

#include "fvv_catch.h"

#include "cli/cli.h"
#include "fvv/stream.h"
#include "fvv_cxx/input_file.h"
#include "fvv_media/frame.h"
#include "mux/src/stream_writer.h"
#include "mux_to_file.h"

#include <cmath>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace fs = std::filesystem;
using namespace fvv;

class Folder {
public:
  Folder() {
    std::string name = (fs::temp_directory_path() / "fvvmux-XXXXXX").string();
    REQUIRE(mkdtemp(name.data()));
    root = name;
  }
  ~Folder() { fs::remove_all(root); }
  Folder(const Folder &) = delete;
  std::string path(const std::string &leaf) const { return (root / leaf).string(); }
  size_t entries() const {
    return size_t(std::distance(fs::directory_iterator(root), fs::directory_iterator()));
  }
  // The files that an interrupted run would leave.
  bool has_partial() const {
    for (const auto &entry : fs::directory_iterator(root))
      if (entry.path().extension() == ".partial") return true;
    return false;
  }

private:
  fs::path root;
};

inline std::string read_bytes(const std::string &path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void write_bytes(const std::string &path, const void *bytes, size_t size) {
  std::ofstream(path, std::ios::binary).write(static_cast<const char *>(bytes), std::streamsize(size));
}

// A closed ball of 12 x 16 cells, radius 0.5, moving along x.
inline geometry::Mesh ball(int64_t frame) {
  constexpr uint32_t rows = 12, columns = 16;
  geometry::Mesh mesh;
  const auto vertex = [&](double polar, double around) {
    mesh.positions.push_back(0.05 * double(frame) + 0.5 * std::sin(polar) * std::cos(around));
    mesh.positions.push_back(0.5 * std::cos(polar));
    mesh.positions.push_back(0.5 * std::sin(polar) * std::sin(around));
  };
  vertex(0, 0);
  for (uint32_t r = 1; r < rows; r++)
    for (uint32_t c = 0; c < columns; c++) vertex(M_PI * r / rows, 2 * M_PI * c / columns);
  vertex(M_PI, 0);
  const auto face = [&](uint32_t a, uint32_t b, uint32_t c) {
    mesh.faces.insert(mesh.faces.end(), {a, b, c});
  };
  const auto at = [&](uint32_t r, uint32_t c) { return 1 + (r - 1) * columns + c % columns; };
  for (uint32_t c = 0; c < columns; c++) {
    face(0, at(1, c + 1), at(1, c));
    for (uint32_t r = 1; r + 1 < rows; r++) {
      face(at(r, c), at(r, c + 1), at(r + 1, c));
      face(at(r, c + 1), at(r + 1, c + 1), at(r + 1, c));
    }
    face(uint32_t(mesh.vertex_count() - 1), at(rows - 1, c), at(rows - 1, c + 1));
  }
  return mesh;
}

struct Shape {
  int64_t first = 0, count = 5, step = 1;
  fvv_rational duration = {1, 25};
  bool meshes = true, pictures = true, masks = false;
  std::vector<std::array<uint32_t, 2>> sizes = {{64, 48}, {64, 48}, {64, 48}};
};

inline Shape with_masks() {
  Shape shape;
  shape.masks = true;
  return shape;
}

inline scene::Camera camera_of(size_t k, uint32_t width, uint32_t height) {
  scene::Camera camera;
  fvv_camera &c = camera.calibration;
  c.id = uint16_t(10 * k + 3);
  c.width = width;
  c.height = height;
  c.fx = 70.25;
  c.fy = 70.5;
  c.cx = width / 2.0;
  c.cy = height / 2.0 + 1.0 / 3;
  const double a = M_PI / 2 * double(k); // 3 m from the origin, at +z, +x and -z
  const double rotation[9] = {std::cos(a), 0, -std::sin(a), 0, -1, 0, -std::sin(a), 0, -std::cos(a)};
  memcpy(c.rotation, rotation, sizeof rotation);
  c.translation[2] = 3;
  c.r_max = INFINITY;
  camera.set_name("camera " + std::to_string(k));
  return camera;
}

inline bool inside(uint32_t x, uint32_t y, uint32_t width, uint32_t height, int64_t frame) {
  const double dx = x - (width / 2.0 + double(frame)), dy = y - height / 2.0;
  return dx * dx + dy * dy < 100;
}

// A textured disc of radius 10 that moves by a pixel a frame, over a ramp.
inline media::Image picture_of(size_t k, uint32_t width, uint32_t height, int64_t frame) {
  media::Image image = media::make_image(width, height, 3, 0);
  for (uint32_t y = 0; y < height; y++)
    for (uint32_t x = 0; x < width; x++) {
      uint8_t *p = &image.pixels[3 * (size_t(y) * width + x)];
      const bool disc = inside(x, y, width, height, frame);
      p[0] = uint8_t(disc ? 120 + 60 * std::sin(0.7 * double(x - frame)) : 2 * x);
      p[1] = uint8_t(disc ? 90 + 50 * std::cos(0.5 * y) : 3 * y);
      p[2] = uint8_t(40 + 50 * k);
    }
  return image;
}

inline media::Image mask_of(uint32_t width, uint32_t height, int64_t frame) {
  media::Image mask = media::make_image(width, height, 1, 0);
  for (uint32_t y = 0; y < height; y++)
    for (uint32_t x = 0; x < width; x++)
      if (inside(x, y, width, height, frame)) mask.pixels[size_t(y) * width + x] = 255;
  return mask;
}

inline void write_png(const std::string &path, const media::Image &image) {
  const std::vector<uint8_t> bytes = media::encode_png(image);
  write_bytes(path, bytes.data(), bytes.size());
}

// Writes capture.json and its files into folder/in, and returns its description.
inline scene::Capture make_capture(const Folder &folder, const Shape &shape = {}) {
  scene::Capture capture;
  capture.path = folder.path("in/capture.json");
  capture.name = "ball";
  capture.frame_duration = shape.duration;
  capture.frames = {shape.first, shape.count, shape.step};
  capture.up = FVV_UP_Y;
  fs::create_directories(folder.path("in/meshes"));
  if (shape.meshes) capture.meshes = scene::Pattern::parse("meshes/%04d.ply", nullptr);
  for (size_t k = 0; k < shape.sizes.size(); k++) {
    capture.cameras.push_back(camera_of(k, shape.sizes[k][0], shape.sizes[k][1]));
    const std::string leaf = "cam" + std::to_string(k) + "/";
    fs::create_directories(folder.path("in/" + leaf));
    if (shape.pictures) capture.cameras[k].pictures = scene::Pattern::parse(leaf + "%04d.png", nullptr);
    if (shape.masks) capture.cameras[k].masks = scene::Pattern::parse(leaf + "mask%04d.png", nullptr);
  }
  for (const int64_t number : capture.frames.numbers()) {
    if (shape.meshes) scene::write_mesh(ball(number), {}, capture.mesh_path(number));
    for (size_t k = 0; k < shape.sizes.size(); k++) {
      const auto [width, height] = shape.sizes[k];
      const scene::Camera &camera = capture.cameras[k];
      if (shape.pictures)
        write_png(capture.picture_path(camera, number), picture_of(k, width, height, number));
      if (shape.masks) write_png(capture.mask_path(camera, number), mask_of(width, height, number));
    }
  }
  scene::write_capture(capture, capture.path);
  return capture;
}

inline FileOptions options_for(const Folder &folder) {
  FileOptions options;
  options.capture = folder.path("in");
  options.output = folder.path("out.fvv");
  options.force = true;
  options.group = 2;
  options.threads = 2;
  options.keep_geometry = true;   // tests count triangles
  options.crop = mux::Crop::none; // and look for pixels where they were
  options.tile_fill = mux::TileFill::keep;
  options.match_colours = mux::MatchColours::off; // cameras of these captures show different things
  options.visibility = mux::Visibility::none;     // and chunks
  options.view_loss = 0;                          // nor do they choose by views
  return options;
}

// The shapes of the frames, written over those of make_capture.
// Groups of 6 frames that verify.
using Frames = std::vector<geometry::Mesh>;
inline FileOptions frames_on_disk(const Folder &folder, const Frames &frames) {
  Shape shape;
  shape.count = int64_t(frames.size());
  shape.pictures = false;
  const scene::Capture capture = make_capture(folder, shape);
  for (size_t i = 0; i < frames.size(); i++)
    scene::write_mesh(frames[i], {{0, 0, 0}, 1e-6}, capture.mesh_path(int64_t(i)));
  FileOptions options = options_for(folder);
  options.group = 6;
  options.verify = true;
  return options;
}

inline Frames balls(size_t count) {
  Frames frames;
  for (size_t i = 0; i < count; i++) frames.push_back(ball(int64_t(i)));
  return frames;
}

// A stream opened through its file; every call must succeed.
class Stream {
public:
  explicit Stream(const std::string &path) : file(path) {
    const fvv_input input = file.input();
    REQUIRE(fvv_stream_open(&input, nullptr, nullptr, &stream, nullptr) == FVV_OK);
  }
  ~Stream() { fvv_stream_close(stream); }
  Stream(const Stream &) = delete;
  size_t frames() const { return fvv_stream_frame_count(stream); }
  fvv_stream *handle() { return stream; }
  const fvv_configuration &configuration() {
    const fvv_configuration *found = nullptr;
    REQUIRE(fvv_stream_configuration(stream, 0, &found, nullptr) == FVV_OK);
    return *found;
  }
  void mesh(size_t frame, fvv_mesh &mesh) {
    REQUIRE(fvv_stream_mesh(stream, frame, 1, &mesh, nullptr) == FVV_OK);
  }
  std::vector<uint8_t> sample(size_t frame, int &key) {
    const uint8_t *bytes = nullptr;
    size_t size = 0;
    REQUIRE(fvv_stream_sample(stream, frame, 2, &bytes, &size, &key, nullptr) == FVV_OK);
    return {bytes, bytes + size};
  }
  // NULL: the frame has none.
  const fvv_visibility *visibility(size_t frame) {
    const fvv_visibility *found = nullptr;
    REQUIRE(fvv_stream_visibility(stream, frame, mux::visibility_track, &found, nullptr) == FVV_OK);
    return found;
  }
  fvv_camera camera(size_t frame, uint16_t id) {
    fvv_camera camera;
    REQUIRE(fvv_stream_camera(stream, frame, id, &camera, nullptr) == FVV_OK);
    return camera;
  }
  // All pictures; tile k of frame i is pictures()[i], extracted.
  std::vector<media::Image> pictures() {
    media::Decoder decoder(configuration().videos[0].config);
    std::vector<media::Image> out;
    for (size_t i = 0; i < frames(); i++) {
      int key = 0;
      const std::vector<uint8_t> bytes = sample(i, key);
      out.push_back(decoder.decode(bytes.data(), bytes.size()));
    }
    return out;
  }

private:
  InputFile file;
  fvv_stream *stream = nullptr;
};

// The tool as a child. in_child runs between fork and exec.
inline pid_t start_tool(
    const std::vector<std::string> &arguments, const std::string &output,
    const std::function<void()> &in_child = [] {}) {
  std::vector<std::string> words = {FVV_TOOL};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char *> argv;
  for (std::string &word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  const std::string out = output + ".stdout", err = output + ".stderr";
  const pid_t child = fork();
  if (child == 0) {
    dup2(open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666), STDOUT_FILENO);
    dup2(open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666), STDERR_FILENO);
    in_child();
    execv(FVV_TOOL, argv.data());
    _exit(126);
  }
  REQUIRE(child > 0);
  return child;
}

struct ToolResult {
  int exit;
  std::string out, err;
};

inline ToolResult run_tool(
    const std::vector<std::string> &arguments, const std::function<void()> &in_child = [] {}) {
  const Folder logs;
  int status = 0;
  const pid_t child = start_tool(arguments, logs.path("log"), in_child);
  REQUIRE(waitpid(child, &status, 0) == child);
  REQUIRE(WIFEXITED(status));
  return {WEXITSTATUS(status), read_bytes(logs.path("log.stdout")), read_bytes(logs.path("log.stderr"))};
}
