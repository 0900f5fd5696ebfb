#include "stream/check_calibration.h"

#include "base/diagnostic.h"
#include "base/layout.h"

void fvv_checked_calibration_reset(fvv_checked_calibration *calibration) {
  fvv_calibration_destroy(calibration->cameras);
  calibration->cameras = NULL;
}

const fvv_calibration *fvv_checked_calibration_at(const fvv_checked_calibration *calibration, uint64_t group,
                                                  int64_t time) {
  return calibration->cameras && !calibration->lost && calibration->group == group &&
                 calibration->time == time
             ? calibration->cameras
             : NULL;
}

void fvv_count_calibrations(fvv_track_summary *summary, const fvv_event *event,
                            const fvv_configuration *configuration) {
  if (event->chunk.size < FVV_CALB_SIZE) return;
  const uint8_t *count = event->payload + FVV_CALB_COUNT;
  const uint64_t entries = count[0] | (uint64_t)count[1] << 8;
  uint64_t moving = 0;
  for (size_t i = 0; i < configuration->camera_count; i++)
    moving += (configuration->cameras[i].flags & FVV_CAMERA_MOVES) != 0;
  summary->calibrations += entries;
  summary->lost_calibrations += entries < moving ? moving - entries : 0;
}

fvv_status fvv_check_calibration(fvv_checked_calibration *calibration, const fvv_event *event, uint64_t block,
                                 uint64_t group, const fvv_configuration *configuration,
                                 const fvv_allocator *allocator, int *whole, fvv_diagnostic *diagnostic) {
  if (calibration->block != block || !calibration->cameras) {
    fvv_checked_calibration_reset(calibration);
    const fvv_status created = fvv_calibration_create(configuration->cameras, configuration->camera_count,
                                                      allocator, &calibration->cameras);
    if (created != FVV_OK) return created;
    calibration->block = block;
    calibration->lost = 0;
  }
  if (calibration->group != group) {
    fvv_calibration_reset(calibration->cameras);
    calibration->group = group;
    calibration->lost = 0;
  }
  calibration->time = event->chunk.time;
  const int key = (event->chunk.flags & FVV_FLAG_KEY) != 0;
  /* Behind a wrong chunk its successors are wrong in vain; behind damage it is not known what is missing. */
  if (!key && calibration->lost) {
    *whole = 0;
    return FVV_OK;
  }
  fvv_diagnostic why = {0};
  const fvv_status status =
      fvv_calibration_decode(calibration->cameras, event->payload, (size_t)event->chunk.size, key, &why);
  calibration->lost = status != FVV_OK;
  if (status == FVV_OK) return FVV_OK;
  if (!key && why.issue == FVV_ISSUE_CALIBRATION_NUMBER && !event->group_intact) {
    *whole = 0;
    return FVV_OK;
  }
  *diagnostic = why;
  return status;
}
