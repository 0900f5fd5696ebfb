// Pictures of a mesh, textured from the cameras that see each point best.
#include "fvv_render/view.h"

#include "blending.h"
#include "fvv_render/normals.h"
#include "surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace fvv::render {

namespace {

// The target camera, in the world.
struct Target {
  explicit Target(const fvv_camera &camera)
      : right{camera.rotation[0], camera.rotation[1], camera.rotation[2]}, up{-camera.rotation[3],
                                                                              -camera.rotation[4],
                                                                              -camera.rotation[5]} {
    double at[3];
    fvv_camera_centre(&camera, at);
    centre = {at[0], at[1], at[2]};
  }

  // What a surface without pictures is multiplied by, so that its shape can be seen: a lamp at the viewer's
  // left shoulder, and a sky above a darker ground.
  double light(const Vec3 &point, const Vec3 &normal) const {
    const Vec3 to_viewer = normalised(centre - point);
    const Vec3 n = dot(normal, to_viewer) < 0 ? normal * -1 : normal;
    const double lamp = std::max(0.0, dot(n, normalised(to_viewer + up * 0.6 - right * 0.5)));
    return 0.38 + 0.3 * (0.5 + 0.5 * dot(n, up)) + 0.62 * lamp;
  }

  Vec3 centre, right, up;
  double inset = 0; // of the surface that sources show
};

// Clause 17.5: of the surface to the viewer's ray, whose way to the inset would become too long.
constexpr double least_slope = 0.5;

struct SurfacePoint {
  uint32_t face = no_face;
  Vec3 position, face_normal; // the normal of any length
  Vec3 shown;                 // where sources show it
  std::array<uint32_t, 3> vertices = {};
  std::array<double, 3> barycentric = {};
};

class TextureSource {
public:
  // Borrows view's pixels and visibility, and rays.
  TextureSource(const SourceView &view, const Mesh &mesh, const RayCaster &rays, const ViewOptions &options);

  Vec3 centre() const { return place; }
  // How much of the point's visibility weight there is (visibility_factor); 1 without visibility weights.
  double visibility_weight(const SurfacePoint &point) const;
  // How well the picture shows the point, 0 to 1, its visibility weight aside; at: where, in the source's
  // pixels.
  double shows(const SurfacePoint &point, double at[2]) const;
  // Bilinear, display values, 1 for white; beyond the centres of the outermost pixels theirs.
  Vec3 colour(const double at[2]) const;

private:
  const SourceView view;
  const RayCaster &rays;
  const double margin;
  const Blend blend;
  Visibility visibility;
  Vec3 place;
  std::optional<DepthMap> map;
};

TextureSource::TextureSource(const SourceView &source, const Mesh &mesh, const RayCaster &caster,
                             const ViewOptions &options)
    : view(source), rays(caster), margin(options.margin), blend(options.blend),
      visibility(options.visibility) {
  if (visibility == Visibility::given && !view.visible_vertices) visibility = Visibility::depth_map;
  double centre[3];
  fvv_camera_centre(&view.camera, centre);
  place = {centre[0], centre[1], centre[2]};
  if (visibility != Visibility::depth_map) return;
  map.emplace(view.camera, mesh, options.depth_test);
  if (map->too_wide()) visibility = Visibility::rays;
}

double TextureSource::visibility_weight(const SurfacePoint &point) const {
  if (visibility != Visibility::given) return 1;
  double seen = 0;
  for (size_t i = 0; i < 3; i++) seen += view.visible_vertices[point.vertices[i]] * point.barycentric[i];
  return visibility_factor(blend, seen);
}

double TextureSource::shows(const SurfacePoint &point, double at[2]) const {
  const double world[3] = {point.shown.x, point.shown.y, point.shown.z};
  if (!fvv_camera_project(&view.camera, world, at, nullptr)) return 0;
  const double inside =
      std::min(std::min(at[0], at[1]), std::min(view.camera.width - at[0], view.camera.height - at[1]));
  const double factor = border_factor(blend, inside - margin);
  if (visibility == Visibility::given || factor == 0) return factor;
  if (!(dot(point.face_normal, place - point.position) > 0)) return 0;
  const bool hidden = visibility == Visibility::rays ? hidden_by_rays(place, point.position, point.face, rays)
                                                     : map->hidden(point.position, point.face_normal);
  return hidden ? 0 : factor;
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

Vec3 interpolated(const std::vector<Vec3> &values, const uint32_t *index,
                  const std::array<double, 3> &weight) {
  return values[index[0]] * weight[0] + values[index[1]] * weight[1] + values[index[2]] * weight[2];
}

void check(const ViewOptions &options) {
  if (!(options.threshold >= 0 && options.threshold <= 1))
    throw std::invalid_argument("the threshold of weights is 0 to 1");
  if (options.best < 1 || options.best > max_best)
    throw std::invalid_argument("a point is textured from 1 to " + std::to_string(max_best) + " cameras");
  if (!(options.inset >= 0 && std::isfinite(options.inset)))
    throw std::invalid_argument("the inset is 0 or more");
  if (!(options.margin >= 0)) throw std::invalid_argument("the margin of tiles is 0 or more");
}

} // namespace

class ViewRenderer::Frame {
public:
  Frame(const Mesh &drawn, std::vector<Vec3> &&given, std::vector<SourceView> &&views,
        const ViewOptions &chosen)
      : mesh(drawn), options(chosen), normals(given.empty() ? vertex_normals(drawn) : std::move(given)),
        rays(drawn) {
    check(options);
    if (normals.size() != mesh.vertex_count)
      throw std::invalid_argument("there are " + std::to_string(normals.size()) + " normals for " +
                                  std::to_string(mesh.vertex_count) + " vertices");
    positions.reserve(mesh.vertex_count);
    for (size_t i = 0; i < mesh.vertex_count; i++) {
      const float *p = mesh.positions + 3 * i;
      positions.push_back({p[0], p[1], p[2]});
    }
    sources.resize(views.size());
    options.executor(views.size(), [&](size_t i) {
      sources[i] = std::make_unique<TextureSource>(views[i], mesh, rays, options);
    });
  }

