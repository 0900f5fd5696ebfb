/* fvv/stream.h: a file or stream as frames. Spec: spec/fvv.md. The one place that ties tracks together:
 *   fvv_configuration  the tracks, cameras, video layouts and metadata of one configuration block;
 *   fvv_stream         random access to groups and chunks, and to meshes and video samples by frame number;
 *   fvv_checker        push bytes, learn everything that is wrong, and which frames are whole.
 * Handles are not thread-safe; separate handles are independent. */
#ifndef FVV_STREAM_H
#define FVV_STREAM_H

#include "fvv/audio.h"
#include "fvv/calibration.h"
#include "fvv/colours.h"
#include "fvv/container.h"
#include "fvv/data.h"
#include "fvv/environment.h"
#include "fvv/mesh.h"
#include "fvv/video.h"
#include "fvv/visibility.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- configuration -------------------------------------------------------------------------------- */

/* A video track with what its frames show. tiles: tile_count > 0 exactly with FVV_SHOWS_TILES; they hold for
 * groups that have no layout of their own: use fvv_stream_tiles. */
typedef struct fvv_video_layout {
  uint16_t track;
  fvv_video_config config;
  const fvv_tile *tiles;
  size_t tile_count;
} fvv_video_layout;

typedef struct fvv_audio_layout {
  uint16_t track;
  fvv_audio_config config;
} fvv_audio_layout;

typedef struct fvv_data_layout {
  uint16_t track;
  fvv_data_config config;
} fvv_data_layout;

typedef struct fvv_text {
  const char *text; /* UTF-8, not terminated */
  size_t size;
} fvv_text;

/* All pointers belong to the configuration and are valid as long as it is. */
typedef struct fvv_configuration {
  fvv_scene scene;
  const fvv_track *tracks;
  size_t track_count;
  const fvv_camera *cameras;
  size_t camera_count;
  const fvv_video_layout *videos;
  size_t video_count;
  const fvv_audio_layout *sounds; /* the audio tracks */
  size_t sound_count;
  const fvv_text *metadata; /* JSON texts, clause 5.3; checked to be UTF-8 only */
  size_t metadata_count;
  fvv_texturing texturing; /* defaults where the block has none */
  int has_texturing;
  const fvv_data_layout *datas; /* the data tracks */
  size_t data_count;
} fvv_configuration;

/* NULL when there is none. */
FVV_API const fvv_track *fvv_configuration_track(const fvv_configuration *configuration, uint16_t id);
/* Whether a chunk of this type and track makes its time a frame (clause 11). configuration may be NULL: it is
 * not known. */
FVV_API int fvv_configuration_makes_frame(const fvv_configuration *configuration, uint32_t type,
                                          uint16_t track);
FVV_API const fvv_camera *fvv_configuration_camera(const fvv_configuration *configuration, uint16_t id);
FVV_API const fvv_video_layout *fvv_configuration_video(const fvv_configuration *configuration,
                                                        uint16_t track);
FVV_API const fvv_audio_config *fvv_configuration_audio(const fvv_configuration *configuration,
                                                        uint16_t track);
FVV_API const fvv_data_config *fvv_configuration_data(const fvv_configuration *configuration, uint16_t track);

/* ---- random access -------------------------------------------------------------------------------- */

typedef struct fvv_stream fvv_stream;

/* input is copied. limits NULL: default; allocator NULL: malloc. Fails when not even the file header is good;
 * a file whose index is missing or damaged opens as FVV_INDEX_REBUILT. Of a file with an index nothing else
 * is read until something requests it. */
FVV_API FVV_MUST_USE fvv_status fvv_stream_open(const fvv_input *input, const fvv_limits *limits,
                                                const fvv_allocator *allocator, fvv_stream **stream,
                                                fvv_diagnostic *diagnostic);
FVV_API void fvv_stream_close(fvv_stream *stream);

/* ---- groups and chunks ---------------------------------------------------------------------------- */

FVV_API fvv_index_state fvv_stream_index_state(const fvv_stream *stream);
/* Damage found while rebuilding the index or later, in tables of groups and in configuration blocks that a
 * repetition replaces. Valid until the next call on this handle. */
