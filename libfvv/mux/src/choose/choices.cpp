// What is chosen once for a stream: normals, winding, and what is sent of visibility.
#include "mux/src/choose/choices.h"
#include "fvv/colours.h"
#include "fvv/mesh.h"
#include "fvv_cxx/error.h"
#include "fvv_cxx/format.h"
#include "fvv_cxx/owned.h"
#include "fvv_cxx/parallel.h"
#include "fvv_geometry/outline.h"
#include "fvv_media/colour.h"
#include "fvv_render/local_origin.h"
#include "fvv_render/vector.h"
#include "mux/src/crop.h"
#include "mux/src/meshes/meshes.h"
#include "mux/src/options/presets.h"
#include "mux/src/pictures.h"
#include "mux/src/plan.h"
#include "mux/src/terms.h"
#include "mux/src/visibility.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>
#include <stdexcept>

namespace fvv::mux {

namespace {

constexpr uint32_t sent_bits = 8; // 0.34 degrees off on average
// Smooth surfaces stay well below both: as source and decoder weigh faces differently, normals of coarse
// meshes differ by up to 10 degrees, where edges are hard by 35 to 90.
constexpr double hard_degrees = 20, hard_fraction = 0.01, odd_fraction = 0.5;

// The mesh on a lattice so fine that rounding to it turns nothing, with normals.
void place(const geometry::Mesh &source, const std::string &name, fvv_mesh &mesh) {
  fvv_mesh_options options;
  fvv_mesh_options_default(&options);
  double extent = 0;
  for (size_t k = 0; k < 3; k++) {
    double low = source.positions[k], high = low;
    for (size_t i = k; i < source.positions.size(); i += 3) {
      low = std::min(low, source.positions[i]);
      high = std::max(high, source.positions[i]);
    }
    options.lattice_origin[k] = low;
    extent = std::max(extent, high - low);
  }
  options.lattice_step = std::ldexp(extent, -26);
  options.normal_bits = FVV_NORMAL_BITS_MAX;
  options.keep_winding = 1;
  const fvv_mesh_source borrowed = {
      source.positions.data(), source.faces.data(), source.vertex_count(), source.face_count(), nullptr,
      source.normals.data()};
  fvv_diagnostic diagnostic = {};
  fvv::check(fvv_mesh_canonicalise(&borrowed, &options, nullptr, &mesh, nullptr, &diagnostic), name,
             diagnostic);
}

// Of each vertex the normal by area of its own faces, those of others on its point left out; any length.
std::vector<double> of_own_faces(const fvv_mesh &mesh) {
  std::vector<double> sums(3 * size_t(mesh.vertex_count));
  for (size_t f = 0; f < mesh.face_count; f++) {
    const uint32_t *face = mesh.faces + 3 * f;
    const auto edge = [&](size_t corner, size_t k) {
      return double(mesh.lattice[3 * size_t(face[corner]) + k]) - mesh.lattice[3 * size_t(face[0]) + k];
    };
    for (size_t k = 0; k < 3; k++) {
      const size_t i = (k + 1) % 3, j = (k + 2) % 3;
      const double area = edge(1, i) * edge(2, j) - edge(1, j) * edge(2, i);
      for (size_t c = 0; c < 3; c++) sums[3 * size_t(face[c]) + k] += area;
    }
  }
  return sums;
}

// The faces define the outside.
template <class Number> bool near(const float *sent, const Number *computed) {
  double dot = 0, length = 0;
  for (size_t k = 0; k < 3; k++) {
    dot += double(sent[k]) * double(computed[k]);
    length += double(computed[k]) * double(computed[k]);
  }
  return std::abs(dot) >= std::cos(hard_degrees * std::acos(-1.0) / 180) * std::sqrt(length);
}

// Fractions of the vertices. hard: the own faces have the vertex's normal, all around its point together do
// not. odd: not even the own faces have it. Some captures have normals that match no vertex.
struct Fractions {
  double hard, odd;
};

Fractions fractions_of(const fvv_mesh &mesh, const std::string &name) {
  const size_t count = mesh.vertex_count;
  std::vector<float> sent(3 * count), computed(3 * count);
  fvv_mesh bare = mesh;
  bare.normals = nullptr;
  bare.normal_bits = 0;
  fvv_diagnostic diagnostic = {};
  fvv::check(fvv_mesh_normals(&mesh, nullptr, sent.data(), &diagnostic), name, diagnostic);
  fvv::check(fvv_mesh_normals(&bare, nullptr, computed.data(), &diagnostic), name, diagnostic);
  const std::vector<double> own = of_own_faces(mesh);
  size_t hard = 0, odd = 0;
  for (size_t v = 0; v < 3 * count; v += 3) {
    if (!near(&sent[v], &own[v]))
      odd++;
    else
      hard += !near(&sent[v], &computed[v]);
  }
  return {double(hard) / double(count), double(odd) / double(count)};
}

NormalChoice judge(const geometry::Mesh &source, const std::string &name) {
  if (source.normals.empty()) return {0, "the source has none"};
  OwnedMesh holder;
  place(source, name, holder);
  const Fractions fractions = fractions_of(holder, name);
  char reason[160];
  if (fractions.odd > odd_fraction)
    std::snprintf(reason, sizeof reason,
                  "%.3g %% of the first mesh's are more than %g degrees off those of their own faces",
                  100 * fractions.odd, hard_degrees);
  else
    std::snprintf(reason, sizeof reason, "%.3g %% of the first mesh's vertices lie on hard edges",
                  100 * fractions.hard);
  return {fractions.odd <= odd_fraction && fractions.hard > hard_fraction ? sent_bits : 0, reason};
}

} // namespace

NormalChoice choose_normals(const Options &options, const SampledScene &scene) {
  const scene::Capture &capture = scene.of();
  if (!capture.meshes) return {};
  if (options.normals == Normals::never) return {0, option_name("normals", "never")};
  const std::string name = capture.mesh_path(scene.first().number);
  if (options.normals == Normals::always) {
    if (scene.first_with_normals().normals.empty())
      throw Error(option_name("normals", "always") + ": " + name +
                  ": expected a normal for every corner, found none");
    return {sent_bits, option_name("normals", "always")};
  }
  // Unusable normals that were not requested are no error.
  try {
    return judge(scene.first_with_normals(), name);
  } catch (const std::exception &error) {
    return {0, std::string("the source's are not usable: ") + error.what()};
  }
}

namespace {

using render::Vec3;

constexpr uint32_t picture_side = 480; // pixels; enough to see the side of a face

struct Pixels {
  uint64_t covered = 0, turned_away = 0;
};

// Of the surface nearest to a camera: holes of an open mesh let it see backs, but few.
Pixels look(const geometry::ViewedSurface &body, const geometry::Mesh &mesh, const fvv_camera &camera) {
  const double scale = std::min(1.0, double(picture_side) / std::max(camera.width, camera.height));
  const auto side = [&](uint32_t size) { return std::max<uint32_t>(1, uint32_t(size * scale)); };
  double centre[3];
  fvv_camera_centre(&camera, centre);
  Pixels out;
  for (const uint32_t face :
       body.nearest(geometry::resized(camera, side(camera.width), side(camera.height)))) {
    if (face == render::no_face) continue;
    const auto corner = [&](size_t c) {
      const double *p = &mesh.positions[3 * size_t(mesh.faces[3 * size_t(face) + c])];
      return Vec3{p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]};
    };
    const Vec3 a = corner(0);
    out.covered++;
    out.turned_away += dot(a, cross(corner(1) - a, corner(2) - a)) > 0;
  }
  return out;
}

} // namespace

