#include "fvvmux/normals.h"

#include "cli/cli.h"
#include "fvv/mesh.h"
#include "fvvmux/meshes.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace fvv::mux {

namespace {

constexpr uint32_t sent_bits = 8; // 0.34 degrees off on average
// Smooth surfaces stay well below both: by how source and decoder weigh faces, normals of coarse meshes
// differ by up to 10 degrees, where edges are hard by 35 to 90.
constexpr double hard_degrees = 20, hard_share = 0.01;

// The mesh on a lattice so fine that rounding to it turns nothing, with normals.
void place(const capture::Mesh &source, const std::string &name, fvv_mesh &mesh) {
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
  cli::check(fvv_mesh_canonicalise(&borrowed, &options, nullptr, &mesh, nullptr, &diagnostic), name,
             diagnostic);
}

// The share of vertices whose normals are off computed ones by more than hard_degrees. Which side is out is
// for the faces to say.
double share_of_hard(const fvv_mesh &mesh, const std::string &name) {
  const size_t count = mesh.vertex_count;
  std::vector<float> sent(3 * count), computed(3 * count);
  fvv_mesh bare = mesh;
  bare.normals = nullptr;
  bare.normal_bits = 0;
  fvv_diagnostic diagnostic = {};
  cli::check(fvv_mesh_normals(&mesh, nullptr, sent.data(), &diagnostic), name, diagnostic);
  cli::check(fvv_mesh_normals(&bare, nullptr, computed.data(), &diagnostic), name, diagnostic);
  const double least = std::cos(hard_degrees * std::acos(-1.0) / 180);
  size_t hard = 0;
  for (size_t v = 0; v < count; v++) {
    double cosine = 0;
    for (size_t k = 3 * v; k < 3 * v + 3; k++) cosine += double(sent[k]) * double(computed[k]);
    hard += std::abs(cosine) < least;
  }
  return double(hard) / double(count);
}

NormalChoice judge(const capture::Mesh &source, const std::string &name) {
  if (source.normals.empty()) return {0, "the source has none"};
  MeshHolder holder;
  place(source, name, holder.mesh);
  const double share = share_of_hard(holder.mesh, name);
  char reason[120];
  std::snprintf(reason, sizeof reason,
                "%.3g %% of the first mesh's are more than %g degrees off computed ones", 100 * share,
                hard_degrees);
  return {share > hard_share ? sent_bits : 0, reason};
}

} // namespace

NormalChoice choose_normals(const Options &options, const capture::Capture &capture) {
  if (!capture.meshes) return {};
  if (options.normals == Normals::never) return {0, "--normals never"};
  const std::string name = capture.mesh_path(capture.frames.first);
  const auto load = [&] { return capture::load_mesh(capture, capture.frames.first, nullptr, nullptr, true); };
  if (options.normals == Normals::always) {
    if (load().normals.empty())
      throw cli::Failure("--normals always: " + name + ": expected a normal for every corner, found none");
    return {sent_bits, "--normals always"};
  }
  // Normals that are no good, which nobody asked for, are no reason to fail.
  try {
    return judge(load(), name);
  } catch (const std::exception &error) {
    return {0, std::string("the source's are not usable: ") + error.what()};
  }
}

} // namespace fvv::mux
