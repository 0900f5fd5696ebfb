#include "compare/src/measure.h"

#include "fvv_geometry/surface.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

namespace fvv::compare {

namespace {

constexpr int dropped_bits = 52 - 10;

} // namespace

void Histogram::add(double value) {
  uint64_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  bins[uint32_t(bits >> dropped_bits)]++;
  total++;
}

void Histogram::add(const Histogram &other) {
  for (const auto &[bin, count] : other.bins) bins[bin] += count;
  total += other.total;
}

double Histogram::quantile(double share) const {
  const uint64_t rank = std::max<uint64_t>(1, uint64_t(std::ceil(share * double(total))));
  uint64_t seen = 0;
  for (const auto &[bin, count] : bins)
    if ((seen += count) >= rank) {
      const uint64_t bits = uint64_t(bin) << dropped_bits;
      double value;
      std::memcpy(&value, &bits, sizeof value);
      return value;
    }
  return 0;
}

void Spread::add(double value) {
  sum += value;
  squares += value * value;
  largest = std::max(largest, value);
  bins.add(value);
}

Figures Spread::figures() const {
  const double n = double(bins.count());
  if (n == 0) return {};
  return {std::sqrt(squares / n), sum / n, bins.quantile(0.99), largest};
}

namespace {

double degrees_between(Vec3 a, Vec3 b) {
  return std::atan2(length(cross(a, b)), dot(a, b)) * (180 / M_PI);
}

// Points with normals, and the nearest of them.
class Cloud {
public:
  Cloud(const Surface &of, const std::vector<Sample> &samples, Points kind) : surface(of) {
    if (kind == Points::vertices) return;
    points = of.points();
    normals = of.normals();
    for (const Sample &s : samples) {
      points.push_back(s.point);
      normals.push_back(of.smooth_normal(s.face, s.barycentric));
    }
    finder.emplace(as_triangles(points));
  }
  const std::vector<Vec3> &all() const { return finder ? points : surface.points(); }
  Vec3 normal(uint32_t i) const { return finder ? normals[i] : surface.normals()[i]; }
  render::ClosestPoint nearest(Vec3 from) const {
    return finder ? finder->nearest(from) : surface.nearest_vertex(from);
  }

private:
  const Surface &surface;
  std::vector<Vec3> points, normals; // with samples only
  std::optional<render::ClosestFinder> finder;
};

void surface_errors(const Surface &from, const std::vector<Sample> &samples, const Surface &to,
                    DirectedErrors &out) {
  size_t turned = 0;
  for (const Sample &s : samples) {
    const render::ClosestPoint hit = to.nearest(s.point);
    out.distance.add(std::sqrt(hit.squared));
    const Vec3 here = from.smooth_normal(s.face, s.barycentric),
               there = to.smooth_normal(hit.face, hit.barycentric);
    // Where normals cancel there is no angle.
    if (dot(here, here) > 0 && dot(there, there) > 0) out.angle.add(degrees_between(here, there));
    if (dot(from.face_normal(s.face), to.face_normal(hit.face)) < 0) turned++;
  }
  out.turned = double(turned) / double(samples.size());
  double furthest = 0;
  for (const Vec3 &p : from.points()) furthest = std::max(furthest, to.nearest(p).squared);
  out.hausdorff = std::max(out.distance.figures().max, std::sqrt(furthest));
}

void point_errors(const Cloud &from, const Cloud &to, DirectedErrors &out) {
  double d1 = 0, d2 = 0;
  for (const Vec3 &p : from.all()) {
    const render::ClosestPoint hit = to.nearest(p);
    const Vec3 normal = to.normal(hit.face);
    d1 += hit.squared;
    const double along = dot(p - hit.point, normal);
    d2 += dot(normal, normal) > 0 ? along * along : hit.squared;
  }
  out.d1 = d1 / double(from.all().size());
  out.d2 = d2 / double(from.all().size());
}

} // namespace

Measure measure(const Surface &a, const Surface &b, size_t samples, Points points) {
  const std::vector<Sample> of_a = a.sample(samples), of_b = b.sample(samples);
  Measure out;
  surface_errors(a, of_a, b, out.a_to_b);
  surface_errors(b, of_b, a, out.b_to_a);
  const Cloud cloud_a(a, of_a, points), cloud_b(b, of_b, points);
  point_errors(cloud_a, cloud_b, out.a_to_b);
  point_errors(cloud_b, cloud_a, out.b_to_a);
  return out;
}

namespace {

// The finder searches used vertices only: others may lie anywhere.
std::vector<bool> used_vertices(const geometry::Mesh &mesh) {
  std::vector<bool> used(mesh.vertex_count());
  for (const uint32_t v : mesh.faces) used[v] = true;
  return used;
}

} // namespace

Correspondence correspondence(const geometry::Mesh &a, const geometry::Mesh &b) {
  const std::vector<Vec3> in_a = positions_of(a), in_b = positions_of(b);
  const std::vector<bool> used_a = used_vertices(a), used_b = used_vertices(b);
  Correspondence out;
  out.of_a.resize(in_b.size());
  out.by_order = in_a.size() == in_b.size() && a.faces == b.faces;
  std::vector<uint32_t> candidates;
  std::vector<Vec3> places;
  for (uint32_t v = 0; v < in_a.size(); v++)
    if (used_a[v]) {
      candidates.push_back(v);
      places.push_back(in_a[v]);
    }
  const render::ClosestFinder finder(as_triangles(places));
  for (uint32_t v = 0; v < in_b.size(); v++) {
    if (!used_b[v]) continue;
    out.of_a[v] = out.by_order ? v : candidates[finder.nearest(in_b[v]).face];
    out.furthest = std::max(out.furthest, length(in_b[v] - in_a[out.of_a[v]]));
  }
  return out;
}

MotionError motion_error(const geometry::Mesh &a_before, const geometry::Mesh &a,
                         const geometry::Mesh &b_before, const geometry::Mesh &b,
                         const Correspondence &match) {
  const std::vector<Vec3> a0 = positions_of(a_before), a1 = positions_of(a), b0 = positions_of(b_before),
                          b1 = positions_of(b);
  const std::vector<bool> used = used_vertices(b);
  double squares = 0, largest = 0, motion = 0, count = 0;
  for (size_t v = 0; v < b1.size(); v++) {
    if (!used[v]) continue;
    const uint32_t w = match.of_a[v];
    const Vec3 ours = a1[w] - a0[w], difference = b1[v] - b0[v] - ours;
    const double square = dot(difference, difference);
    squares += square;
    largest = std::max(largest, square);
    motion += dot(ours, ours);
    count++;
  }
  return {std::sqrt(squares / count), std::sqrt(largest), std::sqrt(motion / count)};
}

} // namespace fvv::compare
