#include "fvv_render/held_out.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace fvv::render {

namespace {

// Odd, so that centres of pixels meet, and no longer than a side.
uint32_t stride_of(const fvv_camera &camera, size_t most_pixels) {
  const double pixels = double(camera.width) * camera.height;
  const double stride =
      std::min({std::sqrt(pixels / double(most_pixels)), double(camera.width), double(camera.height)});
  return 2 * uint32_t((stride - 1) / 2 + 0.25) + 1;
}

// A camera with a picture whose pixel (x, y) has its centre on the centre of the middle one of the source's
// stride x stride pixels.
fvv_camera thinned(const fvv_camera &source, uint32_t stride) {
  fvv_camera camera = source;
  camera.width = source.width / stride;
  camera.height = source.height / stride;
  camera.fx /= stride;
  camera.skew /= stride;
  camera.cx /= stride;
  camera.fy /= stride;
  camera.cy /= stride;
  return camera;
}

template <class Value> double luma_of(const Value *rgb) {
  return 0.2126 * double(rgb[0]) + 0.7152 * double(rgb[1]) + 0.0722 * double(rgb[2]);
}

constexpr double grey = 0.5;
constexpr uint32_t reach = 5; // of a window of SSIM

// A Gaussian of 11 x 11 pixels, standard deviation 1.5; the picture shrinks by 10 on each axis.
class Gaussian {
public:
  Gaussian(uint32_t columns, uint32_t rows) : width(columns), height(rows) {
    double sum = 0;
    for (uint32_t i = 0; i <= 2 * reach; i++) {
      const double off = (double(i) - reach) / 1.5;
      sum += taps[i] = std::exp(-off * off / 2);
    }
    for (double &tap : taps) tap /= sum;
  }

  std::vector<double> operator()(const std::vector<double> &picture) const {
    const uint32_t columns = width - 2 * reach, rows = height - 2 * reach;
    std::vector<double> across(size_t(columns) * height), out(size_t(columns) * rows);
    for (uint32_t y = 0; y < height; y++)
      for (uint32_t x = 0; x < columns; x++)
        for (uint32_t i = 0; i <= 2 * reach; i++)
          across[size_t(y) * columns + x] += taps[i] * picture[size_t(y) * width + x + i];
    for (uint32_t y = 0; y < rows; y++)
      for (uint32_t x = 0; x < columns; x++)
        for (uint32_t i = 0; i <= 2 * reach; i++)
          out[size_t(y) * columns + x] += taps[i] * across[size_t(y + i) * columns + x];
    return out;
  }

private:
  const uint32_t width, height;
  double taps[2 * reach + 1];
};

// Both are luma 0..1, and the same where no pixel counts.
void add_similarity(const std::vector<double> &a, const std::vector<double> &b,
                    const std::vector<size_t> &compared, uint32_t width, uint32_t height, ViewScore &score) {
  if (width <= 2 * reach || height <= 2 * reach) return;
  const Gaussian blurred(width, height);
  const auto product_of = [](const std::vector<double> &p, const std::vector<double> &q) {
    std::vector<double> out(p.size());
    for (size_t i = 0; i < p.size(); i++) out[i] = p[i] * q[i];
    return out;
  };
  const std::vector<double> mean_a = blurred(a), mean_b = blurred(b), square_a = blurred(product_of(a, a)),
                            square_b = blurred(product_of(b, b)), both = blurred(product_of(a, b));
  constexpr double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
  for (const size_t pixel : compared) {
    const size_t x = pixel % width, y = pixel / width;
    if (x < reach || y < reach || x >= width - reach || y >= height - reach) continue;
    const size_t at = (y - reach) * (width - 2 * reach) + x - reach;
    const double means = mean_a[at] * mean_b[at], squares = mean_a[at] * mean_a[at] + mean_b[at] * mean_b[at];
    score.similarity += (2 * means + c1) * (2 * (both[at] - means) + c2) /
                        ((squares + c1) * (square_a[at] + square_b[at] - squares + c2));
    score.windows++;
  }
}

// A picture that drawn ones are compared with, at some of its pixels.
struct Truth {
  uint32_t width = 0, height = 0;
  std::vector<double> rgb; // three a pixel
  std::vector<size_t> compared;

