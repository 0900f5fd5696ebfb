/* fvv/types.h: status codes, diagnostics, allocator, I/O callbacks and limits.
 *
 * Every other public header includes this one. The headers are C99 and C++. The library is tested on Linux;
 * the headers also compile for Windows with MinGW-w64 and with clang (docs/project/abi.md, "Platforms").
 *
 * Option structs (fvv_limits and fvv_..._options) and fvv_mesh_report begin with struct_size, so that later
 * versions can append fields: call the ..._default function of the struct or, where there is none, set
 * struct_size to its sizeof. All other structs are frozen within a SONAME: they neither grow nor change. */
#ifndef FVV_TYPES_H
#define FVV_TYPES_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define FVV_MUST_USE __attribute__((warn_unused_result))
#else
#define FVV_MUST_USE
#endif

/* On Windows a program that links the static library defines FVV_STATIC; the build of the DLL defines
 * FVV_BUILDING_DLL. Elsewhere neither has an effect. */
#if defined(_WIN32)
#if defined(FVV_STATIC)
#define FVV_API
#elif defined(FVV_BUILDING_DLL)
#define FVV_API __declspec(dllexport)
#else
#define FVV_API __declspec(dllimport)
#endif
#elif defined(__GNUC__)
#define FVV_API __attribute__((visibility("default")))
#else
#define FVV_API
#endif

/* What a call returns. Numbers are part of the ABI and never reused.
 * >= 0: nothing is wrong. -1 ... -99: the caller's doing. -100 ... -199: the stream's. -200: ours. */
typedef int32_t fvv_status;
enum {
  FVV_OK = 0,
  FVV_NEED_DATA = 1, /* push more bytes, or call finish */
  FVV_END = 2,       /* nothing further will come */

  FVV_ERROR_ARGUMENT = -1,         /* an argument is outside its documented range */
  FVV_ERROR_MEMORY = -2,           /* the allocator returned NULL */
  FVV_ERROR_BUFFER_TOO_SMALL = -3, /* the caller's buffer; the needed size is reported */
  FVV_ERROR_IO = -4,               /* a callback of the caller reported failure */
  FVV_ERROR_STATE = -5,            /* calls in an order that the documentation forbids */
  FVV_ERROR_INPUT = -6,            /* a mesh, camera or picture handed to an encoder is unusable */

  FVV_ERROR_DAMAGED = -100,     /* a CRC, a continuity counter or a length does not fit the bytes */
  FVV_ERROR_TRUNCATED = -101,   /* the bytes end before the structure does */
  FVV_ERROR_INVALID = -102,     /* intact, but against the specification */
  FVV_ERROR_UNSUPPORTED = -103, /* a later version, an unknown critical chunk, an unknown profile */
  FVV_ERROR_LIMIT = -104,       /* within the specification, beyond this reader's fvv_limits */

  FVV_ERROR_BUG = -200 /* probably a bug in this library: please report */
};

/* Short lower-case English for a status ("damaged"). Static storage, never NULL. */
FVV_API const char *fvv_status_text(fvv_status status);

/* Why a call failed. Caller-owned, plain data. The first error of a call wins. Offsets are absolute in the
 * stream where the callee knows it, else relative to the given payload. */
typedef struct fvv_diagnostic {
  fvv_status status;
  uint32_t issue;      /* n of FVV-n in spec/issues.md; 0: no rule of the specification is concerned */
  uint32_t chunk_type; /* four-character code as stored (little-endian u32); 0: none */
  uint64_t offset;     /* bytes: of the field that is wrong, or of the chunk */
  /* Of the header of the chunk that breaks the rule, or of the place where something is missing: what
   * clause 2.5 calls the place of an issue. */
  uint64_t chunk_offset;
  char message[208]; /* one sentence without file name, offset or issue number; NUL-terminated */
} fvv_diagnostic;

/* Writes "NAME: 0x1a2b: MESH: index 70001 of 65536 vertices [FVV-3012]" into out (always terminated when
 * capacity > 0); parts that are unset are left out. Returns the length that the whole line has. */
FVV_API size_t fvv_diagnostic_format(const fvv_diagnostic *diagnostic, const char *name, char *out,
                                     size_t capacity);

