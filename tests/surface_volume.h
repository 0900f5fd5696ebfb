// What a closed surface encloses, for tests.
#pragma once

#include "fvv_geometry/marching_cubes.h"

// Cubic metres; negative when the faces are inside out.
inline double volume(const fvv::hull::Surface &surface) {
  double sum = 0;
  for (size_t i = 0; i < surface.faces.size(); i += 3)
    sum += dot(surface.vertices[surface.faces[i]],
               cross(surface.vertices[surface.faces[i + 1]], surface.vertices[surface.faces[i + 2]])) /
           6;
  return sum;
}
