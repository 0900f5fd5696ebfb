#include "background.h"

#include <algorithm>
#include <pybind11/stl.h>

namespace fvv::python {

bool add_background(fvv_stream *stream, size_t group, uint16_t track, const Limits &limits,
                    const std::string &file, Background &out) {
  const fvv_background *background = nullptr;
  fvv_diagnostic diagnostic = {};
  const fvv_status status = fvv_stream_background(stream, group, track, &background, &diagnostic);
  require(status, diagnostic, file);
  if (status == FVV_END) return false;
  const size_t first_picture = out.pictures.size();
  for (size_t i = 0; i < background->part_count; i++) {
    const fvv_background_part &source = background->parts[i];
    BackgroundPart part = {};
    part.mesh = std::make_shared<Mesh>();
    require(fvv_background_mesh(background, i, &limits.core, nullptr, &part.mesh->mesh, &diagnostic),
            diagnostic, file);
    std::copy(background->lattice_origin, background->lattice_origin + 3, part.mesh->origin);
    part.mesh->step = background->lattice_step;
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
  for (size_t i = 0; i < background->picture_count; i++)
    out.pictures.emplace_back(reinterpret_cast<const char *>(background->pictures[i].data),
                              background->pictures[i].size);
  out.lights.insert(out.lights.end(), background->lights, background->lights + background->light_count);
  return true;
}

py::tuple described(Background &&background) {
  const auto numbers = [](const double *values, size_t count) {
    return py::tuple(py::cast(std::vector<double>(values, values + count)));
  };
  py::list parts, pictures, lights;
  for (const BackgroundPart &part : background.parts)
    parts.append(py::make_tuple(part.mesh, part.picture, numbers(part.colour, 3), part.unlit,
                                part.double_sided, part.clamped, numbers(part.texture_origin, 2),
                                numbers(part.texture_size, 2)));
  for (const std::string &picture : background.pictures) pictures.append(py::bytes(picture));
  for (const fvv_light &light : background.lights)
    lights.append(py::make_tuple(light.type, (light.flags & FVV_LIGHT_CASTS_SHADOWS) != 0,
                                 numbers(light.position, 3), numbers(light.direction, 3),
                                 numbers(light.colour, 3), light.intensity, light.range, light.inner_cone,
                                 light.outer_cone));
  return py::make_tuple(parts, pictures, lights);
}

} // namespace fvv::python