/* Memory. resize(user, NULL, 0, n) allocates, resize(user, p, n, 0) frees and returns NULL, anything else
 * moves. Alignment as malloc's. May be called from the thread that calls fvv only. */
typedef struct fvv_allocator {
  void *(*resize)(void *user, void *pointer, size_t old_size, size_t new_size);
  void *user;
} fvv_allocator;

/* A growing block of bytes, owned by its allocator; zero-initialise before first use. */
typedef struct fvv_bytes {
  uint8_t *data;
  size_t size;
  size_t capacity;
  fvv_allocator allocator;
} fvv_bytes;

FVV_API void fvv_bytes_free(fvv_bytes *bytes);

/* Random-access input. read_at fills exactly size bytes from offset or returns FVV_ERROR_IO; it is never
 * called for bytes at or beyond size. */
typedef struct fvv_input {
  fvv_status (*read_at)(void *user, uint64_t offset, void *out, size_t size);
  void *user;
  uint64_t size; /* bytes in all */
} fvv_input;

/* A block of bytes as input. Borrowed: it has to stay as it is as long as the input is used. Nothing to
 * close. */
FVV_API fvv_input fvv_input_memory(const void *bytes, size_t size);

/* A file as input, read through stdio. Everything else in this library leaves I/O to its callers; a build
 * with FVV_STDIO=OFF does not have these two functions. Files above 2 GiB are read too. Pipes and folders:
 * FVV_ERROR_IO. path: as fopen takes it. On error *input is empty. The input may be copied; close it once,
 * after the handles that read from it. One thread at a time. */
FVV_API FVV_MUST_USE fvv_status fvv_input_file_open(const char *path, fvv_input *input,
                                                    fvv_diagnostic *diagnostic);
FVV_API void fvv_input_file_close(fvv_input *input);

/* Append-only output. write takes all size bytes or returns FVV_ERROR_IO. */
typedef struct fvv_output {
  fvv_status (*write)(void *user, const void *bytes, size_t size);
  void *user;
} fvv_output;

/* A rational number of seconds per tick: 1/25 for 25 Hz, 1001/30000 for 29.97 Hz. Both > 0. */
typedef struct fvv_rational {
  uint32_t numerator;
  uint32_t denominator;
} fvv_rational;

/* What a reader is willing to hold. Every value is > 0; fvv_limits_default gives the documented values.
 * They bound decoded sizes: allocations also never exceed what the bytes present can justify. Encoders and
 * fvv_writer refuse what a reader with the defaults would refuse. */
typedef struct fvv_limits {
  size_t struct_size;
  uint64_t max_payload;   /* bytes of one chunk. 256 MiB: an 8K x 8K half-float EXR fits. An index may always
                             have the bytes that max_groups groups take */
  uint32_t max_vertices;  /* of one mesh. 4 Mi: a hundred times a captured person */
  uint32_t max_faces;     /* of one mesh. 8 Mi: twice the vertices, as in a closed surface */
  uint32_t max_cameras;   /* 1024: the largest published rigs have about 500 */
  uint32_t max_tracks;    /* 256: every camera of a large rig may have one */
  uint32_t max_dimension; /* width or height of a picture or video frame. 16384: a GPU texture */
  uint32_t max_groups;    /* of a file. 4 Mi: 48 days of groups of one second */
  uint32_t max_group_chunks; /* chunks of one group. 1 Mi */
  uint32_t max_text;         /* bytes of a name or metadata. 1 MiB */
  uint32_t max_environment;  /* parts, pictures or lights of an environment. 1024. All parts together stay
                               below  max_vertices and max_faces, all pictures below max_dimension^2 pixels */
} fvv_limits;

FVV_API void fvv_limits_default(fvv_limits *limits);

/* Version of the library as "MAJOR.MINOR.PATCH": that of the CMake project which built it. Static storage.
 * The format's version is in fvv/format.h. */
FVV_API const char *fvv_version(void);

/* CRC-32C (Castagnoli, RFC 3720 B.4). Continue with the previous result, start with 0. */
FVV_API uint32_t fvv_crc32c(uint32_t crc, const void *bytes, size_t size);

#ifdef __cplusplus
}
#endif
#endif
