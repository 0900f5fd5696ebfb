/* The one place of libfvv that does I/O: a file as fvv_input, through stdio. A build for a platform without
 * files leaves this folder out (FVV_STDIO=OFF), as the browser's does. */
#if !defined(_WIN32)
#define _POSIX_C_SOURCE 200809L
#define _FILE_OFFSET_BITS 64
#endif

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "base/diagnostic.h"

#if defined(_WIN32)
#define SEEK_FILE _fseeki64
#define TELL_FILE _ftelli64
typedef long long file_offset;
#else
#define SEEK_FILE fseeko
#define TELL_FILE ftello
typedef off_t file_offset;
#endif

static fvv_status read_at(void *user, uint64_t offset, void *out, size_t size) {
  FILE *file = (FILE *)user;
  if (SEEK_FILE(file, (file_offset)offset, SEEK_SET) != 0) return FVV_ERROR_IO;
  return fread(out, 1, size, file) == size ? FVV_OK : FVV_ERROR_IO;
}

fvv_status fvv_input_file_open(const char *path, fvv_input *input, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  memset(input, 0, sizeof *input);
  if (!path) return fvv_fail(diagnostic, FVV_ERROR_ARGUMENT, 0, 0, 0, "no path is given");
  FILE *file = fopen(path, "rb");
  if (!file) return fvv_fail(diagnostic, FVV_ERROR_IO, 0, 0, 0, "cannot be opened: %s", strerror(errno));
  file_offset size = SEEK_FILE(file, 0, SEEK_END) == 0 ? TELL_FILE(file) : -1;
  /* A folder can be opened, and has a size, but cannot be read. */
  if (size > 0 && (SEEK_FILE(file, 0, SEEK_SET) != 0 || fgetc(file) == EOF)) size = -1;
  if (size < 0) {
    const int reason = errno;
    (void)fclose(file);
    return fvv_fail(diagnostic, FVV_ERROR_IO, 0, 0, 0, "cannot be read at any position: %s",
                    strerror(reason));
  }
  input->read_at = read_at;
  input->user = file;
  input->size = (uint64_t)size;
  return FVV_OK;
}

void fvv_input_file_close(fvv_input *input) {
  if (input->user) (void)fclose((FILE *)input->user);
  memset(input, 0, sizeof *input);
}
