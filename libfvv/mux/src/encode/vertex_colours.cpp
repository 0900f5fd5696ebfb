#include "mux/src/encode/vertex_colours.h"
#include "fvv_geometry/surface.h"

#include <algorithm>
#include <cmath>

namespace fvv::mux {

namespace {

// Root of the mean square, of 255: 30 dB, below which colours of a single frame are a warning, too.
constexpr double most_difference = 8;
// A lamp that is switched on changes few vertices: one in hundred may be further off than this.
constexpr int far_off = 32;

std::vector<float> local_places(const geometry::Mesh &mesh, const geometry::Lattice &lattice) {
  const render::Vec3 from = origin_of(lattice);
  const double origin[3] = {from.x, from.y, from.z};
  std::vector<float> out(mesh.positions.size());
  for (size_t i = 0; i < out.size(); i++) out[i] = float(mesh.positions[i] - origin[i % 3]);
  return out;
}

// order: for each vertex of a the one of b.
bool are_alike(const std::vector<uint8_t> &a, const std::vector<uint8_t> &b,
               const std::vector<uint32_t> &order) {
  double squares = 0;
  size_t far = 0;
  for (size_t v = 0; v < order.size(); v++) {
    int most = 0;
    for (size_t k = 0; k < 3; k++) {
      const int off = std::abs(int(a[3 * v + k]) - int(b[3 * size_t(order[v]) + k]));
      squares += double(off) * off;
      most = std::max(most, off);
    }
    far += most > far_off;
  }
  return squares <= most_difference * most_difference * 3 * double(order.size()) && 100 * far <= order.size();
}

} // namespace

std::vector<uint8_t> transferred(const geometry::Mesh &source, const std::vector<uint8_t> &colours,
                                 const std::vector<float> &metres, const geometry::Lattice &lattice) {
  geometry::Mesh local = source;
  const render::Vec3 from = origin_of(lattice);
  const double origin[3] = {from.x, from.y, from.z};
  for (size_t i = 0; i < local.positions.size(); i++) local.positions[i] -= origin[i % 3];
  const compare::Faces faces(local);
  std::vector<uint8_t> out;
  uint32_t guess = UINT32_MAX;
  for (size_t i = 0; i < metres.size(); i += 3) {
    const render::ClosestPoint near = faces.nearest({metres[i], metres[i + 1], metres[i + 2]}, guess);
    guess = near.face;
    for (size_t k = 0; k < 3; k++) {
      double value = 0.5;
      for (size_t c = 0; c < 3; c++)
        value += near.barycentric[c] * colours[3 * size_t(local.faces[3 * size_t(near.face) + c]) + k];
      out.push_back(uint8_t(std::clamp(value, 0.0, 255.0)));
    }
  }
  return out;
}

KeyColours::KeyColours(const Plan &chosen, size_t frame, const PreparedMesh &mesh) : plan(chosen), key(mesh) {
  if (plan.colours.of_vertices)
    source = scene::load_coloured_mesh(plan.capture, plan.capture.frames.number(int64_t(frame)), colours);
}

bool KeyColours::serve(size_t frame, const PreparedMesh &mesh) {
  if (!plan.colours.of_vertices) return true;
  std::vector<uint8_t> own;
  const geometry::Mesh there =
      scene::load_coloured_mesh(plan.capture, plan.capture.frames.number(int64_t(frame)), own);
  if (own.empty() || colours.empty()) return own.empty() == colours.empty();
  if (const auto order = same_connectivity(source, there)) return are_alike(colours, own, *order);
  // Of a patched frame the patch has colours of its own.
  const auto order = mesh.body ? std::nullopt : same_connectivity(key.mesh, mesh.mesh);
  if (!order) return true;
  const geometry::Lattice &lattice = plan.lattice.lattice;
  if (!of_key) of_key = transferred(source, colours, local_places(key.mesh, lattice), lattice);
  return are_alike(*of_key, transferred(there, own, local_places(mesh.mesh, lattice), lattice), *order);
}

} // namespace fvv::mux
