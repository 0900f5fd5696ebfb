// Visibility of a file as players use it: how often its bits, and depth maps in their place, are not what
// rays say, and what bits cost in time.
#include "fvvbench.h"

#include "fvv_render/normals.h"
#include "fvv_render/occlusion.h"
#include "fvv_render/visibility_fit.h"

#include <cmath>

namespace {

using namespace fvv::render;

constexpr double weight_threshold = 0.25; // of view-dependent texturing
constexpr size_t most_cameras = 3;        // that a place is textured from
constexpr size_t most_frames = 10;

// Pairs of a camera and a place of the surface that camera might be used for.
struct Pairs {
  double all = 0, shown = 0, hidden = 0; // of all: shown wrongly, hidden wrongly
  void add(bool says, bool truth) {
    all++;
    shown += says && !truth;
    hidden += !says && truth;
  }
  void report(nlohmann::ordered_json &out, const std::string &name, double everything) const {
    out[name + "error_percent"] = 100 * (shown + hidden) / all;
    out[name + "error_of_all_percent"] = 100 * (shown + hidden) / everything;
    out[name + "shown_wrongly_percent"] = 100 * shown / all;
    out[name + "hidden_wrongly_percent"] = 100 * hidden / all;
  }
};

struct Surface {
  fvv_mesh mesh = {};
  std::vector<float> metres;
  std::vector<Vec3> normals;
  Surface(fvv_stream *stream, size_t frame, const fvv_scene &scene) {
    fvv_diagnostic d{};
    require(fvv_stream_mesh(stream, frame, 1, &mesh, &d), d);
    metres.resize(3 * size_t(mesh.vertex_count));
    fvv_lattice_to_floats(scene.lattice_origin, scene.lattice_step, mesh.positions, mesh.vertex_count,
                          metres.data());
    normals = vertex_normals(view());
  }
  Surface(const Surface &) = delete;
  ~Surface() { fvv_mesh_free(&mesh); }
  Mesh view() const { return {metres.data(), mesh.vertex_count, mesh.faces, mesh.face_count}; }
  Vec3 corner(uint32_t face, int i) const {
    const float *p = &metres[3 * size_t(mesh.faces[3 * size_t(face) + size_t(i)])];
    return {p[0], p[1], p[2]};
  }
  Vec3 face_normal(uint32_t f) const { // twice the area long
    return cross(corner(f, 1) - corner(f, 0), corner(f, 2) - corner(f, 0));
  }
};

struct Place {
  uint32_t face;
  double weight[3]; // barycentric
};

// As many places as faces, spread evenly over the area: every part of the surface counts by its size.
std::vector<Place> places_on(const Surface &surface) {
  const uint32_t count = surface.mesh.face_count;
  double area = 0, passed = 0;
  for (uint32_t f = 0; f < count; f++) area += length(surface.face_normal(f));
  const double step = area / count;
  std::vector<Place> out;
  for (uint32_t f = 0; f < count; f++) {
    passed += length(surface.face_normal(f));
    while ((double(out.size()) + 0.5) * step < passed) {
      const auto n = double(out.size());
      double u = std::fmod(0.5 + 0.7548776662466927 * n, 1.0),
             v = std::fmod(0.5 + 0.5698402909980532 * n, 1.0);
      if (u + v > 1) {
        u = 1 - u;
        v = 1 - v;
      }
      out.push_back({f, {1 - u - v, u, v}});
    }
  }
  return out;
}

Vec3 mixed(const Place &place, Vec3 a, Vec3 b, Vec3 c) {
  return a * place.weight[0] + b * place.weight[1] + c * place.weight[2];
}

// As fvv.md, clause 17.4, tells players.
bool says(const std::vector<uint8_t> &shares, const Surface &surface, const Place &place) {
  double seen = 0;
  for (size_t i = 0; i < 3; i++)
    seen += shares[surface.mesh.faces[3 * size_t(place.face) + i]] * place.weight[i];
  return seen >= 127.5;
}

// A camera that a place may be textured from.
struct Candidate {
  double weight;
  bool bits, map, truth;
};

struct Sums {
  Pairs bits, faces, map;         // faces: the bit of the face as it stands, where it has one
  double pairs = 0;               // of place and camera, also where the camera is no candidate
  double coloured = 0;            // places that some camera shows
  double by_bits = 0, by_map = 0; // of their colour, what comes from other cameras than by rays
  double frames = 0, look = 0, order = 0, encode = 0, decode = 0; // seconds
};

// What each candidate gives to the colour of its place.
std::vector<double> given(const std::vector<Candidate> &candidates, bool Candidate::*seen) {
  std::vector<size_t> order;
  for (size_t i = 0; i < candidates.size(); i++)
    if (candidates[i].*seen) order.push_back(i);
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return candidates[a].weight > candidates[b].weight; });
  order.resize(std::min(order.size(), most_cameras));
  double sum = 0;
  for (const size_t i : order) sum += candidates[i].weight;
  std::vector<double> out(candidates.size());
  for (const size_t i : order) out[i] = candidates[i].weight / sum;
  return out;
}

