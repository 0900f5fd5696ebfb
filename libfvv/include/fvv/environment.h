/* fvv/environment.h: the static environment around the action, as triangle meshes with pictures, and lights.
 * Spec: spec/fvv.md clause 18.
 *
 * An environment is coarser and larger than the action, so it has a lattice of its own. It is sent whole, in
 * one chunk. Pictures are files, JPEG or PNG; nothing here decodes pixels. */
#ifndef FVV_ENVIRONMENT_H
#define FVV_ENVIRONMENT_H

#include "fvv/mesh.h"

#ifdef __cplusplus
extern "C" {
#endif

/* One mesh in one colour or with one picture. mesh: a MESH payload that stands alone (fvv_mesh_encode), with
 * texture coordinates when there is a picture, on the lattice of the environment. A vertex with texture
 * coordinates u v shows the picture at texture_origin + texture_size * (u, v), where (0, 0) is its top left
 * corner and (1, 1) its bottom right one; beyond, it repeats, or continues with its last pixel
 * (FVV_PART_CLAMPED). colour: red, green, blue, linear light, 65535 is 1; it multiplies the picture's. */
typedef struct fvv_environment_part {
  const uint8_t *mesh;
  size_t mesh_size;
  uint32_t picture; /* index in pictures, FVV_NO_PICTURE: none */
  uint16_t colour[3];
  uint8_t flags; /* FVV_PART_... */
  double texture_origin[2], texture_size[2];
} fvv_environment_part;

/* A whole file of FVV_PICTURE_JPEG or FVV_PICTURE_PNG, in sRGB. width, height: pixels, as in the file. */
typedef struct fvv_environment_picture {
  uint8_t codec;
  uint32_t width, height;
  const uint8_t *data;
  size_t size;
} fvv_environment_picture;

/* A light as in KHR_lights_punctual of glTF: metadata for players that light or draw shadows. What a type
 * does not use is 0. */
typedef struct fvv_light {
  uint8_t type;        /* FVV_LIGHT_... */
  uint8_t flags;       /* FVV_LIGHT_CASTS_SHADOWS */
  double position[3];  /* world, metres; not directional */
  double direction[3]; /* world, unit length, in which the light travels; not point */
  double colour[3];    /* red, green, blue, linear light, 0 to 1 */
  double intensity;    /* directional: lux; others: candela */
  double range;        /* metres, 0: no end; not directional */
  double inner_cone;   /* radians from direction, >= 0; spot only */
  double outer_cone;   /* radians, above inner_cone, at most pi / 2; spot only */
} fvv_light;

/* To encode: everything borrowed, payload and allocator not read. Decoded: the arrays belong to the struct
 * (fvv_environment_free), what mesh and data point to lies in the given payload. */
typedef struct fvv_environment {
  double lattice_origin[3]; /* world, metres */
  double lattice_step;      /* metres, > 0 */
  fvv_environment_part *parts;
  size_t part_count;
  fvv_environment_picture *pictures;
  size_t picture_count;
  fvv_light *lights;
  size_t light_count;
  const uint8_t *payload;
  fvv_allocator allocator;
} fvv_environment;

/* BACK payload; replaces what payload holds. FVV_ERROR_INPUT: what is described breaks a rule of clause 18;
 * the diagnostic has the issue number that a reader would give. Meshes are taken as they are, not decoded. */
FVV_API FVV_MUST_USE fvv_status fvv_environment_encode(const fvv_environment *environment,
                                                       const fvv_allocator *allocator, fvv_bytes *payload,
                                                       fvv_diagnostic *diagnostic);

/* Reads and checks everything but the data of meshes and pixels. Safe for hostile bytes: counts are checked
 * against the bytes and the limits before anything is allocated; some 150 bytes for each of 48. limits,
 * allocator NULL: defaults. payload has to live as long as what is decoded. On error *environment is empty.
 */
FVV_API FVV_MUST_USE fvv_status fvv_environment_decode(const uint8_t *payload, size_t size,
                                                       const fvv_limits *limits,
                                                       const fvv_allocator *allocator,
                                                       fvv_environment *environment,
                                                       fvv_diagnostic *diagnostic);
FVV_API void fvv_environment_free(fvv_environment *environment);

/* Decodes the mesh of a part, on the lattice of the environment; fvv_mesh_free. */
FVV_API FVV_MUST_USE fvv_status fvv_environment_mesh(const fvv_environment *environment, size_t part,
                                                     const fvv_limits *limits, const fvv_allocator *allocator,
                                                     fvv_mesh *mesh, fvv_diagnostic *diagnostic);

/* Codec and size of a picture file, for an entry that is to be encoded: picture->data and size are read,
 * codec, width and height filled. FVV_ERROR_INPUT: neither a JPEG nor a PNG file that clause 18.3 admits. */
FVV_API FVV_MUST_USE fvv_status fvv_environment_picture_inspect(fvv_environment_picture *picture,
                                                                fvv_diagnostic *diagnostic);

#ifdef __cplusplus
}
#endif
#endif
