#include "fvv_cxx/error.h"
#include "fvv_cxx/untrusted.h"
#include "fvv_media/colour.h"
#include "fvv_scene/mesh_run.h"
#include "scene/src/drc_points.h"
#include "scene/src/gltf/writer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <meshoptimizer.h>
#include <optional>

namespace fvv::scene {

namespace {

using Json = gltf::Writer::Json;

// The vertices in the order in which the faces use them, those that no face uses left out: meshoptimizer's
// codecs then take a quarter less.
MeshRun in_order_of_use(const MeshRun &run) {
  std::vector<unsigned> places(run.vertex_count()); // UINT32_MAX: used by no face
  const size_t count =
      meshopt_optimizeVertexFetchRemap(places.data(), run.faces.data(), run.faces.size(), places.size());
  const auto moved = [&](const auto &values, size_t width) {
    auto out = values;
    for (size_t v = 0; !values.empty() && v < places.size(); v++)
      if (places[v] != UINT32_MAX)
        std::copy_n(values.begin() + ptrdiff_t(v * width), width, out.begin() + ptrdiff_t(places[v] * width));
    out.resize(values.empty() ? 0 : count * width);
    return out;
  };
  MeshRun out;
  out.texture_bits = run.texture_bits;
  out.texture = moved(run.texture, 2);
  out.colours = moved(run.colours, 3);
  for (const MeshRun::Frame &frame : run.frames)
    out.frames.push_back(
        {moved(frame.positions, 3), moved(frame.normals, 3), frame.time, frame.name, frame.held_until});
  for (const uint32_t corner : run.faces) out.faces.push_back(places[corner]);
  return out;
}

class RunWriter {
public:
  RunWriter(const MeshRun &frames, const Lattice &grid, Compression how, const std::string &file)
      : run(frames), lattice(grid), compression(how), name(file), out(file, how == Compression::meshopt) {
    gltf::Bounds<double> bounds;
    for (const MeshRun::Frame &frame : run.frames)
      for (size_t i = 0; i < frame.positions.size(); i++)
        bounds.add(i % 3, metres(i % 3, frame.positions[i]));
    origin = gltf::local_origin(lattice, bounds);
    for (size_t k = 0; origin && k < 3; k++) lattice.origin[k] -= (*origin)[k];
  }
  bool is_local() const { return origin.has_value(); }

  std::string write(const std::string &picture) {
    if (compression == Compression::draco && run.frames.size() > 1)
      throw Error(name + ": Draco cannot compress an animation");
    gltf::Surface surface;
    coloured = picture.empty() && !run.colours.empty() && compression != Compression::draco;
    surface.unlit = coloured;
    if (picture.empty()) {
      for (double &channel : surface.colour) channel = coloured ? 1 : 0.5;
    } else {
      surface.image = out.image(picture);
      surface.clamped = surface.unlit = true;
    }
    textured = !picture.empty() && !run.texture.empty();
    Json primitive = compression == Compression::draco ? draco() : plain();
    primitive["material"] = out.material(surface);
    Json mesh = {{"primitives", {primitive}}};
    if (run.frames.size() > 1) {
      mesh["weights"] = std::vector<int>(run.frames.size() - 1, 0);
      Json names = Json::array();
      for (size_t i = 1; i < run.frames.size(); i++) names.push_back(run.frames[i].name);
      mesh["extras"] = {{"targetNames", names}};
    }
    out.list("meshes").push_back(mesh);
    Json node = {{"mesh", 0}};
    if (integers) {
      node["translation"] = {metres(0, least[0]), metres(1, least[1]), metres(2, least[2])};
      node["scale"] = {lattice.step, lattice.step, lattice.step};
    }
    if (origin) gltf::Writer::place(*origin, node);
    out.list("nodes").push_back(node);
    if (run.frames.size() > 1) animate();
    return out.glb();
  }

private:
  double metres(size_t axis, int32_t index) const { return lattice.origin[axis] + lattice.step * index; }
  // As a reader of float32 has it.
  float stored(size_t i, int32_t index) const { return float(metres(i % 3, index)); }
  const std::vector<int32_t> &first() const { return run.frames[0].positions; }

  // The mesh of the first frame, in metres.
  Mesh mesh() const {
    Mesh result;
    for (size_t i = 0; i < first().size(); i++) result.positions.push_back(metres(i % 3, first()[i]));
    result.faces = run.faces;
    if (textured)
      for (const uint32_t index : run.texture)
        result.texture.push_back(std::ldexp(double(index), -int(run.texture_bits)));
    result.normals.assign(run.frames[0].normals.begin(), run.frames[0].normals.end());
    return result;
  }

