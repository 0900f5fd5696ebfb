// Plain text of K, R and t, as many data sets have it: rows of numbers in OpenCV's axes, world to camera. Two
// shapes: blocks of K, perhaps coefficients of the lens, and [R|t], as in the KRT file of Multiface; and the
// words "extrinsic" and "intrinsic" with a matrix after each, as in the files of MVSNet. Pixel centres are
// taken to lie at integers, as OpenCV has them.

#include "fvv_scene/file_io.h"
#include "scene/src/import/camera.h"

#include <filesystem>
#include <optional>

namespace fvv::import {

namespace {

// The lines of a file that are not empty, one ahead.
class Rows {
public:
  Rows(std::string_view bytes, const std::string &path) : lines(bytes, path) { advance(); }

  bool at_end() const { return !current; }
  std::vector<std::string_view> words() const { return words_of(*current); }
  std::string_view line() const { return *current; }
  std::string where() const { return lines.where(); }
  [[noreturn]] void fail(const std::string &what) const { lines.fail(what); }
  void advance() {
    std::string_view next;
    current = lines.next_content(next) ? std::optional(next) : std::nullopt;
  }
  // One row of count numbers.
  void take(const char *what, size_t count, double *values) {
    const std::string expected =
        "expected a row of " + std::to_string(count) + " numbers of " + what + ", found ";
    if (at_end()) fail(expected + "the end of the file");
    const auto found = words();
    if (found.size() != count) fail(expected + scene::quote(*current));
    for (size_t i = 0; i < count; i++) values[i] = lines.real(found[i], what);
    advance();
  }

private:
  Lines lines;
  std::optional<std::string_view> current;
};

struct Found {
  scene::Camera camera;
  std::string name, where;
};

void set_matrix(const Rows &rows, const double k[9], fvv_camera &camera) {
  if (k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1)
    rows.fail("expected K before this line with k21 = k31 = k32 = 0 and k33 = 1, found others");
  camera.fx = k[0];
  camera.skew = k[1];
  camera.cx = k[2] + 0.5;
  camera.fy = k[4];
  camera.cy = k[5] + 0.5;
}

// Three rows of R and t each, or three rows of R and then t in one row or in three.
void take_pose(Rows &rows, fvv_camera &camera) {
  if (!rows.at_end() && rows.words().size() == 4) {
    for (int i = 0; i < 3; i++) {
      double row[4];
      rows.take("[R|t]", 4, row);
      std::copy(row, row + 3, camera.rotation + 3 * i);
      camera.translation[i] = row[3];
    }
    return;
  }
  for (int i = 0; i < 3; i++) rows.take("R", 3, camera.rotation + 3 * i);
  if (!rows.at_end() && rows.words().size() == 3) return rows.take("t", 3, camera.translation);
  for (int i = 0; i < 3; i++) rows.take("t", 1, camera.translation + i);
}

// A block: perhaps a name, K, perhaps 5 or 8 coefficients, the pose.
Found take_block(Rows &rows) {
  Found found;
  found.where = rows.where();
  if (rows.words().size() == 1) {
    found.name = std::string(rows.words()[0]);
    rows.advance();
  }
  fvv_camera &camera = found.camera.calibration;
  double k[9], coefficients[8] = {};
  for (int i = 0; i < 3; i++) rows.take("K", 3, k + 3 * i);
  if (!rows.at_end())
    if (const size_t count = rows.words().size(); count == 5 || count == 8)
      rows.take("the lens", count, coefficients);
  set_radtan(camera, coefficients);
  take_pose(rows, camera);
  set_matrix(rows, k, camera);
  return found;
}

// "extrinsic" and 4 rows of 4, "intrinsic" and 3 rows of 3, then perhaps a row with a range of depths.
Found take_matrices(Rows &rows) {
  Found found;
  found.where = rows.where();
  fvv_camera &camera = found.camera.calibration;
  rows.advance();
  take_pose(rows, camera);
  double last[4], k[9];
  rows.take("the extrinsic matrix", 4, last);
  if (last[0] != 0 || last[1] != 0 || last[2] != 0 || last[3] != 1)
    rows.fail("expected 0 0 0 1 as the last row of the extrinsic matrix before this line, found others");
  if (rows.at_end() || rows.line().substr(0, 9) != "intrinsic")
    rows.fail("expected the word intrinsic, found " +
              (rows.at_end() ? "the end of the file" : scene::quote(rows.line())));
  rows.advance();
  for (int i = 0; i < 3; i++) rows.take("K", 3, k + 3 * i);
  set_matrix(rows, k, camera);
  if (!rows.at_end()) rows.advance();
  if (!rows.at_end()) rows.fail("expected the end of the file, found " + scene::quote(rows.line()));
  return found;
}

std::vector<Found> read_file(const std::string &file) {
  const std::string bytes = scene::read_file(file, max_text_size);
  Rows rows(bytes, file);
  std::vector<Found> found;
  if (!rows.at_end() && rows.line().substr(0, 9) == "extrinsic") {
    found.push_back(take_matrices(rows));
  } else {
    fvv_limits limits;
    fvv_limits_default(&limits);
    while (!rows.at_end() && found.size() <= limits.max_cameras) found.push_back(take_block(rows));
  }
  if (found.empty()) throw Error(file + ": expected K, R and t of a camera, found nothing");
  if (found.size() == 1 && found[0].name.empty()) found[0].name = std::filesystem::path(file).stem().string();
  return found;
}

} // namespace

Calibration read_krt(const std::vector<std::string> &files, uint32_t width, uint32_t height) {
  Calibration calibration;
  for (const std::string &file : files)
    for (Found &found : read_file(file)) {
      const size_t position = calibration.cameras.size(); // append() allows far fewer cameras than ids
      fvv_camera &camera = found.camera.calibration;
      camera.id = static_cast<uint16_t>(position);
      camera.width = width;
      camera.height = height;
      found.camera.set_name(found.name.empty() ? std::to_string(position) : found.name);
      append(calibration, std::move(found.camera), found.where);
    }
  require_cameras(calibration, files.empty() ? "krt" : files[0]);
  return calibration;
}

} // namespace fvv::import
