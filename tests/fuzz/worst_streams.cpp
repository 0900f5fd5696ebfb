// Streams of at most 4 KiB that cost a reader as much as the rules allow: large meshes of little content, and
// everything that is computed for each vertex of them.
#include "make_seeds.h"

#include "fvv/colours.h"
#include "fvv/stream.h"

#include <string>

namespace fuzz {

namespace {

constexpr size_t longest = 4096;

template <class Encode> Bytes record(const Encode &encode) {
  size_t size = 0;
  (void)!encode(nullptr, 0, &size);
  Bytes out(size);
  expect(encode(out.data(), out.size(), &size) == FVV_OK, "a record can be encoded");
  return out;
}

Bytes bytes_of(const fvv_bytes &bytes) {
  return Bytes(bytes.data, bytes.data + bytes.size);
}

// A flat grid of side x side vertices, decoded from its payload. A plane predicts itself.
struct Grid {
  fvv_mesh mesh = {};
  Bytes payload;
  Grid(uint32_t side, uint8_t profile) {
    std::vector<int32_t> positions;
    std::vector<uint32_t> faces;
    for (uint32_t y = 0; y < side; y++)
      for (uint32_t x = 0; x < side; x++) {
        positions.insert(positions.end(), {int32_t(x), int32_t(y), 0});
        if (x + 1 == side || y + 1 == side) continue;
        const uint32_t a = y * side + x, b = a + 1, c = a + side, d = c + 1;
        faces.insert(faces.end(), {a, b, c, b, d, c});
      }
    const fvv_mesh source = {
        positions.data(), faces.data(), side * side, uint32_t(faces.size() / 3), nullptr, 0, nullptr, 0, {}};
    Payload encoded;
    expect(fvv_mesh_encode(&source, profile, 10, nullptr, &encoded.bytes, nullptr) == FVV_OK,
           "a grid can be encoded");
    payload = bytes_of(encoded.bytes);
    expect(fvv_mesh_decode(payload.data(), payload.size(), nullptr, nullptr, &mesh, nullptr) == FVV_OK,
           "a grid decodes");
  }
  Grid(const Grid &) = delete;
  ~Grid() { fvv_mesh_free(&mesh); }
};

struct Writer {
  Bytes stream;
  fvv_writer *writer = nullptr;
  Writer() {
    const fvv_output output = {append, &stream};
    expect(fvv_writer_create(&output, nullptr, &writer, nullptr) == FVV_OK, "a writer is created");
    const fvv_scene scene = {{1, 25}, 1, {0, 0, 0}, 0.001, FVV_UP_Y, 0};
    configure(FVV_CHUNK_SCENE, 0, record([&](uint8_t *out, size_t n, size_t *size) {
                return fvv_scene_encode(&scene, out, n, size, nullptr);
              }));
  }
  Writer(const Writer &) = delete;
  ~Writer() { fvv_writer_destroy(writer); }
  void configure(uint32_t type, uint16_t track, const Bytes &payload) {
    expect(fvv_writer_configuration(writer, type, track, 0, payload.data(), payload.size(), nullptr) ==
               FVV_OK,
           "a record is written");
  }
  void track(uint16_t id, uint8_t kind) {
    fvv_track track = {};
    track.id = id;
    track.kind = kind;
    configure(FVV_CHUNK_TRACK, id, record([&](uint8_t *out, size_t n, size_t *size) {
                return fvv_track_encode(&track, out, n, size, nullptr);
              }));
  }
  void chunk(uint32_t type, uint16_t track, bool key, int64_t time, const Bytes &payload) {
    expect(fvv_writer_chunk(writer, type, track, key ? FVV_FLAG_KEY : 0, time, payload.data(), payload.size(),
                            nullptr) == FVV_OK,
           "a chunk is written");
  }
};

Bytes visibility_of(const fvv_mesh &mesh, uint32_t number, size_t cameras) {
  fvv_visibility_order *order = nullptr;
  expect(fvv_visibility_order_open(&mesh, nullptr, &order, nullptr) == FVV_OK, "a mesh has an order");
  const std::vector<uint8_t> seen(mesh.vertex_count, FVV_VERTEX_SEEN);
  std::vector<fvv_visibility_view> views;
  for (size_t i = 0; i < cameras; i++)
    views.push_back({uint16_t(i), {0, 0, 1 << 20}, seen.data(), number ? seen.data() : nullptr, nullptr});
  const fvv_visibility_header header = {64, 1, 0, number, 0};
  Payload payload;
  expect(fvv_visibility_encode(order, &mesh, &header, views.data(), views.size(), &payload.bytes, nullptr) ==
             FVV_OK,
         "visibility can be encoded");
  fvv_visibility_order_close(order);
  return bytes_of(payload.bytes);
}

Bytes colours_of(const fvv_mesh &mesh, uint32_t cell) {
  const std::vector<uint8_t> grey(3 * size_t(mesh.vertex_count), 128);
  const fvv_colours_header header = {1, 1, 1, 0, cell, 0};
  Payload payload;
  expect(fvv_colours_encode(&mesh, &header, grey.data(), nullptr, nullptr, &payload.bytes, nullptr) == FVV_OK,
         "colours can be encoded");
  return bytes_of(payload.bytes);
}

// A key mesh, and as many frames that do not move as fit, with visibility and colours if they are wanted.
Bytes still_stream(uint32_t side, uint8_t profile, size_t cameras, bool colours) {
  const Grid grid(side, profile);
  Writer out;
  out.track(1, FVV_TRACK_MESH);
  if (cameras) out.track(2, FVV_TRACK_VISIBILITY);
  if (colours) out.track(3, FVV_TRACK_COLOURS);
  for (size_t i = 0; i < cameras; i++) {
    fvv_camera camera = {};
    camera.id = uint16_t(i);
    camera.width = camera.height = 64;
    camera.fx = camera.fy = 64;
    camera.r_max = 2;
    for (int k = 0; k < 9; k += 4) camera.rotation[k] = 1;
    camera.rotation[4] = camera.rotation[8] = -1; // looks down on the grid
    camera.translation[2] = 1048.576;
    out.configure(FVV_CHUNK_CAMERA, 0, record([&](uint8_t *to, size_t n, size_t *size) {
                    return fvv_camera_encode(&camera, to, n, size, nullptr);
                  }));
  }
  expect(fvv_writer_begin_group(out.writer, 0, 1000, nullptr) == FVV_OK, "a group begins");
  out.chunk(FVV_CHUNK_MESH, 1, true, 0, grid.payload);
  if (cameras) out.chunk(FVV_CHUNK_VISIBILITY, 2, true, 0, visibility_of(grid.mesh, 0, cameras));
  if (colours) out.chunk(FVV_CHUNK_COLOURS, 3, true, 0, colours_of(grid.mesh, 4));
  fvv_mesh_sequence *sequence = nullptr;
  expect(fvv_mesh_sequence_open(&grid.mesh, nullptr, &sequence, nullptr) == FVV_OK, "a grid may be a key");
  // What is left for INDX, FOOT and GEND.
  for (uint32_t frame = 1; out.stream.size() < longest - 500; frame++) {
    Payload payload;
    expect(fvv_mesh_sequence_encode(sequence, grid.mesh.lattice, nullptr, &payload.bytes, nullptr) == FVV_OK,
           "a frame can be encoded");
    out.chunk(FVV_CHUNK_MESH, 1, false, frame, bytes_of(payload.bytes));
    if (cameras) out.chunk(FVV_CHUNK_VISIBILITY, 2, false, frame, visibility_of(grid.mesh, frame, cameras));
  }
  fvv_mesh_sequence_close(sequence);
  expect(fvv_writer_end_group(out.writer, nullptr) == FVV_OK &&
             fvv_writer_finish(out.writer, nullptr) == FVV_OK,
         "a stream ends");
  return out.stream;
}

} // namespace

void write_worst_streams(const Folder &folder) {
  for (const uint8_t profile : {uint8_t(FVV_MESH_DRACO), uint8_t(FVV_MESH_FAST)})
    for (const size_t cameras : {size_t(0), size_t(1), size_t(4)})
      for (const bool colours : {false, true}) {
        // The largest grid that leaves room: large ones take the room of frames.
        for (uint32_t side = 16; side <= 512; side = side * 5 / 4) {
          const Bytes stream = still_stream(side, profile, cameras, colours);
          if (stream.size() > longest) break;
          const std::string name = std::to_string(profile) + "-" + std::to_string(cameras) +
                                   (colours ? "c" : "") + "-" + std::to_string(side);
          folder.write("worst", name, stream);
        }
      }
}

} // namespace fuzz