FVV_API size_t fvv_stream_damage_count(const fvv_stream *stream);
FVV_API const fvv_diagnostic *fvv_stream_damage(const fvv_stream *stream, size_t i);
FVV_API size_t fvv_stream_group_count(const fvv_stream *stream);
/* NULL: there is no such group. Valid until close. */
FVV_API const fvv_group_info *fvv_stream_group(const fvv_stream *stream, size_t i);
/* The chunks of a group, GRUP and GEND left out; valid until close. Loads the group's table on first use. */
FVV_API FVV_MUST_USE fvv_status fvv_stream_group_chunks(fvv_stream *stream, size_t group,
                                                        const fvv_chunk_info **chunks, size_t *count,
                                                        fvv_diagnostic *diagnostic);
/* The chunks of the configuration block that holds for a group: of the block that the index names or, when
 * that is damaged, of a repetition with the same digest. FVV_ERROR_DAMAGED: none is left. Valid until close.
 * fvv_stream_configuration decodes them. */
FVV_API FVV_MUST_USE fvv_status fvv_stream_configuration_chunks(fvv_stream *stream, size_t group,
                                                                const fvv_chunk_info **chunks, size_t *count,
                                                                fvv_diagnostic *diagnostic);
/* Reads one chunk, checks header, payload CRC and padding, and compares it with info. The payload lives in a
 * buffer of the handle: valid until the next call on this handle. */
FVV_API FVV_MUST_USE fvv_status fvv_stream_read_chunk(fvv_stream *stream, const fvv_chunk_info *info,
                                                      const uint8_t **payload, fvv_diagnostic *diagnostic);

/* ---- frames --------------------------------------------------------------------------------------- */

typedef struct fvv_frame {
  int64_t time; /* ticks */
  size_t group; /* for fvv_stream_group */
} fvv_frame;

/* Frames are the times at which a group has a MESH or a VPKT (clause 11), numbered from 0 in order of time.
 */
FVV_API size_t fvv_stream_frame_count(const fvv_stream *stream);
FVV_API FVV_MUST_USE fvv_status fvv_stream_frame(fvv_stream *stream, size_t frame, fvv_frame *out,
                                                 fvv_diagnostic *diagnostic);
/* The configuration that holds for a group. Valid until the next call with a group whose configuration is
 * elsewhere, or close. */
FVV_API FVV_MUST_USE fvv_status fvv_stream_configuration(fvv_stream *stream, size_t group,
                                                         const fvv_configuration **configuration,
                                                         fvv_diagnostic *diagnostic);
/* The tiles of a video track in a group: those of the group's TILE, else the configuration's. FVV_END: the
 * track shows no tiles, or is not a video track. Errors are returned in place of a guess, also where a
 * damaged group may have lost its layout. Belongs to the stream; valid until the next call with another
 * group, or close. */
FVV_API FVV_MUST_USE fvv_status fvv_stream_tiles(fvv_stream *stream, size_t group, uint16_t track,
                                                 const fvv_tile **tiles, size_t *count,
                                                 fvv_diagnostic *diagnostic);
/* Decodes the mesh of a frame on one track. FVV_END: the frame has none there (*mesh is empty). The caller
 * frees it with fvv_mesh_free. A delta frame is decoded from the key mesh before it on; the stream keeps
 * the position of each track, so that frames in order cost one step each, and going back costs those since
 * the key. When a frame on the way is damaged, its error is returned. */
FVV_API FVV_MUST_USE fvv_status fvv_stream_mesh(fvv_stream *stream, size_t frame, uint16_t track,
                                                fvv_mesh *mesh, fvv_diagnostic *diagnostic);
/* A camera as it is in a frame, one that moves by the calibration of the frame. FVV_END: it moves and is not
 * calibrated in this frame; no colours may be taken from its picture (clause 9.6). FVV_ERROR_ARGUMENT: the
 * configuration does not describe it. Like delta frames of meshes, calibrations are followed from their key
 * on. The name belongs to the configuration. */
FVV_API FVV_MUST_USE fvv_status fvv_stream_camera(fvv_stream *stream, size_t frame, uint16_t id,
                                                  fvv_camera *camera, fvv_diagnostic *diagnostic);

