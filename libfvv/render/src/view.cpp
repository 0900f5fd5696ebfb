// Pictures of a mesh, textured from the cameras that see each point best.
#include "fvv_render/view.h"

#include "fvv_render/normals.h"
#include "surface.h"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace fvv::render {

namespace {

// Of a surface without pictures: what it has of its colour where it is seen from the side.
constexpr double ambient = 0.6;

struct SurfacePoint {
  uint32_t face = no_face;
  Vec3 position, face_normal; // the normal of any length
  std::array<uint32_t, 3> vertices = {};
  std::array<double, 3> barycentric = {};
};

class TextureSource {
public:
  // Borrows view's pixels and visibility, and rays.
  TextureSource(const SourceView &view, const Mesh &mesh, const RayCaster &rays, const ViewOptions &options);

  Vec3 centre() const { return place; }
  // at: the position in the source's pixels.
  bool shows(const SurfacePoint &point, double at[2]) const;
  // Bilinear, display values, 1 for white; beyond the centres of the outermost pixels theirs.
  Vec3 colour(const double at[2]) const;

private:
  const SourceView view;
  const RayCaster &rays;
  const double margin;
  Visibility visibility;
  Vec3 place;
  std::optional<DepthMap> map;
};

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

Vec3 interpolated(const std::vector<Vec3> &values, const uint32_t *index,
                  const std::array<double, 3> &weight) {
  return values[index[0]] * weight[0] + values[index[1]] * weight[1] + values[index[2]] * weight[2];
}

void check(const ViewOptions &options) {
  if (!(options.threshold >= 0 && options.threshold <= 1))
    throw std::invalid_argument("the threshold of weights is 0 to 1");
  if (options.best < 1 || options.best > max_best)
    throw std::invalid_argument("a point is textured from 1 to " + std::to_string(max_best) + " cameras");
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

  ViewPicture render(const fvv_camera &target, uint32_t excluded) const {
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
    double viewer[3];
    fvv_camera_centre(&target, viewer);
    options.executor(target.height, [&](size_t y) {
      for (uint32_t x = 0; x < target.width; x++)
        draw(surface, around.get(), {viewer[0], viewer[1], viewer[2]}, x, uint32_t(y), excluded, picture);
    });
    return picture;
  }

private:
  // around may be null.
  void draw(const Surface &surface, const Environment::View *around, Vec3 viewer, uint32_t x, uint32_t y,
            uint32_t excluded, ViewPicture &picture) const {
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
      sum += colour(hit, viewer, excluded, contributions,
                    keep ? &picture.visible[pixel * sources.size()] : nullptr);
      if (sample != centre) continue;
      picture.depth[pixel] = float(hit.depth);
      picture.face[pixel] = hit.face;
      std::copy_n(contributions, options.best, &picture.contributions[pixel * options.best]);
    }
    sum += options.background * double(empty);
    picture.rgb[3 * pixel] = float(sum.x / count);
    picture.rgb[3 * pixel + 1] = float(sum.y / count);
    picture.rgb[3 * pixel + 2] = float(sum.z / count);
    picture.coverage[pixel] = float(covered) / float(count);
  }

  // Where no camera shows the point. viewer: centre of the target.
  Vec3 without_cameras(const SurfacePoint &point, Vec3 normal, Vec3 viewer) const {
    Vec3 colour = options.vertex_colours ? Vec3{} : options.unseen;
    for (size_t i = 0; i < 3 && options.vertex_colours; i++) {
      const uint8_t *rgb = options.vertex_colours + 3 * size_t(point.vertices[i]);
      colour += Vec3{double(rgb[0]), double(rgb[1]), double(rgb[2])} * (point.barycentric[i] / 255);
    }
    if (!sources.empty()) return colour;
    return colour *
           (ambient + (1 - ambient) * std::max(0.0, dot(normal, normalised(viewer - point.position))));
  }

  // Fills the first contributions; visible may be null.
  Vec3 colour(const Hit &hit, Vec3 viewer, uint32_t excluded, Contribution *contributions,
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

    // A weight of 0 would leave nothing to divide by. Best first: for most cameras it is not necessary to
    // test whether they see the point.
    std::vector<std::pair<double, uint32_t>> order;
    order.reserve(sources.size());
    for (uint32_t i = 0; i < sources.size(); i++) {
      const double cosine = dot(normal, normalised(sources[i]->centre() - point.position));
      if (i != excluded && cosine >= options.threshold && cosine > 0) order.emplace_back(cosine, i);
    }
    std::stable_sort(order.begin(), order.end(),
                     [](const auto &p, const auto &q) { return p.first > q.first; });
    Vec3 colours[max_best];
    double cosines[max_best], sum = 0;
    uint32_t used = 0;
    for (const auto &[cosine, i] : order) {
      if (used == options.best && !visible) break;
      double at[2];
      if (!sources[i]->shows(point, at)) continue;
      if (visible) visible[i] = 1;
      if (used == options.best) continue;
      colours[used] = sources[i]->colour(at);
      cosines[used] = cosine;
      contributions[used].source = i;
      sum += cosine;
      used++;
    }
    if (!used) return without_cameras(point, normal, viewer);
    Vec3 mean;
    for (uint32_t i = 0; i < used; i++) {
      contributions[i].weight = float(cosines[i] / sum);
      mean += colours[i] * (cosines[i] / sum);
    }
    return mean;
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

ViewPicture ViewRenderer::render(const fvv_camera &target, uint32_t excluded) const {
  return frame->render(target, excluded);
}

} // namespace fvv::render
