// The pieces of meshes followed from frame to frame: which of them are one object over time. Frames are given
// in their order. Where pieces merge or come apart, that is reported, and a guess is marked as one.
#pragma once

#include "fvv_geometry/mesh.h"
#include "fvv_render/vector.h"

#include <optional>
#include <vector>

namespace fvv::objects {

using render::Vec3;

// A connected piece of a mesh.
struct Piece {
  Vec3 centre;              // of its surface, by area
  double area = 0;          // square metres
  double radius = 0;        // from the centre to the furthest vertex
  std::vector<Vec3> places; // of some vertices, evenly chosen
};

// Those with at least a hundredth of the area of the largest one, the largest first. Vertices at one place
// are one.
std::vector<Piece> pieces_of(const geometry::Mesh &mesh);

struct Object {
  double radius = 0; // the largest of its pieces, of those that are no other's as well
  double area = 0;   // of the first of them
  // Of each frame the centre of its piece, which may be that of several objects.
  std::vector<std::optional<Vec3>> path;
};

// Objects that form one piece from frame first to frame last.
struct Touch {
  std::vector<size_t> objects; // by rising index
  size_t first, last;
  // Whether sizes and places say which piece is which object afterwards. True where they never part.
  bool is_sure = true;
};

// A piece that came off another one, and is followed as an object of its own.
struct Split {
  size_t from, object;
  size_t frame; // the first with both
};

struct Following {
  std::vector<Object> objects; // by their first frame, the larger one first
  std::vector<Touch> touches;  // by their first frame
  std::vector<Split> splits;   // likewise
};

// frames: the pieces of each, as pieces_of finds them; seconds: between two frames. Objects that are there
// for less than a fifth of a second in all are left out, unless that is half of the frames.
Following follow(const std::vector<std::vector<Piece>> &frames, double seconds);

} // namespace fvv::objects
