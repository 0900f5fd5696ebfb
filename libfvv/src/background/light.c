/* What a light may say (clause 18.4). */
#include <math.h>

#include "background/background.h"

#define HALF_PI 1.5707963267948966

static int all_finite(const double *v) {
  return isfinite(v[0]) && isfinite(v[1]) && isfinite(v[2]);
}
static int is_zero(const double *v) {
  return v[0] == 0 && v[1] == 0 && v[2] == 0;
}

fvv_status fvv_light_check(const fvv_light *light, uint64_t offset, fvv_diagnostic *diagnostic) {
  if (light->type > FVV_LIGHT_SPOT)
    WRONG(BACKGROUND_LIGHT, offset + FVV_BACK_LIGHT_TYPE, "light of type %u, known are 0 to 2", light->type);
  const int placed = light->type != FVV_LIGHT_DIRECTIONAL, directed = light->type != FVV_LIGHT_POINT;
  if (!all_finite(light->position) || (!placed && !is_zero(light->position)))
    WRONG(BACKGROUND_LIGHT, offset + FVV_BACK_LIGHT_POSITION,
          "position of a light is not finite, or not 0 although the light is directional");
  const double *d = light->direction;
  const double square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
  if (directed ? !(fabs(sqrt(square) - 1) <= 1e-4) : !is_zero(d))
    WRONG(BACKGROUND_LIGHT, offset + FVV_BACK_LIGHT_DIRECTION,
          "direction of a light has length %g, expected 1, or 0 for point lights", sqrt(square));
  for (int k = 0; k < 3; k++)
    if (!(light->colour[k] >= 0 && light->colour[k] <= 1))
      WRONG(BACKGROUND_LIGHT, offset + FVV_BACK_LIGHT_COLOUR + 8 * (unsigned)k,
            "colour of a light is %g, expected 0 to 1", light->colour[k]);
  if (!(light->intensity >= 0 && isfinite(light->intensity)))
    WRONG(BACKGROUND_LIGHT, offset + FVV_BACK_LIGHT_INTENSITY,
          "intensity of a light is %g, expected 0 or more", light->intensity);
  if (!(light->range >= 0 && isfinite(light->range)) || (!placed && light->range != 0))
    WRONG(BACKGROUND_LIGHT, offset + FVV_BACK_LIGHT_RANGE,
          "range of a light is %g, expected 0 or more, and 0 for directional lights", light->range);
  const int cone =
      light->inner_cone >= 0 && light->inner_cone < light->outer_cone && light->outer_cone <= HALF_PI;
  if (light->type == FVV_LIGHT_SPOT ? !cone : light->inner_cone != 0 || light->outer_cone != 0)
    WRONG(BACKGROUND_LIGHT, offset + FVV_BACK_LIGHT_INNER_CONE,
          "cone of a light is %g to %g, expected 0 <= inner < outer <= pi / 2 for a spot, else 0",
          light->inner_cone, light->outer_cone);
  return FVV_OK;
}