  ViewPicture render(const fvv_camera &target, uint32_t excluded, std::optional<double> inset) const {
    const auto around = options.environment ? options.environment->view(target, options.samples) : nullptr;
    const Surface surface(target, mesh, target.lens == FVV_LENS_NONE ? nullptr : &rays, options.samples);
    ViewPicture picture;
    picture.width = target.width;
    picture.height = target.height;
    picture.best = options.best;
    const size_t pixels = size_t(target.width) * target.height;
    picture.rgb.resize(3 * pixels);
    picture.coverage.resize(pixels);
    picture.depth.resize(pixels, std::numeric_limits<float>::infinity());
    picture.face.resize(pixels, no_face);
    picture.contributions.resize(pixels * options.best);
    if (options.keep_visibility) picture.visible.resize(pixels * sources.size());
    Target viewer(target);
    viewer.inset = inset.value_or(options.inset);
    options.executor(target.height, [&](size_t y) {
      for (uint32_t x = 0; x < target.width; x++)
        draw(viewer, surface, around.get(), x, uint32_t(y), excluded, picture);
    });
    return picture;
  }

private:
  // around may be null.
  void draw(const Target &viewer, const Surface &surface, const Environment::View *around, uint32_t x,
            uint32_t y, uint32_t excluded, ViewPicture &picture) const {
    const uint32_t count = options.samples * options.samples, centre = count / 2;
    const size_t pixel = size_t(y) * picture.width + x;
    Vec3 sum;
    uint32_t covered = 0, empty = 0;
    for (uint32_t sample = 0; sample < count; sample++) {
      const Hit hit = surface.at(x, y, sample);
      const auto behind = around ? around->at(x, y, sample) : std::nullopt;
      if (behind && behind->depth < hit.depth) {
        sum += behind->colour;
        continue;
      }
      if (hit.face == no_face) {
        empty++;
        continue;
      }
      covered++;
      Contribution contributions[max_best];
      const bool keep = sample == centre && options.keep_visibility;
      sum += colour(viewer, hit, excluded, contributions,
                    keep ? picture.visible.data() + pixel * sources.size() : nullptr);
      if (sample != centre) continue;
      picture.depth[pixel] = float(hit.depth);
      picture.face[pixel] = hit.face;
      std::copy_n(contributions, options.best, picture.contributions.data() + pixel * options.best);
    }
    sum += options.background * double(empty);
    picture.rgb[3 * pixel] = float(sum.x / count);
    picture.rgb[3 * pixel + 1] = float(sum.y / count);
    picture.rgb[3 * pixel + 2] = float(sum.z / count);
    picture.coverage[pixel] = float(covered) / float(count);
  }

