// A player as a triangle mesh that its bones carry, and the ball. Knows the figure and the skeleton; knows no
// motion and no colour.
#pragma once

#include "fvvsynth/field.h"
#include "fvvsynth/surface_nets.h"

#include <array>

namespace fvv::synth {

struct Influence { // of bones on a vertex; weights sum to 1
  std::array<Joint, 4> joint;
  std::array<float, 4> weight;
};

struct Body {
  Surface rest;
  std::vector<Influence> influences; // one per vertex
  std::vector<float> exposure;       // one per vertex: how open the rest shape is there, 0..1
};

// One connected closed surface of about 16,500 triangles.
Body make_body(Hair hair);

// Linear-blend skinning: the vertices of body carried by bones, appended to positions (x y z, metres).
void carry(const Body &body, const Bones &bones, std::vector<float> &positions);

// A sphere of radius 1 of 20 n^2 triangles of almost equal size (subdivided icosahedron).
Surface make_ball(uint32_t n);

} // namespace fvv::synth
