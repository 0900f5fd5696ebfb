/* fvv/mesh.h: triangle meshes on the stream's lattice. Spec: spec/fvv.md clause 8.
 *
 * Order of work: canonicalise the source mesh, quantise it, encode, decode what was encoded. What the decoder
 * yields is canonical: visibility and deltas index the decoded vertices and faces, never the source's. */
#ifndef FVV_MESH_H
#define FVV_MESH_H

#include "fvv/format.h"
#include "fvv/types.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A source mesh, borrowed. positions: vertex_count x 3 doubles, metres, x y z. faces: face_count x 3 vertex
 * indices, counter-clockwise seen from outside. texture: vertex_count x 2 doubles, u v on the axes of clause
 * 8.6 ((0, 0) is the top left corner of the atlas picture, (1, 1) its bottom right one, v points down), or
 * NULL. A vertex has one pair: where charts meet, the source has one vertex for each of them. normals:
 * vertex_count x 3 doubles of any length but 0, or NULL; where the surface has a hard edge, one vertex for
 * each side. */
typedef struct fvv_mesh_source {
  const double *positions;
  const uint32_t *faces;
  size_t vertex_count;
  size_t face_count;
  const double *texture;
  const double *normals;
} fvv_mesh_source;

/* A mesh on the lattice, owned by the struct's allocator; free with fvv_mesh_free. lattice: vertex_count
 * x 3 lattice indices, each within +-FVV_LATTICE_MAX. faces: face_count x 3, each < vertex_count. texture:
 * vertex_count x 2 texture indices u v, each 0 to 2^texture_bits inclusive, texture_bits 1 to
 * FVV_TEXTURE_BITS_MAX; NULL and 0 when the mesh has none. normals: vertex_count x 2 normal indices
 * (clause 8.13), each 0 to 2^normal_bits - 2, normal_bits 2 to FVV_NORMAL_BITS_MAX; NULL and 0 when they are
 * to be computed (fvv_mesh_normals). */
typedef struct fvv_mesh {
  int32_t *lattice;
  uint32_t *faces;
  uint32_t vertex_count;
  uint32_t face_count;
  uint32_t *texture;
  uint8_t texture_bits;
  uint32_t *normals;
  uint8_t normal_bits;
  fvv_allocator allocator;
} fvv_mesh;

FVV_API void fvv_mesh_free(fvv_mesh *mesh);

/* lattice index -> metres: origin + step * index, the product rounded to double before the sum (clause 8.2).
 */
FVV_API void fvv_lattice_to_metres(const double origin[3], double step, const int32_t index[3],
                                   double metres[3]);
/* The way back for count vertices: the nearest index, ties to the even one. metres, indices: count x 3.
 * FVV_ERROR_INPUT names the first vertex that is not finite or lies outside the lattice. */
FVV_API FVV_MUST_USE fvv_status fvv_lattice_from_metres(const double origin[3], double step,
                                                        const double *metres, size_t count, int32_t *indices,
                                                        fvv_diagnostic *diagnostic);
/* lattice index -> metres for count vertices, rounded to float at the end. metres: count x 3 floats. */
FVV_API void fvv_lattice_to_floats(const double origin[3], double step, const int32_t *indices, size_t count,
                                   float *metres);

/* texture indices -> u v for count vertices: index * 2^-bits, exact (clause 8.6). bits: 1 to
 * FVV_TEXTURE_BITS_MAX. indices, uv: count x 2. */
FVV_API void fvv_texture_to_floats(uint8_t bits, const uint32_t *indices, size_t count, float *uv);

/* normal indices -> unit vectors for count vertices (clause 8.13). bits: 2 to FVV_NORMAL_BITS_MAX. indices:
 * count x 2, normals: count x 3. */
FVV_API void fvv_normals_to_floats(uint8_t bits, const uint32_t *indices, size_t count, float *normals);

/* The normal of each vertex: the sent one when the mesh has them, otherwise computed from the faces around
 * it, each weighted with its area (clause 8.12); then vertices on one lattice point count as one, so that
 * seams of the atlas don't show. normals: vertex_count x 3 floats, unit length; zero where areas cancel. The
 * same bits on every machine. 0.33 ms for 17,500 vertices; 44 bytes of scratch memory a vertex. allocator
 * NULL: malloc. FVV_ERROR_INPUT: the mesh breaks a rule of clause 8.3. */
FVV_API FVV_MUST_USE fvv_status fvv_mesh_normals(const fvv_mesh *mesh, const fvv_allocator *allocator,
                                                 float *normals, fvv_diagnostic *diagnostic);

/* What the canonicaliser changed. All zero: the mesh went through as it was. A component is a set of faces
 * that are joined over shared edges. Whatever is said of faces, edges and components is judged by lattice
 * points alone: a seam of the atlas or a hard edge, where vertices differ in texture coordinates or normals
 * only, is no boundary.
 */
