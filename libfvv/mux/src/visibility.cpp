#include "mux/src/visibility.h"
#include "fvv_cxx/error.h"
#include "fvv_cxx/owned.h"
#include "fvv_render/visibility_fit.h"
#include "mux/src/stream_writer.h"

namespace fvv::mux {

namespace {

// The gain, in faces of mean area, for which a bit changes, in frames with the faces of the one before. The
// lower one costs no accuracy that can be measured, and saves a tenth of the bytes.
constexpr double change_price = 0.1;

// Decoded meshes of a run of frames.
class DecodedMeshes {
public:
  explicit DecodedMeshes(const std::string &path) : name(path), sequence(nullptr, fvv_mesh_sequence_close) {}

  // The next frame. followed: whether the frame after it is a delta frame.
  const fvv_mesh &next(const MeshFrame &frame, bool followed) {
    if (frame.key) {
      fvv_mesh_free(&key);
      sequence.reset();
      check(fvv_mesh_decode(frame.payload.data(), frame.payload.size(), nullptr, nullptr, &key, &diagnostic));
      if (!followed) return key;
      fvv_mesh_sequence *opened = nullptr;
      const fvv_status status = fvv_mesh_sequence_open(&key, nullptr, &opened, &diagnostic);
      sequence.reset(opened);
      check(status);
    } else {
      check(
          fvv_mesh_sequence_decode(sequence.get(), frame.payload.data(), frame.payload.size(), &diagnostic));
    }
    return *fvv_mesh_sequence_mesh(sequence.get());
  }

private:
  void check(fvv_status status) { fvv::check(status, name, diagnostic); }

  const std::string name;
  fvv_diagnostic diagnostic = {};
  OwnedMesh key;
  std::unique_ptr<fvv_mesh_sequence, void (*)(fvv_mesh_sequence *)> sequence;
};

// The state from one frame to the next with its faces.
struct Former {
  uint32_t number = 0;
  States states;
};

class FrameCoder {
public:
  FrameCoder(const Plan &chosen, const VisibilityChoice &what) : plan(chosen), choice(what) {}

  // follows: mesh has the faces of the one before.
  VisibilityFrame code(const fvv_mesh &mesh, bool follows, const std::vector<fvv_camera> &cameras) {
    if (!follows) open_order(mesh);
    const size_t elements = choice.domain == FVV_VISIBILITY_FACES ? mesh.face_count : mesh.vertex_count;
    VisibilityFrame frame;
    frame.key = !follows || former.states.empty();
    frame.elements = uint32_t(elements);
    Former now;
    now.number = frame.key ? 0 : former.number + 1;
    const std::vector<CameraView> looks =
        look(mesh, plan.lattice.lattice, choice, cameras, frame.key ? States() : former.states);
    std::vector<fvv_visibility_view> views;
    for (const CameraView &one : looks) {
      const auto before = former.states.find(one.camera);
      std::vector<uint8_t> &states = now.states[one.camera];
      states.resize(elements);
      views.push_back({one.camera,
                       {one.centre[0], one.centre[1], one.centre[2]},
                       one.seen.data(),
                       !frame.key && before != former.states.end() ? before->second.data() : nullptr,
                       states.data()});
    }
    for (const fvv_visibility_view &view : views) frame.cameras.push_back(view.camera);
    if (!views.empty()) {
      const fvv_visibility_header header = {choice.domain, choice.threshold, mesh_track, 0, now.number, 0};
      check(fvv_visibility_encode(order.get(), &mesh, &header, views.data(), views.size(), &payload,
                                  &diagnostic));
      frame.payload.assign(payload.data, payload.data + payload.size);
    }
    former = std::move(now);
    return frame;
  }

private:
  void check(fvv_status status) { fvv::check(status, plan.capture.path, diagnostic); }

  void open_order(const fvv_mesh &mesh) {
    fvv_visibility_order *opened = nullptr;
    const fvv_status status = fvv_visibility_order_open(&mesh, choice.domain, nullptr, &opened, &diagnostic);
    order.reset(opened);
    check(status);
  }

  const Plan &plan;
  const VisibilityChoice &choice;
  fvv_diagnostic diagnostic = {};
  OwnedBytes payload;
  Former former;
  std::unique_ptr<fvv_visibility_order, void (*)(fvv_visibility_order *)> order{nullptr,
                                                                                fvv_visibility_order_close};
};

} // namespace

std::vector<CameraView> look(const fvv_mesh &mesh, const geometry::Lattice &lattice,
                             const VisibilityChoice &choice, const std::vector<fvv_camera> &cameras,
                             const States &former) {
  fvv_scene scene = {};
  std::copy_n(lattice.origin, 3, scene.lattice_origin);
  scene.lattice_step = lattice.step;
  std::vector<float> metres(3 * size_t(mesh.vertex_count));
  fvv_lattice_to_floats(lattice.origin, lattice.step, mesh.positions, mesh.vertex_count, metres.data());
  const render::Mesh surface = {metres.data(), mesh.vertex_count, mesh.faces, mesh.face_count};
  const render::RayCaster rays(surface);
  render::FitSettings settings;
  settings.cosine = choice.cosine;
  settings.change = change_price;
  const render::VisibilityFit fit(surface, rays, choice.domain, settings);
  const size_t elements = choice.domain == FVV_VISIBILITY_FACES ? mesh.face_count : mesh.vertex_count;
  std::vector<CameraView> out;
  for (const fvv_camera &camera : cameras) {
    CameraView view = {camera.id, {}, std::vector<uint8_t>(elements), {}};
    if (fvv_visibility_centre(&camera, &scene, view.centre, nullptr) != FVV_OK) continue;
    fvv_visibility_facing(&mesh, choice.domain, view.centre, choice.threshold, view.facing.data());
    const auto before = former.find(camera.id);
    view.seen = fit.seen(camera, view.facing, before == former.end() ? nullptr : before->second.data());
    out.push_back(std::move(view));
  }
  return out;
}

VisibilityCoder::VisibilityCoder(const Plan &chosen)
    : plan(chosen), choice(chosen.visibility), on(choice.on) {
  if (on && any_moves(plan.capture)) moving.emplace(plan.capture, plan.lattice.lattice.step);
}

std::vector<fvv_camera> VisibilityCoder::cameras_of(size_t frame) const {
  const std::vector<fvv_camera> placed = moving ? moving->decoded(frame) : std::vector<fvv_camera>();
  std::vector<fvv_camera> out;
  for (const size_t index : choice.cameras) {
    const fvv_camera camera = described(plan.capture, plan.capture.cameras[index]);
    if (!(camera.flags & FVV_CAMERA_MOVES)) out.push_back(camera);
    for (const fvv_camera &other : placed)
      if (other.id == camera.id) out.push_back(other);
  }
  return out;
}

std::vector<VisibilityFrame> VisibilityCoder::encode(size_t first,
                                                     const std::vector<MeshFrame> &meshes) const {
  std::vector<VisibilityFrame> frames(meshes.size());
  DecodedMeshes decoded(plan.capture.path);
  FrameCoder coder(plan, choice);
  for (size_t i = 0; i < meshes.size() && on; i++) {
    if (meshes[i].payload.empty()) continue;
    const bool followed = i + 1 < meshes.size() && !meshes[i + 1].key;
    frames[i] = coder.code(decoded.next(meshes[i], followed), !meshes[i].key, cameras_of(first + i));
  }
  return frames;
}

} // namespace fvv::mux
