// The scene "game": what moves, moves as people and balls do; the same for any number of threads.
#include "closed.h"
#include "fvv_catch.h"

#include "fvvsynth/filming.h"
#include "fvvsynth/game/game.h"
#include "fvvsynth/scene.h"

#include <algorithm>
#include <cmath>

using namespace fvv::synth;

namespace {

constexpr double frame_rate = 25;
constexpr int frames = 250;

Settings small_game() {
  Settings settings;
  settings.kind = SceneKind::game;
  settings.width = 96;
  settings.height = 54;
  return settings;
}

const Scene &shared_scene() {
  static const Scene scene(small_game());
  return scene;
}

Vec3 vertex(const Moment &moment, size_t i) {
  return {moment.positions[3 * i], moment.positions[3 * i + 1], moment.positions[3 * i + 2]};
}

constexpr Joint ankles[2] = {left_foot, right_foot}, wrists[2] = {left_hand, right_hand};

} // namespace

TEST_CASE("game: feet that carry weight do not slide, and one does unless its player jumps", "[long]") {
  Random random(1);
  const Game game(random);
  double worst = 0;
  int jumped = 0;
  for (int player = 0; player < 2; player++)
    for (int frame = 0; frame < frames; frame++) {
      const double time = frame / frame_rate, next = (frame + 1) / frame_rate;
      const Bones a = solve(game.posture(player, time)), b = solve(game.posture(player, next));
      int down = 0;
      for (int foot = 0; foot < 2; foot++) {
        if (!game.planted(player, foot, time)) continue;
        down++;
        if (!game.planted(player, foot, next)) continue;
        INFO("player " << player << " foot " << foot << " at " << time);
        const double moved = length(b.position[ankles[foot]] - a.position[ankles[foot]]);
        CHECK(moved < 0.002);
        worst = std::max(worst, moved);
      }
      if (down == 0) {
        CHECK(player == 1);
        jumped++;
      }
    }
  CHECK(worst > 0); // legs are stretched a little now and then
  CHECK(jumped >= 10);
  CHECK(jumped <= 13);
}

TEST_CASE("game: hands are at the ball while they hold it", "[long]") {
  Random random(1);
  const Game game(random);
  int held = 0;
  for (int i = 0; i < 1000; i++)
    for (int player = 0; player < 2; player++) {
      const double time = i / 100.0;
      const Posture posture = game.posture(player, time);
      const Bones bones = solve(posture);
      for (int hand = 0; hand < 2; hand++) {
        if (!game.holds(player, hand, time)) continue;
        held++;
        const Vec3 palm =
            bones.position[wrists[hand]] + posture.hand[hand].fingers * (0.09 * game.scale(player));
        INFO("player " << player << " hand " << hand << " at " << time);
        CHECK(std::abs(length(palm - game.ball_position(time)) - ball_radius - 0.026) < 0.03);
      }
    }
  CHECK(held > 500);
}

TEST_CASE("game: the ball flies without jumps, bounces on the floor, goes through the ring and comes back") {
  Random random(2);
  const Game game(random);
  double lowest = 9, highest = 0;
  for (int i = 0; i < 10000; i++) {
    const Vec3 at = game.ball_position(i / 1000.0);
    INFO("at " << i);
    CHECK(length(game.ball_position((i + 1) / 1000.0) - at) < 0.012); // 12 m/s
    lowest = std::min(lowest, at.y);
    highest = std::max(highest, at.y);
  }
  CHECK(lowest == Approx(ball_radius).margin(0.002));
  CHECK(highest > ring_centre.y + 0.3);
  CHECK(game.bounces().size() == 7);
  for (const double time : game.bounces())
    CHECK(game.ball_position(time).y == Approx(ball_radius).margin(1e-6));
  CHECK(length(game.ball_position(game.net_time()) - ring_centre) < 1e-6);
  CHECK(length(game.ball_position(game.duration()) - game.ball_position(0)) < 1e-9);
  for (const Vec3 axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}})
    CHECK(length(game.ball_rotation(game.duration() + 0.1) * axis - game.ball_rotation(0.1) * axis) < 1e-6);
}

TEST_CASE("game: bones move without jumps, and players keep apart", "[long]") {
  Random random(3);
  const Game game(random);
  double fastest = 0, nearest = 9;
  for (int i = 0; i < 1000; i++) {
    Bones now[2];
    for (int player = 0; player < 2; player++) {
      now[player] = solve(game.posture(player, i / 100.0));
      const Bones next = solve(game.posture(player, (i + 1) / 100.0));
      for (size_t j = 0; j < joint_count; j++) {
        const double speed = length(next.position[j] - now[player].position[j]) * 100;
        INFO("player " << player << " joint " << j << " at " << i / 100.0);
        CHECK(speed < 9);
        fastest = std::max(fastest, speed);
      }
    }
    for (size_t j = 0; j < joint_count; j++)
      for (size_t k = 0; k < joint_count; k++)
        nearest = std::min(nearest, length(now[0].position[j] - now[1].position[k]));
  }
  CHECK(fastest > 2);
  CHECK(nearest > 0.1); // a hand that is raised against the shot
}

TEST_CASE("game: the mesh is closed, and the ball is never inside a player", "[long]") {
  const Scene &scene = shared_scene();
  const Closedness found = closedness(scene.vertex_count(), scene.faces());
  CHECK(found.unmatched == 0);
  CHECK(found.pinched == 0);
  CHECK(scene.faces().size() / 3 < 80000);
  size_t players = 0;
  for (const Body &body : scene.players()) players += body.rest.vertices.size();
  for (int frame = 0; frame < frames; frame += 3) {
    const double time = frame / frame_rate;
    const Moment moment = scene.at(time);
    const Vec3 ball = scene.action().ball_position(time);
    double deepest = 0;
    for (size_t i = 0; i < players; i++)
      deepest = std::max(deepest, ball_radius - length(vertex(moment, i) - ball));
    INFO("frame " << frame);
    CHECK(deepest < 0.03);
  }
}

TEST_CASE("game: threads and runs make no difference", "[long]") {
  Settings settings = small_game();
  settings.threads = 3;
  const Scene &one = shared_scene();
  const Scene other(settings);
  CHECK(one.faces() == other.faces());
  fvv::render::SampleBuffer buffer(96, 54, 3);
  const Moment a = one.at(5.64), b = other.at(5.64);
  CHECK(a.positions == b.positions);
  CHECK(one.picture(3, a, buffer).rgb == other.picture(3, b, buffer).rgb);
}

TEST_CASE("game: the ceiling is in the pictures, and it is light") {
  const Scene &scene = shared_scene();
  const auto camera = std::find_if(scene.cameras().begin(), scene.cameras().end(), [](const fvv_camera &c) {
    return std::string(c.name, c.name_size) == "head0";
  });
  REQUIRE(camera != scene.cameras().end());
  const fvv::render::Projection projection(*camera);
  const Vec3 eye = projection.centre();
  const auto &stage = scene.empty_stage(size_t(camera - scene.cameras().begin()));
  const uint32_t x = camera->width / 2;
  const Vec3 way = projection.to_world_direction(projection.ray(x + 0.5, 0.5));
  const Vec3 hit = eye + way * ((ceiling_height - eye.y) / way.y);
  CHECK(way.y > 0);
  CHECK(std::abs(hit.x) < room_length / 2);
  CHECK(std::abs(hit.z) < room_width / 2);
  CHECK(stage[3 * x] > 0.02); // without a ceiling 0.012
}
