// Files of OpenCV's calibration programs, written with cv::FileStorage, one camera in each. Its axes and
// coefficients are those of fvv; its pixel centres lie at integers.

#include "fvv_scene/file_io.h"
#include "scene/src/import/camera.h"
#include "scene/src/import/tree.h"

#include <cmath>
#include <filesystem>

namespace fvv::import {

namespace {

// The keys of one file; every error names its line.
class File {
public:
  explicit File(const std::string &path_) : path(path_) {
    const std::string bytes = scene::read_file(path, max_xml_size);
    const size_t first = bytes.find_first_not_of(" \t\r\n");
    if (first != bytes.npos && bytes[first] == '<') {
      root = parse_xml(bytes, path);
      if (root.name != "opencv_storage")
        fail_at(path, root.line, "expected <opencv_storage>, found <" + root.name.substr(0, 40) + ">");
      return;
    }
    if (bytes.size() > max_yaml_size)
      throw Error(path + ": expected at most " + std::to_string(max_yaml_size) + " bytes of YAML, found " +
                  std::to_string(bytes.size()));
    root = parse_yaml(bytes, path);
  }

  // The one of several keys with the same meaning that is there.
  const Node *find(std::initializer_list<const char *> keys) const {
    const Node *found = nullptr;
    for (const char *key : keys)
      if (const Node *node = root.find(path, key)) {
        if (found) fail_at(path, node->line, "expected " + found->name + " or " + key + ", found both");
        found = node;
      }
    return found;
  }
  const Node &at(std::initializer_list<const char *> keys) const {
    if (const Node *node = find(keys)) return *node;
    std::string names;
    for (const char *key : keys) names += (names.empty() ? "" : " or ") + std::string(key);
    throw Error(path + ": expected the key " + names + ", found none");
  }

  int64_t integer(const Node &node, int64_t least, int64_t most) const {
    const auto words = words_of(node.text);
    return integer_at(path, node.line, words.size() == 1 ? words[0] : std::string_view(node.text),
                      node.name.c_str(), least, most);
  }

  struct Matrix {
    int64_t rows, columns;
    std::vector<double> values;
  };
  Matrix matrix(const Node &node) const {
    const std::string *type = node.find_attribute("type_id");
    Matrix matrix = {1, 1, {}};
    if (type && *type == "opencv-matrix") {
      matrix.rows = integer(node.child(path, "rows"), 1, max_side);
      matrix.columns = integer(node.child(path, "cols"), 1, max_side);
    } else if (type && *type == "opencv-nd-matrix") { // what Python's one-dimensional arrays become
      const Node &node_of_sizes = node.child(path, "sizes");
      const auto sizes = items(node_of_sizes);
      if (sizes.empty() || sizes.size() > 2)
        fail_at(path, node_of_sizes.line,
                "expected one or two sizes of " + node.name + ", found " + std::to_string(sizes.size()));
      const auto side = [&](const Item &item) {
        return integer_at(path, item.line, item.text, "sizes", 1, max_side);
      };
      matrix.rows = side(sizes[0]);
      if (sizes.size() == 2) matrix.columns = side(sizes[1]);
    } else {
      fail_at(path, node.line,
              "expected an opencv-matrix for " + node.name + ", found " +
                  (type ? scene::quote(*type) : "another value"));
    }
    const Node &kind = node.child(path, "dt"), &data = node.child(path, "data");
    const auto word = words_of(kind.text);
    if (word.size() != 1 || (word[0] != "d" && word[0] != "f"))
      fail_at(path, kind.line, "expected d or f for dt, found " + scene::quote(kind.text));
    for (const Item &item : items(data))
      matrix.values.push_back(number_at(path, item.line, item.text, node.name.c_str()));
    if (static_cast<int64_t>(matrix.values.size()) != matrix.rows * matrix.columns)
      fail_at(path, data.line,
              "expected " + std::to_string(matrix.rows * matrix.columns) + " numbers in " + node.name +
                  ", found " + std::to_string(matrix.values.size()));
    return matrix;
  }
  Matrix square(const Node &node) const {
    Matrix m = matrix(node);
    if (m.rows != 3 || m.columns != 3)
      fail_at(path, node.line, "expected 3 x 3 numbers for " + node.name + ", found " + size(m));
    return m;
  }
  // A row or a column.
  std::vector<double> vector(const Node &node) const {
    const Matrix m = matrix(node);
    if (m.rows != 1 && m.columns != 1)
      fail_at(path, node.line, "expected a row or a column for " + node.name + ", found " + size(m));
    return m.values;
  }
  std::vector<double> vector3(const Node &node) const {
    std::vector<double> v = vector(node);
    if (v.size() != 3)
      fail_at(path, node.line, "expected 3 numbers for " + node.name + ", found " + std::to_string(v.size()));
    return v;
  }

private:
  static constexpr int64_t max_side = 16; // far more than a calibration needs