std::vector<fvv_camera> cameras_at(const scene::Capture &capture, int64_t frame) {
  std::vector<fvv_camera> out;
  for (const scene::Camera &camera : capture.cameras)
    if (camera.is_calibrated(frame)) out.push_back(camera.calibration_at(frame));
  return out;
}

WindingChoice choose_winding(const Options &options, const scene::Capture &capture,
                             const std::vector<SampledMesh> &sampled) {
  WindingChoice choice;
  Pixels all;
  size_t meshes = 0, negative = 0;
  for (const auto &[number, mesh] : sampled) {
    std::optional<geometry::ViewedSurface> body;
    try {
      body.emplace(mesh.positions, mesh.faces);
    } catch (const std::invalid_argument &) {
      continue; // the canonicaliser reports the error
    }
    const std::vector<fvv_camera> cameras = cameras_at(capture, number);
    std::vector<Pixels> seen(cameras.size());
    fvv::parallel(options.threads, cameras.size(),
                  [&, &of = mesh](size_t k) { seen[k] = look(*body, of, cameras[k]); });
    for (const Pixels &pixels : seen) {
      all.covered += pixels.covered;
      all.turned_away += pixels.turned_away;
    }
    meshes++;
    negative += body->inside_out();
  }
  choice.by_cameras = all.covered > 0;
  if (choice.by_cameras)
    choice.turned_away = double(all.turned_away) / double(all.covered);
  else if (meshes)
    choice.turned_away = double(negative) / double(meshes);
  choice.flip =
      options.winding == Winding::flip || (options.winding == Winding::automatic && choice.inside_out());
  return choice;
}

