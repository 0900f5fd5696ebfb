#include "fvvcompare/measure.h"

#include <algorithm>
#include <optional>

namespace fvv::compare {

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
                    Direction &out) {
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

void point_errors(const Cloud &from, const Cloud &to, Direction &out) {
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
  surface_errors(a, of_a, b, out.forth);
  surface_errors(b, of_b, a, out.back);
  const Cloud cloud_a(a, of_a, points), cloud_b(b, of_b, points);
  point_errors(cloud_a, cloud_b, out.forth);
  point_errors(cloud_b, cloud_a, out.back);
  return out;
}

} // namespace fvv::compare