  // Where no camera shows the point.
  Vec3 without_cameras(const Target &viewer, const SurfacePoint &point, const Vec3 &normal) const {
    Vec3 colour = options.vertex_colours ? Vec3{} : options.unseen;
    for (size_t i = 0; i < 3 && options.vertex_colours; i++) {
      const uint8_t *rgb = options.vertex_colours + 3 * size_t(point.vertices[i]);
      colour += Vec3{double(rgb[0]), double(rgb[1]), double(rgb[2])} * (point.barycentric[i] / 255);
    }
    return sources.empty() ? colour * viewer.light(point.position, normal) : colour;
  }

  // Fills the first contributions; visible may be null.
  Vec3 colour(const Target &viewer, const Hit &hit, uint32_t excluded, Contribution *contributions,
              uint8_t *visible) const {
    const uint32_t *index = mesh.faces + size_t(3) * hit.face;
    const Vec3 a = positions[index[0]];
    SurfacePoint point;
    point.face = hit.face;
    point.vertices = {index[0], index[1], index[2]};
    point.barycentric = hit.barycentric;
    point.position = interpolated(positions, index, hit.barycentric);
    point.face_normal = cross(positions[index[1]] - a, positions[index[2]] - a);
    const Vec3 normal = normalised(interpolated(normals, index, hit.barycentric));

    // Best first: for most cameras it is not necessary to test whether they see the point.
    std::vector<Candidate> order;
    order.reserve(sources.size());
    const Vec3 to_viewer = normalised(viewer.centre - point.position);
    point.shown = point.position - to_viewer * (viewer.inset / std::max(dot(normal, to_viewer), least_slope));
    for (uint32_t i = 0; i < sources.size(); i++) {
      const Vec3 to_camera = normalised(sources[i]->centre() - point.position);
      if (i == excluded) continue;
      Candidate camera = directed(options, {dot(normal, to_camera), dot(to_viewer, to_camera)});
      camera.source = i;
      camera *= sources[i]->visibility_weight(point);
      if (camera.weight > 0) order.push_back(camera);
    }
    std::stable_sort(order.begin(), order.end(),
                     [](const auto &p, const auto &q) { return p.weight > q.weight; });
    BestCameras best(options);
    for (Candidate &camera : order) {
      if (!visible && !best.accepts(camera.weight)) break;
      camera *= sources[camera.source]->shows(point, camera.at);
      if (!(camera.weight > 0)) continue;
      if (visible) visible[camera.source] = 1;
      best.add(camera);
    }
    if (best.begin() == best.end()) return without_cameras(viewer, point, normal);
    best.normalise();
    Vec3 mean;
    for (const Candidate &camera : best) {
      *contributions++ = {camera.source, float(camera.weight)};
      mean += sources[camera.source]->colour(camera.at) * camera.weight;
    }
    if (!options.vertex_colours) return mean;
    const double share = best.certainty();
    return share < 1 ? mean * share + without_cameras(viewer, point, normal) * (1 - share) : mean;
  }

  const Mesh mesh;
  const ViewOptions options;
  const std::vector<Vec3> normals;
  const RayCaster rays;
  std::vector<Vec3> positions;
  std::vector<std::unique_ptr<const TextureSource>> sources;
};

ViewRenderer::ViewRenderer(const Mesh &mesh, std::vector<Vec3> normals, std::vector<SourceView> sources,
                           const ViewOptions &options)
    : frame(std::make_unique<const Frame>(mesh, std::move(normals), std::move(sources), options)) {}
ViewRenderer::~ViewRenderer() = default;
ViewRenderer::ViewRenderer(ViewRenderer &&) noexcept = default;

ViewPicture ViewRenderer::render(const fvv_camera &target, uint32_t excluded,
                                 std::optional<double> inset) const {
  return frame->render(target, excluded, inset);
}

} // namespace fvv::render