bool warn_of_winding(const Plan &plan) {
  const WindingChoice &choice = plan.winding;
  if (!choice.stays_inside_out() || plan.options.winding == Winding::keep) return false;
  plan.observer.warn(plan.capture.path + ": " +
                     (choice.flip ? "with " + option_name("winding", "flip") + " " : "") +
                     winding_text(choice.in_stream(), choice.by_cameras) + ": the faces are inside out" +
                     (choice.by_cameras ? ", and players find no colours for them" : "") +
                     (choice.flip ? ""
                                  : " (" + option_name("winding", "flip") +
                                        " turns them round, keep keeps them without this warning)"));
  return true;
}

std::string winding_text(double turned_away, bool by_cameras) {
  return by_cameras
             ? fvv::format("%.3g %% of the surface nearest to the cameras has its back to them",
                           100 * turned_away)
             : fvv::format("%.3g %% of the sampled meshes enclose a negative volume", 100 * turned_away);
}

std::optional<fvv_texturing> texturing_of(const Plan &plan) {
  const Options &options = plan.options;
  if (!options.texture_threshold && !options.texture_best && !options.texture_unseen &&
      !options.texture_depth_bias && !options.texture_depth_slope && !options.texture_blend &&
      plan.inset.inset == 0)
    return {};
  fvv_texturing out;
  fvv_texturing_default(&out);
  if (options.texture_blend) {
    out.blend = uint8_t(*options.texture_blend);
    out.threshold = fvv_texturing_threshold(out.blend);
  }
  if (options.texture_threshold) out.threshold = *options.texture_threshold;
  if (options.texture_best) out.best = uint8_t(*options.texture_best);
  if (options.texture_depth_bias) out.depth_bias = *options.texture_depth_bias;
  if (options.texture_depth_slope) out.depth_slope = *options.texture_depth_slope;
  if (options.texture_unseen) std::copy_n(options.texture_unseen->begin(), 3, out.unseen);
  out.inset = plan.inset.inset;
  return out;
}

VisibilityChoice choose_visibility(const Options &options, const scene::Capture &capture,
                                   const Tiling &tiling) {
  VisibilityChoice choice;
  choice.cameras = tiling.cameras;
  if (options.texture_threshold) {
    choice.cosine = *options.texture_threshold;
    choice.threshold =
        uint8_t(std::min(255.0, 256 * choice.cosine)); // rounded down: every usable vertex has a weight
  }
  const bool automatic = options.visibility == Visibility::automatic;
  const bool given = std::any_of(capture.cameras.begin(), capture.cameras.end(),
                                 [](const scene::Camera &camera) { return camera.memory_visibility; });
  // It may be requested for pictures that are not in the stream.
  if ((!automatic || given) && choice.cameras.empty())
    for (size_t i = 0; i < capture.cameras.size(); i++) choice.cameras.push_back(i);
  std::sort(choice.cameras.begin(), choice.cameras.end());
  const char *missing = !capture.meshes ? "there are no meshes"
                        : choice.cameras.empty()
                            ? (automatic ? "there are no pictures of cameras" : "there are no cameras")
                            : nullptr;
  if (options.visibility == Visibility::none)
    choice.reason = option_name("visibility", "none");
  else if (missing && !automatic)
    refuse_option("visibility", missing);
  else if (missing)
    choice.reason = missing;
  else if (automatic && !given && choice.cameras.size() == 1)
    choice.reason = "one camera alone costs a player one depth map";
  else if (automatic && !given && !row_of(options.preset).visibility)
    choice.reason = preset_reason(options.preset);
  else {
    choice.on = choice.known = true;
    choice.open = automatic && !given;
    choice.reason = !automatic ? option_name("visibility") : given ? "it comes with the frames" : "";
  }
  return choice;
}

