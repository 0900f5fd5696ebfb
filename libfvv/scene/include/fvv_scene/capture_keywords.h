// The keywords of values in capture.json, for reader and writer.
#pragma once

#include "fvv/format.h"

#include <cstdint>

namespace fvv::scene {

struct NamedUnit {
  const char *name;
  double metres;
};
constexpr NamedUnit named_units[] = {
    {"metres", 1}, {"centimetres", 0.01}, {"millimetres", 0.001}, {"inches", 0.0254}, {"feet", 0.3048}};
constexpr const char *unknown_units = "unknown";

struct NamedAxis {
  const char *name;
  uint8_t up;
};
constexpr NamedAxis named_axes[] = {
    {"+x", FVV_UP_X}, {"-x", FVV_UP_MINUS_X}, {"+y", FVV_UP_Y},           {"-y", FVV_UP_MINUS_Y},
    {"+z", FVV_UP_Z}, {"-z", FVV_UP_MINUS_Z}, {"unknown", FVV_UP_UNKNOWN}};

struct NamedLens {
  const char *name;
  uint8_t lens;
  unsigned coefficients; // the number that the writer writes: all of the model
};
constexpr NamedLens named_lenses[] = {
    {"none", FVV_LENS_NONE, 0}, {"radtan", FVV_LENS_RADTAN, 8}, {"fisheye", FVV_LENS_FISHEYE, 4}};

constexpr const char *unbounded = "unbounded"; // r_max = +inf, which JSON cannot write as a number

} // namespace fvv::scene
