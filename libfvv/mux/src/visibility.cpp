#include "mux/src/visibility.h"
#include "fvv/colours.h"
#include "fvv_cxx/error.h"
#include "fvv_cxx/owned.h"
#include "fvv_geometry/surface.h"
#include "fvv_render/local_origin.h"
#include "fvv_render/vertex_colours.h"
#include "fvv_render/visibility_fit.h"
#include "fvv_scene/memory_frames.h"
#include "mux/src/encode/vertex_colours.h"
#include "mux/src/meshes/decoded_meshes.h"
#include "mux/src/pictures.h"
#include "mux/src/stream_writer.h"

#include <algorithm>
#include <cmath>

namespace fvv::mux {

namespace {

// The gain, in faces of mean area, for which a weight changes, in frames with the faces of the one before.
// The lower one costs no accuracy that can be measured, and saves a tenth of the bytes.
constexpr double change_price = 0.1;

// The state from one frame to the next with its faces.
struct PreviousFrame {
  uint32_t number = 0;
  States states;
};

class FrameCoder {
public:
  FrameCoder(const Plan &chosen, const VisibilityChoice &what, const MeshTrack &of)
      : plan(chosen), choice(what), track(of) {}

  // follows: mesh has the faces of the one before.
  VisibilityFrame code(const fvv_mesh &mesh, bool follows, const std::vector<fvv_camera> &cameras,
                       const GivenVisibility &given) {
    if (!follows) open_order(mesh);
    VisibilityFrame frame;
    frame.key = !follows || previous.states.empty();
    frame.vertices = mesh.vertex_count;
    PreviousFrame now;
    now.number = frame.key ? 0 : previous.number + 1;
    const std::vector<CameraView> looks =
        look(mesh, plan.lattice.lattice, choice, cameras, frame.key ? States() : previous.states, given);
    std::vector<fvv_visibility_view> views;
    for (const CameraView &one : looks) {
      const auto before = previous.states.find(one.camera);
      std::vector<uint8_t> &states = now.states[one.camera];
      states.resize(mesh.vertex_count);
      views.push_back({one.camera,
                       {one.centre[0], one.centre[1], one.centre[2]},
                       one.seen.data(),
                       !frame.key && before != previous.states.end() ? before->second.data() : nullptr,
                       states.data()});
    }
    for (const fvv_visibility_view &view : views) frame.cameras.push_back(view.camera);
    if (!views.empty()) {
      const fvv_visibility_header header = {choice.threshold, track.id, 0, now.number, 0};
      check(fvv_visibility_encode(order.get(), &mesh, &header, views.data(), views.size(), &payload,
                                  &diagnostic));
      frame.payload.assign(payload.data, payload.data + payload.size);
    }
    previous = std::move(now);
    return frame;
  }

  const States &states() const { return previous.states; }

private:
  void check(fvv_status status) { fvv::check(status, plan.capture.path, diagnostic); }

  void open_order(const fvv_mesh &mesh) {
    fvv_visibility_order *opened = nullptr;
    const fvv_status status = fvv_visibility_order_open(&mesh, nullptr, &opened, &diagnostic);
    order.reset(opened);
    check(status);
  }

