/* The caller's allocator and limits, and a growing block of bytes. */
#include "base/memory.h"

#include "base/bytes.h"
#include "base/diagnostic.h"

#include <stdlib.h>
#include <string.h>

static void *malloc_resize(void *user, void *pointer, size_t old_size, size_t new_size) {
  (void)user;
  (void)old_size;
  if (new_size) return realloc(pointer, new_size);
  free(pointer);
  return NULL;
}

fvv_allocator fvv_allocator_or_default(const fvv_allocator *allocator) {
  if (allocator && allocator->resize) return *allocator;
  const fvv_allocator standard = {malloc_resize, NULL};
  return standard;
}

void *fvv_allocate(const fvv_allocator *allocator, size_t size) {
  return size ? allocator->resize(allocator->user, NULL, 0, size) : NULL;
}

void *fvv_allocate_array(const fvv_allocator *allocator, size_t count, size_t size) {
  return size && count > SIZE_MAX / size ? NULL : fvv_allocate(allocator, count * size);
}

void *fvv_allocate_zeroed(const fvv_allocator *allocator, size_t size) {
  void *pointer = fvv_allocate(allocator, size);
  if (pointer) memset(pointer, 0, size);
  return pointer;
}

void fvv_release(const fvv_allocator *allocator, void *pointer, size_t size) {
  if (pointer) allocator->resize(allocator->user, pointer, size, 0);
}

fvv_status fvv_bytes_reserve(fvv_bytes *bytes, size_t extra) {
  if (extra <= bytes->capacity - bytes->size) return FVV_OK;
  if (extra > SIZE_MAX / 2 - bytes->size) return FVV_ERROR_MEMORY;
  size_t capacity = bytes->size + extra;
  if (capacity < bytes->capacity * 2) capacity = bytes->capacity * 2;
  if (capacity < 256) capacity = 256;
  void *data = bytes->allocator.resize(bytes->allocator.user, bytes->data, bytes->capacity, capacity);
  if (!data) return FVV_ERROR_MEMORY;
  bytes->data = data;
  bytes->capacity = capacity;
  return FVV_OK;
}

fvv_status fvv_bytes_append(fvv_bytes *bytes, const void *source, size_t size) {
  const fvv_status status = fvv_bytes_reserve(bytes, size);
  if (status == FVV_OK && size) {
    memcpy(bytes->data + bytes->size, source, size);
    bytes->size += size;
  }
  return status;
}

fvv_status fvv_bytes_append_uleb(fvv_bytes *bytes, uint64_t value) {
  uint8_t coded[10];
  return fvv_bytes_append(bytes, coded, fvv_put_uleb(coded, value));
}

void fvv_bytes_free(fvv_bytes *bytes) {
  if (bytes->allocator.resize) fvv_release(&bytes->allocator, bytes->data, bytes->capacity);
  bytes->data = NULL;
  bytes->size = bytes->capacity = 0;
}

void fvv_limits_default(fvv_limits *limits) {
  memset(limits, 0, sizeof *limits);
  limits->struct_size = sizeof *limits;
  limits->max_payload = UINT64_C(256) << 20;
  limits->max_vertices = 4u << 20;
  limits->max_faces = 8u << 20;
  limits->max_cameras = 1024;
  limits->max_tracks = 256;
  limits->max_dimension = 16384;
  limits->max_groups = 4u << 20;
  limits->max_group_chunks = 1u << 20;
  limits->max_text = 1u << 20;
  limits->max_environment = 1024;
}

fvv_limits fvv_limits_or_default(const fvv_limits *limits) {
  fvv_limits result;
  fvv_limits_default(&result);
  if (limits) {
    const size_t size = limits->struct_size < sizeof result ? limits->struct_size : sizeof result;
    memcpy(&result, limits, size);
    result.struct_size = sizeof result;
  }
  return result;
}

fvv_status fvv_readable_check(uint64_t count, uint64_t most, const char *what, uint32_t chunk_type,
                              fvv_diagnostic *diagnostic) {
  if (count <= most) return FVV_OK;
  return fvv_fail(diagnostic, FVV_ERROR_INPUT, FVV_ISSUE_LIMIT, chunk_type, 0,
                  "%llu %s, readers accept at most %llu", (unsigned long long)count, what,
                  (unsigned long long)most);
}

const char *fvv_version(void) {
  return FVV_LIBRARY_VERSION;
}

static fvv_status read_memory(void *user, uint64_t offset, void *out, size_t size) {
  if (size) memcpy(out, (const uint8_t *)user + offset, size);
  return FVV_OK;
}

fvv_input fvv_input_memory(const void *bytes, size_t size) {
  const fvv_input input = {read_memory, (void *)bytes, size};
  return input;
}
