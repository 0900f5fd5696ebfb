#include "fvvmux/normals.h"

#include "cli/cli.h"
#include "cli/owned.h"
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
constexpr double hard_degrees = 20, hard_share = 0.01, odd_share = 0.5;

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

// Of each vertex the normal by area of its own faces, those of others on its point left out; any length.
std::vector<double> of_own_faces(const fvv_mesh &mesh) {
  std::vector<double> sums(3 * size_t(mesh.vertex_count));
  for (size_t f = 0; f < mesh.face_count; f++) {
    const uint32_t *face = mesh.faces + 3 * f;
    const auto edge = [&](size_t corner, size_t k) {
      return double(mesh.positions[3 * size_t(face[corner]) + k]) - mesh.positions[3 * size_t(face[0]) + k];
    };
    for (size_t k = 0; k < 3; k++) {
      const size_t i = (k + 1) % 3, j = (k + 2) % 3;
      const double area = edge(1, i) * edge(2, j) - edge(1, j) * edge(2, i);
      for (size_t c = 0; c < 3; c++) sums[3 * size_t(face[c]) + k] += area;
    }
  }
  return sums;
}

// Which side is out is for the faces to say.
template <class Number> bool near(const float *sent, const Number *computed) {
  double dot = 0, length = 0;
  for (size_t k = 0; k < 3; k++) {
    dot += double(sent[k]) * double(computed[k]);
    length += double(computed[k]) * double(computed[k]);
  }
  return std::abs(dot) >= std::cos(hard_degrees * std::acos(-1.0) / 180) * std::sqrt(length);
}

// Shares of vertices. hard: the own faces have the vertex's normal, all around its point together do not.
// odd: not even the own faces have it. Some captures hold normals that belong to no vertex of theirs.
struct Shares {
  double hard, odd;
};

Shares shares_of(const fvv_mesh &mesh, const std::string &name) {
  const size_t count = mesh.vertex_count;
  std::vector<float> sent(3 * count), computed(3 * count);
  fvv_mesh bare = mesh;
  bare.normals = nullptr;
  bare.normal_bits = 0;
  fvv_diagnostic diagnostic = {};
  cli::check(fvv_mesh_normals(&mesh, nullptr, sent.data(), &diagnostic), name, diagnostic);
  cli::check(fvv_mesh_normals(&bare, nullptr, computed.data(), &diagnostic), name, diagnostic);
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

NormalChoice judge(const capture::Mesh &source, const std::string &name) {
  if (source.normals.empty()) return {0, "the source has none"};
  cli::OwnedMesh holder;
  place(source, name, holder);
  const Shares shares = shares_of(holder, name);
  char reason[160];
  if (shares.odd > odd_share)
    std::snprintf(reason, sizeof reason,
                  "%.3g %% of the first mesh's are more than %g degrees off those of their own faces",
                  100 * shares.odd, hard_degrees);
  else
    std::snprintf(reason, sizeof reason, "%.3g %% of the first mesh's vertices lie on hard edges",
                  100 * shares.hard);
  return {shares.odd <= odd_share && shares.hard > hard_share ? sent_bits : 0, reason};
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