// A place without any colour differs by all of it.
double elsewhere(const std::vector<double> &ours, const std::vector<double> &theirs) {
  double more = 0, less = 0;
  for (size_t i = 0; i < ours.size(); i++) {
    more += std::max(0.0, ours[i] - theirs[i]);
    less += std::max(0.0, theirs[i] - ours[i]);
  }
  return std::max(more, less);
}

void compare_colours(const std::vector<std::vector<Candidate>> &places, Sums &sums) {
  for (const std::vector<Candidate> &candidates : places) {
    const std::vector<double> truth = given(candidates, &Candidate::truth);
    sums.coloured += std::any_of(truth.begin(), truth.end(), [](double share) { return share > 0; });
    sums.by_bits += elsewhere(given(candidates, &Candidate::bits), truth);
    sums.by_map += elsewhere(given(candidates, &Candidate::map), truth);
  }
}

// The places for which the camera's weight, by the interpolated normal, reaches the threshold and which stand
// in its picture. Of these the truth is the front and a ray to the place itself.
void compare(const Surface &surface, const std::vector<Place> &places, const fvv_camera &camera,
             const RayCaster &rays, const uint8_t *states, uint8_t domain,
             std::vector<std::vector<Candidate>> &candidates, Sums &sums) {
  double at[3];
  fvv_camera_centre(&camera, at);
  const Vec3 centre = {at[0], at[1], at[2]};
  const DepthMap map(camera, surface.view(), {});
  std::vector<uint32_t> counts(2 * size_t(surface.mesh.vertex_count));
  std::vector<uint8_t> shares(surface.mesh.vertex_count);
  fvv_visibility_shares(&surface.mesh, domain, states, counts.data(), shares.data());
  sums.pairs += double(places.size());
  for (size_t i = 0; i < places.size(); i++) {
    const Place &place = places[i];
    const uint32_t *face = surface.mesh.faces + 3 * size_t(place.face);
    const Vec3 where = mixed(place, surface.corner(place.face, 0), surface.corner(place.face, 1),
                             surface.corner(place.face, 2));
    const Vec3 normal = normalised(
        mixed(place, surface.normals[face[0]], surface.normals[face[1]], surface.normals[face[2]]));
    const double weight = dot(normal, normalised(centre - where));
    if (!(weight >= weight_threshold)) continue;
    const double world[3] = {where.x, where.y, where.z};
    double pixel[2];
    if (!fvv_camera_project(&camera, world, pixel, nullptr) || pixel[0] < 0 || pixel[1] < 0 ||
        pixel[0] >= camera.width || pixel[1] >= camera.height)
      continue;
    const Vec3 face_normal = surface.face_normal(place.face);
    const bool front = dot(face_normal, centre - where) > 0;
    const bool truth = front && !hidden_by_rays(centre, where, place.face, rays);
    const bool by_bits = front && says(shares, surface, place),
               by_map = front && !map.hidden(where, face_normal);
    candidates[i].push_back({weight, by_bits, by_map, truth});
    sums.bits.add(by_bits, truth);
    if (domain == FVV_VISIBILITY_FACES && states[place.face] != FVV_ELEMENT_AVERSE)
      sums.faces.add(states[place.face] == FVV_ELEMENT_SEEN, truth);
    sums.map.add(by_map, truth);
  }
}

// What coder and decoder take, for one frame without the one before.
void time_coding(const Surface &surface, const fvv_visibility_header &coded,
                 const std::vector<fvv_camera> &cameras, const fvv_scene &scene, const RayCaster &rays,
                 Sums &sums) {
  const fvv_mesh &mesh = surface.mesh;
  fvv_visibility_header header = coded;
  header.number = 0;
  std::vector<std::vector<uint8_t>> seen;
  std::vector<fvv_visibility_view> views;
  fvv_diagnostic d{};
  sums.look += seconds([&] {
    const VisibilityFit fit(surface.view(), rays, header.domain, {});
    for (const fvv_camera &camera : cameras) {
      fvv_visibility_view view = {};
      view.camera = camera.id;
      require(fvv_visibility_centre(&camera, &scene, view.centre, &d), d);
      std::vector<uint8_t> facing(header.element_count);
      fvv_visibility_facing(&mesh, header.domain, view.centre, header.threshold, facing.data());
      seen.push_back(fit.seen(camera, facing, nullptr));
      views.push_back(view);
    }
  });
  for (size_t i = 0; i < views.size(); i++) views[i].seen = seen[i].data();
  fvv_visibility_order *order = nullptr;
  fvv_bytes payload{};
  sums.order +=
      seconds([&] { require(fvv_visibility_order_open(&mesh, header.domain, nullptr, &order, &d), d); });
  sums.encode += seconds([&] {
    require(fvv_visibility_encode(order, &mesh, &header, views.data(), views.size(), &payload, &d), d);
  });
  std::vector<fvv_visibility_stream> streams(views.size());
  std::vector<uint8_t> states(header.element_count);
  sums.decode += seconds([&] {
    require(
        fvv_visibility_peek(payload.data, payload.size, nullptr, &header, streams.data(), streams.size(), &d),
        d);
    for (size_t c = 0; c < views.size(); c++)
      require(fvv_visibility_decode(order, &mesh, &header, payload.data + streams[c].offset, streams[c].size,
                                    views[c].centre, nullptr, states.data(), &d),
              d);
  });
  fvv_bytes_free(&payload);
  fvv_visibility_order_close(order);
}

