/* fvv/encoder.h: an encoder. Frames with meshes, pictures and masks are pushed one after the other, and the
 * bytes of the stream come out a group at a time. Part of fvv_mux (static, C++) and of the shared library
 * fvv_encoder, which needs no C++ of its users.
 *
 *   fvv_encoder_options options = {sizeof options};
 *   fvv_encoder_create_file("clip.fvv", &options, &encoder, &diagnostic)
 *   fvv_encoder_add_camera(encoder, &camera, &diagnostic)    for each camera
 *   fvv_encoder_add_frame(encoder, &frame, &diagnostic)      for each frame
 *   fvv_encoder_finish(encoder, &report, &diagnostic)
 *   fvv_encoder_destroy(encoder)
 *
 * Structs begin with their size, and a field of 0 or NULL has its default: clear a struct, set struct_size
 * and the fields of interest. A size below that of this version's first fields, or above what the library
 * knows with fields other than 0 there, is FVV_ERROR_ARGUMENT. Structs without struct_size are frozen.
 *
 * Ownership: everything that a call is given is copied before it returns and stays the caller's. What a
 * callback is given is valid until it returns. Memory is malloc's and operator new's; a frame is held until
 * its group is written, frames before the first mesh until that is there.
 *
 * Threads: one thread at a time may use an encoder, and callbacks are called on that thread. No callback may
 * use the encoder that calls it, nor leave by longjmp or an exception.
 *
 * Errors: a negative status, and the reason in diagnostic, which may be NULL. After FVV_ERROR_ARGUMENT and
 * FVV_ERROR_INPUT of fvv_encoder_add_camera and fvv_encoder_add_sound nothing has changed, and neither after
 * those of fvv_encoder_add_frame unless the encoder is broken: fvv_encoder_broken returns 1 then. A broken
 * encoder returns FVV_ERROR_STATE, and what it wrote is not a whole stream. */
#ifndef FVV_ENCODER_H
#define FVV_ENCODER_H

#include "fvv/calibration.h"
#include "fvv/types.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct fvv_encoder fvv_encoder;

/* An option of fvvmux by its name without dashes, with its value as a text: {"max-error", "1mm"}. Flags are
 * "on" or "off". The help of fvvmux lists them. */
typedef struct fvv_encoder_option {
  const char *name;
  const char *value;
} fvv_encoder_option;

typedef struct fvv_encoder_options {
  size_t struct_size;
  const char *name;            /* of the scene, UTF-8; NULL: none */
  fvv_rational frame_duration; /* seconds; 0/0: 1/25 */
  uint32_t codec;              /* of pictures, FVV_CODEC_... (fvv/format.h); 0: H.264 */
  uint32_t bit_depth;          /* 8, 10 or, of OpenEXR, 16; 0: the least that the codec has */
  double psnr;                 /* of luma, dB, to be reached by pictures; 0: 42, or lossless with OpenEXR */
  uint64_t bit_rate;           /* bits a second of all pictures, in place of psnr; 0: none */
  double max_error;            /* of meshes, in pixels of the sent pictures; 0: 0.15 */
  uint32_t group;              /* frames in a group, where players can begin; 0: one second */
  uint32_t threads;            /* 0: one for each processor. The bytes are the same for any number */
  uint8_t without_meshes;      /* 1: frames have none */
  uint8_t up;                  /* the axis that points up, FVV_UP_... (fvv/format.h); 0: unknown */
  uint8_t scale_unknown;       /* 1: lengths are in an unknown unit */
  /* The rest, and what a field cannot say. Set in this order after all fields, the last one counts. Options
   * of captures on disk have no effect. */
  const fvv_encoder_option *named;
  size_t named_count;
  /* Each may be NULL. warning: a sentence, UTF-8. progress: frames that are written, of those added; a
   * negative status ends the encoding, and the call that led to it returns that status. */
  void (*warning)(void *user, const char *text);
  fvv_status (*progress)(void *user, uint64_t frames);
  void *user; /* of both */
} fvv_encoder_options;

/* options NULL: all defaults. Output is called by fvv_encoder_add_frame and fvv_encoder_finish; a status
 * other than FVV_OK breaks the encoder, and the call returns that status if it is negative, else
 * FVV_ERROR_IO. On an error *encoder is NULL. */
FVV_API FVV_MUST_USE fvv_status fvv_encoder_create(const fvv_encoder_options *options,
                                                   const fvv_output *output, fvv_encoder **encoder,
                                                   fvv_diagnostic *diagnostic);
/* Writes to path + ".part", which fvv_encoder_finish renames to path; a file of that name is replaced.
 * Without fvv_encoder_finish, or if that fails, ".part" is removed. */
FVV_API FVV_MUST_USE fvv_status fvv_encoder_create_file(const char *path, const fvv_encoder_options *options,
                                                        fvv_encoder **encoder, fvv_diagnostic *diagnostic);
/* Frees everything; NULL is allowed. */
FVV_API void fvv_encoder_destroy(fvv_encoder *encoder);