  const Plan &plan;
  const VisibilityChoice &choice;
  const MeshTrack &track;
  fvv_diagnostic diagnostic = {};
  OwnedBytes payload;
  PreviousFrame previous;
  std::unique_ptr<fvv_visibility_order, void (*)(fvv_visibility_order *)> order{nullptr,
                                                                                fvv_visibility_order_close};
};

// The state whose weight is nearest (fvv.md clause 17.4).
uint8_t state_of_weight(uint8_t weight) {
  if (weight >= 128)
    return weight < 156 ? FVV_VERTEX_SEEN_NEARER : weight < 213 ? FVV_VERTEX_SEEN_NEAR : FVV_VERTEX_SEEN;
  return weight >= 99 ? FVV_VERTEX_HIDDEN_NEARER : weight >= 43 ? FVV_VERTEX_HIDDEN_NEAR : FVV_VERTEX_HIDDEN;
}

// Colours of the vertices of a decoded mesh as a payload. grow: cells of twice the size, until the mesh does
// not have too many; else none then.
std::optional<ColourFrame> encode_colours(const Plan &plan, const MeshTrack &track, const fvv_mesh &mesh,
                                          const render::VertexColours &found, uint32_t cell_size, bool grow) {
  fvv_colours_header header = {track.id,          plan.colours.step, plan.colours.step,
                               mesh.vertex_count, cell_size,         0};
  OwnedBytes payload;
  fvv_diagnostic diagnostic = {};
  fvv_status status;
  while ((status = fvv_colours_encode(&mesh, &header, found.rgb.data(), found.weight.data(), nullptr,
                                      &payload, &diagnostic)) == FVV_ERROR_INPUT &&
         grow && header.cell_size <= FVV_COLOURS_MAX_CELL / 2)
    header.cell_size *= 2;
  if (status == FVV_ERROR_INPUT && !grow) return std::nullopt;
  fvv::check(status, plan.capture.path, diagnostic);
  fvv::check(fvv_colours_peek(payload.data, payload.size, nullptr, &header, &diagnostic), plan.capture.path,
             diagnostic);
  std::vector<uint8_t> decoded(found.rgb.size());
  fvv::check(
      fvv_colours_decode(payload.data, payload.size, &mesh, nullptr, nullptr, decoded.data(), &diagnostic),
      plan.capture.path, diagnostic);
  ColourFrame out = {{payload.data, payload.data + payload.size}, header.cell_count, 0, 0, mesh.vertex_count};
  for (size_t v = 0; v < mesh.vertex_count; v++) {
    if (!found.weight[v]) continue;
    out.shown++;
    for (size_t i = 3 * v; i < 3 * v + 3; i++) out.squares += std::pow(decoded[i] - found.rgb[i], 2);
  }
  return out;
}

// What a picture has of 42 dB does not show.
constexpr double enough_for_vertices = 42;

} // namespace

std::vector<CameraView> look(const fvv_mesh &mesh, const geometry::Lattice &lattice,
                             const VisibilityChoice &choice, const std::vector<fvv_camera> &cameras,
                             const States &previous, const GivenVisibility &given) {
  fvv_scene scene = {};
  std::copy_n(lattice.origin, 3, scene.lattice_origin);
  scene.lattice_step = lattice.step;
  const std::vector<float> metres = metres_of(mesh, lattice);
  const render::Mesh surface = {metres.data(), mesh.vertex_count, mesh.faces, mesh.face_count};
  render::FitSettings settings;
  settings.cosine = choice.cosine;
  settings.change = change_price;
  std::optional<render::RayCaster> rays;
  std::optional<render::VisibilityFit> fit;
  std::vector<CameraView> out;
  for (const fvv_camera &camera : cameras) {
    CameraView view = {camera.id, {}, std::vector<uint8_t>(mesh.vertex_count), {}};
    if (fvv_visibility_centre(&camera, &scene, view.centre, nullptr) != FVV_OK) continue;
    fvv_visibility_facing(&mesh, view.centre, choice.threshold, view.facing.data());
    if (const auto known = given.find(camera.id); known != given.end()) {
      for (const uint8_t weight : known->second) view.seen.push_back(state_of_weight(weight));
    } else {
      if (!fit) fit.emplace(surface, rays.emplace(surface), settings);
      const auto before = previous.find(camera.id);
      view.seen = fit->states(render::camera_from(origin_of(lattice), camera), view.facing,
                              before == previous.end() ? nullptr : before->second.data());
    }
    out.push_back(std::move(view));
  }
  return out;
}

SurfaceCoder::SurfaceCoder(const Plan &chosen) : plan(chosen), choice(chosen.visibility), on(choice.on) {
  if ((on || plan.colours.on) && any_moves(plan.capture))
    moving.emplace(plan.capture, plan.lattice.lattice.step);
}

std::vector<fvv_camera> SurfaceCoder::cameras_of(size_t frame, const std::vector<size_t> &indices) const {
  const std::vector<fvv_camera> placed = moving ? moving->decoded(frame) : std::vector<fvv_camera>();
  std::vector<fvv_camera> out;
  for (const size_t index : indices) {
    const fvv_camera camera = described(plan.capture, plan.capture.cameras[index]);
    if (!(camera.flags & FVV_CAMERA_MOVES)) out.push_back(camera);
    for (const fvv_camera &other : placed)
      if (other.id == camera.id) out.push_back(other);
  }
  return out;
}

GivenVisibility SurfaceCoder::given(size_t frame, const fvv_mesh &mesh) const {
  GivenVisibility out;
  std::vector<uint32_t> nearest; // vertex of the source, for each decoded one
  const int64_t number = plan.capture.frames.number(int64_t(frame));
  for (const size_t index : choice.cameras) {
    const scene::Camera &camera = plan.capture.cameras[index];
    if (!camera.memory_visibility) continue;
    if (nearest.empty()) {
      const geometry::Mesh source = plan.capture.memory->mesh(number, false);
      std::vector<render::Vec3> points = compare::positions_of(source);
      for (render::Vec3 &point : points) point = point - origin_of(plan.lattice.lattice);
      const render::ClosestFinder vertices(compare::as_triangles(points));
      const std::vector<float> metres = metres_of(mesh, plan.lattice.lattice);
      for (size_t i = 0; i < metres.size(); i += 3) {
        const uint32_t guess = nearest.empty() ? UINT32_MAX : nearest.back();
        nearest.push_back(vertices.nearest({metres[i], metres[i + 1], metres[i + 2]}, guess).face);
      }
    }
    const std::vector<uint8_t> known = plan.capture.memory->visibility(number, *camera.memory_visibility);
    std::vector<uint8_t> &weights = out[camera.calibration.id];
    for (const uint32_t vertex : nearest) weights.push_back(known[vertex]);
  }
  return out;
}

ColourFrame SurfaceCoder::colours(const MeshTrack &track, size_t frame, const fvv_mesh &mesh,
                                  const fvv_mesh &described, const std::vector<fvv_camera> &cameras,
                                  const States &states) const {
  const int64_t number = plan.capture.frames.number(int64_t(frame));
  const std::vector<float> metres = metres_of(mesh, plan.lattice.lattice);
  const render::Mesh surface = {metres.data(), mesh.vertex_count, mesh.faces, mesh.face_count};
  render::VertexColourGatherer gatherer(surface);
  for (const size_t index : plan.colours.cameras) {
    const scene::Camera &source = plan.capture.cameras[index];
    const auto camera = std::find_if(cameras.begin(), cameras.end(),
                                     [&](const auto &one) { return one.id == source.calibration.id; });
    if (camera == cameras.end()) continue;
    const media::Image picture = load_display(plan, index, number);
    if (picture.width != camera->width || picture.height != camera->height)
      throw Error(plan.capture.path + ": frame " + std::to_string(number) + ": camera " +
                  std::to_string(camera->id) + ": the picture's size is not the calibration's");
    media::Image mask;
    if (source.masks) mask = load_view<uint8_t>(plan, index, *source.masks, number, 1);
    std::vector<uint8_t> seen;
    const auto known = states.find(camera->id);
    if (known != states.end()) {
      seen.resize(mesh.vertex_count);
      fvv_visibility_weights(known->second.data(), known->second.size(), seen.data());
    }
    gatherer.add({render::camera_from(origin_of(plan.lattice.lattice), *camera), picture.pixels.data(),
                  mask.pixels.empty() ? nullptr : mask.pixels.data(), seen.empty() ? nullptr : seen.data()});
  }
  // Cells grow as the pixels of the rung do.
  const double cell_size =
      std::min(std::round(track.times * plan.colours.cell_size), double(FVV_COLOURS_MAX_CELL));
  render::VertexColours found = gatherer.colours();
  const size_t before = mesh.vertex_count - described.vertex_count;
  found.rgb.erase(found.rgb.begin(), found.rgb.begin() + std::ptrdiff_t(3 * before));
  found.weight.erase(found.weight.begin(), found.weight.begin() + std::ptrdiff_t(before));
  return *encode_colours(plan, track, described, found, uint32_t(cell_size), true);
}

ColourFrame SurfaceCoder::vertex_colours(const MeshTrack &track, size_t frame, const fvv_mesh &mesh) const {
  render::VertexColours given;
  const geometry::Mesh source =
      scene::load_coloured_mesh(plan.capture, plan.capture.frames.number(int64_t(frame)), given.rgb);
  ColourFrame best;
  best.vertices = mesh.vertex_count;
  if (given.rgb.empty()) return best;
  given.rgb = transferred(source, given.rgb, metres_of(mesh, plan.lattice.lattice), plan.lattice.lattice);
  given.weight.assign(mesh.vertex_count, 255);
  // As coarse as does not show: smaller cells take more bytes.
  const auto size = [&](double cells) {
    return uint32_t(std::clamp(cells, 1.0, double(FVV_COLOURS_MAX_CELL)));
  };
  uint32_t cell = size(std::round(track.times * plan.colours.cell_size));
  best = *encode_colours(plan, track, mesh, given, cell, true);
  bool is_least = plan.options.colour_cells != 0;
  for (double times = 0.5; !is_least && cell > 1 && best.psnr() < enough_for_vertices;) {
    const uint32_t smaller = std::min(size(times * cell), cell - 1);
    std::optional<ColourFrame> coded = encode_colours(plan, track, mesh, given, smaller, false);
    if (coded) {
      cell = smaller;
      if (coded->squares < best.squares) best = std::move(*coded);
    } else {
      is_least = times > 0.8;
      times = std::sqrt(times);
    }
  }
  return best;
}

SurfaceFrames SurfaceCoder::encode(const MeshTrack &track, size_t first,
                                   const std::vector<MeshFrame> &meshes) const {
  SurfaceFrames frames;
  frames.visibility.resize(meshes.size());
  frames.colours.resize(meshes.size());
  DecodedMeshes decoded(plan.capture.path);
  FrameCoder coder(plan, choice, track);
  const bool visible = on;
  for (size_t i = 0; i < meshes.size() && (visible || plan.colours.on); i++) {
    if (meshes[i].payload.empty()) continue;
    const bool followed = i + 1 < meshes.size() && !meshes[i + 1].key;
    const fvv_mesh &mesh = decoded.next(meshes[i], followed);
    const fvv_mesh *patch = meshes[i].key ? nullptr : decoded.patch();
    const bool has_faces_before = !meshes[i].key && !meshes[i].patched;
    // Of delta frames the key mesh's colours hold, but for a patch.
    const fvv_mesh *described = meshes[i].key ? &mesh : patch;
    const bool for_colours = choice.known && plan.colours.on && described;
    if (visible || for_colours) {
      VisibilityFrame frame =
          coder.code(mesh, has_faces_before, cameras_of(first + i, choice.cameras), given(first + i, mesh));
      if (visible) frames.visibility[i] = std::move(frame);
    }
    if (!described) continue;
    if (plan.colours.of_vertices)
      frames.colours[i] = vertex_colours(track, first + i, *described);
    else if (plan.colours.on)
      frames.colours[i] = colours(track, first + i, mesh, *described,
                                  cameras_of(first + i, plan.colours.cameras), coder.states());
  }
  return frames;
}

} // namespace fvv::mux