  ViewScore score(const ViewPicture &picture, bool similarity) const {
    ViewScore out;
    std::vector<double> a(similarity ? size_t(width) * height : 0, grey), b = a;
    for (const size_t at : compared) {
      const float *drawn = &picture.rgb[3 * at];
      const double *truth = &rgb[3 * at];
      for (size_t k = 0; k < 3; k++) {
        const double difference = double(drawn[k]) - truth[k];
        out.squares += difference * difference;
      }
      const double luma = luma_of(drawn), true_luma = luma_of(truth);
      out.luma += (luma - true_luma) * (luma - true_luma);
      if (!similarity) continue;
      a[at] = luma;
      b[at] = true_luma;
    }
    out.pixels = compared.size();
    if (similarity) add_similarity(a, b, compared, width, height, out);
    return out;
  }
};

Vec3 centre_of(const fvv_camera &camera) {
  double at[3];
  fvv_camera_centre(&camera, at);
  return {at[0], at[1], at[2]};
}

Vec3 middle_of(const Mesh &mesh) {
  Vec3 low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};
  for (size_t i = 0; i < mesh.vertex_count; i++) {
    const float *p = mesh.positions + 3 * i;
    low = {std::min(low.x, double(p[0])), std::min(low.y, double(p[1])), std::min(low.z, double(p[2]))};
    high = {std::max(high.x, double(p[0])), std::max(high.y, double(p[1])), std::max(high.z, double(p[2]))};
  }
  return (low + high) * 0.5;
}

// Half-way from a to b on the way around the middle, as a's camera without lens that is turned half-way too.
fvv_camera half_way(const fvv_camera &a, const fvv_camera &b, const Vec3 &middle) {
  fvv_camera out = a;
  out.lens = FVV_LENS_NONE;
  out.r_max = std::numeric_limits<double>::infinity();
  const auto axis = [](const fvv_camera &camera, size_t row) {
    const double *r = camera.rotation + 3 * row;
    return Vec3{r[0], r[1], r[2]};
  };
  const Vec3 z = normalised(axis(a, 2) + axis(b, 2)), down = axis(a, 1) + axis(b, 1),
             x = normalised(cross(down, z)), y = cross(z, x);
  const Vec3 from_a = centre_of(a) - middle, from_b = centre_of(b) - middle;
  const Vec3 eye =
      middle + normalised(normalised(from_a) + normalised(from_b)) * ((length(from_a) + length(from_b)) / 2);
  const double rotation[9] = {x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z};
  std::copy_n(rotation, 9, out.rotation);
  const double translation[3] = {-dot(x, eye), -dot(y, eye), -dot(z, eye)};
  std::copy_n(translation, 3, out.translation);
  return out;
}

// Each camera of a frame with the one whose direction from the middle is nearest, each pair once. Those that
// are opposite to each other have nothing between them.
std::set<std::pair<size_t, size_t>> neighbours(const HeldOutFrame &frame, const Vec3 &middle) {
  constexpr double opposite = -0.5; // cosine
  std::set<std::pair<size_t, size_t>> out;
  for (size_t i = 0; i < frame.views.size(); i++) {
    const Vec3 direction = normalised(centre_of(frame.views[i].source.camera) - middle);
    double best = opposite;
    size_t nearest = i;
    for (size_t k = 0; k < frame.views.size(); k++) {
      const double cosine = dot(direction, normalised(centre_of(frame.views[k].source.camera) - middle));
      if (k == i || !(cosine > best)) continue;
      best = cosine;
      nearest = k;
    }
    if (nearest != i) out.insert(std::minmax(i, nearest));
  }
  return out;
}

} // namespace

void ViewScore::add(const ViewScore &other) {
  squares += other.squares;
  luma += other.luma;
  pixels += other.pixels;
  similarity += other.similarity;
  windows += other.windows;
}

double ViewScore::psnr() const {
  return luma > 0 ? -10 * std::log10(luma_error()) : std::numeric_limits<double>::infinity();
}

double loss_db(double finest, double error) {
  if (error == finest) return 0;
  return 10 * std::log10(error / finest);
}

DrawnFrames::DrawnFrames(const std::vector<HeldOutFrame> &frames, ViewOptions options) {
  options.samples = 1;
  options.environment = nullptr;
  options.keep_visibility = false;
  options.background = {grey, grey, grey};
  for (const HeldOutFrame &frame : frames) {
    std::vector<SourceView> sources;
    for (const HeldOutView &view : frame.views) sources.push_back(view.source);
    renderers.push_back(
        std::make_unique<const ViewRenderer>(frame.mesh, std::vector<Vec3>(), std::move(sources), options));
  }
}

