// Reprojection errors, as given and with one mistake undone.

#include "fvv_scene/import.h"
#include "scene/src/import/camera.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fvv::import {

namespace {

constexpr double negligible = 0.1;    // px: below this nothing is suspected
constexpr double much_better = 0.5;   // of the rms as given
constexpr double clearly_first = 0.7; // of the rms of the next mistake

using Cameras = std::vector<fvv_camera>;

double distance(const fvv_camera &camera, const Observation &observation, bool *visible = nullptr) {
  double pixel[2];
  const bool seen = fvv_camera_project(&camera, observation.world, pixel, nullptr);
  if (visible) *visible = seen;
  const double diagonal = std::hypot(camera.width, camera.height);
  return seen ? std::min(std::hypot(pixel[0] - observation.pixel[0], pixel[1] - observation.pixel[1]),
                         diagonal)
              : diagonal;
}

// observations: with indices of cameras in place of identifiers.
double rms(const Cameras &cameras, const std::vector<Observation> &observations) {
  double sum = 0;
  for (const Observation &o : observations) {
    const double d = distance(cameras[o.camera], o);
    sum += d * d;
  }
  return std::sqrt(sum / static_cast<double>(observations.size()));
}

void turn_axes(fvv_camera &c) {
  for (int row = 1; row < 3; row++) {
    for (int column = 0; column < 3; column++) c.rotation[3 * row + column] *= -1;
    c.translation[row] *= -1;
  }
}

void invert(fvv_camera &c) {
  double centre[3];
  fvv_camera_centre(&c, centre);
  std::copy(centre, centre + 3, c.translation);
  for (int row = 0; row < 3; row++)
    for (int column = 0; column < row; column++)
      std::swap(c.rotation[3 * row + column], c.rotation[3 * column + row]);
}

// The way back from one variant of a mistake. False when the camera cannot have suffered from it.
using Undo = bool (*)(fvv_camera &);

bool undo_axes(fvv_camera &c) {
  turn_axes(c);
  return true;
}
template <bool Before, bool After> bool undo_inverse(fvv_camera &c) {
  if (Before) turn_axes(c);
  invert(c);
  if (After) turn_axes(c);
  return true;
}
template <int Halves> bool undo_half_pixel(fvv_camera &c) {
  c.cx += 0.5 * Halves;
  c.cy += 0.5 * Halves;
  return true;
}

// The true places of p1, p2 and k3 in the list that should be k1 k2 p1 p2 k3 k4 k5 k6.
template <int P1, int P2, int K3> bool undo_distortion(fvv_camera &c) {
  if (c.lens != FVV_LENS_RADTAN) return false;
  const double *d = c.distortion;
  const double p1 = d[P1], p2 = d[P2], k3 = d[K3];
  if (p1 == d[2] && p2 == d[3] && k3 == d[4]) return false;
  c.distortion[2] = p1;
  c.distortion[3] = p2;
  c.distortion[4] = k3;
  c.r_max = fvv_camera_r_max(&c);
  return true;
}

struct Variant {
  Mistake mistake;
  Undo undo;
};
constexpr Variant variants[] = {{Mistake::axes, undo_axes},
                                {Mistake::inverse, undo_inverse<false, false>},
                                {Mistake::inverse, undo_inverse<true, true>},
                                {Mistake::inverse_and_axes, undo_inverse<true, false>},
                                {Mistake::inverse_and_axes, undo_inverse<false, true>},
                                {Mistake::half_pixel, undo_half_pixel<1>},
                                {Mistake::half_pixel, undo_half_pixel<-1>},
                                {Mistake::distortion, undo_distortion<3, 4, 2>},
                                {Mistake::distortion, undo_distortion<4, 2, 3>},
                                {Mistake::distortion, undo_distortion<3, 2, 4>}};

std::optional<Mistake> suspect(const Diagnosis &diagnosis) {
  if (!(diagnosis.rms > negligible)) return std::nullopt;
  size_t best = mistake_count;
  for (size_t i = 0; i < mistake_count; i++)
    if (!std::isnan(diagnosis.undone[i]) &&
        (best == mistake_count || diagnosis.undone[i] < diagnosis.undone[best]))
      best = i;
  if (best == mistake_count || !(diagnosis.undone[best] <= much_better * diagnosis.rms)) return std::nullopt;
  for (size_t i = 0; i < mistake_count; i++)
    if (i != best && diagnosis.undone[best] > clearly_first * diagnosis.undone[i]) return std::nullopt;
  return static_cast<Mistake>(best);
}

} // namespace