typedef struct fvv_encoder_camera {
  size_t struct_size;
  const fvv_camera *calibration; /* with an id of its own, and a name or none */
  uint8_t without_pictures;      /* 1: frames have none of it */
  uint8_t has_masks;             /* 1: every picture has a mask: what is above 127 shows the scene */
  uint8_t moves;                 /* 1: every frame has a calibration of it */
  uint8_t has_visibility;        /* 1: frames provide per-vertex visibility; otherwise it is ray cast */
} fvv_encoder_camera;

/* Before the first frame. */
FVV_API FVV_MUST_USE fvv_status fvv_encoder_add_camera(fvv_encoder *encoder, const fvv_encoder_camera *camera,
                                                       fvv_diagnostic *diagnostic);

typedef struct fvv_encoder_sound {
  size_t struct_size;
  const float *samples; /* interleaved, 48000 a second, full scale 1 */
  size_t sample_count;  /* of each channel */
  uint32_t channels;    /* 1 to 8 */
  uint32_t bit_rate;    /* bits a second, as Opus; 0: 64,000 for one channel, 96,000 for two, 48,000 more for
                           each further one */
  double start;         /* of the first sample, seconds after frame 0; may be negative */
  const char *title;    /* UTF-8; NULL: none */
  const char *language; /* BCP 47; NULL: unknown */
  /* x y z in metres of where it is heard from. 0: everywhere, 1: it stays there; else of each frame that will
   * be added. */
  const double *positions;
  size_t position_count;
} fvv_encoder_sound;

/* Before the first frame. Groups take what falls into them. */
FVV_API FVV_MUST_USE fvv_status fvv_encoder_add_sound(fvv_encoder *encoder, const fvv_encoder_sound *sound,
                                                      fvv_diagnostic *diagnostic);

/* Rows from top to bottom, channels interleaved. Frozen. */
typedef struct fvv_encoder_picture {
  const void *pixels; /* NULL: there is none, of a camera without pictures or masks */
  uint32_t width, height;
  uint32_t channels; /* of pictures 3: R G B; of masks 1 */
  uint32_t bits;     /* of a sample: 8; 16, in the machine's byte order; 32: float, linear, 1 for white */
  size_t stride;     /* bytes from row to row; 0: rows follow each other without a gap */
} fvv_encoder_picture;

/* One moment. */
typedef struct fvv_encoder_frame {
  size_t struct_size;
  /* The mesh. Without vertices and faces the stage is empty. */
  const double *positions; /* x y z of each vertex, metres, finite */
  size_t vertex_count;
  const uint32_t *faces; /* three vertices each, counter-clockwise seen from outside */
  size_t face_count;
  const double *texture; /* u v of each vertex, (0, 0) the top left corner; NULL: none */
  const double *normals; /* x y z of each vertex, of any length; NULL: none */
  /* Arrays of camera_count elements in the order of fvv_encoder_add_camera. camera_count is that of all
   * cameras, or 0 if no array is needed. An array that no camera needs may be NULL. */
  size_t camera_count;
  const fvv_encoder_picture *pictures;
  const fvv_encoder_picture *masks;
  const fvv_camera *calibrations;   /* used of cameras that move */
  const uint8_t *const *visibility; /* of each camera, for each vertex: 0 not seen to 255 seen; NULL: none */
} fvv_encoder_frame;

/* The next frame. When it completes a group, the group is encoded and written before the call returns.
 * FVV_ERROR_INPUT: a mesh, picture or calibration that is unusable, such as a coordinate that is NaN or a
 * picture of another size than its camera's. */
FVV_API FVV_MUST_USE fvv_status fvv_encoder_add_frame(fvv_encoder *encoder, const fvv_encoder_frame *frame,
                                                      fvv_diagnostic *diagnostic);

/* Bytes are payloads; the rest of bytes are headers, configuration and index. */
typedef struct fvv_encoder_report {
  size_t struct_size; /* set by the caller; fields beyond it are not written */
  uint64_t frames;
  uint64_t groups;
  uint64_t rungs; /* of the ladder of quality */
  uint64_t bytes; /* of the whole stream */
  uint64_t mesh_bytes;
  uint64_t visibility_bytes;
  uint64_t colour_bytes;
  uint64_t video_bytes;
  uint64_t sound_bytes;
  uint64_t calibration_bytes;
  uint64_t faces;    /* of all frames */
  double step;       /* of the lattice that vertices lie on, metres; 0: no meshes */
  double seconds;    /* from the last camera or sound that was added to the last byte */
  uint32_t warnings; /* that were passed to warning, or would have been */
} fvv_encoder_report;

/* Writes what is left, index and footer. At least one frame was added. report may be NULL. Afterwards only
 * fvv_encoder_destroy is useful. */
FVV_API FVV_MUST_USE fvv_status fvv_encoder_finish(fvv_encoder *encoder, fvv_encoder_report *report,
                                                   fvv_diagnostic *diagnostic);

/* 1 after a failure that left the stream incomplete, else 0. */
FVV_API int fvv_encoder_broken(const fvv_encoder *encoder);

#ifdef __cplusplus
}
#endif
#endif
