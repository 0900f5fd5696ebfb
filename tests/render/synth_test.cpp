// The made-up scene: determinism, closed surfaces, plausible motion.
#include "closed.h"
#include "fvv_catch.h"

#include "fvvsynth/scene.h"

#include <algorithm>
#include <cmath>
#include <set>

using namespace fvv::synth;

namespace {

Settings small(uint64_t seed) {
  Settings settings;
  settings.rig = RigKind::small;
  settings.seed = seed;
  settings.cameras = 3;
  settings.width = 64;
  settings.height = 36;
  return settings;
}

Vec3 vertex(const Moment &moment, size_t i) {
  return {moment.positions[3 * i], moment.positions[3 * i + 1], moment.positions[3 * i + 2]};
}

double face_area(const Scene &scene, const Moment &moment, size_t face) {
  const uint32_t *v = scene.faces().data() + 3 * face;
  const Vec3 a = vertex(moment, v[0]);
  return length(cross(vertex(moment, v[1]) - a, vertex(moment, v[2]) - a)) / 2;
}

} // namespace

TEST_CASE("the same seed gives the same scene, another seed another one", "[long]") {
  const Scene one(small(5)), same(small(5)), other(small(6));
  CHECK(one.faces() == same.faces());
  CHECK(one.at(0.4).positions == same.at(0.4).positions);
  CHECK(one.at(0.4).positions != other.at(0.4).positions);
  CHECK(one.cameras()[0].translation[0] == same.cameras()[0].translation[0]);
  CHECK(one.cameras()[0].translation[0] != other.cameras()[0].translation[0]);
  fvv::render::SampleBuffer buffer(64, 36, 3);
  const auto picture = one.picture(1, one.at(0.4), buffer);
  CHECK(picture.rgb == same.picture(1, same.at(0.4), buffer).rgb);
  CHECK(picture.rgb != other.picture(1, other.at(0.4), buffer).rgb);
  CHECK(one.faces() == other.faces()); // topology depends on the figures, not on the seed
}

TEST_CASE("the mesh is three closed surfaces of the intended size") {
  const Scene scene(small(1));
  const auto &faces = scene.faces();
  CHECK(faces.size() / 3 > 34000);
  CHECK(faces.size() / 3 < 36000);
  CHECK(scene.vertex_count() > 17000);
  CHECK(scene.vertex_count() < 18000);
  const Closedness found = closedness(scene.vertex_count(), faces);
  CHECK(found.unmatched == 0);
  CHECK(found.pinched == 0);
  // V - E + F of three spheres.
  CHECK(scene.vertex_count() - found.edges + faces.size() / 3 == 6);
}

TEST_CASE("no face degenerates or is stretched beyond belief, volumes stay", "[long]") {
  for (const uint64_t seed : {1u, 2u}) {
    const Scene scene(small(seed));
    const auto &faces = scene.faces();
    const auto volume = [&](const Moment &moment) {
      double sum = 0;
      for (size_t i = 0; i < faces.size(); i += 3)
        sum +=
            dot(vertex(moment, faces[i]), cross(vertex(moment, faces[i + 1]), vertex(moment, faces[i + 2]))) /
            6;
      return sum;
    };
    double smallest = 1, longest = 0;
    for (int frame = 0; frame < 100; frame += 3) {
      const Moment moment = scene.at(frame / 25.0);
      for (size_t i = 0; i < faces.size() / 3; i++)
        smallest = std::min(smallest, face_area(scene, moment, i));
      for (size_t i = 0; i < faces.size(); i++) {
        const size_t following = i % 3 == 2 ? i - 2 : i + 1;
        longest = std::max(longest, length(vertex(moment, faces[i]) - vertex(moment, faces[following])));
      }
      // Two people of 75 to 110 litres; positive, so that faces are counter-clockwise from outside.
      CHECK(volume(moment) > 0.13);
      CHECK(volume(moment) < 0.23);
    }
    CHECK(smallest > 1e-8);
    CHECK(longest < 0.09);
  }
}

