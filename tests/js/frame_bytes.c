/* Prints what libfvv decodes, for the test of the browser's decoder: for every frame and everything in it a
 * line with a name and a number of bytes, and then those bytes. The reader of this makes the hashes. usage:
 * frame_bytes FILE, or frame_bytes --environment FILE for the environments of the last group. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fvv/stream.h"

static void put(const char *name, unsigned id, const void *bytes, size_t size) {
  printf("%s %u %zu\n", name, id, size);
  fwrite(bytes, 1, size, stdout);
}

static void put_mesh(const fvv_mesh *mesh, unsigned track, const fvv_scene *scene) {
  const size_t vertices = mesh->vertex_count;
  put("lattice", track, mesh->lattice, 12 * vertices);
  put("faces", track, mesh->faces, 12 * (size_t)mesh->face_count);
  float *floats = malloc(12 * vertices + 1);
  if (!floats) exit(1);
  fvv_lattice_to_floats(scene->lattice_origin, scene->lattice_step, mesh->lattice, vertices, floats);
  put("positions", track, floats, 12 * vertices);
  if (fvv_mesh_normals(mesh, NULL, floats, NULL) == FVV_OK) put("normals", track, floats, 12 * vertices);
  if (mesh->texture) {
    fvv_texture_to_floats(mesh->texture_bits, mesh->texture, vertices, floats);
    put("uvs", track, floats, 8 * vertices);
  }
  free(floats);
}

/* With 255 after each, as JavaScript has them. */
static void put_colours(fvv_stream *stream, size_t frame, uint16_t track) {
  const uint8_t *rgb;
  uint32_t count;
  if (fvv_stream_colours(stream, frame, track, &rgb, &count, NULL) != FVV_OK) return;
  uint8_t *rgba = malloc(4 * (size_t)count + 1);
  if (!rgba) exit(1);
  for (size_t i = 0; i < count; i++) {
    memcpy(rgba + 4 * i, rgb + 3 * i, 3);
    rgba[4 * i + 3] = 255;
  }
  put("colours", track, rgba, 4 * (size_t)count);
  free(rgba);
}

