// A capture folder from the scene: capture.json, meshes, pictures, masks, and files for measurements (depth,
// visibility).
#pragma once

#include "cli/output.h"
#include "fvv_geometry/hull.h"
#include "fvv_render/picture.h"
#include "fvvsynth/filming.h"

#include <nlohmann/json_fwd.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace fvv::synth {

// Of texture coordinates (atlas.h).
struct Layout;

// "meshes/" 7 ".ply": "meshes/0007.ply".
std::string numbered(const char *before, size_t number, const char *after);
// The same bytes, borrowed, as files are written from.
std::string_view text_of(const std::vector<uint8_t> &bytes);
// A whole PNG file of pixels of that many channels, of the picture's size.
std::vector<uint8_t> png(const render::Picture &picture, int channels, const std::vector<uint8_t> &pixels);
// layout: of the texture coordinates, for all vertices; NULL: none.
std::vector<uint8_t> ply(const std::vector<float> &positions, const std::vector<uint32_t> &faces,
                         const Layout *layout);
// "25" or "30000/1001".
std::string rate_text(FrameRate rate);
// What capture.json says of a camera that does not move, without files.
nlohmann::ordered_json describe(const fvv_camera &camera);

// An OpenEXR file with the one channel Z, float32: the depth of the picture as it is.
std::vector<uint8_t> depth_exr(const render::Picture &picture);

// NumPy files (format 1.0) of Boolean arrays [cameras, faces] and [cameras, vertices].
struct VisibilityFiles {
  std::vector<uint8_t> faces, vertices;
};

// What the cameras see of a mesh, by fvv_render/ray_visibility.h. positions in metres, three indices a face.
// copies: what the columns of vertices are, each a vertex of this mesh (a seam gives one several); NULL: its
// vertices as they are.
VisibilityFiles visibility_files(const std::vector<fvv_camera> &cameras, const std::vector<float> &positions,
                                 const std::vector<uint32_t> &faces,
                                 const std::vector<uint32_t> *copies = nullptr);

// "25" or "30000/1001". Error (usage) when text is not a positive number or fraction of such.
FrameRate parse_frame_rate(const std::string &text);

enum class Meshes {
  tracked,  // the scene's own: the same faces in all frames
  remeshed, // the same surface, other triangles in every frame
  hull      // carved from the masks, as reconstruction from real cameras does it
};

enum class Pictures {
  png,
  jpeg, // quality 95, 4:4:4
  exr   // OpenEXR: linear light, not clipped; without labels
};

struct Recording {
  uint32_t frames = 50;
  FrameRate rate;
  Realism realism;
  Meshes meshes = Meshes::tracked;
  uint32_t hull_cells = 220; // along the longest side of the space that hulls are carved from
  // Texels of each side of the texture map that tracked meshes have texture coordinates for; 0: none.
  uint32_t atlas = 0;
  bool depth = false;      // of every picture, beside it
  bool visibility = false; // of every written mesh: what each camera sees of it
  Pictures pictures = Pictures::png;
  bool environment = false; // floor and walls as environment.glb
  bool sound =
      false; // claps, which need Realism::claps to be seen, or the game's shoes, and the ball, in WAV
  uint32_t threads = 1; // the bytes written do not depend on it
};

// The grid that hulls are carved from: over the space of the action, with that many cells along its longest
// side, x. The floor y = 0 lies half a cell above its lowest points.
hull::Grid hull_grid(size_t cells);

// Writes frames 0 ... frames - 1 into folder. Failure names the file that could not be written, or the frame
// whose hull is empty. std::invalid_argument: see make_atlas (atlas.h).
void write_capture(const Scene &scene, const Recording &recording, cli::OutputFolder &folder);

} // namespace fvv::synth
