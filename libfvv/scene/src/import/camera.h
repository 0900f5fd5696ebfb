// Common to all readers: poses in fvv's axes, names from file names, the last checks.
#pragma once

#include "fvv_scene/file_io.h"
#include "fvv_scene/import.h"

#include <string>
#include <string_view>
#include <vector>

namespace fvv::import {

// axes: the camera's right, up and backward vectors as rows in world coordinates (OpenGL); centre: its
// position. R = diag(1, -1, -1) axes, t = -R centre.
void set_pose_opengl(fvv_camera &camera, const double axes[9], const double centre[3]);

// The translation of a camera with this centre, whose rotation is set: t = -R centre.
void set_centre(fvv_camera &camera, const double centre[3]);

// The lens from all eight coefficients; without any that is not 0 there is none.
void set_radtan(fvv_camera &camera, const double coefficients[8]);
void set_fisheye(fvv_camera &camera, const double coefficients[4]);

// "images/left/0001.png", "images/right/0001.png" -> "left", "right": without extension, and without the
// folders and last parts that all of them share. Distinct whenever the paths without extension are.
std::vector<std::string> names_of_pictures(const std::vector<std::string> &paths);

// Fills r_max, checks the camera and that its id is new, and appends it. where: "path:LINE" or the like.
void append(Calibration &calibration, scene::Camera camera, const std::string &where);

// Error unless there is a camera.
void require_cameras(const Calibration &calibration, const std::string &path);

constexpr uint64_t max_text_size = uint64_t(64) << 20;

// Error "path:LINE: what".
[[noreturn]] void fail_at(const std::string &path, uint64_t line, const std::string &what);

// The whole of word is a finite decimal number, or fail_at "expected a finite number for NAME, found ...".
double number_at(const std::string &path, uint64_t line, std::string_view word, const char *name);
int64_t integer_at(const std::string &path, uint64_t line, std::string_view word, const char *name,
                   int64_t least, int64_t most);

// The words of a text, delimited by blanks and line ends. Stops after max_words, which is more than any line
// of any format may have, so that a line as long as a file costs no vector of that length.
constexpr size_t max_words = 1000;
std::vector<std::string_view> words_of(std::string_view text);

// Borrows bytes and path.
class Lines {
public:
  // A byte order mark is none of it.
  Lines(std::string_view bytes, const std::string &path)
      : rest(bytes.substr(bytes.substr(0, 3) == "\xef\xbb\xbf" ? 3 : 0)), name(path) {}

  bool next(std::string_view &line);         // the next line
  bool next_content(std::string_view &line); // skips empty lines and those that begin with '#'
  uint64_t number() const { return count; }  // of the last line, from 1
  const std::string &path() const { return name; }
  std::string where() const { return name + ":" + std::to_string(count); }
  [[noreturn]] void fail(const std::string &what) const { fail_at(name, count, what); }
  double real(std::string_view word, const char *what) const { return number_at(name, count, word, what); }
  int64_t integer(std::string_view word, const char *what, int64_t least, int64_t most) const {
    return integer_at(name, count, word, what, least, most);
  }

private:
  std::string_view rest;
  const std::string &name;
  uint64_t count = 0;
};

} // namespace fvv::import
