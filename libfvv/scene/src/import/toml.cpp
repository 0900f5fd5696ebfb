// calibration.toml of Anipose (aniposelib), FreeMoCap, Caliscope and Pose2Sim: a table for each camera with
// size, matrix, distortions, rotation (a vector, as cv::Rodrigues takes it) and translation. World to camera,
// OpenCV's axes and pixel centres.

#include "scene/src/import/fields.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstring>
#define TOML_HEADER_ONLY 1
#include <toml++/toml.h>

namespace fvv::import {

namespace {

class Converter {
public:
  explicit Converter(const std::string &path_) : path(path_) {}

  Node convert(const toml::node &from, const std::string &name, unsigned depth) {
    Node node;
    node.name = name;
    node.line = from.source().begin.line;
    if (++count > max_nodes)
      fail_at(path, node.line, "expected at most " + std::to_string(max_nodes) + " values, found more");
    if (depth == max_depth)
      fail_at(path, node.line, "expected values at most " + std::to_string(max_depth) + " deep, found more");
    if (const toml::table *table = from.as_table()) {
      node.is_scalar = false;
      for (const auto &[key, value] : *table)
        node.children.push_back(convert(value, std::string(key.str()), depth + 1));
    } else if (const toml::array *array = from.as_array()) {
      node.is_scalar = false;
      for (const toml::node &value : *array) node.children.push_back(convert(value, "", depth + 1));
    } else if (const auto text = from.value_exact<std::string>()) {
      node.text = *text;
    } else if (const auto flag = from.value_exact<bool>()) {
      node.text = *flag ? "1" : "0";
    } else if (const auto integer = from.value_exact<int64_t>()) {
      node.text = std::to_string(*integer);
    } else if (const auto number = from.value_exact<double>()) {
      char digits[32];
      node.text.assign(digits, std::to_chars(digits, digits + sizeof digits, *number).ptr);
    } // dates are no part of a calibration
    return node;
  }

private:
  const std::string &path;
  size_t count = 0;
};

// toml++ limits how deep values are, and not how many tables a dotted key makes. Each table costs stack.
// Strings and comments are looked at as well. No calibration has that many names in a row.
void check_dotted_keys(const std::string &bytes, const std::string &path) {
  unsigned dots = 0;
  uint64_t line = 1;
  char before = 0, mark = 0; // the last character, and the last one that is no space
  for (const char c : bytes) {
    const bool space = c == ' ' || c == '\t';
    const bool in_name = std::isalnum(static_cast<unsigned char>(c)) || (c && std::strchr("_-\"'", c));
    const bool begins_name = in_name && mark != '.' && (before == ' ' || before == '\t');
    if (c == '.' && mark != '.')
      dots++;
    else if (begins_name || (!in_name && !space))
      dots = 0;
    if (dots == max_depth)
      fail_at(path, line, "expected keys at most " + std::to_string(max_depth) + " deep, found more");
    line += c == '\n';
    before = c;
    if (!space) mark = c;
  }
}

Node parse_toml(const std::string &path) {
  const std::string bytes = scene::read_file(path, max_yaml_size);
  check_dotted_keys(bytes, path);
  try {
    const toml::table table = toml::parse(bytes, path);
    return Converter(path).convert(table, "", 0);
  } catch (const toml::parse_error &error) {
    fail_at(path, error.source().begin.line, "expected TOML, found: " + std::string(error.description()));
  }
}

// Tables in the order of the file: toml++ has them by name.
std::vector<const Node *> cameras_of(const Node &root) {
  std::vector<const Node *> found;
  for (const Node &node : root.children)
    if (node.name != "metadata" && !node.is_scalar) found.push_back(&node);
  std::stable_sort(found.begin(), found.end(),
                   [](const Node *a, const Node *b) { return a->line < b->line; });
  return found;
}

} // namespace

Calibration read_toml(const std::string &file) {
  const Node root = parse_toml(file);
  Calibration calibration;
  for (const Node *node : cameras_of(root)) {
    const Fields fields(file, *node);
    scene::Camera camera;
    const Node *name = fields.find({"name"});
    camera.set_name(name && !name->text.empty() ? name->text : node->name);
    fvv_camera &model = camera.calibration;
    model.id = static_cast<uint16_t>(calibration.cameras.size()); // append() allows far fewer cameras
    set_size(fields, model);
    set_matrix(fields, fields.at({"matrix"}), model);
    const Node *fisheye = fields.find({"fisheye"});
    set_lens(fields, fields.at({"distortions", "distortion"}), fisheye && fields.integer(*fisheye, 0, 1) == 1,
             model);
    set_turn(fields, fields.at({"rotation"}), model);
    const auto t = fields.vector(fields.at({"translation"}), 3);
    std::copy(t.begin(), t.end(), model.translation);
    append(calibration, std::move(camera), file + ": " + node->name);
  }
  require_cameras(calibration, file);
  return calibration;
}

} // namespace fvv::import