/* What the cameras of one visibility chunk see. */
typedef struct fvv_visibility {
  fvv_visibility_header header;
  uint16_t *cameras; /* header.camera_count identifiers, rising */
  uint8_t *states;   /* FVV_VERTEX_...: a row of header.vertex_count for each camera */
} fvv_visibility;

/* The visibility of a frame on one track, decoded with the mesh that it belongs to and, of cameras that move,
 * the calibration of the frame (a camera without calibration has no visibility, FVV-6003). FVV_END: none.
 * Belongs to the stream, valid until the next call on it. Frames in order cost one step each; others those
 * since the key chunk. fvv_visibility_peek and fvv_visibility_decode decode single cameras. */
FVV_API FVV_MUST_USE fvv_status fvv_stream_visibility(fvv_stream *stream, size_t frame, uint16_t track,
                                                      const fvv_visibility **visibility,
                                                      fvv_diagnostic *diagnostic);

/* The colours of the mesh of a frame on one mesh track (clause 19): R, G, B of each vertex in decoded order,
 * display values, 3 * *vertex_count bytes. Delta frames have those of their key mesh; patched ones those of
 * their patch after them, unseen of the configuration's texturing where the stream has none. FVV_END: the
 * frame has no mesh there, or its key mesh has no colours. Belongs to the stream, valid until the next call
 * of this function for the same track or close. Frames with one key mesh cost one decoding, in any order,
 * and one of each patch. */
FVV_API FVV_MUST_USE fvv_status fvv_stream_colours(fvv_stream *stream, size_t frame, uint16_t mesh_track,
                                                   const uint8_t **colours, uint32_t *vertex_count,
                                                   fvv_diagnostic *diagnostic);

/* The video sample of a frame on one track, checked by fvv_video_sample_check. FVV_END: none. Valid until the
 * next call on this stream. key: non-zero when it decodes alone; decoding starts at the first sample of its
 * group. */
FVV_API FVV_MUST_USE fvv_status fvv_stream_sample(fvv_stream *stream, size_t frame, uint16_t track,
                                                  const uint8_t **sample, size_t *size, int *key,
                                                  fvv_diagnostic *diagnostic);

/* The environment that belongs to a group on one environment track: from the group itself, or from where
 * clause 18.5 says that a writer puts it; for that, the tables of at most three groups are read. FVV_END:
 * none. Belongs to the stream, valid until the next call of this function or close; fvv_environment_mesh
 * decodes its parts. */
FVV_API FVV_MUST_USE fvv_status fvv_stream_environment(fvv_stream *stream, size_t group, uint16_t track,
                                                       const fvv_environment **environment,
                                                       fvv_diagnostic *diagnostic);

/* ---- checking ------------------------------------------------------------------------------------- */

typedef struct fvv_checker fvv_checker;

typedef struct fvv_check_options {
  size_t struct_size;
  int decode; /* non-zero: decode every mesh, visibility, colours and environment, check every video sample,
                 not only structure */
  /* Called for every event of the reader, in order, before it is judged; may be NULL. */
  void (*event)(void *user, const fvv_event *event);
  void *user;
} fvv_check_options;

FVV_API void fvv_check_options_default(fvv_check_options *options);

/* What one track of the stream holds. Sizes in bytes of payload; vertices and faces from the declared counts.
 * TILE chunks of groups count in layouts and bytes, and in nothing else. */
