/* TEXR (clause 17.5): how the colours of cameras are blended. */
#include <math.h>

#include "base/bytes.h"
#include "base/diagnostic.h"
#include "base/layout.h"
#include "fvv/visibility.h"

double fvv_texturing_threshold(uint8_t blend) {
  return blend == FVV_BLEND_PAPER ? 0.25 : 0.05;
}

void fvv_texturing_default(fvv_texturing *texturing) {
  *texturing = (fvv_texturing){
      fvv_texturing_threshold(FVV_BLEND_VIEWER), 0.2, 0.5, 0, 3, {128, 128, 128}, FVV_BLEND_VIEWER};
}

static fvv_status check(const fvv_texturing *t, fvv_status status, fvv_diagnostic *diagnostic) {
  const uint32_t type = FVV_CHUNK_TEXTURING;
  if (!(t->threshold >= 0 && t->threshold <= 1))
    return fvv_fail(diagnostic, status, FVV_ISSUE_TEXTURING_RANGE, type, FVV_TEXR_THRESHOLD,
                    "threshold of weights is %g, expected 0 to 1", t->threshold);
  const double tolerances[] = {t->depth_bias, t->depth_slope};
  for (size_t i = 0; i < 2; i++)
    if (!(tolerances[i] >= 0) || !isfinite(tolerances[i]))
      return fvv_fail(diagnostic, status, FVV_ISSUE_TEXTURING_RANGE, type, FVV_TEXR_DEPTH_BIAS + 8 * i,
                      "tolerance of depth maps is %g, expected 0 or more", tolerances[i]);
  if (!(t->inset >= 0) || !isfinite(t->inset))
    return fvv_fail(diagnostic, status, FVV_ISSUE_TEXTURING_RANGE, type, FVV_TEXR_INSET,
                    "inset is %g, expected 0 or more", t->inset);
  if (!t->best)
    return fvv_fail(diagnostic, status, FVV_ISSUE_TEXTURING_RANGE, type, FVV_TEXR_BEST,
                    "number of blended cameras is 0, expected 1 to 255");
  if (t->blend > FVV_BLEND_PAPER)
    return fvv_fail(diagnostic, status, FVV_ISSUE_TEXTURING_RANGE, type, FVV_TEXR_BLEND,
                    "blend is %u, expected 0 or 1", t->blend);
  return FVV_OK;
}

fvv_status fvv_texturing_encode(const fvv_texturing *texturing, uint8_t *out, size_t capacity,
                                size_t *written, fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  const fvv_status status = check(texturing, FVV_ERROR_ARGUMENT, diagnostic);
  if (status < 0) return status;
  *written = FVV_TEXR_SIZE;
  if (capacity < FVV_TEXR_SIZE) return FVV_ERROR_BUFFER_TOO_SMALL;
  memset(out, 0, FVV_TEXR_SIZE);
  fvv_put_f64(out + FVV_TEXR_THRESHOLD, texturing->threshold);
  fvv_put_f64(out + FVV_TEXR_DEPTH_BIAS, texturing->depth_bias);
  fvv_put_f64(out + FVV_TEXR_DEPTH_SLOPE, texturing->depth_slope);
  fvv_put_f64(out + FVV_TEXR_INSET, texturing->inset);
  out[FVV_TEXR_BEST] = texturing->best;
  memcpy(out + FVV_TEXR_UNSEEN, texturing->unseen, sizeof texturing->unseen);
  out[FVV_TEXR_BLEND] = texturing->blend;
  return FVV_OK;
}

fvv_status fvv_texturing_decode(fvv_texturing *texturing, const uint8_t *payload, size_t size,
                                fvv_diagnostic *diagnostic) {
  fvv_diagnostic_clear(diagnostic);
  fvv_texturing_default(texturing);
  /* What a later version appended is not looked at, here and in other ancillary chunks (clause 16). */
  if (size < FVV_TEXR_SIZE)
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_TEXTURING_PAYLOAD, FVV_CHUNK_TEXTURING, 0,
                    "payload of %zu bytes, expected at least %d", size, FVV_TEXR_SIZE);
  if (!fvv_all_zero(payload + FVV_TEXR_RESERVED, FVV_TEXR_SIZE - FVV_TEXR_RESERVED))
    return fvv_fail(diagnostic, FVV_ERROR_INVALID, FVV_ISSUE_TEXTURING_PAYLOAD, FVV_CHUNK_TEXTURING,
                    FVV_TEXR_RESERVED, "reserved bytes are not 0");
  texturing->threshold = fvv_get_f64(payload + FVV_TEXR_THRESHOLD);
  texturing->depth_bias = fvv_get_f64(payload + FVV_TEXR_DEPTH_BIAS);
  texturing->depth_slope = fvv_get_f64(payload + FVV_TEXR_DEPTH_SLOPE);
  texturing->inset = fvv_get_f64(payload + FVV_TEXR_INSET);
  texturing->best = payload[FVV_TEXR_BEST];
  memcpy(texturing->unseen, payload + FVV_TEXR_UNSEEN, sizeof texturing->unseen);
  texturing->blend = payload[FVV_TEXR_BLEND];
  return check(texturing, FVV_ERROR_INVALID, diagnostic);
}
