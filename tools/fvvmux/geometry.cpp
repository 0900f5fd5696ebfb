#include "fvvmux/geometry.h"

#include "fvvmux/connectivity.h"

#include <algorithm>

namespace fvv::mux {

Geometry::Geometry(const Plan &plan, const Tiling &tiles)
    : capture(plan.capture), tiling(tiles), choice(plan.decimation), group_size(plan.group_size),
      tracked(plan.tracked), normals(plan.normals.bits != 0), groups(plan.group_count()) {}

capture::Mesh Geometry::source(size_t i, capture::MeshReport *report) const {
  return capture::load_mesh(capture, capture.frames.number(int64_t(i)), nullptr, report, normals);
}

decimate::Footprint Geometry::cameras(size_t i) const {
  return footprint(capture, tiling, capture.frames.number(int64_t(i)));
}

void Geometry::add_run(Group &group, size_t group_first, size_t first,
                       std::vector<std::vector<uint32_t>> orders) const {
  if (orders.size() < 2) return;
  const auto mesh = [this, first, &orders](size_t i) {
    return orders[i].empty() ? source(first + i) : reordered(source(first + i), orders[i], source(first));
  };
  const decimate::Frames frames = {orders.size(), mesh,
                                   [this, first](size_t i) { return cameras(first + i); }};
  std::fill_n(group.run_of.begin() + std::ptrdiff_t(first - group_first), orders.size(), group.runs.size());
  decimate::Run run(frames, choice.budget, choice.reach);
  group.runs.push_back({first, std::move(run), std::move(orders)});
}

void Geometry::find_runs(Group &group, size_t first, size_t count) const {
  group.run_of.assign(count, SIZE_MAX);
  if (!tracked) return;
  size_t begin = first;
  capture::Mesh begun = source(first);
  std::vector<std::vector<uint32_t>> orders(1);
  for (size_t i = first + 1; i < first + count; i++) {
    capture::Mesh mesh = source(i);
    if (std::optional<std::vector<uint32_t>> order = same_connectivity(begun, mesh)) {
      if (mesh.faces == begun.faces) order->clear();
      orders.push_back(std::move(*order));
      continue;
    }
    add_run(group, first, begin, std::move(orders));
    begin = i;
    begun = std::move(mesh);
    orders.assign(1, {});
  }
  add_run(group, first, begin, std::move(orders));
}

capture::Mesh Geometry::load(size_t i, capture::MeshReport *report,
                             std::optional<decimate::Report> &decimation) const {
  capture::Mesh mesh = source(i, report);
  if (!choice.on) return mesh;
  const size_t index = i / group_size, first = index * group_size;
  Group &group = groups[index];
  std::call_once(group.known, [&] {
    find_runs(group, first, std::min<size_t>(group_size, size_t(capture.frames.count) - first));
  });
  const size_t of = group.run_of[i - first];
  decimate::Decimated out;
  if (of == SIZE_MAX) {
    out = decimate::decimate(mesh, cameras(i), choice.budget, choice.reach);
  } else {
    const Stretch &run = group.runs[of];
    const std::vector<uint32_t> &order = run.orders[i - run.first];
    if (!order.empty()) mesh = reordered(mesh, order, source(run.first));
    out = run.run.apply(mesh, i - run.first);
  }
  decimation = out.report;
  return std::move(out.mesh);
}

} // namespace fvv::mux
