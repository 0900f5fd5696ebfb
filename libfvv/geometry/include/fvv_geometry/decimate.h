// As few triangles as a budget in pixels allows: the simplifier goes as far as the measured error permits,
// and source faces are restored where the error is too large. docs/encoding/budget.md has the rules and their
// cost. Every function is pure and may run on any thread.
#pragma once

#include "fvv/calibration.h"
#include "fvv_geometry/surface.h"

#include <cmath>
#include <functional>
#include <vector>

namespace fvv::decimate {

// The camera that sees a place sharpest. Lengths in the unit of the cameras, usually metres.
struct Sight {
  double metres_per_pixel = INFINITY; // the smallest over all directions; infinite: no camera sees the place
  double distance = 0;
  uint16_t camera = 0;
};

class Footprint {
public:
  // scale_x, scale_y: pixels of the transmitted picture per pixel of the camera's. For a valid camera, of
  // which all but the name is copied.
  void add(const fvv_camera &camera, double scale_x, double scale_y);
  // A pixel has this size everywhere, whatever cameras see: for a budget that is a length.
  static Footprint uniform(double metres_per_pixel);
  bool empty() const { return views.empty() && !std::isfinite(size); }

  // Of the cameras whose picture contains the place; where none does, of those that would see it in a larger
  // picture, so that places just outside are not treated as unseen. Perspective, skew and the lens are
  // included: the result is the largest singular value of the derivative of the projection, for the worst
  // displacement across the ray.
  Sight look(const double point[3]) const;

private:
  struct View {
    fvv_camera camera;
    double centre[3], scale_x, scale_y;
  };
  std::vector<View> views;
  double size = INFINITY; // of a pixel, when it is uniform
};

// Distances between surfaces, from all vertices of the source to the decimated surface and from samples of
// that to the source; rms is weighted by area and that of the worse direction, max the larger one.
struct SurfaceError {
  double rms = 0, max = 0;               // metres
  double rms_pixels = 0, max_pixels = 0; // each distance divided by what a pixel covers there
};

// Places whose measured distance exceeds a limit.
struct Outliers {
  std::vector<uint32_t> vertices; // of the source, those nearest to such a sample included
  std::vector<uint32_t> faces;    // of the decimated surface, with such a sample
  double area = 0;                // square metres of the source that are beyond the limit
};

// Which places are compared: vertices of the source and samples of the other surface, or also the centres of
// the source's faces, unless a vertex is off already, and more samples.
enum class Looks { at_vertices, within_faces };

// A source that decimated meshes are compared with. const members may run on any thread.
class Reference {
public:
  // source is borrowed; every coordinate finite, every index in range, there is an area.
  // like: NULL, or one of a mesh with the same faces, which saves time.
  Reference(const geometry::Mesh &source, const Footprint &footprint, const Reference *like = nullptr);

  // Appends to outliers.
  SurfaceError measure(const compare::Faces &decimated, double limit_pixels, Outliers &outliers,
                       Looks looks = Looks::at_vertices) const;

  const geometry::Mesh &mesh() const { return source; }
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
  const geometry::Mesh &source;
  std::vector<double> areas, pixels;
  std::vector<uint32_t> order;
  double smallest = INFINITY;
  render::ClosestFinder finder;
};

// The largest permitted distance of any place of either surface, as a multiple of the budget: 0.9 px at 0.15
// px, so that no silhouette moves by a pixel. Noise-like errors stay within it; parts that were cut off do
// not.
constexpr double max_over_rms = 6;

// Which meshes are measured. What is not measured is not promised: its error is about the simplifier's own.
enum class Checks {
  all,  // every frame, until it is within the budget and all its places within max_over_rms
  some, // of frames that share their faces the first, last, middle and every eighth; places within 3
        // max_over_rms
  none  // no frame; pieces do not vanish
};

struct Budget {
  double pixels = 0.15;           // rms over the surface, including rounding to the lattice
  size_t triangles = 0;           // of a frame, in place of pixels, at any error; 0: pixels apply
  uint32_t min_piece = 0;         // pieces of fewer faces are dropped before all else
  geometry::Lattice lattice = {}; // that the stream has
  Checks checks = Checks::all;    // with triangles of all frames

