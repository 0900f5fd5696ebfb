// What a path is, in words.
#pragma once

#include <sys/stat.h>

namespace fvv {

// "a folder", "a pipe", "a socket", "a block device", "a character device", "a file".
const char *file_kind(mode_t mode);

} // namespace fvv
