// Gains of cameras from the light that they show at the same places.
#include "fvv_render/colour_match.h"

#include "fvv_render/normals.h"
#include "fvv_render/scene_lengths.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace fvv::render {

namespace {

constexpr double extent = 4;          // of the scaled surface: a person in metres
constexpr uint32_t depth_side = 1024; // pixels of the depth map
constexpr int depth_margin = 2;       // its pixels around a place that show the same surface
constexpr double depth_slack = 4;     // times depth_margin pixels at that distance; 60 degrees recede by 1.7
constexpr int mask_margin = 4;        // pixels of the picture, where matting leaves soft edges
constexpr int window = 1;             // pixels of the picture on each side, of which the mean is taken
constexpr uint8_t darkest = 20, brightest = 245; // display values that count
constexpr double least_cosine = 0.5;

constexpr size_t least_shared = 48;  // places of a pair of cameras
constexpr double systematic = 0.02;  // by which a pair errs however many places it shares
constexpr double independent = 0.25; // of places: neighbours show the same
constexpr double most_error = 0.05;  // of a pair's ratio: pairs with few places, or unlike ones, say nothing
constexpr double likely = 0.03;      // a pair that differs more from the others counts less
constexpr int rounds = 20;
constexpr double settled = 1e-5;
constexpr double most_gain = 4;     // two stops: what differs more is no picture of the same light
constexpr double gain_steps = 1024; // in 1

fvv_camera scaled(const fvv_camera &source, Vec3 origin, double scale) {
  fvv_camera camera = source;
  const double *r = source.rotation, from[3] = {origin.x, origin.y, origin.z};
  for (int i = 0; i < 3; i++) {
    camera.translation[i] = source.translation[i];
    for (int k = 0; k < 3; k++) camera.translation[i] += r[3 * i + k] * from[k];
    camera.translation[i] *= scale;
  }
  const double side = std::min(1.0, double(depth_side) / std::max(source.width, source.height));
  camera.width = std::max<uint32_t>(1, uint32_t(source.width * side));
  camera.height = std::max<uint32_t>(1, uint32_t(source.height * side));
  const double x = double(camera.width) / source.width, y = double(camera.height) / source.height;
  camera.fx *= x;
  camera.skew *= x;
  camera.cx *= x;
  camera.fy *= y;
  camera.cy *= y;
  return camera;
}

// Whether only the surface around the place shows there. z: of the place.
bool alone(const SampleBuffer &buffer, double u, double v, double z, double focal) {
  const auto column = long(std::floor(u)), row = long(std::floor(v));
  if (column < depth_margin || row < depth_margin || column + depth_margin >= long(buffer.width) ||
      row + depth_margin >= long(buffer.height))
    return false;
  const double slack = depth_slack * depth_margin * z / focal;
  for (long y = row - depth_margin; y <= row + depth_margin; y++)
    for (long x = column - depth_margin; x <= column + depth_margin; x++)
      if (!(std::abs(double(buffer.depth[size_t(y) * buffer.columns + size_t(x)]) - z) <= slack))
        return false;
  return true;
}

bool in_mask(const MatchView &view, long column, long row) {
  if (!view.mask) return true;
  for (long y = row - mask_margin; y <= row + mask_margin; y += mask_margin / 2)
    for (long x = column - mask_margin; x <= column + mask_margin; x += mask_margin / 2)
      if (x < 0 || y < 0 || x >= long(view.camera.width) || y >= long(view.camera.height) ||
          view.mask[size_t(y) * view.camera.width + size_t(x)] <= 127)
        return false;
  return true;
}

// The mean over the window; 0 in channels with pixels that do not count.
void mean_light(const MatchView &view, long column, long row, float *out) {
  const long left = column - window, top = row - window, right = column + window, bottom = row + window;
  if (left < 0 || top < 0 || right >= long(view.camera.width) || bottom >= long(view.camera.height)) return;
  double sum[3] = {0, 0, 0};
  bool usable[3] = {true, true, true};
  for (long y = top; y <= bottom; y++)
    for (long x = left; x <= right; x++) {
      const uint8_t *pixel = view.pixels + 3 * (size_t(y) * view.camera.width + size_t(x));
      for (int k = 0; k < 3; k++) {
        sum[k] += double(view.linear[pixel[k]]);
        usable[k] = usable[k] && pixel[k] <= brightest;
      }
    }
  constexpr double count = (2 * window + 1) * (2 * window + 1);
  for (int k = 0; k < 3; k++)
    if (usable[k] && sum[k] >= count * double(view.linear[darkest])) out[k] = float(sum[k] / count);
}

// What two cameras say of each other.
struct Pair {
  size_t a, b;
  double ratio;  // logarithm of b's light over a's
  double weight; // by the number of places and how far these agree
};

double median(std::vector<double> &values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<Pair> pairs_of(const std::vector<std::vector<PlaceLight>> &frames, size_t cameras,
                           size_t channel) {
  std::vector<Pair> pairs;
  std::vector<double> ratios;
  for (size_t a = 0; a < cameras; a++)
    for (size_t b = a + 1; b < cameras; b++) {
      ratios.clear();
      for (const std::vector<PlaceLight> &frame : frames)
        for (size_t i = channel; i < std::min(frame[a].size(), frame[b].size()); i += 3)
          if (frame[a][i] > 0 && frame[b][i] > 0) ratios.push_back(double(frame[b][i]) / double(frame[a][i]));
      if (ratios.size() < least_shared) continue;
      const double ratio = median(ratios);
      for (double &one : ratios) one = std::abs(one / ratio - 1);
      const double spread = 1.5 * median(ratios); // a standard deviation
      const double error = 1.25 * spread / std::sqrt(independent * double(ratios.size()));
      if (error > most_error) continue;
      pairs.push_back({a, b, std::log(ratio), 1 / (systematic * systematic + error * error)});
    }
  return pairs;
}

// The set of each camera: those that are connected by pairs.
std::vector<size_t> sets_of(const std::vector<Pair> &pairs, size_t cameras) {
  std::vector<size_t> sets(cameras);
  for (size_t i = 0; i < cameras; i++) sets[i] = i;
  for (const Pair &pair : pairs) {
    const size_t from = std::max(sets[pair.a], sets[pair.b]), to = std::min(sets[pair.a], sets[pair.b]);
    std::replace(sets.begin(), sets.end(), from, to);
  }
  return sets;
}

// Gauss-Jordan elimination with pivots; m is n x (n + 1).
std::vector<double> solved(std::vector<double> m, size_t n) {
  const auto at = [&](size_t row, size_t column) -> double & { return m[row * (n + 1) + column]; };
  for (size_t k = 0; k < n; k++) {
    size_t pivot = k;
    for (size_t row = k + 1; row < n; row++)
      if (std::abs(at(row, k)) > std::abs(at(pivot, k))) pivot = row;
    for (size_t column = k; column <= n; column++) std::swap(at(k, column), at(pivot, column));
    for (size_t row = 0; row < n; row++) {
      if (row == k || at(row, k) == 0) continue;
      const double factor = at(row, k) / at(k, k);
      for (size_t column = k; column <= n; column++) at(row, column) -= factor * at(k, column);
    }
  }
  std::vector<double> out(n);
  for (size_t k = 0; k < n; k++) out[k] = at(k, n) / at(k, k);
  return out;
}

// The logarithm of each camera's light over the mean of its set: least squares, in which pairs that differ
// count in proportion to 1 over the difference (Huber).
std::vector<double> levels_of(const std::vector<Pair> &pairs, size_t cameras) {
  std::vector<double> levels(cameras);
  const std::vector<size_t> sets = sets_of(pairs, cameras);
  for (int round = 0; round < rounds; round++) {
    std::vector<double> m(cameras * (cameras + 1));
    const auto at = [&](size_t row, size_t column) -> double & { return m[row * (cameras + 1) + column]; };
    for (const Pair &pair : pairs) {
      const double off = std::abs(pair.ratio - (levels[pair.b] - levels[pair.a]));
      const double weight = round && off > likely ? pair.weight * likely / off : pair.weight;
      at(pair.a, pair.a) += weight;
      at(pair.b, pair.b) += weight;
      at(pair.a, pair.b) -= weight;
      at(pair.b, pair.a) -= weight;
      at(pair.a, cameras) -= weight * pair.ratio;
      at(pair.b, cameras) += weight * pair.ratio;
    }
    // The equations of a set leave its mean open; with these terms it is 0.
    for (size_t a = 0; a < cameras; a++)
      for (size_t b = 0; b < cameras; b++)
        if (sets[a] == sets[b]) at(a, b) += 1;
    std::vector<double> next = solved(std::move(m), cameras);
    double moved = 0;
    for (size_t i = 0; i < cameras; i++) moved = std::max(moved, std::abs(next[i] - levels[i]));
    levels = std::move(next);
    if (moved < settled) break;
  }
  return levels;
}

// Places that each camera shares with any other.
std::vector<size_t> shared_places(const std::vector<std::vector<PlaceLight>> &frames, size_t cameras) {
  std::vector<size_t> shared(cameras);
  const auto shows = [](const PlaceLight &light, size_t i) {
    return i + 2 < light.size() && (light[i] > 0 || light[i + 1] > 0 || light[i + 2] > 0);
  };
  for (const std::vector<PlaceLight> &frame : frames) {
    size_t size = 0;
    for (const PlaceLight &light : frame) size = std::max(size, light.size());
    for (size_t i = 0; i < size; i += 3) {
      size_t count = 0;
      for (const PlaceLight &light : frame) count += shows(light, i);
      for (size_t camera = 0; camera < cameras && count > 1; camera++)
        shared[camera] += shows(frame[camera], i);
    }
  }
  return shared;
}

} // namespace

MatchSurface::MatchSurface(const std::vector<double> &from, std::vector<uint32_t> indices)
    : scale(1), faces(std::move(indices)) {
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (size_t i = 0; i < from.size(); i++) {
    low[i % 3] = std::min(low[i % 3], from[i]);
    high[i % 3] = std::max(high[i % 3], from[i]);
  }
  if (from.empty()) return;
  origin = {(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2};
  const double size = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
  if (size > 0) scale = extent / size;
  positions.reserve(from.size());
  for (size_t i = 0; i < from.size(); i++)
    positions.push_back(float((from[i] - axis_of(origin, int(i % 3))) * scale));
  const std::vector<Vec3> all = vertex_normals(mesh());
  const size_t step = (all.size() + match_places - 1) / match_places;
  for (size_t v = 0; v < all.size(); v += step) {
    places.push_back(uint32_t(v));
    normals.push_back(all[v]);
  }
}

PlaceLight MatchSurface::light(const MatchView &view) const {
  const fvv_camera camera = scaled(view.camera, origin, scale);
  const Projection projection(camera);
  SampleBuffer buffer(camera.width, camera.height, 1);
  rasterise(projection, mesh(), buffer);
  const double to_column = double(view.camera.width) / camera.width,
               to_row = double(view.camera.height) / camera.height;
  const Vec3 centre = projection.centre();
  const double nearest = near_plane(mesh());
  PlaceLight out(3 * places.size());
  for (size_t i = 0; i < places.size(); i++) {
    const float *p = &positions[3 * size_t(places[i])];
    const Vec3 place = {double(p[0]), double(p[1]), double(p[2])}, local = projection.to_camera(place);
    if (!(local.z > nearest) || !(dot(normals[i], normalised(centre - place)) >= least_cosine)) continue;
    const Vec3 pixel = projection.to_pixel(local);
    const double u = pixel.x / pixel.z, v = pixel.y / pixel.z;
    if (!(u >= 0 && v >= 0 && u < camera.width && v < camera.height)) continue;
    if (!alone(buffer, u, v, local.z, std::min(camera.fx, camera.fy))) continue;
    const auto column = long(u * to_column), row = long(v * to_row);
    if (in_mask(view, column, row)) mean_light(view, column, row, &out[3 * i]);
  }
  return out;
}

double ColourMatch::departure() const {
  double most = 0;
  for (const CameraMatch &camera : cameras)
    for (const double gain : camera.gain) most = std::max(most, std::max(gain, 1 / gain) - 1);
  return most;
}

ColourMatch match_colours(const std::vector<std::vector<PlaceLight>> &frames) {
  ColourMatch out;
  const size_t cameras = frames.empty() ? 0 : frames[0].size();
  for (const std::vector<PlaceLight> &frame : frames)
    if (frame.size() != cameras) throw std::invalid_argument("match_colours: frames differ in their cameras");
  out.cameras.resize(cameras);
  double before = 0, after = 0, count = 0;
  std::vector<size_t> channels(cameras); // of which it has a partner
  for (size_t channel = 0; channel < 3; channel++) {
    const std::vector<Pair> pairs = pairs_of(frames, cameras, channel);
    const std::vector<double> levels = levels_of(pairs, cameras);
    std::vector<uint8_t> paired(cameras);
    for (const Pair &pair : pairs) paired[pair.a] = paired[pair.b] = 1;
    for (size_t i = 0; i < cameras; i++) {
      const double gain = std::clamp(std::exp(-levels[i]), 1 / most_gain, most_gain);
      out.cameras[i].gain[channel] = std::round(gain_steps * gain) / gain_steps;
      channels[i] += paired[i];
    }
    for (const Pair &pair : pairs) {
      const double left = pair.ratio - (levels[pair.b] - levels[pair.a]);
      before += pair.ratio * pair.ratio;
      after += left * left;
    }
    count += double(pairs.size());
  }
  const std::vector<size_t> shared = shared_places(frames, cameras);
  for (size_t i = 0; i < cameras; i++) {
    CameraMatch &camera = out.cameras[i];
    camera.places = shared[i];
    camera.matched = channels[i] == 3;
    if (!camera.matched) camera.gain[0] = camera.gain[1] = camera.gain[2] = 1;
  }
  if (count > 0) {
    out.before = std::sqrt(before / count);
    out.after = std::sqrt(after / count);
  }
  return out;
}

} // namespace fvv::render
