// --meshes gltf: animated GLB files of frames that share their faces.
#pragma once

#include "cli/output.h"
#include "fvvdemux/group.h"

#include <cstdint>
#include <vector>

namespace fvv::demux {

// Writes meshes/FIRST-LAST.glb for each run of frames, and meshes/N.glb for a frame alone, when all of them
// and their pictures are in the folder. frames: those of plan that were written, in order. Returns the number
// of files; a run that has one picture for all of its frames is a warning of result.
uint64_t write_animations(fvv_stream *stream, const Plan &plan, const std::vector<WrittenFrame> &frames,
                          const Options &options, const FileName &name, cli::OutputFolder &folder,
                          Result &result);

} // namespace fvv::demux