void add_frame(fvv_stream *stream, size_t frame, uint16_t track, Sums &sums) {
  fvv_diagnostic d{};
  const fvv_configuration *configuration = nullptr;
  fvv_frame where;
  require(fvv_stream_frame(stream, frame, &where, &d), d);
  require(fvv_stream_configuration(stream, where.group, &configuration, &d), d);
  const fvv_scene scene = configuration->scene;
  const Surface surface(stream, frame, scene);
  const RayCaster rays(surface.view());
  const std::vector<Place> places = places_on(surface);
  const fvv_visibility *visibility = nullptr;
  require(fvv_stream_visibility(stream, frame, track, &visibility, &d), d);
  if (!visibility) return;
  const fvv_visibility_header header = visibility->header;
  const std::vector<uint8_t> states(visibility->states,
                                    visibility->states + size_t(header.camera_count) * header.element_count);
  const std::vector<uint16_t> ids(visibility->cameras, visibility->cameras + header.camera_count);
  std::vector<fvv_camera> cameras(ids.size());
  std::vector<std::vector<Candidate>> candidates(places.size());
  for (size_t i = 0; i < ids.size(); i++) {
    require(fvv_stream_camera(stream, frame, ids[i], &cameras[i], &d), d);
    compare(surface, places, cameras[i], rays, &states[i * header.element_count], header.domain, candidates,
            sums);
  }
  compare_colours(candidates, sums);
  time_coding(surface, header, cameras, scene, rays, sums);
  sums.frames++;
}

} // namespace

// error_percent: of the pairs of a camera and a place, with places spread over the surface by area, that
// stand in the picture and whose weight reaches 0.25, those where a player would show the camera's picture
// though something hides the place, or not show it though nothing does. The truth is the ray to that place.
// error_of_all_percent: the same beside all pairs of a camera and a place, as bits are counted beside all
// pairs of a camera and a face; where a camera is not asked for a place nothing can be wrong.
// colour_elsewhere_percent: of the colour of the places that some camera shows, by the three best of those
// that see them, the share that comes from other cameras than by rays. depth_map: the same with the
// reference's depth map at the size of the picture.
nlohmann::ordered_json visibility(const char *path) {
  Bytes source = read_file(path);
  fvv_diagnostic d{};
  fvv_stream *stream = nullptr;
  const fvv_input input = input_of(source);
  require(fvv_stream_open(&input, nullptr, nullptr, &stream, &d), d);
  const fvv_configuration *configuration = nullptr;
  require(fvv_stream_configuration(stream, 0, &configuration, &d), d);
  uint16_t track = 0;
  for (size_t i = 0; i < configuration->track_count; i++)
    if (configuration->tracks[i].kind == FVV_TRACK_VISIBILITY) track = configuration->tracks[i].id;
  if (!track) throw std::runtime_error("the file has no visibility");
  Sums sums;
  for (size_t f = 0; f < std::min(fvv_stream_frame_count(stream), most_frames); f++)
    add_frame(stream, f, track, sums);
  nlohmann::ordered_json out;
  sums.bits.report(out, "", sums.pairs);
  out["colour_elsewhere_percent"] = 100 * sums.by_bits / sums.coloured;
  if (sums.faces.all > 0) sums.faces.report(out, "plain_face_bits_", sums.pairs);
  sums.map.report(out, "depth_map_", sums.pairs);
  out["depth_map_colour_elsewhere_percent"] = 100 * sums.by_map / sums.coloured;
  out["look_ms"] = sums.look / sums.frames * 1e3;
  out["order_ms"] = sums.order / sums.frames * 1e3;
  out["encode_ms"] = sums.encode / sums.frames * 1e3;
  out["decode_ms"] = sums.decode / sums.frames * 1e3;
  fvv_stream_close(stream);
  return out;
}
