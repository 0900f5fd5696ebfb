// What the presets are (docs/encoding/presets.md).
#pragma once

#include "fvv_geometry/decimate.h"
#include "fvv_media/video.h"
#include "fvv_mux/options.h"

namespace fvv::mux {

struct PresetRow {
  const char *name;
  media::Effort pictures;  // of their encoder
  size_t sample_frames;    // by which their quality is found, at most
  decimate::Checks checks; // of decimated meshes
  int mesh_level;          // of Draco
  bool visibility;         // found by rays, where it pays; without it players make depth maps
  bool colours;            // of vertices, from the pictures
  bool match_colours;      // looked for
  bool view_loss;          // a choice by views where options state no goal
  Track track;
};

const PresetRow &row_of(Preset preset);

// Sets what options leave open and a value can say; the rest is for those who decide, by row_of().
void fill_in_preset(Options &options);

// "as the preset live has it", for what is left out.
std::string preset_reason(Preset preset);

} // namespace fvv::mux
