// Putting the parts of the scene together.
#include "fvvsynth/scene.h"

#include "fvv_cxx/parallel.h"
#include "fvvsynth/game/player.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace fvv::synth {

namespace {

constexpr uint32_t ball_division = 10; // 2,000 triangles

constexpr double texel_at_960 = 0.006; // metres of the floor's finest detail, for pictures 960 wide
// The hoop throws long shadows: a map of 7.4 m.
constexpr double game_shadow_cell = 0.0165, contact_cell = 0.0125;
// Of a lamp's light: a tenth of a display value. Sums of the blur leave as much where nothing is.
constexpr float invisible = 1.0f / 2048;
// Where soles and the ball come near the floor, the surroundings' light does not reach it: what is lower than
// this shades what is right below it. Not quite vertical, because a camera that looks down has no side up.
struct ContactShadow {
  double below;
  Lamp lamp;
};
const Vec3 overhead_light = normalised(Vec3{0.01, 1, 0.01});
const ContactShadow contacts[] = {{0.045, {overhead_light, 0.42, 0.03}},
                                  {0.14, {overhead_light, 0.30, 0.08}}};

// The game goes higher than a practice, and further to the sides.
constexpr Framing game_framing{0.22, 0.84, 0.5, 5.9};
constexpr double longest_zoom = 1.8; // of the camera that moves, times its shortest focal length

const render::Light light_of_day = {
    normalised(Vec3{0.35, 0.85, 0.40}), {0.95, 0.91, 0.84}, {0.62, 0.65, 0.70}, {0.30, 0.24, 0.19}};
// The lamps that light the floor: that of the players, and a fill light from the other side.
const std::array<Lamp, 2> lamps = {
    {{light_of_day.towards, 0.50, 0.04}, {normalised(Vec3{-0.45, 0.80, -0.30}), 0.22, 0.07}}};

std::unique_ptr<const Action> make_action(SceneKind kind, Random &random) {
  if (kind == SceneKind::game) return std::make_unique<Game>(random);
  return std::make_unique<Play>(random);
}

Body make_one(SceneKind kind, const Look &look) {
  return kind == SceneKind::game ? make_player(look.style, look.key) : make_body(look.style);
}

Settings checked(const Settings &s) {
  const auto side = [](uint32_t n, uint32_t most) { return n >= 16 && n <= most; };
  const uint32_t most = s.rig == RigKind::studio ? studio_max_side : 4096;
  if (s.rig != RigKind::studio && (s.cameras < 1 || s.cameras > 64))
    throw std::invalid_argument("a scene has 1 to 64 cameras, not " + std::to_string(s.cameras));
  if (!side(s.width, most) || !side(s.height, most))
    throw std::invalid_argument("pictures have sides of 16 to " + std::to_string(most) + " pixels, not " +
                                std::to_string(s.width) + "x" + std::to_string(s.height));
  return s;
}

// Unit normals: the mean of the faces around a vertex, each weighted with its area.
std::vector<float> vertex_normals(const std::vector<float> &positions, const std::vector<uint32_t> &faces) {
  std::vector<Vec3> sum(positions.size() / 3);
  const auto point = [&](uint32_t v) {
    return Vec3{positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]};
  };
  for (size_t i = 0; i < faces.size(); i += 3) {
    const Vec3 a = point(faces[i]);
    const Vec3 normal = cross(point(faces[i + 1]) - a, point(faces[i + 2]) - a);
    for (size_t c = 0; c < 3; c++) sum[faces[i + c]] += normal;
  }
  std::vector<float> normals;
  normals.reserve(positions.size());
  for (const Vec3 n : sum) {
    const Vec3 unit = normalised(n);
    for (const double value : {unit.x, unit.y, unit.z}) normals.push_back(float(value));
  }
  return normals;
}

} // namespace

