// Putting the parts of the scene together.
#include "fvvsynth/scene.h"

#include "cli/parallel.h"
#include "fvvsynth/court.h"

#include <stdexcept>

namespace fvv::synth {

namespace {

constexpr uint32_t ball_division = 10; // 2,000 triangles

const render::Light light = {
    normalised(Vec3{0.35, 0.85, 0.40}), {0.95, 0.91, 0.84}, {0.62, 0.65, 0.70}, {0.30, 0.24, 0.19}};

Settings checked(const Settings &s) {
  const auto side = [](uint32_t n, uint32_t most) { return n >= 16 && n <= most; };
  const uint32_t most = s.rig == RigKind::studio ? studio_max_side : 4096;
  if (s.rig == RigKind::small && (s.cameras < 1 || s.cameras > 64))
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
    : wanted(checked(settings)), random(wanted.seed), looks(make_looks(random)), choreography(random),
      court_key(uint32_t(random.next())),
      ball_key(uint32_t(random.next())), bodies{make_body(looks[0].style), make_body(looks[1].style)},
      ball(make_ball(ball_division)) {
  const auto append = [&](const Surface &surface) {
    const uint32_t first = uint32_t(texture.size() / 3);
    for (const uint32_t v : surface.faces) all_faces.push_back(first + v);
    for (const Vec3 p : surface.vertices)
      for (const double value : {p.x, p.y, p.z}) texture.push_back(float(value));
  };
  for (size_t i = 0; i < 2; i++) {
    append(bodies[i].rest);
    face_count[i] = bodies[i].rest.faces.size() / 3;
    exposure.insert(exposure.end(), bodies[i].exposure.begin(), bodies[i].exposure.end());
  }
  append(ball);
  exposure.insert(exposure.end(), ball.vertices.size(), 0.85f);

  Rig made = wanted.rig == RigKind::studio
                 ? make_studio_rig(random, wanted.width, wanted.height)
                 : make_small_rig(random, wanted.cameras, wanted.width, wanted.height);
  rig = std::move(made.cameras);
  names = std::move(made.names);
  projections.reserve(rig.size());
  for (size_t i = 0; i < rig.size(); i++) {
    rig[i].name = names[i].data();
    rig[i].name_size = names[i].size();
    projections.emplace_back(rig[i]);
  }
  backgrounds.resize(rig.size());
  cli::parallel(wanted.threads, rig.size(),
                [&](size_t i) { backgrounds[i] = draw_court(projections[i], court_key); });
}

Moment Scene::at(double seconds) const {
  Moment moment;
  moment.positions.reserve(texture.size());
  for (int i = 0; i < 2; i++)
    carry(bodies[size_t(i)], solve(choreography.posture(i, seconds)), moment.positions);
  const Vec3 centre = choreography.ball().position(seconds);
  const Mat3 turned = choreography.ball().rotation(seconds);
  for (const Vec3 p : ball.vertices) {
    const Vec3 at = centre + turned * p * ball_radius;
    for (const double value : {at.x, at.y, at.z}) moment.positions.push_back(float(value));
  }
  moment.normals = vertex_normals(moment.positions, all_faces);
  return moment;
}

render::Picture Scene::picture(size_t camera, const Moment &moment, render::SampleBuffer &buffer) const {
  const render::Mesh mesh = {moment.positions.data(), vertex_count(), all_faces.data(), all_faces.size() / 3};
  const render::Attributes attributes = {moment.normals.data(), texture.data(), exposure.data()};
  const auto material = [&](uint32_t face, Vec3 at) {
    if (face < face_count[0]) return player_reflectance(looks[0], at);
    if (face < face_count[0] + face_count[1]) return player_reflectance(looks[1], at);
    return ball_reflectance(at, ball_key);
  };
  return render::draw(projections[camera], mesh, attributes, material, light, backgrounds[camera], buffer);
}

} // namespace fvv::synth
