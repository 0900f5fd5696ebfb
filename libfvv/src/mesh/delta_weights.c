#include "base/shift.h"
#include "mesh/delta_hierarchy.h"

enum {
  SHARE_BITS = 12,   /* of the uncorrected weights */
  MATRIX_BITS = 17,  /* of the trace: products of three entries and a mean stay below 2^63 */
  INVERSE_BITS = 16, /* fraction of the solution */
  RIDGE = 32,
  CORRECTION_MAX = 1 << 18 /* 4 */
};

/* Inverse squared distances that add up to 2^12; the nearest one takes what rounding leaves. */
static void shares_of(int32_t offsets[][3], uint32_t count, int64_t *shares) {
  uint64_t inverse[FVV_DELTA_NEIGHBOURS], sum = 0;
  for (uint32_t i = 0; i < count; i++) {
    uint64_t squared = 1;
    for (int a = 0; a < 3; a++) squared += (uint64_t)((int64_t)offsets[i][a] * offsets[i][a]);
    inverse[i] = (UINT64_C(1) << 30) / squared;
    sum += inverse[i];
  }
  int64_t rest = 1 << SHARE_BITS;
  for (uint32_t i = 0; i < count; i++) {
    shares[i] = (int64_t)((inverse[i] << SHARE_BITS) / sum);
    rest -= shares[i];
  }
  shares[0] += rest;
}

/* Solves (spread + ridge) * x = -mean by the adjugate: x = solution * 2^-16 * 2^-shift. 0 where all points
 * lie together and there is nothing to solve. */
static int solve(int32_t offsets[][3], uint32_t count, const int64_t *shares, const int64_t mean[3],
                 int64_t solution[3], int *shift) {
  int64_t s[3][3];
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++) {
      int64_t sum = 0;
      for (uint32_t i = 0; i < count; i++) sum += shares[i] * offsets[i][a] * offsets[i][b];
      s[a][b] = sum * (1 << SHARE_BITS) - mean[a] * mean[b];
    }
  const int64_t trace = s[0][0] + s[1][1] + s[2][2];
  *shift = 0;
  while (trace >> *shift >= 1 << MATRIX_BITS) ++*shift;
  for (int a = 0; a < 3; a++) {
    s[a][a] += trace / RIDGE + 1;
    for (int b = 0; b < 3; b++) s[a][b] = fvv_shift_right(s[a][b], *shift);
  }
  int64_t adjugate[3][3];
  for (int a = 0; a < 3; a++)
    for (int b = 0; b < 3; b++) {
      const int a1 = (a + 1) % 3, a2 = (a + 2) % 3, b1 = (b + 1) % 3, b2 = (b + 2) % 3;
      adjugate[a][b] = s[a1][b1] * s[a2][b2] - s[a1][b2] * s[a2][b1];
    }
  const int64_t determinant = s[0][0] * adjugate[0][0] + s[0][1] * adjugate[0][1] + s[0][2] * adjugate[0][2];
  const int64_t divisor = fvv_shift_right(determinant, INVERSE_BITS);
  if (divisor <= 0) return 0;
  for (int a = 0; a < 3; a++)
    solution[a] = -(adjugate[a][0] * mean[0] + adjugate[a][1] * mean[1] + adjugate[a][2] * mean[2]) / divisor;
  return 1;
}

void fvv_delta_weights(int32_t offsets[][3], uint32_t count, int32_t *weights) {
  int64_t shares[FVV_DELTA_NEIGHBOURS] = {0}, mean[3] = {0, 0, 0}, solution[3];
  shares_of(offsets, count, shares);
  for (uint32_t i = 0; i < count; i++)
    for (int a = 0; a < 3; a++) mean[a] += shares[i] * offsets[i][a];
  int shift;
  const int solved = solve(offsets, count, shares, mean, solution, &shift);
  int64_t rest = 1 << FVV_DELTA_WEIGHT_BITS;
  for (uint32_t i = 0; i < count; i++) {
    int64_t correction = 0;
    for (int a = 0; solved && a < 3; a++)
      correction += ((int64_t)offsets[i][a] * (1 << SHARE_BITS) - mean[a]) * solution[a];
    if (solved) correction = fvv_shift_right(correction, shift);
    if (correction > CORRECTION_MAX) correction = CORRECTION_MAX;
    if (correction < -CORRECTION_MAX) correction = -CORRECTION_MAX;
    weights[i] =
        (int32_t)fvv_shift_right(shares[i] * ((1 << FVV_DELTA_WEIGHT_BITS) + correction), SHARE_BITS);
    rest -= weights[i];
  }
  weights[0] += (int32_t)rest;
}