// A camera that is drawn from the others of its frame.
class ViewMeasure::Camera {
public:
  Camera(const HeldOutView &view, size_t of_frame, uint32_t index, const DrawnFrames &finest, size_t most)
      : frame(of_frame), place(index) {
    const fvv_camera &source = view.source.camera;
    const uint32_t stride = stride_of(source, most);
    camera = thinned(source, stride);
    const ViewPicture picture = finest[frame].render(camera, place, 0);
    truth.width = camera.width;
    truth.height = camera.height;
    truth.rgb.resize(3 * size_t(camera.width) * camera.height);
    for (uint32_t y = 0; y < camera.height; y++)
      for (uint32_t x = 0; x < camera.width; x++) {
        const size_t at = size_t(y) * camera.width + x;
        const size_t pixel = (size_t(y) * stride + stride / 2) * source.width + x * stride + stride / 2;
        if (picture.contributions[at * picture.best].source == no_source) continue;
        if (view.mask && view.mask[pixel] <= 127) continue;
        truth.compared.push_back(at);
        for (size_t k = 0; k < 3; k++)
          truth.rgb[3 * at + k] = view.source.wide_pixels ? double(view.source.wide_pixels[3 * pixel + k])
                                                          : view.source.pixels[3 * pixel + k] / 65535.0;
      }
  }

  size_t pixels() const { return truth.compared.size(); }
  ViewScore score(const DrawnFrames &drawn, std::optional<double> inset, bool similarity) const {
    return truth.score(drawn[frame].render(camera, place, inset), similarity);
  }

private:
  const size_t frame;
  const uint32_t place;
  fvv_camera camera;
  Truth truth;
};

ViewMeasure::ViewMeasure(const std::vector<HeldOutFrame> &frames, const DrawnFrames &finest, size_t most) {
  for (size_t k = 0; k < frames.size(); k++)
    for (uint32_t i = 0; i < frames[k].views.size(); i++)
      cameras.emplace_back(frames[k].views[i], k, i, finest, most);
}

ViewMeasure::~ViewMeasure() = default;

size_t ViewMeasure::pixels() const {
  size_t sum = 0;
  for (const Camera &camera : cameras) sum += camera.pixels();
  return sum;
}

std::vector<ViewScore> ViewMeasure::held_out(const DrawnFrames &drawn, std::optional<double> inset,
                                             bool similarity) const {
  std::vector<ViewScore> out;
  for (const Camera &camera : cameras) out.push_back(camera.score(drawn, inset, similarity));
  return out;
}

ViewScore ViewMeasure::held_out_sum(const DrawnFrames &drawn) const {
  ViewScore sum;
  for (const ViewScore &score : held_out(drawn)) sum.add(score);
  return sum;
}

// A place between two cameras, with what the finest show there.
class BetweenMeasure::Place {
public:
  Place(const fvv_camera &at, size_t of_frame, const DrawnFrames &finest, size_t most)
      : frame(of_frame), camera(thinned(at, stride_of(at, most))) {
    const ViewPicture picture = finest[frame].render(camera);
    truth.width = camera.width;
    truth.height = camera.height;
    truth.rgb.assign(picture.rgb.begin(), picture.rgb.end());
    for (size_t i = 0; i < picture.face.size(); i++)
      if (picture.contributions[i * picture.best].source != no_source) truth.compared.push_back(i);
  }

  ViewScore score(const DrawnFrames &drawn) const { return truth.score(drawn[frame].render(camera), true); }

private:
  const size_t frame;
  const fvv_camera camera;
  Truth truth;
};

BetweenMeasure::BetweenMeasure(const std::vector<HeldOutFrame> &frames, const DrawnFrames &finest,
                               size_t most) {
  for (size_t k = 0; k < frames.size(); k++) {
    const Vec3 middle = middle_of(frames[k].mesh);
    for (const auto &[a, b] : neighbours(frames[k], middle))
      places.emplace_back(
          half_way(frames[k].views[a].source.camera, frames[k].views[b].source.camera, middle), k, finest,
          most);
  }
}

BetweenMeasure::~BetweenMeasure() = default;

ViewScore BetweenMeasure::score(const DrawnFrames &drawn) const {
  ViewScore sum;
  for (const Place &place : places) sum.add(place.score(drawn));
  return sum;
}

} // namespace fvv::render
