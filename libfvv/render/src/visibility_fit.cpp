#include "fvv_render/visibility_fit.h"

#include "face_places.h"
#include "fvv_render/normals.h"
#include "visibility_weights.h"

#include <algorithm>
#include <utility>

namespace fvv::render {

VisibilityFit::VisibilityFit(const Mesh &seen, const RayCaster &caster, uint8_t domain,
                             const FitSettings &chosen)
    : mesh(seen), rays(caster), faces(domain == FVV_VISIBILITY_FACES), settings(chosen),
      normals(vertex_normals(seen)), area(seen.face_count), first(seen.vertex_count + 1),
      around(3 * seen.face_count) {
  double sum = 0;
  for (size_t f = 0; f < mesh.face_count; f++) {
    Vec3 corner[3];
    for (size_t k = 0; k < 3; k++) {
      const float *p = mesh.positions + size_t(3) * mesh.faces[3 * f + k];
      corner[k] = {p[0], p[1], p[2]};
      first[mesh.faces[3 * f + k] + 1]++;
    }
    area[f] = length(cross(corner[1] - corner[0], corner[2] - corner[0]));
    sum += area[f];
  }
  for (double &one : area) one *= sum > 0 ? double(mesh.face_count) / sum : 0;
  for (size_t v = 0; v < mesh.vertex_count; v++) first[v + 1] += first[v];
  std::vector<uint32_t> next(first.begin(), first.end() - 1);
  for (size_t i = 0; i < around.size(); i++) around[next[mesh.faces[i]]++] = uint32_t(i / 3);
  if (domain == FVV_VISIBILITY_WEIGHTS)
    neighbours = std::make_unique<const WeightNeighbours>(mesh, first, around);
}

VisibilityFit::~VisibilityFit() = default;

// Of one camera.
class VisibilityFit::Search {
public:
  Search(const VisibilityFit &shared, Viewer &eye, const FacePlaces &looked, std::vector<uint8_t> &bits,
         const std::vector<uint8_t> &wanted, const uint8_t *last)
      : fit(shared), viewer(eye), places(looked), seen(bits), selected(wanted), former(last),
        counts(2 * (fit.faces ? fit.mesh.vertex_count : fit.mesh.face_count)), weight(fit.mesh.vertex_count),
        weighs(fit.mesh.face_count, unknown), stamp(fit.mesh.face_count) {
    for (uint32_t e = 0; e < seen.size(); e++)
      if (selected[e]) count(e, 1);
    if (fit.faces)
      for (uint32_t v = 0; v < weight.size(); v++) weight[v] = weight_of(v);
    else
      for (uint32_t v = 0; v < weight.size(); v++) weight[v] = seen[v] ? 255 : 0;
  }

  void run() {
    const std::vector<uint32_t> doubtful = elements_near_changes();
    accept_by_threshold(fit.settings.tolerance, [&](double worse) { return improve(doubtful, worse); });
  }

private:
  static constexpr uint16_t unknown = 1 << 15;

  // worse: by how much the sum may grow with one bit. Returns whether any was turned.
  bool improve(const std::vector<uint32_t> &elements, double worse) {
    bool changed = false;
    for (const uint32_t e : elements) {
      gather(e);
      const double before = cost(e);
      flip(e);
      if (cost(e) < before + worse)
        changed = true;
      else
        flip(e);
    }
    return changed;
  }

  template <class Body> void each_place(uint32_t e, Body body) const {
    if (fit.faces)
      for (size_t k = 0; k < 3; k++) body(fit.mesh.faces[3 * size_t(e) + k]);
    else
      for (uint32_t i = fit.first[e]; i < fit.first[e + 1]; i++) body(fit.around[i]);
  }

  void count(uint32_t e, int by) {
    each_place(e, [&](uint32_t place) { counts[2 * size_t(place) + !seen[e]] += uint32_t(by); });
  }

  // As fvv_visibility_weights.
  int weight_of(uint32_t v) const {
    const uint32_t a = counts[2 * size_t(v)], b = counts[2 * size_t(v) + 1];
    return a + b ? int((255 * a + (a + b) / 2) / (a + b)) : 127;
  }

  void flip(uint32_t e) {
    count(e, -1);
    seen[e] = !seen[e];
    count(e, 1);
    if (fit.faces)
      each_place(e, [&](uint32_t v) { weight[v] = weight_of(v); });
    else
      weight[e] = seen[e] ? 255 : 0;
  }

  // Faces that the element's bit affects.
  void gather(uint32_t e) {
    affected.clear();
    now++;
    const auto add = [&](uint32_t v) {
      for (uint32_t i = fit.first[v]; i < fit.first[v + 1]; i++)
        if (std::exchange(stamp[fit.around[i]], now) != now) affected.push_back(fit.around[i]);
    };
    if (fit.faces)
      each_place(e, add);
    else
      add(e);
  }

  double error(uint32_t f) {
    if (!places.judged[f]) return 0;
    if (weighs[f] == unknown) weighs[f] = fit.places_that_weigh(viewer, f, ninths, place_count);
    if (!weighs[f]) return 0;
    const uint32_t *face = fit.mesh.faces + 3 * size_t(f);
    const int s[3] = {weight[face[0]], weight[face[1]], weight[face[2]]};
    unsigned says = 0;
    if (s[0] > 127 && s[1] > 127 && s[2] > 127)
      says = all_places;
    else if (s[0] > 127 || s[1] > 127 || s[2] > 127)
      for (int p = 0; p < place_count; p++)
        says |= unsigned(2 * (ninths[p][0] * s[0] + ninths[p][1] * s[1] + ninths[p][2] * s[2]) >= 9 * 255)
                << p;
    return fit.area[f] * count_of((says ^ places.free[f]) & weighs[f]) / place_count;
  }

