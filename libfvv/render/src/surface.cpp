#include "surface.h"

#include "fvv_render/scene_lengths.h"

namespace fvv::render {

Surface::Surface(const fvv_camera &target, const Mesh &drawn, const RayCaster *caster, uint32_t samples)
    : projection(target), mesh(drawn), rays(caster), n(samples) {
  if (rays) {
    nearest = near_plane(mesh);
    return;
  }
  buffer.emplace(target.width, target.height, samples);
  rasterise(projection, mesh, *buffer);
}

Hit Surface::at(uint32_t x, uint32_t y, uint32_t sample) const {
  const double u = x + (sample % n + 0.5) / n, v = y + (sample / n + 0.5) / n;
  if (rays) {
    // Of a ray with z = 1 the distance is the depth.
    const Vec3 ray = projection.to_world_direction(projection.ray(u, v));
    const RayHit hit =
        rays->nearest(projection.centre(), ray, nearest, std::numeric_limits<double>::infinity());
    if (hit.face == no_face) return {};
    return {hit.face, hit.barycentric, hit.distance};
  }
  const size_t i = (size_t(y) * n + sample / n) * buffer->columns + size_t(x) * n + sample % n;
  if (buffer->face[i] == no_face) return {};
  return {buffer->face[i], barycentric(projection, mesh, buffer->face[i], u, v), double(buffer->depth[i])};
}

} // namespace fvv::render