Scene::Scene(const Settings &settings)
    : wanted(checked(settings)), random(wanted.seed), looks(make_looks(random)),
      choreography(make_action(wanted.kind, random)), match(dynamic_cast<const Game *>(choreography.get())),
      studio_key(uint32_t(random.next())),
      ball_key(uint32_t(random.next())), bodies{make_one(wanted.kind, looks[0]),
                                                make_one(wanted.kind, looks[1])},
      ball(make_ball(ball_division)) {
  if (match)
    for (Look &look : looks) look.fine = true;
  const auto append = [&](const Surface &surface) {
    const uint32_t first = uint32_t(texture.size() / 3);
    for (const uint32_t v : surface.faces) all_faces.push_back(first + v);
    for (const Vec3 p : surface.vertices)
      for (const double value : {p.x, p.y, p.z}) texture.push_back(float(value));
  };
  for (size_t i = 0; i < 2; i++) {
    append(bodies[i].rest);
    face_ends[i] = all_faces.size() / 3;
    exposure.insert(exposure.end(), bodies[i].exposure.begin(), bodies[i].exposure.end());
  }
  append(ball);
  face_ends[2] = all_faces.size() / 3;
  exposure.insert(exposure.end(), ball.vertices.size(), 0.85f);
  if (match) {
    hoop = make_hoop();
    append(hoop->rest);
    exposure.insert(exposure.end(), hoop->rest.vertices.size(), 0.85f);
  }

  Rig made = wanted.rig == RigKind::studio
                 ? make_studio_rig(random, wanted.width, wanted.height, match ? game_framing : Framing{})
             : wanted.rig == RigKind::arc
                 ? make_arc_rig(wanted.cameras, wanted.width, wanted.height)
                 : make_small_rig(random, wanted.cameras, wanted.width, wanted.height);
  rig = std::move(made.cameras);
  names = std::move(made.names);
  if (!wanted.still) moving = made.moving;
  for (size_t i = 0; i < rig.size(); i++) {
    rig[i].name = names[i].data();
    rig[i].name_size = names[i].size();
  }
  if (moving) {
    at_rest = rig[*moving];
    rig[*moving] = camera(*moving, 0);
  }
  projections.reserve(rig.size());
  for (const fvv_camera &one : rig) projections.emplace_back(one);
  studio = std::make_unique<Studio>(studio_key, std::clamp(texel_at_960 * 960 / wanted.width, 0.003, 0.02),
                                    rig, light_of_day, match != nullptr, wanted.threads);
  backgrounds.resize(rig.size());
  fvv::parallel(wanted.threads, rig.size(), [&](size_t i) {
    render::SampleBuffer buffer(1, 1, 3);
    if (!moves(i)) backgrounds[i] = studio->seen(projections[i], i, buffer);
  });
}

// Pans and tilts after the ball, with the inertia of a hand, and zooms in and out once in a cycle of the
// play.
fvv_camera Scene::camera(size_t number, double seconds) const {
  if (!moves(number)) return rig[number];
  constexpr int steps = 24;
  constexpr double inertia = 0.6; // seconds before and after
  Vec3 followed;
  double weights = 0;
  for (int i = -steps; i <= steps; i++) {
    const double away = double(i) / (steps + 1), weight = (1 - away * away) * (1 - away * away);
    followed += choreography->ball_position(seconds + inertia * away) * weight;
    weights += weight;
  }
  followed = followed * (1 / weights);
  const Vec3 target = mix(Vec3{0, 0.95, 0}, followed, 0.6);
  const double wave = std::cos(seconds * 6.283185307179586 / choreography->duration());
  return turned(at_rest, target, 1 + (longest_zoom - 1) * (0.5 - 0.5 * wave));
}