  Json draco() {
    constexpr const char *extension = "KHR_draco_mesh_compression";
    out.use(extension, true);
    const Mesh source = mesh();
    const std::string bytes = format_drc_points(source, lattice, run.texture_bits, name);
    // Draco may leave out vertices: the accessors describe what a decoder finds.
    const DrcPoints found = parse_drc_points(bytes, name, limits_or_default(nullptr), {0});
    gltf::Bounds<float> bounds;
    for (size_t i = 0; i < size_t(found.count) * 3; i++) {
      float value;
      memcpy(&value, &found.attributes.at(0).bytes[i * sizeof value], sizeof value);
      const double index = std::nearbyint((double(value) - lattice.origin[i % 3]) / lattice.step);
      gltf::check_on_lattice(value, lattice.origin[i % 3] + lattice.step * index, i / 3, lattice.step, name);
      bounds.add(i % 3, value);
    }
    const auto accessor = [&](const char *type) {
      return out.accessor({}, gltf::component_float32, found.count, type);
    };
    int identifier = 0;
    const size_t positions = accessor("VEC3");
    out.bound(positions, bounds.low, bounds.high);
    Json attributes = {{"POSITION", positions}}, identifiers = {{"POSITION", identifier++}};
    if (textured) {
      attributes["TEXCOORD_0"] = accessor("VEC2");
      identifiers["TEXCOORD_0"] = identifier++;
    }
    if (!source.normals.empty()) {
      attributes["NORMAL"] = accessor("VEC3");
      identifiers["NORMAL"] = identifier++;
    }
    const size_t corners = out.accessor({}, gltf::component_uint32, found.triangles.size(), "SCALAR");
    return {{"attributes", attributes},
            {"indices", corners},
            {"extensions", {{extension, {{"bufferView", out.view(bytes)}, {"attributes", identifiers}}}}}};
  }

  Json plain() {
    const Mesh source = mesh();
    geometry::check(source, name);
    integers = compression == Compression::meshopt && fits_integers();
    Json attributes = {{"POSITION", integers ? integer_positions() : float_positions(source)}};
    if (!source.normals.empty()) attributes["NORMAL"] = out.floats(source.normals, 3, false);
    if (textured) attributes["TEXCOORD_0"] = out.floats(source.texture, 2, false);
    if (coloured) attributes["COLOR_0"] = out.floats(linear_colours(), 3, false);
    Json primitive = {{"attributes", attributes}, {"indices", out.corners(run.faces)}};
    if (run.frames.size() == 1) return primitive;
    const std::vector<size_t> moved = integers ? integer_targets() : float_targets();
    const std::vector<size_t> turned = source.normals.empty() ? std::vector<size_t>() : normal_targets();
    Json targets = Json::array();
    for (size_t i = 0; i < moved.size(); i++) {
      targets.push_back({{"POSITION", moved[i]}});
      if (!turned.empty()) targets.back()["NORMAL"] = turned[i];
    }
    primitive["targets"] = targets;
    return primitive;
  }

  // Colours of glTF are linear light.
  std::vector<double> linear_colours() const {
    const std::vector<float> linear = media::linear_of_codes(255);
    std::vector<double> out_of;
    for (const uint8_t code : run.colours) out_of.push_back(double(linear[code]));
    return out_of;
  }

  size_t float_positions(const Mesh &source) {
    for (size_t i = 0; i < source.positions.size(); i++)
      gltf::check_on_lattice(double(float(source.positions[i])), source.positions[i], i / 3, lattice.step,
                             name);
    return out.floats(source.positions, 3, true);
  }

  // Whether positions are uint16 from the least on, and displacements int16.
  bool fits_integers() {
    gltf::Bounds<int32_t> bounds;
    for (size_t i = 0; i < first().size(); i++) bounds.add(i % 3, first()[i]);
    least = bounds.low;
    for (size_t k = 0; k < 3; k++)
      if (int64_t(bounds.high[k]) - bounds.low[k] > UINT16_MAX) return false;
    for (const MeshRun::Frame &frame : run.frames)
      for (size_t i = 0; i < first().size(); i++)
        if (std::abs(int64_t(frame.positions[i]) - first()[i]) > INT16_MAX) return false;
    return true;
  }

  // Elements of three 16-bit components and two bytes of padding.
  static constexpr size_t integer_stride = 8;

  size_t integer_positions() {
    out.use("KHR_mesh_quantization", true);
    std::string bytes;
    gltf::Bounds<int32_t> bounds;
    for (size_t i = 0; i < first().size(); i++) {
      const int32_t value = first()[i] - least[i % 3];
      gltf::put_u16(bytes, uint16_t(value));
      if (i % 3 == 2) gltf::put_u16(bytes, 0);
      bounds.add(i % 3, value);
    }
    const size_t accessor = out.accessor(out.elements(bytes, gltf::Use::vertices, integer_stride, true),
                                         gltf::component_uint16, run.vertex_count(), "VEC3");
    out.bound(accessor, bounds.low, bounds.high);
    return accessor;
  }