typedef struct fvv_mesh_report {
  size_t struct_size;             /* the caller sets it before the call */
  uint32_t welded_vertices;       /* same lattice point, texture and normal indices as an earlier vertex */
  uint32_t degenerate_faces;      /* two corners on one lattice point, or zero area on the lattice */
  uint32_t duplicate_faces;       /* same three lattice points as an earlier face, either winding */
  uint32_t unreferenced_vertices; /* used by no face that is left */
  uint32_t flipped_faces;         /* winding turned so that neighbours agree */
  uint32_t nonmanifold_edges;     /* shared by more than two faces: reported, left as they are */
  uint32_t boundary_edges;        /* used by one face: reported, left as they are */
  uint32_t dropped_components;    /* specks below min_component_faces */
  uint32_t dropped_component_faces;
  double max_error; /* metres: largest distance source vertex -> its lattice point, per axis */
  uint32_t
      seam_vertices; /* on the lattice point of an earlier vertex, kept: other texture or normal indices */
  uint32_t clamped_vertices; /* texture coordinates outside 0 to 1 by no more than the tolerance */
} fvv_mesh_report;

typedef struct fvv_mesh_options {
  size_t struct_size;
  double lattice_origin[3];
  double lattice_step;          /* metres, > 0 */
  uint32_t min_component_faces; /* drop components with fewer faces; 0: keep all */
  int keep_winding;             /* non-zero: do not turn faces */
  /* Bits of a texture index, 1 to FVV_TEXTURE_BITS_MAX; 0 leaves texture coordinates out. Has no effect on a
   * source without them. Default 12: off by a quarter of a texel at most in an atlas 2,048 pixels wide, half
   * a texel at 4,096. Each bit more costs about one bit for u and one for v of each vertex. */
  uint32_t texture_bits;
  /* Bits of a normal index, 2 to FVV_NORMAL_BITS_MAX; 0, the default, leaves normals out. Has no effect on a
   * source without them. With 8 bits normals are off by 0.3 degrees on average, 0.95 at worst. */
  uint32_t normal_bits;
} fvv_mesh_options;

/* How far outside 0 to 1 a texture coordinate may lie, 2^-16: what single precision and texts of six decimals
 * leave, less than a texel of any atlas. Repeating coordinates are not supported. */
#define FVV_TEXTURE_TOLERANCE (1.0 / 65536)

FVV_API void fvv_mesh_options_default(fvv_mesh_options *options);

/* Quantises and canonicalises: source -> mesh on the lattice. Refuses NaN, infinities, coordinates outside
 * the lattice, texture coordinates more than FVV_TEXTURE_TOLERANCE outside 0 to 1 (nearer ones are clamped),
 * normals that are zero or not finite, indices out of range (FVV_ERROR_INPUT; the message names vertex or
 * face). An empty result is an error too ("no face is left"). Same input, same output, on every machine.
 * report may be NULL; it is filled on failure too, as far as the work went. */
FVV_API FVV_MUST_USE fvv_status fvv_mesh_canonicalise(const fvv_mesh_source *source,
                                                      const fvv_mesh_options *options,
                                                      const fvv_allocator *allocator, fvv_mesh *mesh,
                                                      fvv_mesh_report *report, fvv_diagnostic *diagnostic);

/* The same for a run of frames that share faces and texture coordinates: source is the first of them,
 * later[i] the lattice indices of frame i + 1 (fvv_lattice_from_metres), source->vertex_count x 3. What is
 * done holds for the whole run: vertices are welded that have the same point in every frame, faces are
 * dropped that have no area in any, or the same points as another in all. So nothing that comes apart later
 * is lost, and the mesh, which has the positions of the first frame, may have vertices on one point and faces
 * without area. vertices: for each source vertex the vertex of the mesh that represents it, UINT32_MAX where
 * none does; source->vertex_count entries, filled on success. NULL: not wanted. later may be NULL when
 * later_count is 0. The report counts once for the run; its max_error is that of the first frame. */
FVV_API FVV_MUST_USE fvv_status fvv_mesh_canonicalise_run(const fvv_mesh_source *source,
                                                          const int32_t *const *later, size_t later_count,
                                                          const fvv_mesh_options *options,
                                                          const fvv_allocator *allocator, fvv_mesh *mesh,
                                                          uint32_t *vertices, fvv_mesh_report *report,
                                                          fvv_diagnostic *diagnostic);

