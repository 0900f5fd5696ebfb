// A player of the game: finer than that of the practice. Head and hands are surfaces of their own, with
// shorter edges; cloth has folds, hair is uneven.
#pragma once

#include "fvvsynth/body/body.h"

#include <cstdint>

namespace fvv::synth {

// Trunk and limbs, head, left and right hand: four closed surfaces, the ends of necks and wrists inside the
// first. key: of the folds' noise, see cloth_fold.
Body make_player(Hair hair, uint32_t key);

// How deep a point of jersey or shorts is in a fold: 0 on the ridges, 1 in the valleys.
double cloth_fold(Vec3 rest, uint32_t key);

} // namespace fvv::synth
