// capture/capture_background.cpp: the background of a capture: its description, and its environment in the
// world of the meshes.
#include "capture/capture_fields.h"
#include "capture/environment.h"

namespace fvv::capture {

Background read_background(const JsonValue &value) {
  value.allow_keys({"file", "transform", "lattice"});
  Background out;
  const JsonValue file = value.at("file");
  out.file = file.text();
  if (!is_gltf(out.file)) file.fail("expected a .glb or .gltf file, found " + file.found());
  if (const auto lattice = value.find("lattice")) out.lattice = read_lattice(*lattice);
  if (const auto transform = value.find("transform")) {
    for (size_t row = 0; row < 3; row++)
      for (size_t column = 0; column < 4; column++)
        out.transform.m[4 * row + column] = finite(transform->items(3, row).items(4, column));
    if (!(std::fabs(out.transform.determinant()) > 0))
      transform->fail("expected a transform that keeps volume, found one with the determinant 0");
  }
  return out;
}

Environment load_environment(const Capture &capture, const fvv_limits *limits) {
  const Background &background = capture.background.value();
  const std::string path = capture.resolve(background.file);
  Environment environment = parse_environment(read_file(path, max_mesh_file), path, limits);
  gltf::Transform by = background.transform;
  for (double &element : by.m) element *= capture.metres_per_unit;
  environment.transform(by);
  return environment;
}

} // namespace fvv::capture
