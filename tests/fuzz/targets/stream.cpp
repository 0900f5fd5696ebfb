// Everything that random access by frame gives, in any order of frames.
#include "../fuzz.h"

#include "fvv/stream.h"

#include <algorithm>

namespace {

void read_mesh(fvv_stream *stream, size_t frame, uint16_t track) {
  fvv_mesh mesh;
  const fvv_status status = fvv_stream_mesh(stream, frame, track, &mesh, nullptr);
  fuzz::expect_status(status);
  fuzz::expect(status == FVV_OK || (!mesh.lattice && !mesh.faces), "a mesh that is not there is empty");
  for (size_t i = 0; status == FVV_OK && i < 3 * size_t(mesh.face_count); i++)
    fuzz::expect(mesh.faces[i] < mesh.vertex_count, "faces index vertices");
  if (status == FVV_OK) fvv_mesh_free(&mesh);
}

void read_track(fvv_stream *stream, size_t frame, size_t group, const fvv_track &track) {
  const uint8_t *bytes = nullptr;
  size_t size = 0;
  uint32_t vertices = 0;
  int key = 0;
  const fvv_tile *tiles = nullptr;
  const fvv_visibility *visibility = nullptr;
  const fvv_environment *environment = nullptr;
  switch (track.kind) {
  case FVV_TRACK_MESH:
    read_mesh(stream, frame, track.id);
    if (fvv_stream_colours(stream, frame, track.id, &bytes, &vertices, nullptr) == FVV_OK)
      (void)fvv_crc32c(0, bytes, 3 * size_t(vertices));
    break;
  case FVV_TRACK_VIDEO:
    if (fvv_stream_sample(stream, frame, track.id, &bytes, &size, &key, nullptr) == FVV_OK)
      (void)fvv_crc32c(0, bytes, size);
    if (fvv_stream_tiles(stream, group, track.id, &tiles, &size, nullptr) == FVV_OK)
      fuzz::expect(size > 0 && tiles[size - 1].destination.width > 0, "tiles are not empty");
    break;
  case FVV_TRACK_VISIBILITY:
    if (fvv_stream_visibility(stream, frame, track.id, &visibility, nullptr) == FVV_OK)
      (void)fvv_crc32c(0, visibility->states,
                       size_t(visibility->header.camera_count) * visibility->header.vertex_count);
    break;
  case FVV_TRACK_ENVIRONMENT:
    if (fvv_stream_environment(stream, group, track.id, &environment, nullptr) != FVV_OK) break;
    for (size_t i = 0; i < std::min<size_t>(environment->part_count, 4); i++) {
      fvv_mesh mesh;
      if (fvv_environment_mesh(environment, i, nullptr, nullptr, &mesh, nullptr) == FVV_OK)
        fvv_mesh_free(&mesh);
    }
    break;
  default:
    break;
  }
}

void read_frame(fvv_stream *stream, size_t number) {
  fvv_frame frame;
  const fvv_configuration *configuration = nullptr;
  if (fvv_stream_frame(stream, number, &frame, nullptr) != FVV_OK) return;
  const fvv_status status = fvv_stream_configuration(stream, frame.group, &configuration, nullptr);
  fuzz::expect_status(status);
  if (status != FVV_OK) return;
  // The configuration is valid until another group's is read; nothing below reads another.
  for (size_t i = 0; i < std::min<size_t>(configuration->track_count, 8); i++)
    read_track(stream, number, frame.group, configuration->tracks[i]);
  for (size_t i = 0; i < std::min<size_t>(configuration->camera_count, 8); i++) {
    fvv_camera camera;
    if (fvv_stream_camera(stream, number, configuration->cameras[i].id, &camera, nullptr) != FVV_OK) continue;
    const double world[3] = {0.5, 0.25, 3};
    double pixel[2];
    (void)fvv_camera_project(&camera, world, pixel, nullptr);
  }
}

} // namespace

FVV_FUZZ_TARGET(stream, fuzz::Form::stream) {
  fuzz::Memory memory = {data, size};
  const fvv_input input = memory.input();
  fvv_stream *stream = nullptr;
  const fvv_status opened = fvv_stream_open(&input, nullptr, nullptr, &stream, nullptr);
  fuzz::expect_status(opened);
  if (opened != FVV_OK) return;
  const size_t frames = fvv_stream_frame_count(stream);
  fuzz::Random random(fuzz::digest(data, size));
  for (size_t i = 0; i < std::min<size_t>(frames, 12); i++) read_frame(stream, i);
  for (size_t i = 0; i < std::min<size_t>(frames, 4); i++) read_frame(stream, random.below(uint32_t(frames)));
  fvv_stream_close(stream);
}