/* MESH payload of profile FVV_MESH_RAW, FVV_MESH_DRACO or FVV_MESH_FAST (clause 8.3, 8.4, 8.11), with texture
 * coordinates and normals when the mesh has them; replaces what payload holds. level: 0 (fastest) to 10
 * (smallest) for Draco, ignored for others. Deterministic. The decoded mesh may have another order of
 * vertices and faces than the given one, and more vertices where the surface is no manifold: decode to learn
 * it. The encoder has decoded its output and found the same triangles, texture coordinates and normals
 * included. Draco and meshoptimizer take their memory from operator new, not from the allocator. The first
 * fast mesh sets the versions that meshoptimizer writes in this process: vertex codec 0, index codec 1. */
FVV_API FVV_MUST_USE fvv_status fvv_mesh_encode(const fvv_mesh *mesh, uint8_t profile, int level,
                                                const fvv_allocator *allocator, fvv_bytes *payload,
                                                fvv_diagnostic *diagnostic);

/* The same, with what its decoders get (decoded, free with fvv_mesh_free; empty on error) and, for each of
 * its vertices, which one of mesh it is. Several decoded vertices may be one: Draco splits vertices where the
 * surface is no manifold. Vertices at one point are distinguished. vertices: room for
 * 3 * mesh->face_count entries, of which the first decoded->vertex_count are filled. Encodes twice. */
FVV_API FVV_MUST_USE fvv_status fvv_mesh_encode_mapped(const fvv_mesh *mesh, uint8_t profile, int level,
                                                       const fvv_allocator *allocator, fvv_bytes *payload,
                                                       fvv_mesh *decoded, uint32_t *vertices,
                                                       fvv_diagnostic *diagnostic);

/* "raw", "draco", "delta" and so on, the names of clause 8.3; NULL for a profile that has none. */
FVV_API const char *fvv_mesh_profile_name(uint8_t profile);
enum { FVV_MESH_PROFILE_COUNT = 6 };

/* What a MESH payload declares, read without decoding. */
typedef struct fvv_mesh_header {
  uint8_t profile; /* FVV_MESH_... */
  uint32_t vertex_count;
  uint32_t face_count;
  size_t data_size;     /* bytes after the header */
  uint8_t texture_bits; /* of a texture index; 0: no texture coordinates */
  uint8_t normal_bits;  /* of a normal index; 0: no normals */
} fvv_mesh_header;

FVV_API FVV_MUST_USE fvv_status fvv_mesh_peek(const uint8_t *payload, size_t size, const fvv_limits *limits,
                                              fvv_mesh_header *header, fvv_diagnostic *diagnostic);

/* Decodes a key MESH payload. Safe for hostile bytes: counts are checked against limits and against the bytes
 * before anything is allocated. limits, allocator NULL: defaults. On error *mesh is empty. */
FVV_API FVV_MUST_USE fvv_status fvv_mesh_decode(const uint8_t *payload, size_t size, const fvv_limits *limits,
                                                const fvv_allocator *allocator, fvv_mesh *mesh,
                                                fvv_diagnostic *diagnostic);

/* ---- delta and patched frames: clauses 8.7 to 8.9, 8.14 ---------------------------------------------- */

/* A key mesh and the frames after it, which move its vertices; patched ones also replace some of its faces,
 * for themselves and all frames that follow. Encoder and decoder hold the same state, bit for bit: what is
 * encoded is what will be decoded, and each frame is predicted from the one before as it was decoded. The
 * vertices form levels, coarse to fine; the motion of each level is predicted from that of the levels before.
 * Handles are not thread-safe; separate ones are independent. */
typedef struct fvv_mesh_sequence fvv_mesh_sequence;

/* key: the decoded key mesh (fvv_mesh_decode), never the one handed to the encoder; it is copied. Close with
 * fvv_mesh_sequence_close. Some 140 bytes a vertex, 56 more with normals; twice that and some while a
 * patched frame is decoded. allocator NULL: malloc. On error
 * *sequence is NULL. */
FVV_API FVV_MUST_USE fvv_status fvv_mesh_sequence_open(const fvv_mesh *key, const fvv_allocator *allocator,
                                                       fvv_mesh_sequence **sequence,
                                                       fvv_diagnostic *diagnostic);
FVV_API void fvv_mesh_sequence_close(fvv_mesh_sequence *sequence);

/* The current frame, the key mesh at first. Belongs to the sequence; valid until the next encode or decode.
 * In a delta frame only lattice and, when the mesh has them, normals differ from the frame before (sent
 * normals turn with the faces, clause 8.13). A patched frame (clause 8.14) has those vertices of the frame
 * before that a remaining face uses, then those of its patch; and the faces that remain, then those of the
 * patch. */
FVV_API const fvv_mesh *fvv_mesh_sequence_mesh(const fvv_mesh_sequence *sequence);