typedef struct fvv_track_summary {
  uint16_t track;
  uint8_t kind;
  uint64_t chunks, key_chunks, bytes, smallest, largest;
  uint32_t min_vertices, max_vertices, min_faces, max_faces; /* mesh tracks */
  uint64_t vertices, faces;                                  /* mesh tracks: sums */
  uint64_t textured;                                         /* mesh chunks with texture coordinates */
  uint8_t min_texture_bits, max_texture_bits;                /* of these; 0 when there is none */
  uint64_t with_normals;                                     /* mesh chunks with normals */
  uint8_t min_normal_bits, max_normal_bits;                  /* of these; 0 when there is none */
  uint64_t profile_chunks[FVV_MESH_PROFILE_COUNT];           /* mesh chunks of each profile */
  uint64_t profile_bytes[FVV_MESH_PROFILE_COUNT];            /* and bytes of payload */
  uint64_t layouts;                                          /* video tracks: valid TILE chunks in groups */
  uint64_t least_tile_pixels, most_tile_pixels;              /* of these: pixels of the frame in tiles */
  uint64_t calibrations, lost_calibrations; /* calibration chunks: declared entries, and cameras that move and
                                               have none in a chunk */
  uint32_t parts, pictures, lights;  /* environment tracks: of the last chunk; vertices and faces too */
  uint64_t pairs;                    /* visibility tracks: of a vertex and a camera, all chunks together */
  uint32_t min_cameras, max_cameras; /* visibility tracks: cameras of a chunk */
  uint64_t cells;                    /* colour tracks: occupied cells, all chunks together */
  uint32_t min_cell_size, max_cell_size; /* colour tracks: side of a cell in lattice steps */
  uint64_t packets;                      /* audio tracks: of all chunks, without those that repeat others */
} fvv_track_summary;

/* A run of frames that are whole: every chunk arrived, none damaged, and (with decode) every mesh decodes. */
typedef struct fvv_frame_run {
  uint64_t first; /* number of the first, counted over all frames seen */
  uint64_t count;
  int64_t first_time, last_time; /* ticks */
} fvv_frame_run;

typedef struct fvv_check_summary {
  uint64_t bytes; /* pushed */
  uint64_t chunks, groups, frames, whole_frames;
  uint64_t payload_bytes; /* of chunks of tracks */
  uint64_t problems;      /* all, also those that are not kept */
  /* Ticks: from the first group's start to the last one's end, or to that of the last frame in a group that
   * is cut. Equal when no frame is there. */
  int64_t start, end;
  uint16_t written_major, written_minor; /* format version of the writer; 0.0 when its header is damaged */
  uint64_t configurations;               /* blocks, repetitions counted */
  int has_footer;                        /* the stream has its footer: it is complete */
  int truncated;                         /* the bytes end inside a chunk or a group, or no footer came */
} fvv_check_summary;

FVV_API FVV_MUST_USE fvv_status fvv_checker_create(const fvv_check_options *options, const fvv_limits *limits,
                                                   const fvv_allocator *allocator, fvv_checker **checker);
FVV_API void fvv_checker_destroy(fvv_checker *checker);
/* FVV_OK, or the final error after which further bytes are ignored; it is a problem as well. Once the
 * summary has_footer, further bytes are one problem and are only counted: bytes may be NULL. */
FVV_API fvv_status fvv_checker_push(fvv_checker *checker, const void *bytes, size_t size);
/* No more bytes will come. FVV_NEED_DATA: groups counted as lost because their configuration block is damaged
 * or lost, and an intact repetition of it came later. A caller that can push the same bytes again, from the
 * first on: the checker remembers the repetition, counts from the beginning and gives these groups as well.
 * Without that, what it found so far holds. */
FVV_API fvv_status fvv_checker_finish(fvv_checker *checker);
/* The first 1000 problems in order of the stream; summary.problems counts all. Valid until destroy. */
FVV_API size_t fvv_checker_problem_count(const fvv_checker *checker);
FVV_API const fvv_diagnostic *fvv_checker_problem(const fvv_checker *checker, size_t i);
/* All of the following are valid until the next push, finish or destroy. */
FVV_API const fvv_check_summary *fvv_checker_summary(const fvv_checker *checker);
FVV_API size_t fvv_checker_track_count(const fvv_checker *checker);
FVV_API const fvv_track_summary *fvv_checker_track(const fvv_checker *checker, size_t i);
FVV_API size_t fvv_checker_run_count(const fvv_checker *checker);
FVV_API const fvv_frame_run *fvv_checker_run(const fvv_checker *checker, size_t i);
/* The last complete configuration, NULL before the first. */
FVV_API const fvv_configuration *fvv_checker_configuration(const fvv_checker *checker);

#ifdef __cplusplus
}
#endif
#endif
