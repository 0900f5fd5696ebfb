// Numbers, rows and matrices of a calibration's tree, as cv::FileStorage, ROS and plain lists write them, and
// cameras of them in OpenCV's conventions: pixel centres at integers.
#pragma once

#include "scene/src/import/tree.h"

#include <initializer_list>

namespace fvv::import {

// The keys of one map; every error names file and line. Borrows the path; the node too.
class Fields {
public:
  Fields(const std::string &path_, const Node &node_) : path(path_), node(node_) {}

  struct Matrix {
    int64_t rows, columns;
    std::vector<double> values; // row by row
    bool is_flat;               // one list, which may stand for a matrix of as many numbers
  };

  // The one of several keys with the same meaning that is there.
  const Node *find(std::initializer_list<const char *> keys) const;
  const Node &at(std::initializer_list<const char *> keys) const;

  // Of a node of this map.
  int64_t integer(const Node &of, int64_t least, int64_t most) const;
  double number(const Node &of) const;
  Matrix matrix(const Node &of) const;
  std::vector<double> square(const Node &of) const;               // 9 numbers
  std::vector<double> vector(const Node &of) const;               // a row or a column
  std::vector<double> vector(const Node &of, size_t count) const; // of that many
  [[noreturn]] void fail(const Node &of, const std::string &what) const { fail_at(path, of.line, what); }

private:
  Matrix stored(const Node &of, const std::string &type) const;
  Matrix listed(const Node &of) const;

  const std::string &path;
  const Node &node;
};

// XML of cv::FileStorage, YAML or JSON by its first character.
Node parse_storage(const std::string &path);

// A value of a node that counts pixels: 1 or more, whole.
uint32_t pixels_of(const Fields &fields, const Node &node, double value);
// Width and height: two numbers of one key or of two.
void set_size(const Fields &fields, fvv_camera &camera);
// K, whose skew must be 0: cv::projectPoints ignores it.
void set_matrix(const Fields &fields, const Node &node, fvv_camera &camera);
// 4, 5, 8, 12 or 14 coefficients of OpenCV, or 4 of cv::fisheye.
void set_lens(const Fields &fields, const Node &node, bool is_fisheye, fvv_camera &camera);
// Rodrigues' formula, as cv::Rodrigues. v: 3 numbers.
void set_rotation_vector(const std::vector<double> &v, fvv_camera &camera);
// The turn of a camera: a matrix, or a vector of 3.
void set_turn(const Fields &fields, const Node &node, fvv_camera &camera);

} // namespace fvv::import
