// decimate/decimate.h: as few triangles as a budget in pixels allows: the simplifier goes as far as the
// measured error permits, and what it spoils is given back. Knows meshes and footprints; knows no streams, no
// files and no options. Every function is pure and may run on any thread. docs/fvvmux-budget.md has the rules
// and what they cost.
#pragma once

#include "decimate/error.h"
#include "decimate/simplify.h"

#include <functional>

namespace fvv::decimate {

// No place of either surface may be further off than this many times the budget: 0.9 px at 0.15 px, so that
// no silhouette moves by a pixel. Errors that are spread like noise keep it; what breaks it is a part that
// was cut off.
constexpr double max_over_rms = 6;

struct Budget {
  double pixels = 0.15;          // rms over the surface, what rounding to the lattice adds included
  size_t triangles = 0;          // of a frame, in place of pixels, whatever that costs; 0: pixels hold
  uint32_t min_piece = 0;        // pieces of fewer faces are dropped before all else
  capture::Lattice lattice = {}; // that the stream has
};

// Connected pieces of the source, and their area in square metres.
struct Lost {
  size_t pieces = 0;
  double area = 0;
};

struct Report {
  size_t faces_before = 0, faces_after = 0;
  double volume_before = 0, volume_after = 0; // cubic metres, signed (enclosed_volume)
  Error error;                                // of the decimated surface on the lattice
  double reach = 0;                           // of the simplifier, metres; 0: nothing was decimated
  size_t held_faces = 0; // kept as they were, because max_over_rms would have been broken there
  Lost vanished;         // pieces of which nothing is left
  double thin_area = 0;  // square metres of the source further off than max_over_rms allows: thin parts
  size_t dropped_pieces = 0, dropped_faces = 0; // by min_piece
  bool kept = false; // the budget cannot be held with fewer faces: the source as it was
};

struct Decimated {
  capture::Mesh mesh;             // not yet rounded; vertices in the order of the source
  std::vector<uint32_t> vertices; // of the source, from which each came
  Report report;
};

// reach: where to begin, as find_reach answers; a frame that needs less goes further down by itself. A mesh
// with a coordinate that is not finite, or without area, comes back as it is, kept. A mesh that no camera
// sees is only decimated to a number of triangles.
Decimated decimate(const capture::Mesh &source, const Footprint &footprint, const Budget &budget,
                   double reach);

// The furthest reach of the simplifier, up to at_most, whose error in this frame is within the budget, within
// some percent; 0: none is. For the least of several frames hand what one answers to the next: mostly that
// frame has room for it, and a single attempt tells.
double find_reach(const capture::Mesh &source, const Footprint &footprint, const Budget &budget,
                  double at_most = INFINITY);

// ---- frames that share their faces -----------------------------------------------------------------------

// Frames 0 to count - 1 of constant topology: all meshes have the faces (and texture coordinates) of the
// first. Called for a frame again whenever it is needed.
struct Frames {
  size_t count;
  std::function<capture::Mesh(size_t)> mesh;
  std::function<Footprint(size_t)> footprint;
};

// What all frames of a run have in common after decimation, and how each came out.
class Run {
public:
  // The first frame's surface is what the simplifier sees; the budget holds in every frame, or the source is
  // kept. Vertices stay vertices of the source, exactly, so that motion stays as smooth as it was.
  Run(const Frames &frames, const Budget &budget, double reach);
  // frame: its number in the run; source: its mesh.
  Decimated apply(const capture::Mesh &source, size_t frame) const;

private:
  bool try_faces(const Frames &frames, const Budget &budget, const Reference &like,
                 std::vector<size_t> &order, Outliers &outliers, double &worst);

  std::vector<uint32_t> large_pieces; // faces of the source without what goes in front
  Report dropped;                     // what these were
  std::vector<uint32_t> faces;        // what is left; over the vertices of the source; empty: it is kept
  std::vector<Report> reports;
};

} // namespace fvv::decimate
