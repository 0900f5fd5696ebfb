/* The configuration as flat structs. */
#include <string.h>

#include "decoder.h"

void fvvjs_flatten_camera(const fvv_camera *camera, int calibrated, flat_camera *flat) {
  memset(flat, 0, sizeof *flat);
  flat->fx = camera->fx;
  flat->fy = camera->fy;
  flat->cx = camera->cx;
  flat->cy = camera->cy;
  flat->skew = camera->skew;
  memcpy(flat->distortion, camera->distortion, sizeof flat->distortion);
  flat->r_max = camera->r_max;
  memcpy(flat->rotation, camera->rotation, sizeof flat->rotation);
  memcpy(flat->translation, camera->translation, sizeof flat->translation);
  flat->id = camera->id;
  flat->lens = camera->lens;
  flat->flags = camera->flags;
  flat->width = camera->width;
  flat->height = camera->height;
  flat->calibrated = (uint32_t)calibrated;
  flat->name = camera->name;
  flat->name_size = (uint32_t)camera->name_size;
}

static int put(fvv_bytes *list, const void *element, size_t size) {
  return fvv_bytes_append(list, element, size) == FVV_OK;
}

static void rect(const fvv_rect *from, uint32_t to[4]) {
  to[0] = from->x;
  to[1] = from->y;
  to[2] = from->width;
  to[3] = from->height;
}

/* Appends flat tiles. 0: no memory. */
int fvvjs_put_tiles(fvv_bytes *list, const fvv_tile *tiles, size_t count) {
  for (size_t i = 0; i < count; i++) {
    flat_tile tile = {tiles[i].camera_id, {0}, {0}};
    rect(&tiles[i].source, tile.source);
    rect(&tiles[i].destination, tile.destination);
    if (!put(list, &tile, sizeof tile)) return 0;
  }
  return 1;
}

static int put_video(fvvjs_decoder *d, const fvv_video_layout *video) {
  const fvv_video_config *config = &video->config;
  /* tiles: how many stand before, until the list does not move any more. */
  const size_t before = d->lists[FVVJS_TILES].size;
  if (!fvvjs_put_tiles(&d->lists[FVVJS_TILES], video->tiles, video->tile_count)) return 0;
  const flat_video flat = {video->track,
                           config->codec,
                           config->width,
                           config->height,
                           config->shows,
                           config->bit_depth,
                           config->camera_id,
                           config->colour_primaries,
                           config->transfer_characteristics,
                           config->matrix_coefficients,
                           config->full_range,
                           config->record,
                           (uint32_t)config->record_size,
                           config->codec_string,
                           (uint32_t)config->codec_string_size,
                           (const flat_tile *)before,
                           (uint32_t)video->tile_count};
  return put(&d->lists[FVVJS_VIDEOS], &flat, sizeof flat);
}

static int put_lists(fvvjs_decoder *d, const fvv_configuration *c) {
  for (size_t i = 0; i < c->track_count; i++) {
    const flat_track flat = {c->tracks[i].id, c->tracks[i].kind, c->tracks[i].name,
                             (uint32_t)c->tracks[i].name_size};
    if (!put(&d->lists[FVVJS_TRACKS], &flat, sizeof flat)) return 0;
  }
  for (size_t i = 0; i < c->camera_count; i++) {
    flat_camera flat;
    fvvjs_flatten_camera(&c->cameras[i], !(c->cameras[i].flags & FVV_CAMERA_MOVES), &flat);
    if (!put(&d->lists[FVVJS_CAMERAS], &flat, sizeof flat)) return 0;
  }
  for (size_t i = 0; i < c->video_count; i++)
    if (!put_video(d, &c->videos[i])) return 0;
  for (size_t i = 0; i < c->metadata_count; i++) {
    const flat_text flat = {c->metadata[i].text, (uint32_t)c->metadata[i].size};
    if (!put(&d->lists[FVVJS_METADATA], &flat, sizeof flat)) return 0;
  }
  return 1;
}

/* NULL: there is none yet, or no memory. Valid until the next call of fvvjs_next or fvvjs_play. */
FVVJS_EXPORT const flat_configuration *fvvjs_configuration(fvvjs_decoder *d) {
  const fvv_configuration *c = d->configuration;
  for (int i = FVVJS_TRACKS; i <= FVVJS_METADATA; i++) d->lists[i].size = 0;
  if (!c || !put_lists(d, c)) return NULL;
  flat_video *videos = (flat_video *)d->lists[FVVJS_VIDEOS].data;
  for (size_t i = 0; i < c->video_count; i++)
    videos[i].tiles = (const flat_tile *)(d->lists[FVVJS_TILES].data + (size_t)videos[i].tiles);
  flat_configuration *flat = &d->flat;
  memset(flat, 0, sizeof *flat);
  memcpy(flat->origin, c->scene.lattice_origin, sizeof flat->origin);
  flat->step = c->scene.lattice_step;
  flat->frame_duration = c->scene.frame_duration;
  flat->numerator = c->scene.time_base.numerator;
  flat->denominator = c->scene.time_base.denominator;
  flat->up_axis = c->scene.up_axis;
  flat->flags = c->scene.flags;
  flat->tracks = (const flat_track *)d->lists[FVVJS_TRACKS].data;
  flat->track_count = (uint32_t)c->track_count;
  flat->cameras = (const flat_camera *)d->lists[FVVJS_CAMERAS].data;
  flat->camera_count = (uint32_t)c->camera_count;
  flat->videos = videos;
  flat->video_count = (uint32_t)c->video_count;
  flat->metadata = (const flat_text *)d->lists[FVVJS_METADATA].data;
  flat->metadata_count = (uint32_t)c->metadata_count;
  const fvv_texturing *t = &c->texturing;
  flat->threshold = t->threshold;
  flat->depth_bias = t->depth_bias;
  flat->depth_slope = t->depth_slope;
  flat->best = t->best;
  flat->unseen = (uint32_t)t->unseen[0] << 16 | (uint32_t)t->unseen[1] << 8 | t->unseen[2];
  return flat;
}

void fvvjs_free_flat(fvvjs_decoder *d) {
  for (int i = 0; i < FVVJS_LISTS; i++) fvv_bytes_free(&d->lists[i]);
}
