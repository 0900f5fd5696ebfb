// RealityCapture (RealityScan): sidecars *.xmp with the pose of a picture, or the table of "Internal/External
// camera parameters". Lengths in the picture are in 36ths of its longer side, as of a film of 35 mm, from the
// middle. A sidecar has world to camera in OpenCV's axes and the centre; the table has heading, pitch and
// roll of a camera that looks down with the picture's top to the north, in a world whose z is up.

#include "scene/src/import/tree.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

namespace fvv::import {

namespace {

constexpr double film = 36; // millimetres

struct Lens {
  double focal = 0, u = 0, v = 0, skew = 0, aspect = 1; // focal, u, v: in 36ths of the longer side
  double k[6] = {};                                     // k1 k2 k3 k4 t1 t2
};

void set_lens(const Lens &lens, const std::string &where, fvv_camera &camera) {
  const double unit = std::max(camera.width, camera.height) / film;
  if (lens.k[3] != 0) throw Error(where + ": expected 0 for k4, which fvv does not have: align with brown3");
  if (lens.aspect != 1) throw Error(where + ": expected an aspect ratio of 1");
  camera.fx = camera.fy = lens.focal * unit;
  camera.skew = lens.skew * unit;
  camera.cx = camera.width / 2.0 + lens.u * unit;
  camera.cy = camera.height / 2.0 + lens.v * unit;
  const double k[8] = {lens.k[0], lens.k[1], lens.k[4], lens.k[5], lens.k[2]};
  set_radtan(camera, k);
}

class Sidecar {
public:
  explicit Sidecar(const std::string &path_)
      : path(path_), root(parse_xml(scene::read_file(path, max_xml_size), path)) {
    const Node *node = &root;
    if (node->name == "x:xmpmeta") node = &node->child(path, "rdf:RDF");
    if (node->name != "rdf:RDF")
      fail_at(path, root.line, "expected XMP, found <" + root.name.substr(0, 40) + ">");
    description = &node->child(path, "rdf:Description");
  }

  void read(fvv_camera &camera) const {
    Lens lens;
    lens.focal = number("FocalLength35mm");
    lens.u = film * number("PrincipalPointU", 0);
    lens.v = film * number("PrincipalPointV", 0);
    lens.skew = number("Skew", 0);
    lens.aspect = number("AspectRatio", 1);
    const std::string *model = text("DistortionModel");
    if (model && *model != "perspective") {
      if (*model != "brown3" && *model != "brown3t2")
        fail_at(path, description->line,
                "expected perspective, brown3 or brown3t2 for xcr:DistortionModel, found " +
                    scene::quote(*model) + ": align with one of them");
      // Spelt like this.
      const auto k = numbers("DistortionCoeficients", 6);
      std::copy(k.begin(), k.end(), lens.k);
    }
    set_lens(lens, path, camera);
    const auto r = numbers("Rotation", 9), c = numbers("Position", 3);
    std::copy(r.begin(), r.end(), camera.rotation);
    set_centre(camera, c.data());
  }

private:
  // An attribute or an element of that name.
  const std::string *text(const char *key) const {
    const std::string name = std::string("xcr:") + key;
    if (const std::string *value = description->find_attribute(name.c_str())) return value;
    const Node *node = description->find(path, name.c_str());
    return node ? &node->text : nullptr;
  }
  std::vector<double> numbers(const char *key, size_t count) const {
    const std::string *value = text(key);
    if (!value)
      fail_at(path, description->line,
              std::string("expected xcr:") + key +
                  ", found none: export the poses with the "
                  "sidecars");
    const auto words = words_of(*value);
    if (words.size() != count)
      fail_at(path, description->line,
              "expected " + std::to_string(count) + " numbers for xcr:" + key + ", found " +
                  std::to_string(words.size()));
    std::vector<double> out;
    for (const std::string_view word : words) out.push_back(number_at(path, description->line, word, key));
    return out;
  }
  double number(const char *key) const { return numbers(key, 1)[0]; }
  double number(const char *key, double absent) const { return text(key) ? number(key) : absent; }

