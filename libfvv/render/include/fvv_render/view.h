// The picture of a mesh from anywhere, textured from the cameras that see each point best: the reference that
// players are compared with.
//
// Point by point of the surface, as clause 17.5 of fvv.md defines it:
//   - A camera can show the point when the point lies in front of it, within the lens' r_max and the camera's
//     pixels, and nothing of the mesh is between: by visibility weights, or by rays or a depth map
//     (occlusion.h), which also ask that the face turns its front to the camera: a face seen from behind,
//     next to an outline, is as far away as its neighbour that hides it, and no tolerance distinguishes the
//     two.
//   - ViewOptions::inset: a source shows the point where the viewer's ray meets the surface moved inward.
//   - Blend::viewer: cameras are weighted by how near their direction is to the viewer's (after Buehler et
//     al., "Unstructured Lumigraph Rendering", 2001), by the cosine between normal and ray, and by factors
//     that fall to 0 at the border of the picture and of what the camera sees. The best few are mixed, each
//     less the weight of the next one: no camera enters or leaves with a jump.
//   - Blend::paper: by the cosine alone, as Budd, Grau, Schuebel, "Web delivery of free-viewpoint video of
//     sport events" (BBC R&D White Paper 235, 2012), section 4.
// Normals of vertices are interpolated over the face; they are not turned to the viewer. At equal weight the
// camera that was named first is preferred.
// Colours are interpolated and added as display values (sRGB), not as light: so did the paper, so do players
// that sample textures of 8 bits, and video is scaled and coded in display values too. Light beyond white has
// display values too, beyond 1, by the curve continued (the format's clause 10.12).
#pragma once

#include "fvv_render/environment.h"
#include "fvv_render/occlusion.h"

#include <functional>
#include <memory>
#include <optional>

namespace fvv::render {

// A camera as source of texture. camera: valid, of these pixels: for a tile that is the camera with its
// picture cut and scaled like the tile. pixels: width x height of the camera, three values a pixel, rows from
// the top, 65535 for white; borrowed. wide_pixels, if not NULL: in their place the same with 1 for white and
// any finite value.
struct SourceView {
  fvv_camera camera;
  const uint16_t *pixels;
  // Visibility::given: of each vertex 0 to 255, interpolated over the face: seen above 127.5
  // (fvv_visibility_weights). Borrowed. NULL: the source has a depth map.
  const uint8_t *visible_vertices = nullptr;
  const float *wide_pixels = nullptr;
};

enum class Visibility {
  depth_map, // as players do: DepthTest
  rays,      // the reference
  given      // SourceView::visible_vertices
};

// What decides which cameras are mixed at a point.
enum class Blend { viewer = FVV_BLEND_VIEWER, paper = FVV_BLEND_PAPER };

// Calls work(0) ... work(count - 1), each once, in any order or concurrently.
using Executor = std::function<void(size_t count, const std::function<void(size_t)> &work)>;

struct ViewOptions {
  Blend blend = Blend::viewer;
  double threshold = 0.05; // least cosine between normal and ray to a camera, 0 to 1
  uint32_t best = 3;       // cameras for one point, 1 to max_best
  double margin = 0.5;     // of the sources' pixels: a border that is not used; from 0.5 on nothing is
                           // read twice
  Visibility visibility = Visibility::depth_map;
  DepthTest depth_test; // pixels are those of the source
  double inset = 0;     // from the mesh inward to the surface that sources show, 0 or more
  uint32_t samples = 1; // of a pixel of the target, along its side: 1, 3, 5 or 7
  Vec3 background;      // display values 0..1, where there is no surface
  // The same, where no camera shows the surface. Without any source it is shaded, as if the viewer held a
  // light.
  Vec3 unseen{0.5, 0.5, 0.5};
  // R, G, B of each vertex, display values, interpolated over faces, in place of unseen. Borrowed; NULL:
  // none.
  const uint8_t *vertex_colours = nullptr;
  bool keep_visibility = false; // fill ViewPicture::visible
  Executor executor = [](size_t count, const std::function<void(size_t)> &work) {
    for (size_t i = 0; i < count; i++) work(i);
  };
  // Drawn where it is nearer than the mesh, or the mesh is not; borrowed; NULL: none. Where it hides the mesh
  // there is no surface. It does not hide the mesh from sources, whose pictures are as they were taken.
  const Environment *environment = nullptr;
};
constexpr uint32_t max_best = 8;

constexpr uint32_t no_source = UINT32_MAX;
struct Contribution {
  uint32_t source = no_source; // index
  float weight = 0;            // normalised: those of a point add up to 1
};

// rgb and coverage are means over the samples of a pixel; all else is of the pixel's centre.
struct ViewPicture {
  uint32_t width = 0, height = 0, best = 0;
  std::vector<float> rgb;                  // display values, three a pixel; 0..1, or wide as the sources are
  std::vector<float> coverage;             // share of samples with surface
  std::vector<float> depth;                // z_c in metres, linear; +inf: no surface
  std::vector<uint32_t> face;              // no_face: no surface
  std::vector<Contribution> contributions; // best a pixel, by falling weight, no_source after the last
  // A byte for each pixel and source: 1 when the camera has a weight at the point, among the best or not.
  // Empty without ViewOptions::keep_visibility.
  std::vector<uint8_t> visible;
};

// A frame, ready to be drawn from several places.
class ViewRenderer {
public:
  // mesh and the sources' pixels are borrowed. normals: of vertices, unit length or zero (nothing is textured
  // there); none: vertex_normals(mesh). Throws std::invalid_argument for options out of range, normals of
  // another number than vertices.
  ViewRenderer(const Mesh &mesh, std::vector<Vec3> normals, std::vector<SourceView> sources,
               const ViewOptions &options);
  ~ViewRenderer();
  ViewRenderer(ViewRenderer &&) noexcept;

  // What the target camera sees: its whole picture, of 1 to 16384 pixels a side. Without a lens it is
  // rasterised (rasteriser.h: fill rule, clipping at near_plane()). With one, a ray is cast through every
  // sample, so that edges bend as the lens bends them: to a hundredth of a pixel. excluded: index of a source
  // that is left out. inset: in place of the options'. The same result for every executor.
  ViewPicture render(const fvv_camera &target, uint32_t excluded = no_source,
                     std::optional<double> inset = {}) const;

private:
  class Frame;
  std::unique_ptr<const Frame> frame;
};

} // namespace fvv::render