TEST_CASE("feet are on the floor, and one of each player's always is", "[nightly]") {
  for (const uint64_t seed : {1u, 2u, 3u}) {
    const Scene scene(small(seed));
    for (int frame = 0; frame < 100; frame++) {
      const Moment moment = scene.at(frame / 25.0);
      double lowest[2] = {1, 1};
      const size_t ball = scene.vertex_count() - 1002;
      for (size_t i = 0; i < ball; i++) {
        double &low = lowest[moment.positions[3 * i] > 0];
        low = std::min(low, double(moment.positions[3 * i + 1]));
      }
      INFO("seed " << seed << " frame " << frame);
      for (const double low : lowest) {
        CHECK(low > -0.03);
        CHECK(low < 0.01);
      }
    }
  }
}

TEST_CASE("the ball moves without jumps, stays above the floor, and reaches both players") {
  for (const uint64_t seed : {1u, 2u}) {
    const Scene scene(small(seed));
    const Action &action = scene.action();
    double left = 0, right = 0, lowest = 9;
    for (int i = 0; i < 4000; i++) {
      const Vec3 at = action.ball_position(i / 1000.0);
      CHECK(length(action.ball_position((i + 1) / 1000.0) - at) < 0.012); // 12 m/s
      left = std::min(left, at.x);
      right = std::max(right, at.x);
      lowest = std::min(lowest, at.y);
    }
    CHECK(left < -0.7);
    CHECK(right > 0.7);
    CHECK(lowest == Approx(ball_radius).margin(0.006));
    CHECK(length(action.ball_position(4.0) - action.ball_position(0)) < 1e-9);
  }
}

TEST_CASE("the mesh of the ball is on its path") {
  const Scene scene(small(4));
  for (const double time : {0.0, 0.52, 1.2, 1.9}) {
    const Moment moment = scene.at(time);
    double worst = 0;
    for (size_t i = scene.vertex_count() - 1002; i < scene.vertex_count(); i++)
      worst = std::max(
          worst, std::abs(length(vertex(moment, i) - scene.action().ball_position(time)) - ball_radius));
    CHECK(worst < 1e-5);
  }
}

TEST_CASE("hands are at the ball while it is held, and limbs keep their lengths") {
  for (const uint64_t seed : {1u, 2u, 3u, 4u}) {
    Random random(seed);
    const Play play(random);
    const auto &rest = rest_joints();
    const Timing &t = play.ball().timing();
    for (int i = 0; i < 400; i++) {
      const double time = i / 100.0;
      for (int player = 0; player < 2; player++) {
        const Bones bones = solve(play.posture(player, time));
        for (const Joint joint : {left_forearm, left_hand, right_forearm, right_hand, left_shin, left_foot,
                                  right_shin, right_foot}) {
          const double expected = length(rest[joint] - rest[joint - 1]) * play.scale(player);
          CHECK(length(bones.position[joint] - bones.position[joint - 1]) == Approx(expected).epsilon(1e-6));
        }
        const double own = std::fmod(time - player * half_cycle + cycle, cycle);
        const bool both = (own > t.gather + 0.12 && own < t.pass) ||
                          (own > half_cycle + t.take && own < half_cycle + t.take + 0.15);
        const bool one = both || own < t.push_end || own > half_cycle + t.take;
        const auto reach = [&](Joint hand) {
          return length(bones.position[hand] - play.ball().position(time));
        };
        INFO("seed " << seed << " player " << player << " own time " << own);
        if (one) CHECK(reach(right_hand) < 0.22);
        if (both) CHECK(reach(left_hand) < 0.22);
      }
    }
  }
}

TEST_CASE("bones move without jumps") {
  Random random(9);
  const Play play(random);
  double fastest = 0;
  for (int i = 0; i < 2000; i++)
    for (int player = 0; player < 2; player++) {
      const Bones a = solve(play.posture(player, i / 500.0)),
                  b = solve(play.posture(player, (i + 1) / 500.0));
      for (size_t j = 0; j < joint_count; j++)
        fastest = std::max(fastest, length(b.position[j] - a.position[j]) * 500);
    }
  CHECK(fastest > 1); // m/s: they do move
  CHECK(fastest < 9);
}

