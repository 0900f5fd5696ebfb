#include "mesh/octahedral.h"

#include <math.h>

#include "fvv/mesh.h"

static double sign_of(double x) {
  return x < 0 ? -1 : 1;
}

/* The fold, which is its own inverse: the lower half of the octahedron lies in the corners of the square.
 * Exact for integers. */
static void fold(double half, double at[2]) {
  const double a = at[0], b = at[1];
  at[0] = (half - fabs(b)) * sign_of(a);
  at[1] = (half - fabs(a)) * sign_of(b);
}

/* A grid point (integers within +-half) -> its vector of integers; answers the length. */
static double grid_vector(double half, double a, double b, double vector[3]) {
  double at[2] = {a, b};
  const double z = half - fabs(a) - fabs(b);
  if (z < 0) fold(half, at);
  vector[0] = at[0];
  vector[1] = at[1];
  vector[2] = z;
  return sqrt(at[0] * at[0] + at[1] * at[1] + z * z);
}

static double half_of(unsigned bits) {
  return (double)(fvv_octahedral_most(bits) / 2);
}

void fvv_octahedral_vector(unsigned bits, const uint32_t index[2], double vector[3]) {
  const double half = half_of(bits);
  const double length = grid_vector(half, (double)index[0] - half, (double)index[1] - half, vector);
  for (int k = 0; k < 3; k++) vector[k] /= length;
}

void fvv_octahedral_index(unsigned bits, const double vector[3], uint32_t index[2]) {
  const double half = half_of(bits), sum = fabs(vector[0]) + fabs(vector[1]) + fabs(vector[2]);
  double at[2] = {vector[0] / sum * half, vector[1] / sum * half};
  if (vector[2] < 0) fold(half, at);
  const double low[2] = {floor(at[0]), floor(at[1])};
  double best = -INFINITY, chosen[2] = {0, 0};
  for (int i = 0; i < 4; i++) {
    double grid[3];
    const double a = low[0] + i % 2, b = low[1] + i / 2;
    if (fabs(a) > half || fabs(b) > half) continue;
    const double length = grid_vector(half, a, b, grid);
    const double cosine = (grid[0] * vector[0] + grid[1] * vector[1] + grid[2] * vector[2]) / length;
    if (cosine <= best) continue;
    best = cosine;
    chosen[0] = a;
    chosen[1] = b;
  }
  /* Two points of the rim that mirror each other are one on the sphere, the four corners as well. */
  const int rim[2] = {fabs(chosen[0]) == half, fabs(chosen[1]) == half};
  if (rim[1]) chosen[0] = fabs(chosen[0]);
  if (rim[0]) chosen[1] = fabs(chosen[1]);
  for (int k = 0; k < 2; k++) index[k] = (uint32_t)(chosen[k] + half);
}

void fvv_normals_to_floats(uint8_t bits, const uint32_t *indices, size_t count, float *normals) {
  for (size_t i = 0; i < count; i++) {
    double vector[3];
    fvv_octahedral_vector(bits, indices + 2 * i, vector);
    for (size_t k = 0; k < 3; k++) normals[3 * i + k] = (float)vector[k];
  }
}
