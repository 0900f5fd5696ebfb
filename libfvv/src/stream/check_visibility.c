#include "stream/check_visibility.h"

#include "base/diagnostic.h"

/* A chunk that is no key follows one that was not decoded: only its number and key flag can be judged. */
static fvv_status judge_structure(const fvv_event *event, const fvv_configuration *configuration,
                                  const fvv_limits *limits, fvv_diagnostic *diagnostic) {
  const int key = (event->chunk.flags & FVV_FLAG_KEY) != 0;
  fvv_visibility_header header;
  fvv_visibility_frames before = {0};
  const size_t size = (size_t)event->chunk.size;
  const fvv_status status = fvv_visibility_peek(event->payload, size, limits, &header, NULL, 0, diagnostic);
  if (status != FVV_OK) return status;
  before.current.header = header;
  before.current.header.number = header.number - 1;
  return fvv_visibility_frames_check(&before, event->payload, size, key, configuration, limits, &header,
                                     diagnostic);
}

static int any_moves(const fvv_configuration *configuration) {
  for (size_t i = 0; i < configuration->camera_count; i++)
    if (configuration->cameras[i].flags & FVV_CAMERA_MOVES) return 1;
  return 0;
}

fvv_status fvv_check_visibility(fvv_checked_visibility *visibility, const fvv_event *event, uint64_t group,
                                int decode, const fvv_checked_mesh *mesh,
                                const fvv_checked_calibration *calibration,
                                const fvv_configuration *configuration, const fvv_limits *limits,
                                const fvv_allocator *allocator, int *whole, fvv_diagnostic *diagnostic) {
  const int key = (event->chunk.flags & FVV_FLAG_KEY) != 0;
  const size_t size = (size_t)event->chunk.size;
  if (visibility->group != group) {
    fvv_visibility_frames_reset(&visibility->frames);
    visibility->group = group;
    visibility->lost = 0;
  }
  if (!decode) return judge_structure(event, configuration, limits, diagnostic);
  const fvv_mesh *current =
      mesh && !mesh->lost && mesh->time == event->chunk.time ? fvv_mesh_frames_current(&mesh->frames) : NULL;
  const fvv_calibration *placed =
      calibration ? fvv_checked_calibration_at(calibration, group, event->chunk.time) : NULL;
  const int placed_unknown = calibration && calibration->group == group && calibration->lost;
  /* Behind damage it is not known what is missing; that mesh or calibration was wrong has been said. */
  const int unknown = (!current && ((mesh && mesh->lost) || !event->group_intact)) ||
                      (!placed && any_moves(configuration) && (placed_unknown || !event->group_intact)) ||
                      (!key && (visibility->lost || !event->group_intact));
  if (unknown) {
    visibility->lost = 1;
    *whole = 0;
    return judge_structure(event, configuration, limits, diagnostic);
  }
  const fvv_status status = fvv_visibility_frames_add(&visibility->frames, event->payload, size, key, current,
                                                      placed, configuration, limits, allocator, diagnostic);
  visibility->lost = status != FVV_OK;
  return status;
}
