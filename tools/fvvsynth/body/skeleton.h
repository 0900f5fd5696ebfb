// The joints of a player, how they move and how they carry the skin (linear-blend skinning). Metres; at rest
// the player is upright on y = 0 facing +z, his left is +x, arms spread downwards.
#pragma once

#include "fvv_render/vector.h"

#include <array>
#include <cstdint>

namespace fvv::synth {

using render::Mat3;
using render::Vec3;

// One bone starts at each joint. In the limbs each bone follows its parent.
enum Joint : uint8_t {
  pelvis,
  spine,
  chest,
  head,
  left_upper_arm,
  left_forearm,
  left_hand,
  right_upper_arm,
  right_forearm,
  right_hand,
  left_thigh,
  left_shin,
  left_foot,
  right_thigh,
  right_shin,
  right_foot,
  left_fingers, // the four fingers bend together
  left_fingertips,
  left_thumb,
  right_fingers,
  right_fingertips,
  right_thumb,
  joint_count
};

// Joint positions at rest, and the directions of the limbs there.
const std::array<Vec3, joint_count> &rest_joints();
Vec3 rest_arm(int side);  // unit vector from shoulder to hand; side: +1 left, -1 right
Vec3 rest_leg(int side);  // unit vector from hip to ankle
Vec3 rest_palm(int side); // unit vector that the palm faces

// The goal of a hand: position of the wrist, directions of fingers and palm (unit vectors), and how far the
// fingers are bent in each of two joints, in radians.
struct HandGoal {
  Vec3 wrist, fingers, palm;
  double curl = 0;
};
struct FootGoal {
  Vec3 ankle;
  Mat3 rotation; // of the rest foot, whose toes point to +z
};

// A posture in world axes. Index 0 is left, 1 right.
struct Posture {
  double scale = 1; // of the player against the rest figure
  Vec3 pelvis;
  Mat3 pelvis_rotation, chest_rotation, head_rotation;
  HandGoal hand[2];
  FootGoal foot[2];
  Vec3 elbow_towards[2], knee_towards[2]; // the side to which the joint bends
};

// Where each bone is: rest point p of bone b goes to rotation[b] * (p - rest_joints()[b]) * scale +
// position[b].
struct Bones {
  double scale;
  std::array<Vec3, joint_count> position;
  std::array<Mat3, joint_count> rotation;
};

// Limbs by two-bone inverse kinematics. A goal beyond reach is approached along the straight line; bone
// lengths never change.
Bones solve(const Posture &posture);

Mat3 rotation_about(Vec3 unit_axis, double radians);
// The frame whose z is along forward and whose y is as near to up as it can be.
Mat3 facing(Vec3 forward, Vec3 up);

} // namespace fvv::synth
