// Colours of a texture map. Knows texels, triangles and what they are to be coloured with; knows no scene.
#pragma once

#include "fvv_media/image.h"
#include "fvv_render/picture.h"
#include "fvvsynth/layout.h"

#include <functional>

namespace fvv::synth {

// The colour (linear) of a face at weights of its three corners that add up to 1.
using Paint = std::function<render::Rgb(uint32_t face, const std::array<double, 3> &weights)>;

// See make_atlas (atlas.h). paint is called from several threads.
media::Image bake(const std::vector<Chart> &charts, const Layout &layout, const Paint &paint,
                  uint32_t threads);

} // namespace fvv::synth
