// Accessors (glTF 2.0 clause 3.6.2) as numbers: strided, normalised, sparse, or without any bytes.
#pragma once

#include "scene/src/gltf/container.h"

#include <vector>

namespace fvv::scene::gltf {

// The purpose of an accessor; each allows other types and components.
enum class Purpose {
  indices,
  positions,     // also by KHR_mesh_quantization
  texture,       // coordinates, also by KHR_mesh_quantization
  normals,       // also by KHR_mesh_quantization
  displacements, // of morph targets, also by KHR_mesh_quantization
  joints,
  weights,
  matrices, // inverse bind matrices
  times,
  vectors, // animated translation or scale
  rotations,
  amounts, // animated weights of morph targets
  colours,
  colours_alpha, // with opacity
};

// The layout that an accessor declares, valid for its purpose.
struct Layout {
  uint64_t count;      // elements
  unsigned components; // of an element
  unsigned type;       // GL code of a component
  bool normalised;

  unsigned component_size() const;
  unsigned element_size() const { return components * component_size(); }
};

Layout accessor_layout(const Container &container, const JsonValue &reference, Purpose purpose);

// All numbers of an accessor, element by element; finite. Error names the accessor.
std::vector<double> accessor_numbers(Container &container, const JsonValue &reference, Purpose purpose);

// Numbers from elements of that layout. place: for messages. bytes: at least count elements, stride bytes
// from one to the next.
std::vector<double> unpack(const Layout &layout, std::string_view bytes, uint64_t stride,
                           const JsonValue &place);

} // namespace fvv::scene::gltf
