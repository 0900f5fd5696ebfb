// cameras.xml of Agisoft Metashape (File > Export > Export Cameras, Agisoft XML). The pose of a camera is
// camera to chunk in OpenCV's axes; the transform of the chunk, or of its component that the camera is of,
// (scale, rotation, translation) leads to the world.
// Pixels: u = w/2 + cx + f x' + b1 x' + b2 y', v = h/2 + cy + f y', from the corner of the picture
// (Metashape's manual, appendix on camera models), so that b1 lengthens f and b2 is the skew.

#include "scene/src/import/tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

namespace fvv::import {

namespace {

struct Similarity {
  std::array<double, 9> rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  std::array<double, 3> translation = {};
  double scale = 1;
};

class Document {
public:
  explicit Document(const std::string &path_)
      : path(path_), root(parse_xml(scene::read_file(path, max_xml_size), path)) {
    if (root.name != "document")
      fail_at(path, root.line, "expected <document> of Metashape, found <" + root.name.substr(0, 40) + ">");
  }

  Calibration read() {
    const Node *chunk = nullptr;
    for (const Node &node : root.children) {
      if (node.name != "chunk" || !node.find(path, "cameras")) continue;
      if (chunk)
        fail_at(path, node.line, "expected one chunk with cameras, found a second: export one alone");
      chunk = &node;
    }
    if (!chunk) throw Error(path + ": expected a chunk with cameras, found none");
    if (const Node *transform = chunk->find(path, "transform")) world = read_transform(*transform);
    if (const Node *list = chunk->find(path, "components"))
      for (const Node &node : list->children)
        if (const Node *transform = node.name == "component" ? node.find(path, "transform") : nullptr)
          components.emplace(node.attribute(path, "id"), read_transform(*transform));
    for (const Node &node : chunk->child(path, "sensors").children)
      if (node.name == "sensor") sensors.emplace(node.attribute(path, "id"), &node);
    read_cameras(chunk->child(path, "cameras"));
    if (!out.cameras.empty() && unaligned)
      out.notes.push_back(std::to_string(unaligned) + " of " +
                          std::to_string(unaligned + out.cameras.size()) +
                          " cameras are not aligned and left out");
    require_cameras(out, path);
    return std::move(out);
  }

private:
  std::vector<double> numbers(const Node &node, size_t count) const {
    const auto words = words_of(node.text);
    if (words.size() != count)
      fail_at(path, node.line,
              "expected " + std::to_string(count) + " numbers in <" + node.name + ">, found " +
                  std::to_string(words.size()));
    std::vector<double> values;
    for (const std::string_view word : words)
      values.push_back(number_at(path, node.line, word, node.name.c_str()));
    return values;
  }
  double number(const Node &parent, const char *key) const {
    const Node *node = parent.find(path, key);
    return node ? numbers(*node, 1)[0] : 0;
  }

  Similarity read_transform(const Node &node) {
    Similarity read;
    if (const Node *part = node.find(path, "rotation")) {
      const auto values = numbers(*part, 9);
      std::copy(values.begin(), values.end(), read.rotation.begin());
    }
    if (const Node *part = node.find(path, "translation")) {
      const auto values = numbers(*part, 3);
      std::copy(values.begin(), values.end(), read.translation.begin());
    }
    if (const Node *part = node.find(path, "scale")) read.scale = numbers(*part, 1)[0];
    if (!(read.scale > 0)) fail_at(path, node.line, "expected a scale above 0 of the chunk");
    // Without a scale bar or coordinates the world is that of the first camera, in lengths of no unit.
    out.metres_per_unit = node.find(path, "scale") ? 1 : 0;
    return read;
  }

  void read_lens(const Node &sensor, fvv_camera &camera) const {
    const std::string *type = sensor.find_attribute("type");
    if (type && *type != "frame")
      fail_at(path, sensor.line,
              "expected a sensor of the type frame, found " + scene::quote(*type) +
                  ", whose projection fvv does not have");
    const Node *found = nullptr;
    for (const Node &node : sensor.children) {
      if (node.name != "calibration") continue;
      const std::string *kind = node.find_attribute("class");
      if (!kind || *kind == "adjusted") found = &node;
    }
    if (!found)
      fail_at(path, sensor.line, "expected an adjusted <calibration>, found none: align the cameras first");
    const Node &c = *found;
    for (const char *key : {"k4", "p3", "p4"})
      if (number(c, key) != 0)
        fail_at(path, c.line,
                std::string("expected 0 for ") + key +
                    ", which fvv does not have: optimise the cameras without it");
    const Node *size = c.find(path, "resolution");
    if (!size) size = &sensor.child(path, "resolution");
    const auto side = [&](const char *key) {
      return integer_at(path, size->line, size->attribute(path, key), key, 1, INT32_MAX);
    };
    camera.width = uint32_t(side("width"));
    camera.height = uint32_t(side("height"));
    const double f = numbers(c.child(path, "f"), 1)[0];
    camera.fx = f + number(c, "b1");
    camera.fy = f;
    camera.skew = number(c, "b2");
    camera.cx = camera.width / 2.0 + number(c, "cx");
    camera.cy = camera.height / 2.0 + number(c, "cy");
    // Metashape's p1 goes with r^2 + 2 x^2, OpenCV's p2 does.
    const double k[8] = {number(c, "k1"), number(c, "k2"), number(c, "p2"), number(c, "p1"), number(c, "k3")};
    set_radtan(camera, k);
  }

  // camera: to the chunk. World to camera is its inverse after the chunk's transform, whose scale is that of
  // the world's lengths.
  void set_pose(const std::vector<double> &m, const Similarity &placed, fvv_camera &camera) const {
    double centre[3];
    for (size_t i = 0; i < 3; i++) {
      centre[i] = placed.translation[i];
      for (size_t k = 0; k < 3; k++) centre[i] += placed.scale * placed.rotation[3 * i + k] * m[4 * k + 3];
    }
    for (size_t row = 0; row < 3; row++)
      for (size_t column = 0; column < 3; column++) {
        double r = 0;
        for (size_t k = 0; k < 3; k++) r += placed.rotation[3 * column + k] * m[4 * k + row];
        camera.rotation[3 * row + column] = r;
      }
    set_centre(camera, centre);
  }

  void read_cameras(const Node &list) {
    for (const Node &node : list.children) {
      if (node.name == "group") read_cameras(node);
      if (node.name != "camera") continue;
      const Node *transform = node.find(path, "transform");
      if (!transform) {
        unaligned++;
        continue;
      }
      const std::string &sensor = node.attribute(path, "sensor_id");
      const auto lens = sensors.find(sensor);
      if (lens == sensors.end())
        fail_at(path, node.line, "expected a sensor with the id " + scene::quote(sensor) + ", found none");
      scene::Camera camera;
      camera.set_name(node.attribute(path, "label"));
      camera.calibration.id = uint16_t(out.cameras.size()); // append() allows far fewer cameras
      read_lens(*lens->second, camera.calibration);
      const std::string *part = node.find_attribute("component_id");
      const auto component = part ? components.find(*part) : components.end();
      set_pose(numbers(*transform, 16), component == components.end() ? world : component->second,
               camera.calibration);
      append(out, std::move(camera), path + ":" + std::to_string(node.line));
    }
  }

  const std::string &path;
  Node root;
  Similarity world;                             // of the chunk
  std::map<std::string, Similarity> components; // of its parts, which newer versions have instead
  std::map<std::string, const Node *> sensors;
  Calibration out;
  size_t unaligned = 0;
};

} // namespace

Calibration read_metashape(const std::string &file) {
  return Document(file).read();
}

} // namespace fvv::import
