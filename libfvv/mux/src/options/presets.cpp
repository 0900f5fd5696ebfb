#include "mux/src/options/presets.h"
#include "mux/src/options/option_values.h"

namespace fvv::mux {

namespace {

using decimate::Checks;
using media::Effort;

// In the order of Preset. Each lies on the line of least time for its bytes (docs/encoding/presets.md).
const PresetRow rows[] = {
    // name, pictures, sample, checks, level, visibility, colours, match, views, track
    {"live", Effort::live, 8, Checks::none, 5, false, false, false, false, Track::never},
    {"fast", Effort::fast, 12, Checks::some, 7, false, false, true, false, Track::never},
    {"medium", Effort::full, 25, Checks::all, 9, true, true, true, true, Track::never},
    {"slow", Effort::full, 25, Checks::all, 10, true, true, true, true, Track::automatic},
};

} // namespace

const PresetRow &row_of(Preset preset) {
  return rows[size_t(preset)];
}

void fill_in_preset(Options &options) {
  const PresetRow &row = row_of(options.preset);
  if (!options.mesh_level) options.mesh_level = row.mesh_level;
  const bool moves = options.delta && !options.keep_geometry && !options.triangles;
  if (!options.track) options.track = moves ? row.track : Track::never;
}

std::string preset_reason(Preset preset) {
  return "as " + option_name("preset", row_of(preset).name) + " has it";
}

} // namespace fvv::mux