  // What any place may be off, times pixels, and in pixels.
  double most_over_rms() const { return (checks == Checks::some ? 3 : 1) * max_over_rms; }
  double most() const { return most_over_rms() * pixels; }
};

// Connected pieces of the source, and their area in square metres.
struct Lost {
  size_t pieces = 0;
  double area = 0;
};

// The pieces that vanish on the budget's lattice, whatever is decimated, but for those below its min_piece.
// None if all do.
Lost vanishing_pieces(const geometry::Mesh &source, const Budget &budget);

// The closed pieces that remain on a lattice but lose half their volume or more, as plates thinner than a
// step do, whose two sides become one. None of those that are only a few steps large.
Lost flattened_pieces(const geometry::Mesh &source, const geometry::Lattice &lattice);

// Square metres of the faces that others cover on a lattice, corner on corner, but not in the source.
double merged_area(const geometry::Mesh &source, const geometry::Lattice &lattice);

struct Report {
  size_t faces_before = 0, faces_after = 0;
  double volume_before = 0, volume_after = 0; // cubic metres, signed (enclosed_volume)
  SurfaceError error;                         // of the decimated surface on the lattice
  double target_error = 0;                    // of the simplifier, metres; 0: nothing was decimated
  size_t locked_faces = 0; // not changed, because max_over_rms would have been exceeded there
  Lost vanished;           // pieces of which nothing is left
  double thin_area = 0;    // square metres of the source further off than max_over_rms allows: thin parts
  size_t dropped_pieces = 0, dropped_faces = 0; // by min_piece
  // A hull in another frame's faces, whose outlines are within the budget (track.h); its distance from the
  // frame's own hull need not be, and thin_area is 0.
  bool by_outlines = false;
  bool measured = true; // error, volumes and thin_area are known
  bool kept = false;    // the budget cannot be met with fewer faces: the unchanged source
};

// Measures a mesh, rounded to the budget's lattice, and fills the report but for target_error, locked_faces,
// vanished and what was dropped. outliers: empty; receives what is beyond max_over_rms.
Report measure_on_lattice(const Reference &reference, const geometry::Mesh &mesh, const Budget &budget,
                          Outliers &outliers, Looks looks = Looks::at_vertices);

struct Decimated {
  geometry::Mesh mesh;            // not yet rounded; vertices in the order of the source
  std::vector<uint32_t> vertices; // of the source, from which each came
  Report report;
};

// target_error: where to begin, from find_target_error; it is reduced where a frame needs less. A mesh with a
// coordinate that is not finite, or without area, is returned unchanged, as kept. A mesh that no camera sees
// is only decimated to a number of triangles.
Decimated decimate(const geometry::Mesh &source, const Footprint &footprint, const Budget &budget,
                   double target_error);

// The largest target error of the simplifier, up to at_most, whose error in this frame is within the budget,
// within some percent; 0: none is. For the minimum over several frames pass the result for one to the next:
// mostly it is within the budget there too, and a single attempt is enough.
double find_target_error(const geometry::Mesh &source, const Footprint &footprint, const Budget &budget,
                         double at_most = INFINITY);

// ---- frames that share their faces -----------------------------------------------------------------------

// Frames 0 to count - 1 of constant topology: all meshes have the faces (and texture coordinates) of the
// first. Called several times for a frame.
struct Frames {
  size_t count;
  std::function<geometry::Mesh(size_t)> mesh;
  std::function<Footprint(size_t)> footprint;
};

// What all frames of a run share after decimation, and the report of each.
class TopologyRun {
public:
  // The simplifier works on the surface of the first frame; the budget is met in every frame, or the source
  // is kept. Vertices are exactly vertices of the source, so that motion stays as smooth as it was.
  TopologyRun(const Frames &frames, const Budget &budget, double target_error);
  // frame: its number in the run; source: its mesh.
  Decimated apply(const geometry::Mesh &source, size_t frame) const;

private:
  bool try_faces(const Frames &frames, const Budget &budget, const Reference &like,
                 std::vector<size_t> &order, Outliers &outliers, double &worst);

  std::vector<uint32_t> large_pieces; // faces of the source without the dropped pieces
  Report dropped;                     // reports the dropped pieces
  std::vector<uint32_t> faces;        // of the result, with vertices of the source; empty: the source is kept
  std::vector<Report> reports;
};

} // namespace fvv::decimate
