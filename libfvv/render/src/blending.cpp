#include "blending.h"

#include <algorithm>

namespace fvv::render {

namespace {

// Clause 17.5: what keeps the weight of a camera on the viewer's own ray finite; it is 8 degrees wide.
constexpr double direction_width = 0.01;
// Pixels of the source over which its weight falls to 0 at the border.
constexpr double border_width = 8;
// Of the first camera that is not mixed, this much is subtracted from the others: a camera that enters or
// leaves has no weight then. Less than all, so that equal cameras keep some.
constexpr double handover = 1023.0 / 1024;
// From this certainty on the colour is the cameras' alone.
constexpr double fully_certain = 0.1;

} // namespace

Candidate directed(const ViewOptions &options, const ViewAngles &angles) {
  Candidate camera;
  if (options.blend == Blend::paper) {
    // A weight of 0 would leave nothing to divide by.
    if (angles.facing >= options.threshold && angles.facing > 0) camera.weight = angles.facing;
    camera.certainty = 1;
    return camera;
  }
  if (!(angles.facing > options.threshold)) return camera;
  const double apart = 1 + direction_width - angles.direction;
  camera.certainty = (angles.facing - options.threshold) / (1 - options.threshold);
  camera.weight = camera.certainty / (apart * apart);
  return camera;
}

double visibility_factor(Blend blend, double seen) {
  if (blend == Blend::paper) return seen >= 127.5;
  return std::max(0.0, seen / 127.5 - 1);
}

double border_factor(Blend blend, double distance) {
  if (blend == Blend::paper) return distance >= 0;
  return std::clamp(distance / border_width, 0.0, 1.0);
}

BestCameras::BestCameras(const ViewOptions &options)
    : blend(options.blend), best(options.best), kept(best + (options.blend == Blend::viewer)) {}

void BestCameras::add(const Candidate &camera) {
  if (!accepts(camera.weight)) return;
  size_t i = std::min(count, kept - 1);
  for (; i > 0 && camera.weight > all[i - 1].weight; i--) all[i] = all[i - 1];
  all[i] = camera;
  count = std::min(count + 1, kept);
}

void BestCameras::normalise() {
  const double next = count > best ? handover * all[best].weight : 0;
  count = std::min(count, best);
  double sum = 0;
  for (size_t i = 0; i < count; i++) sum += all[i].weight -= next;
  for (size_t i = 0; i < count; i++) all[i].weight /= sum;
}

double BestCameras::certainty() const {
  double mean = 0;
  for (const Candidate &camera : *this) mean += camera.weight * camera.certainty;
  return blend == Blend::paper ? 1 : std::min(1.0, mean / fully_certain);
}

} // namespace fvv::render
