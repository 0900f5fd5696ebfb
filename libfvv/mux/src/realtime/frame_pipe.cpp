#include "mux/src/realtime/frame_pipe.h"
#include "fvv_cxx/format.h"
#include "fvv_cxx/untrusted.h"
#include "fvv_media/memory_limit.h"

#include <algorithm>
#include <cstring>

namespace fvv::mux {

namespace {

constexpr uint8_t signature[8] = {0x89, 'F', 'V', 'P', '\r', '\n', 0x1a, '\n'};
constexpr size_t head_size = 16, record_size = 40;
constexpr uint32_t version = 1;
constexpr uint32_t most_description = 16 << 20, most_reason = 4096;

std::string printable(const uint8_t *bytes, size_t count) {
  std::string out;
  for (size_t i = 0; i < count; i++) out += fvv::format(i ? " %02x" : "%02x", bytes[i]);
  return out;
}

} // namespace

FramePipe::FramePipe(Read from, const std::string &shown, const media::MemoryLimit &most)
    : read(std::move(from)), name(shown), limit(most), current("the head") {
  uint8_t head[head_size];
  fill(head, sizeof head, "the head");
  if (std::memcmp(head, signature, sizeof signature) != 0)
    fail(0, "expected a pipe of frames (spec/frame-pipe.md), which begins with " +
                printable(signature, sizeof signature) + ", found " + printable(head, sizeof signature));
  if (const uint32_t found = load_u32(head + 8); found != version)
    fail(8, fvv::format("expected version %u of the pipe, found %u", version, found));
  const uint32_t size = load_u32(head + 12);
  if (size == 0 || size > most_description)
    fail(12, fvv::format("expected a description of 1 to %u bytes, found %u", most_description, size));
  std::string text(size, '\0');
  fill(text.data(), text.size(), "the description");
  description = scene::parse_capture(text, name);
  description.memory_limit = limit;
  for (const scene::Camera &camera : description.cameras) {
    const uint64_t pixels = uint64_t(camera.calibration.width) * camera.calibration.height;
    if (camera.pictures) pictures_size += 3 * pixels + (camera.masks ? pixels : 0);
  }
  media::check_memory(name + ": the pictures of a frame", pictures_size, limit);
}

void FramePipe::fail(uint64_t offset, const std::string &text) const {
  throw Error(name + fvv::format(": 0x%llx: ", static_cast<unsigned long long>(offset)) + text);
}

void FramePipe::fill(void *bytes, size_t size, const char *what) {
  for (size_t done = 0; done < size;) {
    const size_t count = read(static_cast<uint8_t *>(bytes) + done, size - done);
    if (!count)
      fail(at, fvv::format("the pipe was closed within %s: expected %zu more bytes of %s", current.c_str(),
                           size - done, what));
    done += count;
    at += count;
  }
}

void FramePipe::pass(uint64_t size) {
  std::vector<uint8_t> part(size_t(std::min<uint64_t>(size, 1 << 16)));
  for (; size; size -= std::min<uint64_t>(size, part.size()))
    fill(part.data(), size_t(std::min<uint64_t>(size, part.size())), "what it holds");
}

FramePipe::Record FramePipe::next() {
  pass(left);
  left = 0;
  const uint64_t start = at;
  uint8_t head[record_size];
  current = "a record";
  if (const size_t count = read(head, 1); !count) fail(at, "the pipe was closed without a record ENDS");
  at++;
  fill(head + 1, sizeof head - 1, "its head");
  const bool is_frame = !std::memcmp(head, "FRAM", 4), is_lost = !std::memcmp(head, "LOST", 4);
  if (!is_frame && !is_lost && std::memcmp(head, "ENDS", 4) != 0)
    fail(start, "expected a record FRAM, LOST or ENDS, found " + printable(head, 4));
  vertices = load_u32(head + 4);
  faces = load_u32(head + 8);
  if (load_u32(head + 12) != 0) fail(start + 12, "expected 0");
  Record out;
  out.number = load_i64(head + 16);
  out.time = load_i64(head + 24);
  const uint64_t size = uint64_t(load_i64(head + 32));
  const auto expect_size = [&](uint64_t expected) {
    if (size != expected)
      fail(start + 32,
           fvv::format("expected %llu bytes after the record's head, found %llu",
                       static_cast<unsigned long long>(expected), static_cast<unsigned long long>(size)));
  };
  if (!is_frame && (vertices || faces)) fail(start + 4, "expected no mesh");
  if (is_frame) {
    current = "frame " + std::to_string(out.number);
    const fvv_limits limits = limits_or_default(nullptr);
    if (vertices > limits.max_vertices || faces > limits.max_faces)
      fail(start + 4, fvv::format("expected at most %u vertices and %u faces, found %u and %u",
                                  limits.max_vertices, limits.max_faces, vertices, faces));
    if (!description.meshes && (vertices || faces))
      fail(start + 4, "expected no mesh, as the description has none");
    expect_size(12 * uint64_t(vertices) + 12 * uint64_t(faces) + pictures_size);
    out.kind = Record::frame;
    left = size;
  } else if (is_lost) {
    if (size > most_reason)
      fail(start + 32, fvv::format("expected a reason of at most %u bytes, found %llu", most_reason,
                                   static_cast<unsigned long long>(size)));
    out.reason.resize(size_t(size));
    fill(out.reason.data(), out.reason.size(), "its reason");
    out.kind = Record::lost;
  } else {
    expect_size(0);
  }
  return out;
}

media::Image FramePipe::picture(const fvv_camera &camera, int channels) {
  media::Image out = media::make_image(camera.width, camera.height, channels, 0);
  fill(out.pixels.data(), out.pixels.size(), "a picture");
  left -= out.pixels.size();
  return out;
}

Frame FramePipe::take(const std::vector<scene::Camera> &wanted) {
  media::check_memory(name + ": " + current, left + 12 * uint64_t(vertices),
                      limit); // positions become doubles
  Frame frame;
  std::vector<uint8_t> bytes(12 * size_t(vertices));
  fill(bytes.data(), bytes.size(), "positions");
  frame.mesh.positions.resize(3 * size_t(vertices));
  for (size_t i = 0; i < frame.mesh.positions.size(); i++) {
    const uint32_t bits = load_u32(bytes.data() + 4 * i);
    float value;
    std::memcpy(&value, &bits, sizeof value);
    frame.mesh.positions[i] = double(value) * description.metres_per_unit;
  }
  bytes.resize(12 * size_t(faces));
  fill(bytes.data(), bytes.size(), "faces");
  frame.mesh.faces.resize(3 * size_t(faces));
  for (size_t i = 0; i < frame.mesh.faces.size(); i++) frame.mesh.faces[i] = load_u32(bytes.data() + 4 * i);
  left -= 12 * uint64_t(vertices) + 12 * uint64_t(faces);
  if (vertices || faces) geometry::check(frame.mesh, "its mesh");
  frame.pictures.resize(wanted.size());
  frame.masks.resize(wanted.size());
  for (const scene::Camera &camera : description.cameras) {
    if (!camera.pictures) continue;
    const fvv_camera &shape = camera.calibration;
    const uint64_t pixels = uint64_t(shape.width) * shape.height;
    const auto place = std::find_if(wanted.begin(), wanted.end(), [&](const scene::Camera &one) {
      return one.pictures && one.calibration.id == shape.id;
    });
    if (place == wanted.end()) {
      const uint64_t size = 3 * pixels + (camera.masks ? pixels : 0);
      pass(size);
      left -= size;
      continue;
    }
    const size_t i = size_t(place - wanted.begin());
    frame.pictures[i] = picture(shape, 3);
    if (camera.masks) frame.masks[i] = picture(shape, 1);
  }
  return frame;
}

} // namespace fvv::mux