  // The numbers of a list: words of an element, scalars of a sequence.
  struct Item {
    std::string_view text;
    uint64_t line;
  };
  static std::vector<Item> items(const Node &node) {
    std::vector<Item> out;
    for (const std::string_view word : words_of(node.text)) out.push_back({word, node.line});
    for (const Node &item : node.children)
      out.push_back({item.is_scalar ? std::string_view(item.text) : std::string_view(), item.line});
    return out;
  }

  static std::string size(const Matrix &m) {
    return std::to_string(m.rows) + " x " + std::to_string(m.columns);
  }

  const std::string &path;
  Node root;
};

void read_intrinsics(const File &file, const std::string &path, fvv_camera &camera) {
  camera.width = static_cast<uint32_t>(file.integer(file.at({"image_width"}), 1, INT32_MAX));
  camera.height = static_cast<uint32_t>(file.integer(file.at({"image_height"}), 1, INT32_MAX));
  const Node &node = file.at({"camera_matrix", "K", "M"});
  const auto k = file.square(node).values;
  // cv::projectPoints ignores K[0][1], so that a value there would be ambiguous.
  if (k[1] != 0 || k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1)
    fail_at(path, node.line, "expected fx 0 cx, 0 fy cy, 0 0 1 for " + node.name + ", found others");
  camera.fx = k[0];
  camera.fy = k[4];
  camera.cx = k[2] + 0.5;
  camera.cy = k[5] + 0.5;
}

void read_lens(const File &file, const std::string &path, fvv_camera &camera) {
  const Node &node = file.at({"distortion_coefficients", "D"});
  std::vector<double> d = file.vector(node);
  const size_t count = d.size();
  const Node *fisheye = file.find({"fisheye_model"});
  const bool is_fisheye = fisheye && file.integer(*fisheye, 0, 1) == 1;
  if (is_fisheye ? count != 4 : count != 4 && count != 5 && count != 8 && count != 12 && count != 14)
    fail_at(path, node.line,
            std::string("expected ") + (is_fisheye ? "4" : "4, 5, 8, 12 or 14") + " coefficients in " +
                node.name + ", found " + std::to_string(count));
  for (size_t i = 8; i < count; i++)
    if (d[i] != 0)
      fail_at(path, node.line,
              std::string("expected 0 for the coefficients of ") +
                  (i < 12 ? "thin prism" : "a tilted sensor") + ", which fvv does not have, in " + node.name);
  d.resize(8);
  if (is_fisheye)
    set_fisheye(camera, d.data());
  else
    set_radtan(camera, d.data());
}

// Rodrigues' formula, as cv::Rodrigues.
void set_rotation(fvv_camera &camera, const std::vector<double> &v) {
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

} // namespace

Calibration read_opencv(const std::vector<std::string> &files) {
  Calibration calibration;
  for (const std::string &path : files) {
    const File file(path);
    scene::Camera camera;
    camera.set_name(std::filesystem::path(path).stem().string());
    fvv_camera &model = camera.calibration;
    model.id = static_cast<uint16_t>(calibration.cameras.size()); // append() allows far fewer cameras
    read_intrinsics(file, path, model);
    read_lens(file, path, model);
    const Node &turn = file.at({"rvec", "R"});
    if (turn.name == "R") {
      const auto r = file.square(turn).values;
      std::copy(r.begin(), r.end(), model.rotation);
    } else {
      set_rotation(model, file.vector3(turn));
    }
    const auto t = file.vector3(file.at({"tvec", "T"}));
    std::copy(t.begin(), t.end(), model.translation);
    append(calibration, std::move(camera), path);
  }
  return calibration;
}

} // namespace fvv::import
