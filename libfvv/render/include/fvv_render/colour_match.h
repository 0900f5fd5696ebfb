// How cameras of a rig differ in exposure and white balance, from the surface that they see in common.
#pragma once

#include "fvv_render/rasteriser.h"

namespace fvv::render {

// A camera's picture. Borrowed.
struct MatchView {
  fvv_camera camera;             // valid; its pixels are those of the picture
  const uint8_t *pixels;         // R, G, B, display values, width x height, rows from the top
  const uint8_t *mask = nullptr; // a byte a pixel, above 127 where it shows the scene; NULL: everywhere
  const float *linear;           // the linear light of display values 0 ... 255, which rises
};

// Linear light of the places of a surface in one camera, R, G, B for each place; 0 where it cannot be
// compared.
using PlaceLight = std::vector<float>;

// The places of a mesh at which pictures are compared: some of its vertices, at most match_places.
constexpr size_t match_places = 10000;
class MatchSurface {
public:
  // positions: three for each vertex, finite, in any unit; the fronts of faces are outside.
  MatchSurface(const std::vector<double> &positions, std::vector<uint32_t> faces);

  // The mean light around each place that the camera sees well: turned to it by 60 degrees or less, away from
  // the silhouette and from edges of what hides other surface, neither near black nor clipped. May be called
  // by several threads.
  PlaceLight light(const MatchView &view) const;

private:
  Mesh mesh() const { return {positions.data(), positions.size() / 3, faces.data(), faces.size() / 3}; }

  Vec3 origin;
  double scale;                 // to a size that suits the rasteriser
  std::vector<float> positions; // (source - origin) * scale
  std::vector<uint32_t> faces, places;
  std::vector<Vec3> normals; // of places
};

struct CameraMatch {
  double gain[3] = {1, 1, 1}; // of linear light, R, G, B, by which its pictures become like the others'
  bool matched = false;       // else it shares too little surface with others, and its gains are 1
  size_t places = 0;          // of all frames, which it shares with any other camera
};

struct ColourMatch {
  std::vector<CameraMatch> cameras;
  // The root mean square of the differences between two cameras, as fractions, over pairs of cameras and
  // channels: of the pictures as they are, and with the gains.
  double before = 0, after = 0;

  double departure() const; // the largest difference of a gain from 1, as a fraction
};

// frames: PlaceLight of each camera, in one order; an empty one where a frame lacks the camera. Of each pair
// of cameras the median ratio counts, of all pairs those that agree with the others, so that highlights and
// surface that is reconstructed wrongly have little influence. The geometric mean of the gains of cameras
// that share surface is 1. Gains are rounded to multiples of 1/1024, so that the last bit of a logarithm
// does not show.
ColourMatch match_colours(const std::vector<std::vector<PlaceLight>> &frames);

} // namespace fvv::render