Moment Scene::at(double seconds) const {
  Moment moment;
  moment.positions.reserve(texture.size());
  for (int i = 0; i < 2; i++)
    carry(bodies[size_t(i)], solve(choreography->posture(i, seconds)), moment.positions);
  const Vec3 centre = choreography->ball_position(seconds);
  const Mat3 turned = choreography->ball_rotation(seconds);
  for (const Vec3 p : ball.vertices) {
    const Vec3 at = centre + turned * p * ball_radius;
    for (const double value : {at.x, at.y, at.z}) moment.positions.push_back(float(value));
  }
  if (hoop) carry(*hoop, *match, seconds, moment.positions);
  moment.normals = vertex_normals(moment.positions, all_faces);
  moment.seconds = seconds;
  const render::Mesh mesh = {moment.positions.data(), vertex_count(), all_faces.data(), all_faces.size() / 3};
  if (!match) {
    for (const Lamp &lamp : lamps) moment.shadows.emplace_back(mesh, lamp);
    return moment;
  }
  for (const Lamp &lamp : lamps) moment.shadows.emplace_back(mesh, lamp, game_shadow_cell, invisible);
  for (const ContactShadow &contact : contacts) {
    std::vector<uint32_t> low;
    const auto height = [&](uint32_t v) { return double(moment.positions[3 * v + 1]); };
    for (size_t i = 0; i < all_faces.size(); i += 3) {
      const uint32_t *v = &all_faces[i];
      if (std::max(height(v[0]), std::max(height(v[1]), height(v[2]))) < contact.below)
        low.insert(low.end(), v, v + 3);
    }
    const render::Mesh near_floor = {moment.positions.data(), vertex_count(), low.data(), low.size() / 3};
    moment.shadows.emplace_back(near_floor, contact.lamp, contact_cell, invisible);
  }
  return moment;
}

render::Reflectance Scene::reflectance(uint32_t face, Vec3 at) const {
  if (face < face_ends[0]) return player_reflectance(looks[0], at);
  if (face < face_ends[1]) return player_reflectance(looks[1], at);
  if (face < face_ends[2]) return ball_reflectance(at, ball_key);
  return hoop_reflectance(at);
}

Scene::Facing Scene::facing_faces(const Moment &moment, Vec3 eye) const {
  Facing out;
  out.corners.reserve(all_faces.size() / 2);
  out.numbers.reserve(all_faces.size() / 6);
  const auto point = [&](uint32_t v) {
    const float *p = &moment.positions[size_t(3) * v];
    return Vec3{p[0], p[1], p[2]};
  };
  for (size_t i = 0; i < all_faces.size(); i += 3) {
    const Vec3 a = point(all_faces[i]);
    const Vec3 normal = cross(point(all_faces[i + 1]) - a, point(all_faces[i + 2]) - a);
    if (!(dot(normal, eye - a) > 0)) continue;
    out.corners.insert(out.corners.end(), &all_faces[i], &all_faces[i] + 3);
    out.numbers.push_back(uint32_t(i / 3));
  }
  return out;
}

render::LitPicture Scene::light(size_t number, const Moment &moment, render::SampleBuffer &buffer,
                                std::optional<uint32_t> part) const {
  const render::Attributes attributes = {moment.normals.data(), texture.data(), exposure.data()};
  const auto seen = [&](const render::Projection &projection, render::LightField background) {
    Shadow::cast(moment.shadows, projection, background);
    const Facing facing = match ? facing_faces(moment, projection.centre()) : Facing();
    const std::vector<uint32_t> &drawn = match ? facing.corners : all_faces;
    const render::Mesh mesh = {moment.positions.data(), vertex_count(), drawn.data(), drawn.size() / 3};
    const auto material = [&](uint32_t face, Vec3 at) {
      return reflectance(match ? facing.numbers[face] : face, at);
    };
    return render::illuminate(projection, mesh, attributes, material, light_of_day, std::move(background),
                              buffer, part);
  };
  if (!moves(number)) return seen(projections[number], backgrounds[number]);
  const render::Projection projection(camera(number, moment.seconds));
  return seen(projection, studio->seen(projection, number, buffer, part));
}

render::LitPicture Scene::light_object(size_t camera, const render::Mesh &mesh,
                                       const render::Attributes &attributes, const render::Material &material,
                                       render::SampleBuffer &buffer) const {
  return render::illuminate(projections[camera], mesh, attributes, material, light_of_day,
                            backgrounds[camera], buffer);
}

const std::array<Lamp, 2> &studio_lamps() {
  return lamps;
}

} // namespace fvv::synth
