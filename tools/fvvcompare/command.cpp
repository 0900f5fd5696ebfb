// The files of a comparison: a table, and meshes whose colours show how far each vertex is off.
#include "fvvcompare/command.h"

#include "cli/cli.h"
#include "cli/output.h"
#include "fvv_cxx/parallel.h"
#include "fvv_geometry/surface.h"
#include "fvvcompare/report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

namespace fvv::compare {

namespace {

template <class Value> void put(std::string &out, Value value) {
  uint8_t bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
  out.append(reinterpret_cast<const char *>(bytes), sizeof bytes);
}

// Five colours of viridis (Smith and van der Walt, 2015), and straight lines between them.
std::array<uint8_t, 3> colour_of(double share) {
  constexpr double stops[5][3] = {{68, 1, 84}, {59, 82, 139}, {33, 145, 140}, {94, 201, 98}, {253, 231, 37}};
  const double at = 4 * std::clamp(share, 0.0, 1.0);
  const size_t stop = std::min<size_t>(3, size_t(at));
  std::array<uint8_t, 3> out;
  for (size_t k = 0; k < 3; k++)
    out[k] = uint8_t(stops[stop][k] + (stops[stop + 1][k] - stops[stop][k]) * (at - double(stop)) + 0.5);
  return out;
}

// PLY, binary_little_endian: x y z as double, the distance as float, red green blue as uchar, in the colours
// of viridis: dark blue for 0, yellow for most and beyond. distances: of each vertex; most: >= 0.
std::string format_heatmap(const geometry::Mesh &mesh, const std::vector<double> &distances, double most) {
  char scale[32];
  std::snprintf(scale, sizeof scale, "%.6g", most);
  std::string out = "ply\nformat binary_little_endian 1.0\ncomment yellow: a distance of " +
                    std::string(scale) + " or more\nelement vertex " + std::to_string(mesh.vertex_count()) +
                    "\nproperty double x\nproperty double y\nproperty double z\nproperty float distance\n"
                    "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face " +
                    std::to_string(mesh.face_count()) +
                    "\nproperty list uchar uint vertex_indices\nend_header\n";
  for (size_t v = 0; v < mesh.vertex_count(); v++) {
    for (size_t k = 0; k < 3; k++) put(out, mesh.positions[3 * v + k]);
    put(out, float(distances[v]));
    for (const uint8_t sample : colour_of(most > 0 ? distances[v] / most : 0)) put(out, sample);
  }
  for (size_t f = 0; f < mesh.faces.size(); f += 3) {
    put(out, uint8_t(3));
    for (size_t k = 0; k < 3; k++) put(out, mesh.faces[f + k]);
  }
  return out;
}

// B in colours of its distance from A, on one scale for all frames.
void heatmaps(const Sequence &a, const Sequence &b, const Result &result, uint32_t threads,
              cli::OutputFolder &folder) {
  fvv::parallel(threads, result.frames.size(), [&](size_t i) {
    const Meshes meshes = load(a, b, result.frames[i].pair);
    const Surface in_a(meshes.a);
    std::vector<double> off;
    for (const Vec3 &p : positions_of(meshes.b)) off.push_back(std::sqrt(in_a.nearest(p).squared));
    char name[32];
    std::snprintf(name, sizeof name, "%04lld.ply", (long long)result.frames[i].number_a);
    folder.write(name, format_heatmap(meshes.b, off, result.errors.distance[b_to_a].p99));
  });
}

} // namespace

void run(const Command &command, Result &result) {
  const Sequence a(command.a, command.memory), b(command.b, command.memory);
  // Refused before the work, not after it.
  const cli::Inputs read = [&](const std::function<void(const std::string &)> &visit) {
    for (const Sequence *sequence : {&a, &b}) sequence->visit_files(visit);
  };
  std::optional<cli::OutputFile> table;
  std::optional<cli::OutputFolder> folder;
  if (!command.table.empty()) table.emplace(command.table, command.force, read);
  if (!command.heatmap.empty()) folder.emplace(command.heatmap, command.force, read);
  std::optional<cli::Progress> progress;
  Options options = command;
  options.progress = [&](size_t done, size_t pairs) {
    if (done)
      progress->step();
    else
      progress.emplace("fvvcompare: " + a.path() + " and " + b.path(), pairs);
  };
  compare(a, b, options, result);
  std::vector<cli::Output *> outputs;
  if (folder) {
    heatmaps(a, b, result, command.threads, *folder);
    outputs.push_back(&*folder);
  }
  if (table) {
    const std::string lines = csv(result);
    table->write(lines.data(), lines.size());
    outputs.push_back(&*table);
  }
  cli::commit(outputs);
}

} // namespace fvv::compare
