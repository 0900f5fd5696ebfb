// capture/drc_header.h: what a Draco file declares, read without libdraco: the decoder allocates by these
// counts before it looks at anything else.
#pragma once

#include "capture/mesh_file.h"

namespace fvv::capture {

struct DrcCounts {
  uint64_t faces, vertices;
};

// FileError "name: 0xOFFSET: what" for anything but a triangular mesh of bitstream 2.2.
DrcCounts parse_drc_header(std::string_view bytes, const std::string &name);

} // namespace fvv::capture