namespace {

// Cells on the first mesh, measured in docs/encoding/colours.md. Key frames that follow each other take few
// bytes each; one that serves a whole group may have more.
constexpr double cells_of_each = 750, cells_of_runs = 3000;
// Of these where bytes have to be seen: between cameras more make no difference (docs/encoding/view-loss.md).
constexpr double cells_by_views = 0.4;
constexpr uint8_t step_of_each = 24, step_of_runs = 12;
// Occupied cells of side 1 for a surface of area 1.
constexpr double cells_of_area = 1.15;
// Of colours that meshes bring: at first a cell for each vertex, and steps that are below what is seen.
constexpr uint8_t step_of_vertices = 4;

std::vector<size_t> cameras_with_pictures(const scene::Capture &capture) {
  std::vector<size_t> out;
  for (size_t i = 0; i < capture.cameras.size(); i++)
    if (capture.cameras[i].pictures) out.push_back(i);
  return out;
}

double area_of(const geometry::Mesh &mesh) {
  const auto position = [&](uint32_t v) {
    const double *p = mesh.positions.data() + 3 * size_t(v);
    return render::Vec3{p[0], p[1], p[2]};
  };
  double twice = 0;
  for (size_t i = 0; i < mesh.faces.size(); i += 3) {
    const render::Vec3 a = position(mesh.faces[i]);
    twice += length(cross(position(mesh.faces[i + 1]) - a, position(mesh.faces[i + 2]) - a));
  }
  return twice / 2;
}

// Whether some of the sampled meshes bring colours of their vertices.
bool brings_colours(const SampledScene &scene) {
  const scene::Capture &capture = scene.of();
  if (!capture.meshes || capture.memory) return false;
  std::vector<uint8_t> colours;
  for (const SampledScene::Frame &frame : scene.frames()) {
    scene::load_coloured_mesh(capture, frame.number, colours);
    if (!colours.empty()) return true;
  }
  return false;
}

// The size at which the first mesh occupies about that number of cells.
uint32_t cell_size_for(const Plan &plan, const SampledScene &scene, double cells) {
  const double side =
      std::sqrt(cells_of_area * area_of(scene.first().mesh) / cells) / plan.lattice.lattice.step;
  return uint32_t(std::clamp(side, 1.0, double(FVV_COLOURS_MAX_CELL)));
}

void choose_vertex_colours(const Plan &plan, const SampledScene &scene, ColourChoice &choice) {
  const uint32_t chosen = plan.options.colour_cells;
  choice.on = choice.of_vertices = true;
  choice.step = step_of_vertices;
  choice.cell_size = cell_size_for(
      plan, scene,
      chosen ? chosen
             : std::min<double>(double(scene.first().mesh.vertex_count()), FVV_COLOURS_MAX_CELLS / 2));
  choice.reason = fvv::format("those of the meshes' vertices, in cells of at most %s",
                              length_text(plan, choice.cell_size * plan.lattice.lattice.step).c_str());
}

} // namespace

ColourChoice choose_colours(const Plan &plan, const SampledScene &scene) {
  ColourChoice choice;
  const Options &options = plan.options;
  const scene::Capture &capture = plan.capture;
  choice.cameras = cameras_with_pictures(capture);
  const bool automatic = options.colours == Colours::automatic;
  const char *missing = !capture.meshes          ? "there are no meshes"
                        : choice.cameras.empty() ? "there are no pictures of cameras"
                                                 : nullptr;
  if (options.colours == Colours::off)
    choice.reason = option_name("colours", "off");
  else if (capture.meshes && choice.cameras.empty() && !capture.atlas && brings_colours(scene))
    choose_vertex_colours(plan, scene, choice);
  else if (missing && !automatic)
    refuse_option("colours", missing);
  else if (missing)
    choice.reason = missing;
  else if (automatic && options.texture_unseen)
    choice.reason = option_name("texture-unseen") + " is shown where no camera sees the surface";
  else if (automatic && capture.atlas)
    choice.reason = "the atlas has the colours of the whole surface";
  else if (automatic && !row_of(options.preset).colours)
    choice.reason = preset_reason(options.preset);
  else {
    choice.on = true;
    const bool fewer = plan.view.on() && choice.cameras.size() >= cameras_all_round;
    const double usual = plan.has_constant_topology ? cells_of_runs : cells_of_each,
                 cells = options.colour_cells ? options.colour_cells
                         : fewer              ? cells_by_views * usual
                                              : usual;
    choice.cell_size = cell_size_for(plan, scene, cells);
    choice.step = plan.has_constant_topology ? step_of_runs : step_of_each;
    choice.reason =
        fvv::format("cells of %s, about %g on the first mesh",
                    length_text(plan, choice.cell_size * plan.lattice.lattice.step).c_str(), cells);
  }
  return choice;
}

