/* Prints what libfvv decodes, for the test of the browser's decoder: for every frame and everything in it a
 * line with a name and a number of bytes, and then those bytes. The reader of this makes the hashes. usage:
 * frame_bytes FILE */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fvv/stream.h"

static fvv_status read_at(void *user, uint64_t offset, void *out, size_t size) {
  FILE *file = user;
  return !fseek(file, (long)offset, SEEK_SET) && fread(out, 1, size, file) == size ? FVV_OK : FVV_ERROR_IO;
}

static void put(const char *name, unsigned id, const void *bytes, size_t size) {
  printf("%s %u %zu\n", name, id, size);
  fwrite(bytes, 1, size, stdout);
}

static void put_mesh(const fvv_mesh *mesh, unsigned track, const fvv_scene *scene) {
  const size_t vertices = mesh->vertex_count;
  put("lattice", track, mesh->positions, 12 * vertices);
  put("indices", track, mesh->faces, 12 * (size_t)mesh->face_count);
  float *floats = malloc(12 * vertices + 1);
  if (!floats) exit(1);
  fvv_lattice_to_floats(scene->lattice_origin, scene->lattice_step, mesh->positions, vertices, floats);
  put("positions", track, floats, 12 * vertices);
  if (fvv_mesh_normals(mesh, NULL, floats, NULL) == FVV_OK) put("normals", track, floats, 12 * vertices);
  if (mesh->texture) {
    fvv_texture_to_floats(mesh->texture_bits, mesh->texture, vertices, floats);
    put("uvs", track, floats, 8 * vertices);
  }
  free(floats);
}

/* The numbers of a camera in the order in which JavaScript lists them, and a projected point. */
static void put_camera(const fvv_camera *camera) {
  double numbers[32] = {camera->fx, camera->fy, camera->cx, camera->cy, camera->skew};
  memcpy(numbers + 5, camera->distortion, sizeof camera->distortion);
  numbers[13] = camera->r_max;
  memcpy(numbers + 14, camera->rotation, sizeof camera->rotation);
  memcpy(numbers + 23, camera->translation, sizeof camera->translation);
  put("camera", camera->id, numbers, 26 * sizeof *numbers);
  const double point[3] = {0.25, 1.0, -0.5};
  double pixel[3];
  if (fvv_camera_project(camera, point, pixel, pixel + 2)) put("pixel", camera->id, pixel, sizeof pixel);
}

/* Camera, source and destination of each tile. */
static void put_tiles(const fvv_tile *tiles, size_t count, unsigned track) {
  uint32_t *numbers = malloc(36 * count + 1);
  if (!numbers) exit(1);
  for (size_t i = 0; i < count; i++) {
    const fvv_rect *s = &tiles[i].source, *d = &tiles[i].destination;
    const uint32_t tile[9] = {tiles[i].camera_id, s->x,     s->y, s->width, s->height, d->x, d->y,
                              d->width,           d->height};
    memcpy(numbers + 9 * i, tile, sizeof tile);
  }
  put("tiles", track, numbers, 36 * count);
  free(numbers);
}

static void put_track(fvv_stream *stream, size_t frame, size_t group, const fvv_track *track,
                      const fvv_scene *scene) {
  fvv_mesh mesh;
  const fvv_visibility *visibility;
  const uint8_t *sample;
  const fvv_tile *tiles;
  size_t size;
  int key;
  if (track->kind == FVV_TRACK_MESH && fvv_stream_mesh(stream, frame, track->id, &mesh, NULL) == FVV_OK) {
    put_mesh(&mesh, track->id, scene);
    fvv_mesh_free(&mesh);
  }
  if (track->kind == FVV_TRACK_VISIBILITY &&
      fvv_stream_visibility(stream, frame, track->id, &visibility, NULL) == FVV_OK) {
    const size_t elements = visibility->header.element_count;
    for (size_t i = 0; i < visibility->header.camera_count; i++)
      put("visibility", visibility->cameras[i], visibility->states + i * elements, elements);
  }
  if (track->kind == FVV_TRACK_VIDEO &&
      fvv_stream_sample(stream, frame, track->id, &sample, &size, &key, NULL) == FVV_OK)
    put(key ? "key" : "sample", track->id, sample, size);
  if (track->kind == FVV_TRACK_VIDEO &&
      fvv_stream_tiles(stream, group, track->id, &tiles, &size, NULL) == FVV_OK)
    put_tiles(tiles, size, track->id);
}

int main(int count, char **arguments) {
  FILE *file = count == 2 ? fopen(arguments[1], "rb") : NULL;
  if (!file || fseek(file, 0, SEEK_END)) return 2;
  const fvv_input input = {read_at, file, (uint64_t)ftell(file)};
  fvv_diagnostic diagnostic;
  fvv_stream *stream;
  if (fvv_stream_open(&input, NULL, NULL, &stream, &diagnostic) != FVV_OK) {
    fprintf(stderr, "%s\n", diagnostic.message);
    return 1;
  }
  for (size_t f = 0; f < fvv_stream_frame_count(stream); f++) {
    fvv_frame frame;
    const fvv_configuration *configuration;
    if (fvv_stream_frame(stream, f, &frame, NULL) != FVV_OK ||
        fvv_stream_configuration(stream, frame.group, &configuration, NULL) != FVV_OK)
      continue;
    put("time", 0, &frame.time, sizeof frame.time);
    const fvv_scene scene = configuration->scene;
    for (size_t i = 0; i < configuration->track_count; i++)
      put_track(stream, f, frame.group, &configuration->tracks[i], &scene);
    for (size_t i = 0; i < configuration->camera_count; i++) {
      fvv_camera camera;
      if (fvv_stream_camera(stream, f, configuration->cameras[i].id, &camera, NULL) == FVV_OK)
        put_camera(&camera);
    }
  }
  fvv_stream_close(stream);
  fclose(file);
  return 0;
}
