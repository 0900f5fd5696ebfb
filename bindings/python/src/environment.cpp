#include "environment.h"

#include <algorithm>
#include <pybind11/stl.h>

namespace fvv::python {

bool add_environment(fvv_stream *stream, size_t group, uint16_t track, const Limits &limits,
                     const std::string &file, Environment &out) {
  const fvv_environment *environment = nullptr;
  fvv_diagnostic diagnostic = {};
  const fvv_status status = fvv_stream_environment(stream, group, track, &environment, &diagnostic);
  require(status, diagnostic, file);
  if (status == FVV_END) return false;
  const size_t first_picture = out.pictures.size();
  for (size_t i = 0; i < environment->part_count; i++) {
    const fvv_environment_part &source = environment->parts[i];
    EnvironmentPart part = {};
    part.mesh = std::make_shared<Mesh>();
    require(fvv_environment_mesh(environment, i, &limits.core, nullptr, &part.mesh->mesh, &diagnostic),
            diagnostic, file);
    std::copy(environment->lattice_origin, environment->lattice_origin + 3, part.mesh->origin);
    part.mesh->step = environment->lattice_step;
    part.mesh->track = track;
    if (source.picture != FVV_NO_PICTURE) part.picture = first_picture + source.picture;
    for (int k = 0; k < 3; k++) part.colour[k] = source.colour[k] / 65535.0;
    part.unlit = source.flags & FVV_PART_UNLIT;
    part.double_sided = source.flags & FVV_PART_DOUBLE_SIDED;
    part.clamped = source.flags & FVV_PART_CLAMPED;
    std::copy(source.texture_origin, source.texture_origin + 2, part.texture_origin);
    std::copy(source.texture_size, source.texture_size + 2, part.texture_size);
    out.parts.push_back(std::move(part));
  }
  for (size_t i = 0; i < environment->picture_count; i++)
    out.pictures.emplace_back(reinterpret_cast<const char *>(environment->pictures[i].data),
                              environment->pictures[i].size);
  out.lights.insert(out.lights.end(), environment->lights, environment->lights + environment->light_count);
  return true;
}

py::tuple described(Environment &&environment) {
  const auto numbers = [](const double *values, size_t count) {
    return py::tuple(py::cast(std::vector<double>(values, values + count)));
  };
  py::list parts, pictures, lights;
  for (const EnvironmentPart &part : environment.parts)
    parts.append(py::make_tuple(part.mesh, part.picture, numbers(part.colour, 3), part.unlit,
                                part.double_sided, part.clamped, numbers(part.texture_origin, 2),
                                numbers(part.texture_size, 2)));
  for (const std::string &picture : environment.pictures) pictures.append(py::bytes(picture));
  for (const fvv_light &light : environment.lights)
    lights.append(py::make_tuple(light.type, (light.flags & FVV_LIGHT_CASTS_SHADOWS) != 0,
                                 numbers(light.position, 3), numbers(light.direction, 3),
                                 numbers(light.colour, 3), light.intensity, light.range, light.inner_cone,
                                 light.outer_cone));
  return py::make_tuple(parts, pictures, lights);
}

} // namespace fvv::python
