/* For tests, by LD_PRELOAD, of programs with 64-bit offsets in either way, and of Python: FAULT=CALL:N:ERRNO
   makes the N-th call fail, FAULT=CALL:N+:ERRNO that and all later ones. Calls: open, write, fsync, rename,
   close, mkdir, link. NOEXCHANGE=1: no file system knows RENAME_EXCHANGE, as on NFS. FAULT_LOG=FILE: gets a
   byte for each fault. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

/* POSIX has dlsym return an object pointer for functions too. */
#define REAL(name)                                                                                           \
  __typeof__(&name) real;                                                                                    \
  *(void **)&real = dlsym(RTLD_NEXT, #name)

static int fails(const char *call) {
  static atomic_int calls;
  const char *fault = getenv("FAULT");
  const size_t size = strlen(call);
  if (!fault || strncmp(fault, call, size) != 0 || fault[size] != ':') return 0;
  char *end;
  const long first = strtol(fault + size + 1, &end, 10);
  const int on = *end == '+', now = atomic_fetch_add(&calls, 1) + 1;
  if (on ? now < first : now != first) return 0;
  const char *log = getenv("FAULT_LOG");
  if (log) {
    REAL(open);
    const int file = real(log, O_WRONLY | O_CREAT | O_APPEND, 0600);
    if (file >= 0) {
      (void)!syscall(SYS_write, file, "x", 1);
      syscall(SYS_close, file);
    }
  }
  errno = atoi(end + 1 + on);
  return 1;
}

/* Files that are read, and libraries, are not meant. */
static int writes(int flags) {
  return (flags & O_ACCMODE) != O_RDONLY;
}

/* The mode is there when a file may be made. */
#define READ_MODE(flags, mode)                                                                               \
  mode_t mode = 0;                                                                                           \
  if ((flags) & (O_CREAT | O_TMPFILE)) {                                                                     \
    va_list list;                                                                                            \
    va_start(list, flags);                                                                                   \
    mode = va_arg(list, mode_t);                                                                             \
    va_end(list);                                                                                            \
  }

int open(const char *path, int flags, ...) {
  REAL(open);
  READ_MODE(flags, mode)
  return writes(flags) && fails("open") ? -1 : real(path, flags, mode);
}

int open64(const char *path, int flags, ...) {
  REAL(open64);
  READ_MODE(flags, mode)
  return writes(flags) && fails("open") ? -1 : real(path, flags, mode);
}

int openat(int folder, const char *path, int flags, ...) {
  REAL(openat);
  READ_MODE(flags, mode)
  return writes(flags) && fails("open") ? -1 : real(folder, path, flags, mode);
}

int openat64(int folder, const char *path, int flags, ...) {
  REAL(openat64);
  READ_MODE(flags, mode)
  return writes(flags) && fails("open") ? -1 : real(folder, path, flags, mode);
}

ssize_t write(int descriptor, const void *bytes, size_t size) {
  REAL(write);
  return descriptor > 2 && fails("write") ? -1 : real(descriptor, bytes, size);
}

int fsync(int descriptor) {
  REAL(fsync);
  return fails("fsync") ? -1 : real(descriptor);
}

int close(int descriptor) {
  REAL(close);
  struct stat status;
  const int flags = fcntl(descriptor, F_GETFL);
  const int written =
      flags >= 0 && writes(flags) && fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode);
  if (written && fails("close")) {
    const int reason = errno;
    real(descriptor);
    errno = reason;
    return -1;
  }
  return real(descriptor);
}

int mkdir(const char *path, mode_t mode) {
  REAL(mkdir);
  return fails("mkdir") ? -1 : real(path, mode);
}

int renameat(int from_folder, const char *from, int to_folder, const char *to) {
  REAL(renameat);
  return fails("rename") ? -1 : real(from_folder, from, to_folder, to);
}

/* A name for what has one is another way to give an output its own. */
int link(const char *from, const char *to) {
  REAL(link);
  return fails("link") ? -1 : real(from, to);
}

int rename(const char *from, const char *to) {
  REAL(rename);
  return fails("rename") ? -1 : real(from, to);
}

int renameat2(int from_folder, const char *from, int to_folder, const char *to, unsigned flags) {
  REAL(renameat2);
  if (getenv("NOEXCHANGE")) {
    errno = EINVAL;
    return -1;
  }
  return fails("rename") ? -1 : real(from_folder, from, to_folder, to, flags);
}
