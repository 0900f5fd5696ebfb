// Meshes whose distances are known, and captures of them: shared by the tests of fvvcompare.
#pragma once

#include "mux_fixture.h"

#include "fvvcompare/command.h"
#include "fvvsynth/random.h"
#include "mux/src/options/option_values.h"

#include <cmath>

namespace shapes {

using fvv::geometry::Mesh;

// A square of side 1 in z = height, cells x cells squares of two triangles, seen from above.
inline Mesh plane(uint32_t cells, double height, double shift_x = 0) {
  Mesh mesh;
  for (uint32_t y = 0; y <= cells; y++)
    for (uint32_t x = 0; x <= cells; x++)
      for (const double value : {double(x) / cells + shift_x, double(y) / cells, height})
        mesh.positions.push_back(value);
  for (uint32_t y = 0; y < cells; y++)
    for (uint32_t x = 0; x < cells; x++) {
      const uint32_t a = y * (cells + 1) + x, b = a + 1, c = a + cells + 1, d = c + 1;
      mesh.faces.insert(mesh.faces.end(), {a, b, d, a, d, c});
    }
  return mesh;
}

// The plane wound into a sphere, poles with triangles without area and all.
inline Mesh sphere(uint32_t cells, double radius) {
  Mesh mesh = plane(cells, 0);
  for (size_t v = 0; v < mesh.vertex_count(); v++) {
    double *p = &mesh.positions[3 * v];
    const double around = 2 * M_PI * p[0], up = M_PI * (p[1] - 0.5);
    p[0] = radius * std::cos(up) * std::cos(around);
    p[1] = radius * std::cos(up) * std::sin(around);
    p[2] = radius * std::sin(up);
  }
  return mesh;
}

inline Mesh quantised(Mesh mesh, double step) {
  for (double &value : mesh.positions) value = step * std::floor(value / step + 0.5);
  return mesh;
}

inline Mesh turned_over(Mesh mesh) {
  for (size_t i = 0; i < mesh.faces.size(); i += 3) std::swap(mesh.faces[i], mesh.faces[i + 1]);
  return mesh;
}

inline Mesh noisy(Mesh mesh, double deviation, uint64_t seed) {
  fvv::synth::Random random(seed);
  // Uniform, whose standard deviation is the width / sqrt(12).
  const double half = deviation * std::sqrt(3);
  for (double &value : mesh.positions) value += random.between(-half, half);
  return mesh;
}

// The same surface with its vertices in another order.
inline Mesh reversed(const Mesh &mesh) {
  Mesh out;
  for (size_t v = mesh.vertex_count(); v-- > 0;)
    out.positions.insert(out.positions.end(), &mesh.positions[3 * v], &mesh.positions[3 * v] + 3);
  for (const uint32_t v : mesh.faces) out.faces.push_back(uint32_t(mesh.vertex_count() - 1 - v));
  return out;
}

struct Shown {
  fvv::scene::Frames frames = {0, 1, 1};
  bool scale_unknown = false;
  fvv_rational duration = {1, 25};
};

// Writes a capture without cameras into folder/leaf and returns its path. meshes: one for each frame.
inline std::string make_capture(const Folder &folder, const std::string &leaf,
                                const std::vector<Mesh> &meshes, Shown shown = {}) {
  fvv::scene::Capture capture;
  capture.path = folder.path(leaf + "/capture.json");
  shown.frames.count = int64_t(meshes.size());
  capture.frames = shown.frames;
  capture.scale_unknown = shown.scale_unknown;
  capture.frame_duration = shown.duration;
  capture.meshes = fvv::scene::Pattern::parse("%04d.ply", nullptr);
  fs::create_directories(folder.path(leaf));
  for (size_t i = 0; i < meshes.size(); i++)
    fvv::scene::write_mesh(meshes[i], {}, capture.mesh_path(capture.frames.number(int64_t(i))));
  fvv::scene::write_capture(capture, capture.path);
  return capture.path;
}

inline std::string make_stream(const Folder &folder, const std::string &capture, const std::string &leaf,
                               const std::string &step,
                               fvv::mux::Normals normals = fvv::mux::Normals::automatic) {
  FileOptions options;
  options.capture = capture;
  options.output = folder.path(leaf);
  options.keep_geometry = true;
  options.step = fvv::mux::parse_length("step", step);
  options.normals = normals;
  options.threads = 1;
  mux_file(options);
  return options.output;
}

inline fvv::compare::Result compared(const std::string &a, const std::string &b,
                                     fvv::compare::Command options = {}) {
  options.a = a;
  options.b = b;
  fvv::compare::Result result;
  fvv::compare::run(options, result);
  return result;
}

} // namespace shapes
