// decimate/error.h: how far a decimated surface lies from its source, in pixels of the cameras. Knows meshes
// and footprints; knows no simplifier. docs/fvvmux-budget.md says what is bounded, and why this.
#pragma once

#include "decimate/footprint.h"
#include "fvvcompare/surface.h"

namespace fvv::decimate {

// Distances between surfaces, from all vertices of the source to the decimated surface and from samples of
// that to the source; rms is weighted by area and that of the worse direction, max the larger one.
struct Error {
  double rms = 0, max = 0;               // metres
  double rms_pixels = 0, max_pixels = 0; // each distance divided by what a pixel covers there
};

// Places that a measurement found further off than a limit.
struct Outliers {
  std::vector<uint32_t> vertices; // of the source, those nearest to such a sample included
  std::vector<uint32_t> faces;    // of the decimated surface, with such a sample
  double area = 0;                // square metres of the source that are beyond the limit
};

// A source that decimated meshes are held against. const members may run on any thread.
class Reference {
public:
  // source is borrowed; every coordinate finite, every index in range, there is an area.
  // like: NULL, or one of a mesh with the same faces, which saves time.
  Reference(const capture::Mesh &source, const Footprint &footprint, const Reference *like = nullptr);

  // outliers: what there is is added.
  Error measure(const compare::Faces &decimated, double limit_pixels, Outliers &outliers) const;

  const capture::Mesh &mesh() const { return source; }
  // What a pixel covers at a vertex, metres; of cells of 1/32 of the mesh's diagonal, over which it changes
  // by a hundredth where cameras stand a few diagonals off. Infinite where there are no cameras.
  double pixel(uint32_t vertex) const { return pixels[vertex]; }
  // The smallest of them; infinite without cameras.
  double sharpest() const { return smallest; }
  // Vertices with an area, neighbours mostly after each other.
  const std::vector<uint32_t> &along_surface() const { return order; }
  // guess, enough: as ClosestFinder has them.
  render::ClosestPoint nearest(render::Vec3 from, uint32_t guess, double enough = -1) const {
    return finder.nearest(from, guess, enough);
  }
  // A third of the area of the faces around each vertex.
  double area(uint32_t vertex) const { return areas[vertex]; }

private:
  const capture::Mesh &source;
  std::vector<double> areas, pixels;
  std::vector<uint32_t> order;
  double smallest = INFINITY;
  render::ClosestFinder finder;
};

} // namespace fvv::decimate
