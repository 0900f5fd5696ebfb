/* flat.h: what the decoder hands to JavaScript, as structs of 32-bit words and doubles at fixed offsets.
 * wasm.js reads them; the assertions below and the numbers there say the same. New members go to the end, and
 * the size into both. Pointers are addresses in the module's memory. */
#ifndef FVV_JS_FLAT_H
#define FVV_JS_FLAT_H

#include <stddef.h>
#include <stdint.h>

typedef struct flat_track {
  uint32_t id, kind;
  const char *name;
  uint32_t name_size;
} flat_track;

/* calibrated: 0 for a camera that moves, of which nothing is known in this frame. */
typedef struct flat_camera {
  double fx, fy, cx, cy, skew, distortion[8], r_max, rotation[9], translation[3];
  uint32_t id, lens, flags, width, height, calibrated;
  const char *name;
  uint32_t name_size;
} flat_camera;

typedef struct flat_tile {
  uint32_t camera, source[4], destination[4]; /* x y width height */
} flat_tile;

typedef struct flat_video {
  uint32_t track, codec, width, height, shows, bit_depth, camera;
  uint32_t primaries, transfer, matrix, full_range;
  const uint8_t *record;
  uint32_t record_size;
  const char *codec_string;
  uint32_t codec_string_size;
  const flat_tile *tiles;
  uint32_t tile_count;
} flat_video;

typedef struct flat_text {
  const char *text;
  uint32_t size;
} flat_text;

typedef struct flat_configuration {
  double origin[3], step;
  int64_t frame_duration;
  uint32_t numerator, denominator, up_axis, flags;
  const flat_track *tracks;
  uint32_t track_count;
  const flat_camera *cameras;
  uint32_t camera_count;
  const flat_video *videos;
  uint32_t video_count;
  const flat_text *metadata;
  uint32_t metadata_count;
  double threshold, depth_bias, depth_slope; /* of texturing */
  uint32_t best, unseen;                     /* 0xRRGGBB */
} flat_configuration;

typedef struct flat_mesh {
  uint32_t track, profile, key, vertex_count, face_count;
  const int32_t *lattice; /* vertex_count x 3 */
  const uint32_t *faces;  /* face_count x 3 */
  const float *positions; /* vertex_count x 3 metres */
  const float *normals;   /* vertex_count x 3, or 0 */
  const float *texture;   /* vertex_count x 2, or 0 */
  uint32_t texture_bits, normal_bits;
} flat_mesh;

typedef struct flat_visibility {
  uint32_t track, mesh_track, domain, threshold, camera_count, element_count;
  const uint16_t *cameras;
  const uint8_t *states; /* camera_count rows of element_count */
  const uint8_t *shares; /* camera_count rows of vertex_count, or 0 */
  uint32_t vertex_count;
} flat_visibility;

typedef struct flat_sample {
  uint32_t track, key;
  const uint8_t *data;
  uint32_t size;
} flat_sample;

/* The layout that a video track has in this group, in place of the configuration's. */
typedef struct flat_layout {
  uint32_t track;
  const flat_tile *tiles;
  uint32_t tile_count;
} flat_layout;

/* cameras: those that move. */
typedef struct flat_frame {
  int64_t time;
  const flat_mesh *meshes;
  uint32_t mesh_count;
  const flat_visibility *visibility;
  uint32_t visibility_count;
  const flat_camera *cameras;
  uint32_t camera_count;
  const flat_sample *samples;
  uint32_t sample_count;
  const flat_layout *layouts;
  uint32_t layout_count;
  const flat_sample *backgrounds; /* payloads of BACK, for the module of environments */
  uint32_t background_count;
} flat_frame;

/* Of an environment: a mesh in one colour or with one picture. */
typedef struct flat_part {
  uint32_t vertex_count, face_count;
  const uint32_t *faces;  /* face_count x 3 */
  const float *positions; /* vertex_count x 3 metres */
  const float *texture;   /* vertex_count x 2, places in the picture, or 0 */
  uint32_t picture, flags, colour[3];
} flat_part;

typedef struct flat_picture {
  uint32_t codec, width, height;
  const uint8_t *data;
  uint32_t size;
} flat_picture;

typedef struct flat_light {
  double position[3], direction[3], colour[3], intensity, range, inner_cone, outer_cone;
  uint32_t type, flags;
} flat_light;

typedef struct flat_background {
  uint32_t codecs, part_count; /* FVVJS_CODEC_... */
  const flat_picture *pictures;
  uint32_t picture_count;
  const flat_light *lights;
  uint32_t light_count;
} flat_background;

/* What the event that next answered speaks of. configuration: CRC that the group names its configuration by.
 */
typedef struct flat_event {
  uint64_t offset, skipped;
  int64_t start, end; /* of a group */
  uint32_t sequence, configuration;
} flat_event;

typedef struct flat_group {
  uint64_t offset, size;
  int64_t start, end;
  uint32_t sequence, frame_count, intact, end_size; /* end_size: of its GEND, bytes */
} flat_group;

#ifdef __wasm__
#define FLAT_ASSERT(type, member, at) _Static_assert(offsetof(type, member) == (at), #type "." #member)
FLAT_ASSERT(flat_camera, r_max, 104);
FLAT_ASSERT(flat_camera, id, 208);
_Static_assert(sizeof(flat_track) == 16, "flat_track");
_Static_assert(sizeof(flat_camera) == 240, "flat_camera");
_Static_assert(sizeof(flat_tile) == 36, "flat_tile");
_Static_assert(sizeof(flat_video) == 68, "flat_video");
_Static_assert(sizeof(flat_text) == 8, "flat_text");
FLAT_ASSERT(flat_configuration, frame_duration, 32);
FLAT_ASSERT(flat_configuration, numerator, 40);
FLAT_ASSERT(flat_configuration, threshold, 88);
_Static_assert(sizeof(flat_configuration) == 120, "flat_configuration");
_Static_assert(sizeof(flat_mesh) == 48, "flat_mesh");
_Static_assert(sizeof(flat_visibility) == 40, "flat_visibility");
_Static_assert(sizeof(flat_sample) == 16, "flat_sample");
FLAT_ASSERT(flat_frame, meshes, 8);
_Static_assert(sizeof(flat_layout) == 12, "flat_layout");
_Static_assert(sizeof(flat_frame) == 56, "flat_frame");
_Static_assert(sizeof(flat_part) == 40, "flat_part");
_Static_assert(sizeof(flat_picture) == 20, "flat_picture");
_Static_assert(sizeof(flat_light) == 112, "flat_light");
_Static_assert(sizeof(flat_background) == 24, "flat_background");
_Static_assert(sizeof(flat_event) == 40, "flat_event");
_Static_assert(sizeof(flat_group) == 48, "flat_group");
#endif

#endif