static void put_texturing(const fvv_texturing *t) {
  const double numbers[6] = {t->threshold,
                             t->depth_bias,
                             t->depth_slope,
                             t->best,
                             65536.0 * t->unseen[0] + 256.0 * t->unseen[1] + t->unseen[2],
                             t->blend};
  put("texturing", 0, numbers, sizeof numbers);
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

static void put_weights(const fvv_visibility *visibility) {
  const size_t count = visibility->header.vertex_count;
  uint8_t *weights = malloc(count + 1);
  if (!weights) exit(1);
  for (size_t i = 0; i < visibility->header.camera_count; i++) {
    fvv_visibility_weights(visibility->states + i * count, count, weights);
    put("weights", visibility->cameras[i], weights, count);
  }
  free(weights);
}

static void put_tiles(fvv_stream *stream, size_t group, unsigned track) {
  const fvv_tile *tiles;
  size_t count;
  if (fvv_stream_tiles(stream, group, (uint16_t)track, &tiles, &count, NULL) != FVV_OK) return;
  uint32_t *numbers = malloc(36 * count + 1);
  if (!numbers) exit(1);
  for (size_t i = 0; i < count; i++) {
    const fvv_rect *s = &tiles[i].source, *d = &tiles[i].destination;
    const uint32_t one[9] = {tiles[i].camera_id, s->x,     s->y, s->width, s->height, d->x, d->y,
                             d->width,           d->height};
    memcpy(numbers + 9 * i, one, sizeof one);
  }
  put("tiles", track, numbers, 36 * count);
  free(numbers);
}

static void put_part(const fvv_environment *environment, size_t i) {
  fvv_mesh mesh;
  if (fvv_environment_mesh(environment, i, NULL, NULL, &mesh, NULL) != FVV_OK) exit(1);
  const size_t vertices = mesh.vertex_count;
  float *floats = malloc(12 * vertices + 1);
  if (!floats) exit(1);
  fvv_lattice_to_floats(environment->lattice_origin, environment->lattice_step, mesh.lattice, vertices,
                        floats);
  put("part-positions", (unsigned)i, floats, 12 * vertices);
  put("part-faces", (unsigned)i, mesh.faces, 12 * (size_t)mesh.face_count);
  if (mesh.texture) {
    const fvv_environment_part *part = &environment->parts[i];
    fvv_texture_to_floats(mesh.texture_bits, mesh.texture, vertices, floats);
    for (size_t k = 0; k < 2 * vertices; k++)
      floats[k] = (float)(part->texture_origin[k % 2] + part->texture_size[k % 2] * (double)floats[k]);
    put("part-uvs", (unsigned)i, floats, 8 * vertices);
  }
  free(floats);
  fvv_mesh_free(&mesh);
}

static void put_environment(const fvv_environment *environment) {
  for (size_t i = 0; i < environment->part_count; i++) put_part(environment, i);
  for (size_t i = 0; i < environment->picture_count; i++)
    put("picture", (unsigned)i, environment->pictures[i].data, environment->pictures[i].size);
  for (size_t i = 0; i < environment->light_count; i++) {
    const fvv_light *l = &environment->lights[i];
    const double numbers[13] = {l->position[0],  l->position[1],  l->position[2], l->direction[0],
                                l->direction[1], l->direction[2], l->colour[0],   l->colour[1],
                                l->colour[2],    l->intensity,    l->range,       l->inner_cone,
                                l->outer_cone};
    put("light", (unsigned)i, numbers, sizeof numbers);
  }
}

static int put_environments(fvv_stream *stream) {
  const size_t groups = fvv_stream_group_count(stream);
  const fvv_configuration *configuration;
  if (!groups || fvv_stream_configuration(stream, groups - 1, &configuration, NULL) != FVV_OK) return 1;
  for (size_t i = 0; i < configuration->track_count; i++) {
    const fvv_environment *environment;
    if (fvv_stream_environment(stream, groups - 1, configuration->tracks[i].id, &environment, NULL) == FVV_OK)
      put_environment(environment);
  }
  return 0;
}

static void put_track(fvv_stream *stream, size_t frame, const fvv_track *track, const fvv_scene *scene) {
  fvv_mesh mesh;
  const fvv_visibility *visibility;
  const uint8_t *sample;
  size_t size;
  int key;
  if (track->kind == FVV_TRACK_MESH && fvv_stream_mesh(stream, frame, track->id, &mesh, NULL) == FVV_OK) {
    put_mesh(&mesh, track->id, scene);
    put_colours(stream, frame, track->id);
    fvv_mesh_free(&mesh);
  }
  if (track->kind == FVV_TRACK_VISIBILITY &&
      fvv_stream_visibility(stream, frame, track->id, &visibility, NULL) == FVV_OK)
    put_weights(visibility);
  if (track->kind == FVV_TRACK_VIDEO &&
      fvv_stream_sample(stream, frame, track->id, &sample, &size, &key, NULL) == FVV_OK)
    put(key ? "key" : "sample", track->id, sample, size);
}

int main(int count, char **arguments) {
  const int environment = count == 3 && !strcmp(arguments[1], "--environment");
  fvv_input input;
  fvv_diagnostic diagnostic;
  if (count != 2 + environment || fvv_input_file_open(arguments[count - 1], &input, &diagnostic) != FVV_OK)
    return 2;
  fvv_stream *stream;
  if (fvv_stream_open(&input, NULL, NULL, &stream, &diagnostic) != FVV_OK) {
    fprintf(stderr, "%s\n", diagnostic.message);
    return 1;
  }
  if (environment) return put_environments(stream);
  for (size_t f = 0; f < fvv_stream_frame_count(stream); f++) {
    fvv_frame frame;
    const fvv_configuration *configuration;
    if (fvv_stream_frame(stream, f, &frame, NULL) != FVV_OK ||
        fvv_stream_configuration(stream, frame.group, &configuration, NULL) != FVV_OK)
      continue;
    put("time", 0, &frame.time, sizeof frame.time);
    put_texturing(&configuration->texturing);
    const fvv_scene scene = configuration->scene;
    for (size_t i = 0; i < configuration->track_count; i++)
      if (!configuration->tracks[i].rank) put_track(stream, f, &configuration->tracks[i], &scene);
    for (size_t i = 0; i < configuration->video_count; i++) {
      const uint16_t track = configuration->videos[i].track;
      if (!fvv_configuration_track(configuration, track)->rank) put_tiles(stream, frame.group, track);
    }
    for (size_t i = 0; i < configuration->camera_count; i++) {
      fvv_camera camera;
      if (fvv_stream_camera(stream, f, configuration->cameras[i].id, &camera, NULL) == FVV_OK)
        put_camera(&camera);
    }
  }
  fvv_stream_close(stream);
  fvv_input_file_close(&input);
  return 0;
}