/* The patch of the current frame, with vertices numbered from 0; NULL: it has none. In the mesh of the frame
 * they come after those that are kept. Belongs to the sequence, valid until the next encode or decode. */
FVV_API const fvv_mesh *fvv_mesh_sequence_patch(const fvv_mesh_sequence *sequence);

/* What a patched frame keeps: vertex i of the current frame, for i below *count, is vertex kept[i] of the
 * frame before, rising; what callers know of it goes with it. NULL: the frame is not patched and has all
 * *count vertices of the frame before. Belongs to the sequence, valid as above. */
FVV_API const uint32_t *fvv_mesh_sequence_kept(const fvv_mesh_sequence *sequence, uint32_t *count);

/* Decodes the next frame, of profile FVV_MESH_DELTA or FVV_MESH_PATCHED. Safe for hostile bytes; the counts
 * of a patch are bounded by its bytes, and by limits that the caller has applied with fvv_mesh_peek. After
 * an error in the stream every further decode returns FVV_ERROR_STATE, because what follows depends on this
 * frame: continue at the next key mesh. */
FVV_API FVV_MUST_USE fvv_status fvv_mesh_sequence_decode(fvv_mesh_sequence *sequence, const uint8_t *payload,
                                                         size_t size, fvv_diagnostic *diagnostic);

typedef struct fvv_mesh_delta_options {
  size_t struct_size;
  /* How far a decoded position may lie from the requested one, on each axis, in steps of the lattice, up to
   * 32767; 0: not at all. Default 1. A lattice finer than the error that is wanted codes best: with a step of
   * 0.4 mm and an error of 2, 1 mm from the source at most, frames take about half the bytes of a step of 2
   * mm and an error of 0, as the rounding of the former frame is not passed on as motion. At the edge of the
   * lattice it may be twice as far. */
  uint32_t max_error;
} fvv_mesh_delta_options;

FVV_API void fvv_mesh_delta_options_default(fvv_mesh_delta_options *options);

/* MESH payload of profile FVV_MESH_DELTA for the next frame; replaces what payload holds. lattice: for each
 * vertex of the current mesh, in its order, x 3, within the lattice. options NULL: defaults. Afterwards
 * fvv_mesh_sequence_mesh is what decoders get. Deterministic. On error the sequence is as it was, but for
 * FVV_ERROR_MEMORY: then it can only be closed. */
FVV_API FVV_MUST_USE fvv_status fvv_mesh_sequence_encode(fvv_mesh_sequence *sequence, const int32_t *lattice,
                                                         const fvv_mesh_delta_options *options,
                                                         fvv_bytes *payload, fvv_diagnostic *diagnostic);

/* What a patched frame has in place of some faces of the mesh before. */
typedef struct fvv_mesh_patch {
  size_t struct_size; /* sizeof(fvv_mesh_patch) */
  /* For each face of the mesh before whether it is left out from this frame on, 0 or 1; NULL: none. */
  const uint8_t *absent;
  /* In their place; NULL: nothing. texture_bits and normal_bits are those of the mesh before. */
  const fvv_mesh *mesh;
  /* For each vertex of mesh the vertex of the mesh before on whose point it lies, UINT32_MAX: on none. It is
   * sent at the point that that vertex has in this frame as decoded, so that no gap opens within max_error;
   * if no remaining face uses it, at that of another on its seam that one uses, or where mesh has it. NULL:
   * all are sent where mesh has them. */
  const uint32_t *border;
  uint8_t profile; /* of the patch: FVV_MESH_RAW, FVV_MESH_DRACO or FVV_MESH_FAST */
  int level;       /* for Draco, as in fvv_mesh_encode */
  /* Receives for each vertex of fvv_mesh_sequence_patch which one of mesh it is, as fvv_mesh_encode_mapped
   * has it: room for 3 * mesh->face_count entries. NULL: not wanted. */
  uint32_t *vertices;
} fvv_mesh_patch;

/* MESH payload of profile FVV_MESH_PATCHED for the next frame; replaces what payload holds. As
 * fvv_mesh_sequence_encode for the vertices of the mesh before; where those go that no remaining face uses
 * does not matter and costs nothing. The encoder has decoded its output; vertices and faces of the patch may
 * have another order (fvv_mesh_sequence_patch). Frames that follow move the mesh that is then the current
 * one. When the arguments are wrong the sequence is as it was; after other errors it
 * can only be closed, and each further call returns FVV_ERROR_STATE. */
FVV_API FVV_MUST_USE fvv_status fvv_mesh_sequence_encode_patched(
    fvv_mesh_sequence *sequence, const int32_t *lattice, const fvv_mesh_delta_options *options,
    const fvv_mesh_patch *patch, fvv_bytes *payload, fvv_diagnostic *diagnostic);

#ifdef __cplusplus
}
#endif
#endif
