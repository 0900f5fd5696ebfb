// decimate/attempt.h: the steps that a single frame and a run share: from faces to a report, and from what
// went wrong to faces that have to stay. Internal to decimate/.
#pragma once

#include "decimate/decimate.h"

namespace fvv::decimate {

// How often faces are given back before the simplifier has to go less far.
constexpr int rounds = 6;
// How often it goes less far before the source is kept.
constexpr int attempts = 8;

// Whether there is anything to decimate: finite coordinates, and an area.
bool sound(const capture::Mesh &mesh);

// The faces of pieces that are not below the budget's min_piece, and of which the lattice leaves something as
// they are: what it does not can't be kept by any decimation. What is left out is counted in report, as
// dropped and as vanished. All faces when every piece is: the canonicaliser has a message for that. source:
// as sound() wants it.
std::vector<uint32_t> without_specks(const capture::Mesh &source, const Budget &budget, Report &report);

// The source as it is, with the report of that.
Decimated as_it_is(const capture::Mesh &source);

// Measures a mesh, rounded to the lattice, and fills the report but for what its caller knows better (reach,
// held_faces, dropped) and what takes time (vanished). outliers: a fresh one.
Report look_at(const Reference &reference, const capture::Mesh &mesh, const Budget &budget,
               Outliers &outliers);

// Pieces of the source of which the mesh, rounded to the lattice, has nothing left. vertices: of the source,
// from which those of mesh came.
Lost vanished(const capture::Mesh &source, const capture::Mesh &mesh, const std::vector<uint32_t> &vertices,
              const Budget &budget);

// Adds to held the faces of the source around outliers. Answers whether another round is worth while: there
// are new ones, and not too many in all.
bool hold(const capture::Mesh &source, const std::vector<uint32_t> &alike, const capture::Mesh &decimated,
          const std::vector<uint32_t> &vertices, const Outliers &outliers, std::vector<bool> &held);

// The next, smaller reach after an error in pixels.
double shorter(double reach, double pixels, const Budget &budget);

} // namespace fvv::decimate
