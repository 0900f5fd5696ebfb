// The static environment of a clip, as Python sees it.
#pragma once

#include "source.h"
#include "values.h"

namespace fvv::python {

// One mesh of it.
struct EnvironmentPart {
  std::shared_ptr<Mesh> mesh; // uvs run over the part's rectangle of the picture
  std::optional<size_t> picture;
  double colour[3];
  bool unlit, double_sided, clamped;
  double texture_origin[2], texture_size[2];
};

struct Environment {
  std::vector<EnvironmentPart> parts;
  std::vector<std::string> pictures; // files
  std::vector<fvv_light> lights;
};

// Appends what belongs to a group on one environment track; false: it has none. Throws Failure.
bool add_environment(fvv_stream *stream, size_t group, uint16_t track, const Limits &limits,
                     const std::string &file, Environment &out);

// (parts, pictures, lights) as tuples, for fvv/environment.py.
py::tuple described(Environment &&environment);

} // namespace fvv::python
