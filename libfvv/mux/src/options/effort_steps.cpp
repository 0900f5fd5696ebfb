#include "mux/src/options/effort_steps.h"

#include <algorithm>

namespace fvv::mux {

namespace {

// Every step keeps the configuration of the stream: size of the video frame, record, lattice. Of CRF 6 units
// are about half the bytes.
const EffortStep effort_rows[effort_steps] = {
    // text, least effort, coarser, mesh level
    {"as planned", false, 0, 10},
    {"pictures are searched less, meshes packed less", true, 0, 1},
    {"pictures are coarser by 3", true, 3, 0},
    {"pictures are coarser by 6", true, 6, 0},
};

} // namespace

const EffortStep &effort_step(size_t number) {
  return effort_rows[std::min(number, effort_steps - 1)];
}

void lower(media::VideoSettings &settings, const EffortStep &step) {
  const media::VideoCodec &codec = *media::find_video_codec(settings.codec);
  if (step.least_effort && settings.effort == media::Effort::live) settings.effort = media::Effort::least;
  if (settings.bit_rate) return; // it says how coarse
  const int way = codec.coarsest < codec.finest ? -1 : 1, most = std::abs(codec.coarsest - settings.quality);
  // Stills have a scale of a hundred, others of about fifty.
  const int units = step.coarser * (codec.code == FVV_CODEC_JPEG ? 4 : 1);
  settings.quality += way * std::min(units, most);
  if (settings.quality == codec.coarsest) settings.parts = 0;
}

} // namespace fvv::mux
