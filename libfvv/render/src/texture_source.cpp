#include "texture_source.h"

#include <algorithm>

namespace fvv::render {

TextureSource::TextureSource(const SourceView &source, const Mesh &mesh, const RayCaster &caster,
                             const ViewOptions &options)
    : view(source), rays(caster), margin(options.margin), visibility(options.visibility) {
  if (visibility == Visibility::given && !view.visible_faces && !view.visible_vertices)
    visibility = Visibility::depth_map;
  double centre[3];
  fvv_camera_centre(&view.camera, centre);
  place = {centre[0], centre[1], centre[2]};
  if (visibility != Visibility::depth_map) return;
  map.emplace(view.camera, mesh, options.depth_test);
  if (map->too_wide()) visibility = Visibility::rays;
}

bool TextureSource::shows(const SurfacePoint &point, double at[2]) const {
  const double world[3] = {point.position.x, point.position.y, point.position.z};
  if (!fvv_camera_project(&view.camera, world, at, nullptr)) return false;
  if (!(at[0] >= margin && at[1] >= margin && at[0] <= view.camera.width - margin &&
        at[1] <= view.camera.height - margin))
    return false;
  if (visibility == Visibility::given && view.visible_faces) return view.visible_faces[point.face] != 0;
  if (!(dot(point.face_normal, place - point.position) > 0)) return false;
  if (visibility == Visibility::given) {
    double seen = 0;
    for (size_t i = 0; i < 3; i++) seen += view.visible_vertices[point.vertices[i]] * point.barycentric[i];
    return seen >= 127.5;
  }
  if (visibility == Visibility::rays) return !hidden_by_rays(place, point.position, point.face, rays);
  return !map->hidden(point.position, point.face_normal);
}

Vec3 TextureSource::colour(const double at[2]) const {
  const uint32_t width = view.camera.width, height = view.camera.height;
  const double x = std::clamp(at[0] - 0.5, 0.0, width - 1.0), y = std::clamp(at[1] - 0.5, 0.0, height - 1.0);
  const auto left = uint32_t(x), top = uint32_t(y);
  const uint32_t right = std::min(left + 1, width - 1), bottom = std::min(top + 1, height - 1);
  const auto texel = [&](uint32_t column, uint32_t row) {
    const size_t at_pixel = 3 * (size_t(row) * width + column);
    const auto vector = [](const auto *p) { return Vec3{double(p[0]), double(p[1]), double(p[2])}; };
    return view.wide_pixels ? vector(view.wide_pixels + at_pixel) : vector(view.pixels + at_pixel);
  };
  const Vec3 upper = mix(texel(left, top), texel(right, top), x - left),
             lower = mix(texel(left, bottom), texel(right, bottom), x - left);
  return mix(upper, lower, y - top) * (view.wide_pixels ? 1 : 1.0 / 65535);
}

} // namespace fvv::render