const char *name_of(Mistake mistake) {
  constexpr const char *names[mistake_count] = {"axes", "inverse", "inverse_and_axes", "half_pixel",
                                                "distortion"};
  return names[static_cast<size_t>(mistake)];
}

const char *description_of(Mistake mistake) {
  constexpr const char *texts[mistake_count] = {
      "the camera axes are OpenGL's where OpenCV's are expected, or the reverse",
      "the pose goes from the camera to the world where the reverse is expected, or the reverse",
      "the pose is inverted and its camera axes are OpenGL's where OpenCV's are expected, or the reverse",
      "the principal point, or the points, count pixel centres half a pixel off",
      "the coefficients of the lens are in another order (k1 k2 p1 p2 k3 is expected)"};
  return texts[static_cast<size_t>(mistake)];
}

std::vector<Observation> read_observations(const std::string &path,
                                           const std::vector<scene::Camera> &cameras) {
  const std::string bytes = scene::read_file(path, max_text_size);
  Lines lines(bytes, path);
  std::vector<Observation> observations;
  for (std::string_view line; lines.next_content(line);) {
    const auto words = words_of(line);
    if (words.size() != 6)
      lines.fail("expected X Y Z CAMERA_ID U V, found " + std::to_string(words.size()) + " words");
    Observation o;
    for (size_t i = 0; i < 3; i++) o.world[i] = lines.real(words[i], "X Y Z");
    o.camera = static_cast<uint16_t>(lines.integer(words[3], "CAMERA_ID", 0, UINT16_MAX - 1));
    for (size_t i = 0; i < 2; i++) o.pixel[i] = lines.real(words[4 + i], "U V");
    if (std::none_of(cameras.begin(), cameras.end(),
                     [&](const auto &c) { return c.calibration.id == o.camera; }))
      lines.fail("expected the id of a camera of the calibration, found " + std::to_string(o.camera));
    observations.push_back(o);
  }
  if (observations.size() < min_observations)
    throw Error(path + ": expected at least " + std::to_string(min_observations) + " points, found " +
                std::to_string(observations.size()));
  return observations;
}

Diagnosis diagnose(const std::vector<scene::Camera> &cameras, const std::vector<Observation> &given) {
  std::vector<Observation> observations = given;
  Cameras models;
  for (size_t i = 0; i < cameras.size(); i++) {
    models.push_back(cameras[i].calibration);
    for (size_t k = 0; k < given.size(); k++)
      if (given[k].camera == models[i].id) observations[k].camera = static_cast<uint16_t>(i);
  }
  Diagnosis diagnosis;
  diagnosis.points = observations.size();
  diagnosis.rms = rms(models, observations);
  std::vector<double> squares(models.size());
  std::vector<size_t> counts(models.size());
  for (const Observation &o : observations) {
    bool visible;
    const double d = distance(models[o.camera], o, &visible);
    diagnosis.max = std::max(diagnosis.max, d);
    diagnosis.invisible += !visible;
    squares[o.camera] += d * d;
    counts[o.camera]++;
  }
  for (size_t i = 0; i < models.size(); i++) // 0 / 0 is the documented NaN
    diagnosis.rms_of_camera.push_back(std::sqrt(squares[i] / static_cast<double>(counts[i])));
  diagnosis.undone.fill(std::numeric_limits<double>::quiet_NaN());
  for (const Variant &variant : variants) {
    Cameras changed = models;
    bool possible = false;
    for (fvv_camera &camera : changed) possible = variant.undo(camera) || possible;
    double &best = diagnosis.undone[static_cast<size_t>(variant.mistake)];
    if (possible) best = std::fmin(best, rms(changed, observations));
  }
  diagnosis.suspected = suspect(diagnosis);
  return diagnosis;
}

} // namespace fvv::import
