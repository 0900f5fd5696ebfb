// Metres <-> lattice.
#include "fvv_catch.h"

#include <cfenv>
#include <cmath>
#include <limits>

#include "fvv/mesh.h"
extern "C" {
#include "mesh/mesh.h"
}

TEST_CASE("quantisation takes the nearest index, ties the even one, in every rounding mode") {
  const struct {
    double x;
    int32_t index;
  } cases[] = {{0, 0},
               {0.49, 0},
               {0.5, 0},
               {0.51, 1},
               {1.5, 2},
               {2.5, 2},
               {3.5, 4},
               {-0.49, 0},
               {-0.5, 0},
               {-0.51, -1},
               {-1.5, -2},
               {-2.5, -2},
               {-3.5, -4},
               {268435456, FVV_LATTICE_MAX},
               {268435456.5, FVV_LATTICE_MAX},
               {-268435456.5, -FVV_LATTICE_MAX},
               {268435455.5, FVV_LATTICE_MAX}};
  for (const int mode : {FE_TONEAREST, FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO}) {
    fesetround(mode);
    for (const auto &c : cases) {
      int32_t index = 77;
      const int inside = fvv_lattice_quantise(c.x, 0, 1, &index);
      CHECK(inside == 1);
      CHECK(index == c.index);
    }
  }
  fesetround(FE_TONEAREST);
}

TEST_CASE("quantisation refuses what lies outside the lattice") {
  int32_t index = 77;
  for (const double x : {268435456.51, -268435456.51, 268435457.0, 1e300, -1e300}) {
    CHECK_FALSE(fvv_lattice_quantise(x, 0, 1, &index));
  }
  CHECK_FALSE(fvv_lattice_quantise(1.7e308, -1.7e308, 1e-300, &index));
  CHECK(index == 77);
}

TEST_CASE("indices go to metres and back without change, off by at most half a step") {
  const double origin[3] = {-1.25, 0.1, 1e4}, step = 0.0007;
  for (const int32_t i : {-FVV_LATTICE_MAX, -1000003, -1, 0, 1, 12345, FVV_LATTICE_MAX}) {
    const int32_t index[3] = {i, -i, i / 2};
    double metres[3];
    fvv_lattice_to_metres(origin, step, index, metres);
    for (int k = 0; k < 3; k++) {
      int32_t back = 0;
      REQUIRE(fvv_lattice_quantise(metres[k], origin[k], step, &back));
      CHECK(back == index[k]);
      REQUIRE(fvv_lattice_quantise(metres[k] + 0.49 * step, origin[k], step, &back));
      CHECK(back == index[k]);
    }
  }
}

TEST_CASE("dequantisation rounds the product before the sum") {
  // 0.1 * 3 rounds up to 0.30000000000000004; fused with -0.3 the unrounded product gives another difference.
  const double origin[3] = {-0.3, 0, 0}, step = 0.1;
  const int32_t index[3] = {3, 3, 0};
  double metres[3];
  fvv_lattice_to_metres(origin, step, index, metres);
  CHECK(metres[0] == 0.1 * 3 - 0.3);
  CHECK(metres[0] != std::fma(0.1, 3, -0.3));
  CHECK(metres[1] == 0.30000000000000004);
  float floats[3];
  fvv_lattice_to_floats(origin, step, index, 1, floats);
  for (int k = 0; k < 3; k++) CHECK(floats[k] == float(metres[k]));
}
