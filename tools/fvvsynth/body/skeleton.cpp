// Rest skeleton and inverse kinematics.
#include "fvvsynth/body/skeleton.h"

#include <algorithm>
#include <cmath>

namespace fvv::synth {

namespace {

constexpr double upper_arm_length = 0.30, forearm_length = 0.27, thigh_length = 0.45, shin_length = 0.44;

std::array<Vec3, joint_count> make_rest() {
  std::array<Vec3, joint_count> joint;
  joint[pelvis] = {0, 1.00, 0};
  joint[spine] = {0, 1.10, -0.01};
  joint[chest] = {0, 1.28, -0.01};
  joint[head] = {0, 1.56, -0.012};
  for (const int side : {1, -1}) {
    const size_t arm = side > 0 ? left_upper_arm : right_upper_arm, leg = side > 0 ? left_thigh : right_thigh;
    joint[arm] = {side * 0.185, 1.47, -0.015};
    joint[arm + 1] = joint[arm] + rest_arm(side) * upper_arm_length;
    joint[arm + 2] = joint[arm + 1] + rest_arm(side) * forearm_length;
    const size_t finger = side > 0 ? left_fingers : right_fingers;
    joint[finger] = joint[arm + 2] + rest_arm(side) * 0.090;
    joint[finger + 1] = joint[finger] + rest_arm(side) * 0.042;
    joint[finger + 2] = joint[arm + 2] + rest_arm(side) * 0.030 + Vec3{0, 0, 0.028};
    joint[leg] = {side * 0.095, 0.95, 0};
    joint[leg + 1] = joint[leg] + rest_leg(side) * thigh_length;
    joint[leg + 2] = joint[leg + 1] + rest_leg(side) * shin_length;
  }
  return joint;
}

// The smallest rotation that takes unit vector a to unit vector b (Rodrigues). Half a turn does not occur
// between a limb and its rest direction; there the axis is arbitrary and the turn stops a little short.
Mat3 swing(Vec3 a, Vec3 b) {
  const Vec3 v = cross(a, b);
  const double k = 1 / std::max(1 + dot(a, b), 1e-4);
  const auto column = [&](Vec3 e) { return e + cross(v, e) + cross(v, cross(v, e)) * k; };
  return {column({1, 0, 0}), column({0, 1, 0}), column({0, 0, 1})};
}

// Rotation that takes the frame (along, beside) to the frame (new_along, as near to new_beside as can be).
Mat3 turn(Vec3 along, Vec3 beside, Vec3 new_along, Vec3 new_beside) {
  return facing(new_along, new_beside) * transposed(facing(along, beside));
}

// Middle joint of a chain of two bones from start to at most end (law of cosines).
struct Chain {
  Vec3 middle, end;
};
Chain bend(Vec3 start, Vec3 goal, double first, double second, Vec3 towards) {
  const Vec3 span = goal - start;
  const double distance =
      std::clamp(length(span), std::abs(first - second) + 0.01, (first + second) * 0.9995);
  const Vec3 along = normalised(span);
  const Vec3 side = normalised(towards - along * dot(along, towards));
  const double x = (first * first - second * second + distance * distance) / (2 * distance);
  const double y = std::sqrt(std::max(0.0, first * first - x * x));
  return {start + along * x + side * y, start + along * distance};
}

void pose_arm(const Posture &posture, int i, Bones &bones) {
  const int side = i == 0 ? 1 : -1;
  const size_t upper = i == 0 ? left_upper_arm : right_upper_arm;
  const HandGoal &goal = posture.hand[i];
  const double s = posture.scale;
  const Chain chain = bend(bones.position[upper], goal.wrist, upper_arm_length * s, forearm_length * s,
                           posture.elbow_towards[i]);
  const Vec3 rest = rest_arm(side);
  const Vec3 to_elbow = normalised(chain.middle - bones.position[upper]);
  const Vec3 to_wrist = normalised(chain.end - chain.middle);
  bones.rotation[upper] = swing(bones.rotation[chest] * rest, to_elbow) * bones.rotation[chest];
  // The forearm shares the twist between upper arm and hand (pronation), so that no joint takes all of it.
  const Mat3 swung = swing(bones.rotation[upper] * rest, to_wrist) * bones.rotation[upper];
  const Vec3 palm = normalised(goal.palm - to_wrist * dot(goal.palm, to_wrist));
  bones.rotation[upper + 1] = turn(rest, rest_palm(side), to_wrist, swung * rest_palm(side) + palm);
  bones.rotation[upper + 2] = turn(rest, rest_palm(side), goal.fingers, goal.palm);
  bones.position[upper + 1] = chain.middle;
  bones.position[upper + 2] = chain.end;
  // Fingers bend towards the palm, the thumb towards the fingers.
  const size_t finger = i == 0 ? left_fingers : right_fingers;
  const auto &joints = rest_joints();
  const auto bent = [&](size_t joint, size_t parent, Vec3 axis, double angle) {
    bones.position[joint] =
        bones.position[parent] + bones.rotation[parent] * (joints[joint] - joints[parent]) * s;
    bones.rotation[joint] = bones.rotation[parent] * rotation_about(axis, angle);
  };
  const Vec3 across = normalised(cross(rest, rest_palm(side)));
  bent(finger, upper + 2, across, goal.curl);
  bent(finger + 1, finger, across, goal.curl);
  bent(finger + 2, upper + 2, normalised(cross(Vec3{0, 0, 1}, rest_palm(side))), 0.5 * goal.curl);
}

void pose_leg(const Posture &posture, int i, Bones &bones) {
  const int side = i == 0 ? 1 : -1;
  const size_t thigh = i == 0 ? left_thigh : right_thigh;
  const double s = posture.scale;
  const Chain chain = bend(bones.position[thigh], posture.foot[i].ankle, thigh_length * s, shin_length * s,
                           posture.knee_towards[i]);
  const Vec3 rest = rest_leg(side);
  const Vec3 to_knee = normalised(chain.middle - bones.position[thigh]);
  const Vec3 to_ankle = normalised(chain.end - chain.middle);
  bones.rotation[thigh] = turn(rest, {0, 0, 1}, to_knee,
                               swing(bones.rotation[pelvis] * rest, to_knee) * bones.rotation[pelvis].z +
                                   posture.knee_towards[i]);
  bones.rotation[thigh + 1] = swing(bones.rotation[thigh] * rest, to_ankle) * bones.rotation[thigh];
  bones.rotation[thigh + 2] = posture.foot[i].rotation;
  bones.position[thigh + 1] = chain.middle;
  bones.position[thigh + 2] = chain.end;
}

} // namespace

Vec3 rest_arm(int side) {
  return normalised(Vec3{side * 0.82, -0.57, 0});
}
Vec3 rest_leg(int side) {
  return normalised(Vec3{side * 0.22, -0.975, 0});
}
Vec3 rest_palm(int side) {
  return normalised(Vec3{side * -0.57, -0.82, 0});
}

const std::array<Vec3, joint_count> &rest_joints() {
  static const std::array<Vec3, joint_count> joints = make_rest();
  return joints;
}

Mat3 rotation_about(Vec3 axis, double radians) {
  const double c = std::cos(radians), s = std::sin(radians);
  const auto column = [&](Vec3 e) { return e * c + cross(axis, e) * s + axis * (dot(axis, e) * (1 - c)); };
  return {column({1, 0, 0}), column({0, 1, 0}), column({0, 0, 1})};
}

Mat3 facing(Vec3 forward, Vec3 up) {
  const Vec3 z = normalised(forward);
  const Vec3 x = normalised(cross(up, z));
  return {x, cross(z, x), z};
}

Bones solve(const Posture &posture) {
  const auto &rest = rest_joints();
  Bones bones;
  bones.scale = posture.scale;
  const auto place = [&](Joint joint, Joint parent, const Mat3 &rotation) {
    bones.position[joint] =
        bones.position[parent] + bones.rotation[parent] * (rest[joint] - rest[parent]) * posture.scale;
    bones.rotation[joint] = rotation;
  };
  // The spine takes half of the turn between pelvis and chest.
  const Mat3 &p = posture.pelvis_rotation, &c = posture.chest_rotation;
  bones.position[pelvis] = posture.pelvis;
  bones.rotation[pelvis] = p;
  place(spine, pelvis, facing(p.z + c.z, p.y + c.y));
  place(chest, spine, c);
  place(head, chest, posture.head_rotation);
  for (int i = 0; i < 2; i++) {
    const Joint arm = i == 0 ? left_upper_arm : right_upper_arm, thigh = i == 0 ? left_thigh : right_thigh;
    place(arm, chest, c);
    place(thigh, pelvis, p);
    pose_arm(posture, i, bones);
    pose_leg(posture, i, bones);
  }
  return bones;
}

} // namespace fvv::synth
