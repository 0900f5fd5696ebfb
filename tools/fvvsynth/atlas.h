// The tracked mesh with texture coordinates, and the texture map that they address: its solid textures, baked
// once, for all frames. Knows the scene's rest shapes and their colours; knows no motion, light or files.
#pragma once

#include "fvv_media/image.h"
#include "fvvsynth/layout.h"
#include "fvvsynth/scene.h"

namespace fvv::synth {

constexpr uint32_t default_atlas_size = 1024;

struct Atlas {
  std::vector<Chart> charts;
  Layout layout;        // of the faces of Scene::faces()
  media::Image picture; // diffuse reflectance alone, as display values

  // What the layout's vertices have of something that the scene's have, in groups of per numbers.
  template <class Value> std::vector<Value> opened(const std::vector<Value> &values, size_t per) const {
    std::vector<Value> result;
    result.reserve(layout.source.size() * per);
    for (const uint32_t vertex : layout.source)
      result.insert(result.end(), values.begin() + ptrdiff_t(vertex * per),
                    values.begin() + ptrdiff_t((vertex + 1) * per));
    return result;
  }
};

// size: texels of each side; throws std::invalid_argument as lay_out does. A texel is the mean, in linear
// light, of the solid texture at those of 4 x 4 points in it that belong to a face. Colours go on unchanged
// through the margins of charts; what is left is filled smoothly, which costs a codec little. The result is
// the same for any number of threads.
Atlas make_atlas(const Scene &scene, uint32_t size, uint32_t threads);

} // namespace fvv::synth
