// Rows and matrices of a calibration's tree.

#include "scene/src/import/fields.h"
#include "fvv_scene/file_io.h"

#include <algorithm>
#include <cmath>

namespace fvv::import {

namespace {

constexpr int64_t max_side = 16; // far more than a calibration needs

// The numbers of a list: words of an element, scalars of a sequence.
struct Item {
  std::string_view text;
  uint64_t line;
};
std::vector<Item> items(const Node &node) {
  std::vector<Item> out;
  for (const std::string_view word : words_of(node.text)) out.push_back({word, node.line});
  for (const Node &item : node.children)
    out.push_back({item.is_scalar ? std::string_view(item.text) : std::string_view(), item.line});
  return out;
}

bool is_list(const Node &node) {
  return !node.is_scalar && !node.children.empty() &&
         std::all_of(node.children.begin(), node.children.end(),
                     [](const Node &child) { return child.name.empty(); });
}

std::string size_of(const Fields::Matrix &m) {
  return std::to_string(m.rows) + " x " + std::to_string(m.columns);
}

} // namespace

const Node *Fields::find(std::initializer_list<const char *> keys) const {
  const Node *found = nullptr;
  for (const char *key : keys)
    if (const Node *one = node.find(path, key)) {
      if (found) fail(*one, "expected " + found->name + " or " + key + ", found both");
      found = one;
    }
  return found;
}

const Node &Fields::at(std::initializer_list<const char *> keys) const {
  if (const Node *found = find(keys)) return *found;
  std::string names;
  for (const char *key : keys) names += (names.empty() ? "" : " or ") + std::string(key);
  const std::string where = node.name.empty() ? path : path + ":" + std::to_string(node.line);
  throw Error(where + ": expected the key " + names + (node.name.empty() ? "" : " in " + node.name) +
              ", found none");
}

int64_t Fields::integer(const Node &of, int64_t least, int64_t most) const {
  const auto words = words_of(of.text);
  return integer_at(path, of.line, words.size() == 1 ? words[0] : std::string_view(of.text), of.name.c_str(),
                    least, most);
}

double Fields::number(const Node &of) const {
  const auto words = words_of(of.text);
  return number_at(path, of.line, words.size() == 1 ? words[0] : std::string_view(of.text), of.name.c_str());
}

// rows, cols, dt and data of cv::FileStorage. ROS writes the same without a type and without dt.
Fields::Matrix Fields::stored(const Node &of, const std::string &type) const {
  Matrix m = {1, 1, {}, false};
  if (type == "opencv-nd-matrix") { // what Python's one-dimensional arrays become
    const Node &node_of_sizes = of.child(path, "sizes");
    const auto sizes = items(node_of_sizes);
    if (sizes.empty() || sizes.size() > 2)
      fail(node_of_sizes,
           "expected one or two sizes of " + of.name + ", found " + std::to_string(sizes.size()));
    const auto side = [&](const Item &item) {
      return integer_at(path, item.line, item.text, "sizes", 1, max_side);
    };
    m.rows = side(sizes[0]);
    if (sizes.size() == 2) m.columns = side(sizes[1]);
  } else {
    m.rows = integer(of.child(path, "rows"), 1, max_side);
    m.columns = integer(of.child(path, "cols"), 1, max_side);
  }
  if (!type.empty()) {
    const Node &kind = of.child(path, "dt");
    const auto word = words_of(kind.text);
    if (word.size() != 1 || (word[0] != "d" && word[0] != "f" && word[0] != "i"))
      fail(kind, "expected d, f or i for dt, found " + scene::quote(kind.text));
  }
  const Node &data = of.child(path, "data");
  for (const Item &item : items(data))
    m.values.push_back(number_at(path, item.line, item.text, of.name.c_str()));
  if (static_cast<int64_t>(m.values.size()) != m.rows * m.columns)
    fail(data, "expected " + std::to_string(m.rows * m.columns) + " numbers in " + of.name + ", found " +
                   std::to_string(m.values.size()));
  return m;
}

// [a, b, c], or [[a, b], [c, d]].
Fields::Matrix Fields::listed(const Node &of) const {
  const bool nested = !of.children[0].is_scalar;
  Matrix m = {static_cast<int64_t>(of.children.size()), 1, {}, !nested};
  if (of.children.size() > size_t(max_side * max_side)) fail(of, "expected fewer numbers for " + of.name);
  for (const Node &row : of.children) {
    if (!nested) {
      m.values.push_back(
          number_at(path, row.line, row.is_scalar ? std::string_view(row.text) : "", of.name.c_str()));
      continue;
    }
    const auto numbers = items(row);
    if (m.values.empty()) m.columns = static_cast<int64_t>(numbers.size());
    if (numbers.empty() || static_cast<int64_t>(numbers.size()) != m.columns)
      fail(row, "expected rows of one length in " + of.name + ", found one of " +
                    std::to_string(numbers.size()) + " after " + std::to_string(m.columns));
    for (const Item &item : numbers)
      m.values.push_back(number_at(path, item.line, item.text, of.name.c_str()));
  }
  return m;
}

Fields::Matrix Fields::matrix(const Node &of) const {
  if (is_list(of)) return listed(of);
  // A list or a cv::Size in XML.
  if (const auto words = words_of(of.text); of.children.empty() && words.size() > 1) {
    Matrix m = {static_cast<int64_t>(words.size()), 1, {}, true};
    if (words.size() > size_t(max_side * max_side)) fail(of, "expected fewer numbers for " + of.name);
    for (const std::string_view word : words)
      m.values.push_back(number_at(path, of.line, word, of.name.c_str()));
    return m;
  }
  const std::string *type = of.find_attribute("type_id");
  if (!type) // JSON has no tags
    if (const Node *key = of.find(path, "type_id")) type = &key->text;
  if (type && (*type == "opencv-matrix" || *type == "opencv-nd-matrix")) return stored(of, *type);
  if (!type && of.find(path, "rows") && of.find(path, "data")) return stored(of, "");
  fail(of, "expected an opencv-matrix or a list for " + of.name + ", found " +
               (type ? scene::quote(*type) : "another value"));
}

std::vector<double> Fields::square(const Node &of) const {
  Matrix m = matrix(of);
  if ((m.rows != 3 || m.columns != 3) && !(m.is_flat && m.values.size() == 9))
    fail(of, "expected 3 x 3 numbers for " + of.name + ", found " + size_of(m));
  return std::move(m.values);
}

std::vector<double> Fields::vector(const Node &of) const {
  Matrix m = matrix(of);
  if (m.rows != 1 && m.columns != 1)
    fail(of, "expected a row or a column for " + of.name + ", found " + size_of(m));
  return std::move(m.values);
}

std::vector<double> Fields::vector(const Node &of, size_t count) const {
  std::vector<double> v = vector(of);
  if (v.size() != count)
    fail(of, "expected " + std::to_string(count) + " numbers for " + of.name + ", found " +
                 std::to_string(v.size()));
  return v;
}

Node parse_storage(const std::string &path) {
  std::string bytes = scene::read_file(path, max_xml_size);
  const size_t first = bytes.find_first_not_of(" \t\r\n");
  if (first != bytes.npos && bytes[first] == '<') {
    Node root = parse_xml(bytes, path);
    if (root.name != "opencv_storage")
      fail_at(path, root.line, "expected <opencv_storage>, found <" + root.name.substr(0, 40) + ">");
    root.name.clear();
    return root;
  }
  if (bytes.size() > max_yaml_size)
    throw Error(path + ": expected at most " + std::to_string(max_yaml_size) + " bytes of YAML, found " +
                std::to_string(bytes.size()));
  // JSON is YAML but for tabs, which its texts cannot contain.
  if (first != bytes.npos && bytes[first] == '{') std::replace(bytes.begin(), bytes.end(), '\t', ' ');
  return parse_yaml(bytes, path);
}

uint32_t pixels_of(const Fields &fields, const Node &node, double value) {
  if (!(value >= 1 && value <= INT32_MAX) || value != std::floor(value))
    fields.fail(node, "expected a whole number of pixels for " + node.name);
  return static_cast<uint32_t>(value);
}

void set_size(const Fields &fields, fvv_camera &camera) {
  if (const Node *both = fields.find({"image_size", "img_size", "imageSize", "resolution", "size"})) {
    const auto sides = fields.vector(*both, 2);
    camera.width = pixels_of(fields, *both, sides[0]);
    camera.height = pixels_of(fields, *both, sides[1]);
    return;
  }
  camera.width = static_cast<uint32_t>(fields.integer(fields.at({"image_width", "width"}), 1, INT32_MAX));
  camera.height = static_cast<uint32_t>(fields.integer(fields.at({"image_height", "height"}), 1, INT32_MAX));
}

void set_matrix(const Fields &fields, const Node &node, fvv_camera &camera) {
  const auto k = fields.square(node);
  if (k[1] != 0 || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1)
    fields.fail(node, "expected fx 0 cx, 0 fy cy, 0 0 1 for " + node.name + ", found others");
  camera.fx = k[0];
  camera.fy = k[4];
  camera.cx = k[2] + 0.5;
  camera.cy = k[5] + 0.5;
}

void set_lens(const Fields &fields, const Node &node, bool is_fisheye, fvv_camera &camera) {
  std::vector<double> d = fields.vector(node);
  const size_t count = d.size();
  if (is_fisheye ? count != 4 : count != 4 && count != 5 && count != 8 && count != 12 && count != 14)
    fields.fail(node, std::string("expected ") + (is_fisheye ? "4" : "4, 5, 8, 12 or 14") +
                          " coefficients in " + node.name + ", found " + std::to_string(count));
  for (size_t i = 8; i < count; i++)
    if (d[i] != 0)
      fields.fail(node, std::string("expected 0 for the coefficients of ") +
                            (i < 12 ? "thin prism" : "a tilted sensor") + ", which fvv does not have, in " +
                            node.name);
  d.resize(8);
  if (is_fisheye)
    set_fisheye(camera, d.data());
  else
    set_radtan(camera, d.data());
}

void set_rotation_vector(const std::vector<double> &v, fvv_camera &camera) {
  const double angle = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  // sin(a)/a and (1 - cos(a))/a^2; below 1e-8 their series' first terms are exact to a double.
  const double s = angle > 1e-8 ? std::sin(angle) / angle : 1;
  const double half = angle > 1e-8 ? std::sin(angle / 2) / angle : 0.5, c = 2 * half * half;
  const double cross[9] = {0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0};
  for (size_t row = 0; row < 3; row++)
    for (size_t column = 0; column < 3; column++) {
      const double outer = v[row] * v[column] - (row == column ? angle * angle : 0);
      camera.rotation[3 * row + column] = (row == column) + s * cross[3 * row + column] + c * outer;
    }
}

void set_turn(const Fields &fields, const Node &node, fvv_camera &camera) {
  const Fields::Matrix m = fields.matrix(node);
  if (m.values.size() == 3) {
    set_rotation_vector(m.values, camera);
  } else {
    const auto r = fields.square(node);
    std::copy(r.begin(), r.end(), camera.rotation);
  }
}

} // namespace fvv::import