namespace {

constexpr size_t compared_frames = 5;
// Measured in docs/encoding/match.md.
constexpr double least_difference = 0.03; // of two cameras
constexpr double most_left = 0.5;         // of what cameras differ by, with the gains

// What the cameras of a choice show of one frame's mesh.
std::vector<render::PlaceLight> light_of(const Plan &plan, const SampledScene &scene,
                                         const MatchChoice &choice, int64_t number,
                                         const std::vector<float> &linear) {
  const scene::Capture &capture = plan.capture;
  geometry::Mesh mesh = scene.mesh(number);
  const render::MatchSurface surface(mesh.positions, std::move(mesh.faces));
  std::vector<render::PlaceLight> out(choice.cameras.size());
  fvv::parallel(plan.options.threads, out.size(), [&](size_t i) {
    plan.observer.check_cancelled();
    const scene::Camera &camera = capture.cameras[choice.cameras[i]];
    if (!camera.is_calibrated(number)) return;
    const fvv_camera calibration = camera.calibration_at(number);
    const std::optional<SampledScene::View> view = scene.view(plan, choice.cameras[i], number, calibration);
    if (!view) return;
    out[i] = surface.light({calibration, view->picture.pixels.data(),
                            view->mask.pixels.empty() ? nullptr : view->mask.pixels.data(), linear.data()});
  });
  return out;
}

} // namespace

MatchChoice choose_match(const Plan &plan, const SampledScene &scene, bool encoded) {
  MatchChoice choice;
  const Options &options = plan.options;
  const scene::Capture &capture = plan.capture;
  choice.cameras = cameras_with_pictures(capture);
  const bool automatic = options.match_colours == MatchColours::automatic;
  const char *missing = !capture.meshes                   ? "there are no meshes"
                        : encoded                         ? "pictures that come encoded stay as they are"
                        : choice.cameras.size() < 2       ? "there are no two cameras with pictures"
                        : options.codec == FVV_CODEC_OEXR ? "pictures in OpenEXR stay as they are"
                                                          : nullptr;
  if (options.match_colours == MatchColours::off)
    choice.reason = option_name("match-colours", "off");
  else if (automatic && !row_of(options.preset).match_colours)
    choice.reason = preset_reason(options.preset);
  else if (missing && !automatic)
    refuse_option("match-colours", missing);
  else if (missing)
    choice.reason = missing;
  else if (automatic && capture.atlas)
    choice.reason = "the atlas has the colours of the surface";
  if (!choice.reason.empty()) return choice;
  const std::vector<int64_t> numbers = capture.mesh_frames();
  choice.frames = std::min(compared_frames, numbers.size());
  const std::vector<float> linear = media::linear_of_codes(255);
  std::vector<std::vector<render::PlaceLight>> frames;
  for (size_t i = 0; i < choice.frames; i++)
    frames.push_back(
        light_of(plan, scene, choice, numbers[(2 * i + 1) * numbers.size() / (2 * choice.frames)], linear));
  choice.found = render::match_colours(frames);
  const double departure = choice.found.departure();
  choice.on = departure > 0 && (!automatic || (choice.found.before > least_difference &&
                                               choice.found.after < most_left * choice.found.before));
  if (std::none_of(choice.found.cameras.begin(), choice.found.cameras.end(),
                   [](const render::CameraMatch &camera) { return camera.matched; }))
    choice.reason = "no two cameras share enough surface";
  else
    choice.reason = fvv::format(
        "two cameras differ by %.2g %%, with gains by %.2g %%; gains differ from 1 by %.3g %% at most",
        100 * choice.found.before, 100 * choice.found.after, 100 * departure);
  return choice;
}