  double cost(uint32_t e) {
    double sum = 0;
    for (const uint32_t f : affected) sum += error(f);
    double pairs = 0;
    each_place(e, [&](uint32_t p) { pairs += double(counts[2 * size_t(p)]) * counts[2 * size_t(p) + 1]; });
    sum += fit.settings.edge * pairs;
    if (former && former[e] != FVV_ELEMENT_BACKFACING && (former[e] == FVV_ELEMENT_SEEN) != (seen[e] != 0))
      sum += fit.settings.change;
    return sum;
  }

  std::vector<uint32_t> elements_near_changes() const {
    std::vector<uint32_t> out;
    for (uint32_t e = 0; e < seen.size(); e++) {
      if (!selected[e]) continue;
      bool near = fit.faces && places.touches_mixed(fit.mesh.faces + 3 * size_t(e));
      if (!fit.faces)
        for (uint32_t i = fit.first[e]; i < fit.first[e + 1] && !near; i++)
          near = places.touches_mixed(fit.mesh.faces + 3 * size_t(fit.around[i]));
      if (near) out.push_back(e);
    }
    return out;
  }

  const VisibilityFit &fit;
  Viewer &viewer;
  const FacePlaces &places;
  std::vector<uint8_t> &seen;
  const std::vector<uint8_t> &selected;
  const uint8_t *former;
  std::vector<uint32_t> counts; // of bits of 1 and 0 around each place that elements touch
  std::vector<int> weight;      // of each vertex
  std::vector<uint16_t> weighs; // of each face: the places that count
  std::vector<uint32_t> stamp, affected;
  uint32_t now = 0;
};

std::vector<uint8_t> VisibilityFit::faces_to_judge(const Viewer &viewer,
                                                   const std::vector<uint8_t> &selected) const {
  std::vector<uint8_t> out(mesh.face_count);
  for (uint32_t f = 0; f < mesh.face_count; f++) {
    const uint32_t *face = mesh.faces + 3 * size_t(f);
    out[f] = faces && selected[f];
    if (out[f]) continue;
    const Vec3 a = viewer.position(face[0]), way = viewer.way_from(viewer.at(face, 3, 3, 3));
    if (!(dot(cross(viewer.position(face[1]) - a, viewer.position(face[2]) - a), way) > 0)) continue;
    const double enough = settings.cosine * length(way);
    out[f] = dot(normals[face[0]], way) >= enough || dot(normals[face[1]], way) >= enough ||
             dot(normals[face[2]], way) >= enough;
  }
  return out;
}

uint16_t VisibilityFit::places_that_weigh(Viewer &viewer, uint32_t f, const int (*places)[3],
                                          int count) const {
  const uint32_t *face = mesh.faces + 3 * size_t(f);
  const bool whole = viewer.in_picture(face[0]) && viewer.in_picture(face[1]) && viewer.in_picture(face[2]);
  const Vec3 corner = viewer.position(face[0]);
  const Vec3 normal = cross(viewer.position(face[1]) - corner, viewer.position(face[2]) - corner);
  uint16_t out = 0;
  for (int p = 0; p < count; p++) {
    const auto &[a, b, c] = places[p];
    const Vec3 at = viewer.at(face, a, b, c), way = viewer.way_from(at),
               mean = normals[face[0]] * a + normals[face[1]] * b + normals[face[2]] * c;
    const bool counts = dot(normal, way) > 0 &&
                        dot(mean, way) >= settings.cosine * length(mean) * length(way) &&
                        (whole || viewer.in_picture(at));
    out |= uint16_t(counts << p);
  }
  return out;
}

std::vector<uint8_t> VisibilityFit::weights(Viewer &viewer, const std::vector<uint8_t> &selected,
                                            const uint8_t *former) const {
  const WeightPlaces places(viewer, mesh, faces_to_judge(viewer, selected), first, around);
  // Without an outline nearby nothing changes, and nothing has to be counted.
  std::vector<uint8_t> near(mesh.vertex_count);
  std::vector<uint16_t> weighs(mesh.face_count);
  for (uint32_t f = 0; f < mesh.face_count; f++) {
    const uint32_t *face = mesh.faces + 3 * size_t(f);
    if (places.judged[f] && (places.mixed[face[0]] || places.mixed[face[1]] || places.mixed[face[2]]))
      for (size_t k = 0; k < 3; k++) near[face[k]] = 1;
  }
  for (uint32_t f = 0; f < mesh.face_count; f++) {
    const uint32_t *face = mesh.faces + 3 * size_t(f);
    if (places.judged[f] && (near[face[0]] || near[face[1]] || near[face[2]]))
      weighs[f] = places_that_weigh(viewer, f, twelfths, weight_place_count);
  }
  return WeightSearch(mesh, *neighbours, first, around, area, places, weighs, selected, former, settings)
      .run();
}

std::vector<uint8_t> VisibilityFit::seen(const fvv_camera &camera, const std::vector<uint8_t> &selected,
                                         const uint8_t *former) const {
  Viewer viewer(camera, mesh, rays);
  if (neighbours) return weights(viewer, selected, former);
  const FacePlaces places(viewer, mesh, faces_to_judge(viewer, selected));
  std::vector<uint8_t> bits(selected.size());
  if (!faces) bits = seen_vertices(camera, mesh, rays, selected);
  for (size_t f = 0; faces && f < bits.size(); f++)
    bits[f] = selected[f] && count_of(places.free[f]) > place_count / 2;
  Search(*this, viewer, places, bits, selected, former).run();
  return bits;
}

} // namespace fvv::render