  const std::string &path;
  Node root;
  const Node *description;
};

std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  for (size_t begin = 0; begin <= line.size() && cells.size() < max_words;) {
    const size_t end = std::min(line.find(',', begin), line.size());
    std::string_view cell = line.substr(begin, end - begin);
    while (!cell.empty() && (cell.front() == ' ' || cell.front() == '#')) cell.remove_prefix(1);
    while (!cell.empty() && (cell.back() == ' ' || cell.back() == '\r')) cell.remove_suffix(1);
    cells.push_back(cell);
    begin = end + 1;
  }
  return cells;
}

// Rz(-heading) Rx(pitch) Ry(roll) takes the camera's OpenGL axes to the world's.
void set_pose(const double degrees[3], const double centre[3], fvv_camera &camera) {
  const double to = std::acos(-1.0) / 180;
  const double ch = std::cos(-degrees[0] * to), sh = std::sin(-degrees[0] * to);
  const double cp = std::cos(degrees[1] * to), sp = std::sin(degrees[1] * to);
  const double cr = std::cos(degrees[2] * to), sr = std::sin(degrees[2] * to);
  // Rows: the camera's right, up and backward vectors in the world.
  const double axes[9] = {ch * cr - sh * sp * sr, sh * cr + ch * sp * sr, -cp * sr, -sh * cp, ch * cp, sp,
                          ch * sr + sh * sp * cr, sh * sr - ch * sp * cr, cp * cr};
  set_pose_opengl(camera, axes, centre);
}

Calibration read_table(const std::string &path, uint32_t width, uint32_t height) {
  const std::string bytes = scene::read_file(path, max_text_size);
  Lines lines(bytes, path);
  std::string_view line;
  if (!lines.next(line)) throw Error(path + ": expected a table, found nothing");
  std::map<std::string, size_t, std::less<>> column;
  const auto head = cells_of(line);
  for (size_t i = 0; i < head.size(); i++) column.emplace(std::string(head[i]), i);
  for (const char *name : {"name", "x", "y", "alt", "heading", "pitch", "roll", "f", "px", "py", "k1", "k2",
                           "k3", "k4", "t1", "t2"})
    if (!column.count(name)) lines.fail(std::string("expected the column ") + name + ", found none");
  Calibration calibration;
  while (lines.next_content(line)) {
    const auto cells = cells_of(line);
    if (cells.size() < head.size())
      lines.fail("expected " + std::to_string(head.size()) + " cells, found " + std::to_string(cells.size()));
    const auto number = [&](const char *name) { return lines.real(cells[column.find(name)->second], name); };
    scene::Camera camera;
    camera.set_name(std::filesystem::path(std::string(cells[column.find("name")->second])).stem().string());
    fvv_camera &model = camera.calibration;
    model.id = static_cast<uint16_t>(calibration.cameras.size()); // append() allows far fewer cameras
    model.width = width;
    model.height = height;
    Lens lens;
    lens.focal = number("f");
    lens.u = number("px");
    lens.v = number("py");
    size_t i = 0;
    for (const char *name : {"k1", "k2", "k3", "k4", "t1", "t2"}) lens.k[i++] = number(name);
    set_lens(lens, lines.where(), model);
    const double degrees[3] = {number("heading"), number("pitch"), number("roll")};
    const double centre[3] = {number("x"), number("y"), number("alt")};
    set_pose(degrees, centre, model);
    append(calibration, std::move(camera), lines.where());
  }
  require_cameras(calibration, path);
  return calibration;
}

} // namespace

Calibration read_realitycapture(const std::vector<std::string> &files, uint32_t width, uint32_t height) {
  if (files.size() == 1 && std::filesystem::path(files[0]).extension() != ".xmp")
    return read_table(files[0], width, height);
  Calibration calibration;
  for (const std::string &path : files) {
    scene::Camera camera;
    camera.set_name(std::filesystem::path(path).stem().string());
    fvv_camera &model = camera.calibration;
    model.id = static_cast<uint16_t>(calibration.cameras.size()); // append() allows far fewer cameras
    model.width = width;
    model.height = height;
    Sidecar(path).read(model);
    append(calibration, std::move(camera), path);
  }
  return calibration;
}

} // namespace fvv::import