namespace {

constexpr uint32_t inset_side = 800; // pixels of a camera's picture, at most

// Cameras and positions count from origin_of() the plan's lattice.
struct CutView {
  fvv_camera camera = {};
  media::DeepImage picture;
  media::Image mask;
};

// What a camera shows of a mesh, cut out and made smaller; without pixels if it shows nothing of it.
CutView cut_view(const Plan &plan, const SampledScene &scene, size_t index) {
  CutView out;
  const auto &[number, mesh] = static_cast<const SampledMesh &>(scene.middle());
  const fvv_camera calibration = plan.capture.cameras[index].calibration_at(number);
  const Silhouette box = box_of_mesh(mesh, calibration);
  if (box.empty()) return out;
  const uint32_t width = box.right - box.left, height = box.bottom - box.top;
  const double scale = std::min(1.0, double(inset_side) / std::max(width, height));
  const auto side = [&](uint32_t pixels) { return uint16_t(std::max(1.0, std::round(scale * pixels))); };
  const fvv_tile tile = {calibration.id,
                         {uint16_t(box.left), uint16_t(box.top), uint16_t(width), uint16_t(height)},
                         {0, 0, side(width), side(height)}};
  const auto part = [&](const media::Image &image) {
    return media::scale(media::crop(image, box.left, box.top, width, height), tile.destination.width,
                        tile.destination.height);
  };
  const std::optional<SampledScene::View> view = scene.view(plan, index, number, calibration);
  if (!view) return out;
  out.camera = render::camera_from(origin_of(plan.lattice.lattice), fvv_camera_of_tile(&calibration, &tile));
  out.picture = media::with_samples<uint16_t>(part(view->picture));
  if (!view->mask.pixels.empty()) out.mask = part(view->mask);
  return out;
}

// A frame of which cameras can be drawn from each other. Owns what frame borrows.
struct CutFrame {
  std::vector<float> positions;
  std::vector<uint32_t> faces;
  std::vector<CutView> views;

  render::HeldOutFrame frame() const {
    render::HeldOutFrame out = {{positions.data(), positions.size() / 3, faces.data(), faces.size() / 3}, {}};
    for (const CutView &view : views)
      if (!view.picture.pixels.empty())
        out.views.push_back({{view.camera, view.picture.pixels.data()},
                             view.mask.pixels.empty() ? nullptr : view.mask.pixels.data()});
    return out;
  }
};

CutFrame cut_frame(const Plan &plan, const SampledScene &scene, const std::vector<size_t> &cameras) {
  const geometry::Mesh &mesh = scene.middle().mesh;
  CutFrame out;
  out.views.resize(cameras.size());
  fvv::parallel(plan.options.threads, cameras.size(), [&](size_t i) {
    plan.observer.check_cancelled();
    if (plan.capture.cameras[cameras[i]].is_calibrated(scene.middle().number))
      out.views[i] = cut_view(plan, scene, cameras[i]);
  });
  out.positions = render::positions_from(origin_of(plan.lattice.lattice), mesh.positions);
  out.faces = mesh.faces;
  return out;
}

} // namespace

InsetChoice choose_inset(const Plan &plan, const SampledScene &scene, bool encoded) {
  InsetChoice choice;
  const Options &options = plan.options;
  const scene::Capture &capture = plan.capture;
  const std::vector<size_t> cameras = cameras_with_pictures(capture);
  if (options.texture_inset) {
    choice.inset = *options.texture_inset;
    choice.reason = option_name("texture-inset");
  } else if (scene.frames().empty())
    choice.reason = "there are no meshes";
  else if (capture.atlas)
    choice.reason = "the atlas has the colours of the surface";
  else if (encoded)
    choice.reason = "pictures that come encoded are not decoded";
  else if (cameras.size() < 2)
    choice.reason = "there are no two cameras with pictures";
  else if (options.texture_blend == uint32_t(FVV_BLEND_PAPER))
    choice.reason = "the paper's method has none";
  if (!choice.reason.empty()) return choice;
  choice.frame = scene.middle().number;
  const CutFrame frame = cut_frame(plan, scene, cameras);
  render::ViewOptions view;
  view.depth_test.samples = 1; // nine times the work would improve outlines alone
  view.executor = [&](size_t count, const std::function<void(size_t)> &work) {
    fvv::parallel(options.threads, count, [&](size_t i) {
      plan.observer.check_cancelled();
      work(i);
    });
  };
  choice.found = render::find_texture_inset({frame.frame()}, view);
  choice.inset = choice.found.inset;
  const render::TextureInset &found = choice.found;
  choice.reason =
      found.pixels < render::least_compared
          ? "cameras share too little surface"
          : fvv::format("cameras drawn from the others have %.2f dB without, %.2f dB with the best inset; it "
                        "improves %zu of %zu",
                        found.before, found.after, found.better, found.views);
  return choice;
}

} // namespace fvv::mux
