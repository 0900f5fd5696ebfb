#include "cli/cli.h"

#include <cstdlib>
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace fvv::cli {

void keep_freed_memory() {
#ifdef __GLIBC__
  constexpr int megabyte = 1 << 20;
  mallopt(M_MMAP_THRESHOLD, 32 * megabyte); // the most that glibc takes
  mallopt(M_TRIM_THRESHOLD, 64 * megabyte);
#endif
}

} // namespace fvv::cli
