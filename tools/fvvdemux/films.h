// Video tracks as films: the samples of the stream in MP4.
#pragma once

#include "cli/output.h"
#include "fvv_demux/frame_plan.h"
#include "fvvdemux/demux.h"

#include <string>

namespace fvv::demux {

// Error (usage), naming the frames of the group, when only part of a group is selected: its later samples
// need the earlier ones.
void check_whole_groups(const Plan &plan, const Selection &frames);

// Writes video/TRACK.mp4 for each video track of the rung that shows a selected camera or the atlas. Returns
// their number; tracks that cannot be a film become warnings of result, lost samples its losses.
uint64_t write_films(fvv_stream *stream, const std::string &file, const Plan &plan, const Options &options,
                     cli::OutputFolder &folder, Result &result);

} // namespace fvv::demux