TEST_CASE("cameras are around the scene and look at it") {
  Settings settings = small(3);
  settings.cameras = 9;
  const Scene scene(settings);
  REQUIRE(scene.cameras().size() == 9);
  for (const fvv_camera &camera : scene.cameras()) {
    fvv_diagnostic diagnostic = {};
    CHECK(fvv_camera_validate(&camera, &diagnostic) == FVV_OK);
    double centre[3], pixel[2], depth;
    fvv_camera_centre(&camera, centre);
    CHECK(centre[1] >= 1.5);
    CHECK(centre[1] <= 3.0);
    const double middle[3] = {0, 0.95, 0};
    REQUIRE(fvv_camera_project(&camera, middle, pixel, &depth) == 1);
    CHECK(std::abs(pixel[0] - 32) < 3);
    CHECK(std::abs(pixel[1] - 18) < 3);
    CHECK(depth / camera.fx * 64 / 480 == Approx(0.014).epsilon(0.15)); // metres of a pixel at 480 wide
  }
  settings.cameras = 65;
  CHECK_THROWS_AS(Scene(settings), std::invalid_argument);
  settings = small(3);
  settings.width = 15;
  CHECK_THROWS_AS(Scene(settings), std::invalid_argument);
}

TEST_CASE("the studio has thirteen unlike cameras that see the action") {
  Settings settings = small(3);
  settings.rig = RigKind::studio;
  settings.width = 96;
  settings.height = 54;
  const Scene scene(settings);
  const auto &cameras = scene.cameras();
  REQUIRE(cameras.size() == 13);
  double shortest = 9, longest = 0, lowest_k1 = 0, highest_k1 = 0;
  std::set<uint32_t> widths;
  for (size_t i = 0; i < 13; i++) {
    const fvv_camera &camera = cameras[i];
    const std::string name(camera.name, camera.name_size);
    INFO(name);
    fvv_diagnostic diagnostic = {};
    CHECK(fvv_camera_validate(&camera, &diagnostic) == FVV_OK);
    double centre[3], pixel[2];
    fvv_camera_centre(&camera, centre);
    CHECK(name == (i < 10   ? "oval" + std::to_string(i)
                   : i < 12 ? "head" + std::to_string(i - 10)
                            : std::string("overhead")));
    CHECK(centre[1] == Approx(i < 10 ? 2.5 : i < 12 ? 1.7 : 7.0));
    const double zoom = camera.fx / camera.width;
    shortest = std::min(shortest, zoom);
    longest = std::max(longest, zoom);
    widths.insert(camera.width);
    lowest_k1 = std::min(lowest_k1, camera.distortion[0]);
    highest_k1 = std::max(highest_k1, camera.distortion[0]);
    for (const double x : {-1.6, 1.6})
      for (const double y : {0.1, 1.7}) {
        const double world[3] = {x, y, 0};
        REQUIRE(fvv_camera_project(&camera, world, pixel, nullptr) == 1);
        CHECK(pixel[0] > 0);
        CHECK(pixel[0] < camera.width);
        CHECK(pixel[1] > 0);
        CHECK(pixel[1] < camera.height);
      }
    // The lens reaches every corner of the picture.
    for (int corner = 0; corner < 4; corner++) {
      const double at[2] = {corner & 1 ? double(camera.width) : 0, corner & 2 ? double(camera.height) : 0};
      double ray[3];
      CHECK(fvv_camera_unproject(&camera, at, ray) == 1);
    }
  }
  CHECK(longest / shortest > 1.4);
  CHECK(widths.size() == 3);
  CHECK(lowest_k1 == -0.2);
  CHECK(highest_k1 == 0.1);
  settings.width = studio_max_side + 1;
  CHECK_THROWS_AS(Scene(settings), std::invalid_argument);
}