  // Accessors of all targets in one view; bounds empty: without bounds.
  template <class Number>
  std::vector<size_t> targets(const std::string &bytes, size_t stride, gltf::Component component,
                              const std::vector<gltf::Bounds<Number>> &bounds) {
    const size_t view = out.elements(bytes, gltf::Use::vertices, stride, true);
    std::vector<size_t> accessors;
    for (size_t i = 0; i + 1 < run.frames.size(); i++) {
      accessors.push_back(
          out.accessor(view, component, run.vertex_count(), "VEC3", i * run.vertex_count() * stride));
      if (!bounds.empty()) out.bound(accessors.back(), bounds[i].low, bounds[i].high);
    }
    return accessors;
  }

  std::vector<size_t> integer_targets() {
    std::string bytes;
    std::vector<gltf::Bounds<int32_t>> bounds(run.frames.size() - 1);
    for (size_t f = 1; f < run.frames.size(); f++)
      for (size_t i = 0; i < first().size(); i++) {
        const int32_t value = run.frames[f].positions[i] - first()[i];
        gltf::put_u16(bytes, uint16_t(value));
        if (i % 3 == 2) gltf::put_u16(bytes, 0);
        bounds[f - 1].add(i % 3, value);
      }
    return targets(bytes, integer_stride, gltf::component_int16, bounds);
  }

  std::vector<size_t> float_targets() {
    std::string bytes;
    std::vector<gltf::Bounds<float>> bounds(run.frames.size() - 1);
    for (size_t f = 1; f < run.frames.size(); f++)
      for (size_t i = 0; i < first().size(); i++) {
        const int32_t index = run.frames[f].positions[i];
        const float from = stored(i, first()[i]), by = stored(i, index) - from;
        gltf::check_on_lattice(double(from + by), metres(i % 3, index), i / 3, lattice.step, name);
        gltf::put_float(bytes, by);
        bounds[f - 1].add(i % 3, by);
      }
    return targets(bytes, 3 * sizeof(float), gltf::component_float32, bounds);
  }

  std::vector<size_t> normal_targets() {
    std::string bytes;
    for (size_t f = 1; f < run.frames.size(); f++)
      for (size_t i = 0; i < first().size(); i++)
        gltf::put_float(bytes, run.frames[f].normals[i] - run.frames[0].normals[i]);
    return targets<float>(bytes, 3 * sizeof(float), gltf::component_float32, {});
  }

  // At the time of frame i, and while it rests, the weight of its target is 1, and all others are 0.
  void animate() {
    const size_t count = run.frames.size();
    std::string times, weights;
    std::vector<float> keys;
    const auto add = [&](size_t i, double time) {
      keys.push_back(float(time));
      gltf::put_float(times, float(time));
      for (size_t target = 1; target < count; target++) gltf::put_float(weights, i == target ? 1 : 0);
    };
    for (size_t i = 0; i < count; i++) {
      const MeshRun::Frame &frame = run.frames[i];
      add(i, frame.time);
      if (float(frame.held_until) > float(frame.time)) add(i, frame.held_until);
    }
    const size_t input = out.accessor(out.view(times), gltf::component_float32, keys.size(), "SCALAR");
    out.bound<float>(input, {keys.front()}, {keys.back()});
    const size_t output = out.accessor(out.elements(weights, gltf::Use::unstated, sizeof(float)),
                                       gltf::component_float32, keys.size() * (count - 1), "SCALAR");
    out.list("animations")
        .push_back({{"name", "frames"},
                    {"samplers", {{{"input", input}, {"interpolation", "LINEAR"}, {"output", output}}}},
                    {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}}});
  }

  const MeshRun &run;
  Lattice lattice;                             // with its origin relative to the local one
  std::optional<std::array<double, 3>> origin; // of all positions; none: they are those of the world
  const Compression compression;
  const std::string &name;
  gltf::Writer out;
  bool textured = false, coloured = false, integers = false;
  std::vector<int32_t> least; // position of the integers' zero
};

} // namespace

std::string format_run(const MeshRun &run, const Lattice &lattice, const std::string &picture,
                       Compression compression, const std::string &name, bool *is_local) {
  if (run.frames.empty()) throw Error(name + ": expected at least one frame");
  const MeshRun sorted = compression == Compression::meshopt ? in_order_of_use(run) : MeshRun();
  RunWriter writer(compression == Compression::meshopt ? sorted : run, lattice, compression, name);
  if (is_local) *is_local = writer.is_local();
  return writer.write(picture);
}

} // namespace fvv::scene
