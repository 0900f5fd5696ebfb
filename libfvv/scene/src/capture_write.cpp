// Capture -> capture.json, one line per matrix, so that people can read it.

#include "fvv_scene/capture.h"
#include "fvv_scene/capture_keywords.h"
#include "fvv_scene/file_io.h"
#include "scene/src/capture_fields.h"

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

namespace fvv::scene {

namespace {

// JSON's "-0" is an integer to most readers, and the sign is lost.
std::string number(double value) {
  std::string text;
  append_double(text, value);
  return text == "-0" ? "-0.0" : text;
}

std::string text(const std::string &value) {
  try {
    return nlohmann::json(value).dump();
  } catch (const nlohmann::json::exception &) {
    throw Error("expected UTF-8 to write into a capture description, found " + quote(value));
  }
}

std::string list(const double *values, size_t count) {
  std::string out = "[";
  for (size_t i = 0; i < count; i++) out += (i ? ", " : "") + number(values[i]);
  return out + "]";
}

template <class Row> const Row &lookup(const Row *begin, const Row *end, uint8_t Row::*code, uint8_t value) {
  while (begin + 1 < end && begin->*code != value) begin++;
  return *begin;
}

std::string lens_text(const fvv_camera &camera) {
  const NamedLens &lens =
      lookup(std::begin(named_lenses), std::end(named_lenses), &NamedLens::lens, camera.lens);
  std::string out = "{\"model\": " + text(lens.name);
  if (lens.coefficients) out += ", \"coefficients\": " + list(camera.distortion, lens.coefficients);
  return out + ", \"r_max\": " + (std::isinf(camera.r_max) ? text(unbounded) : number(camera.r_max)) + "}";
}

// The values that change when a camera moves or zooms, each line after indent.
std::string calibration_text(const fvv_camera &c, const std::string &indent) {
  return indent + "\"intrinsics\": {\"fx\": " + number(c.fx) + ", \"fy\": " + number(c.fy) +
         ", \"cx\": " + number(c.cx) + ", \"cy\": " + number(c.cy) + ", \"skew\": " + number(c.skew) + "}," +
         indent + "\"lens\": " + lens_text(c) + "," + indent + "\"rotation\": [" + list(c.rotation, 3) +
         ", " + list(c.rotation + 3, 3) + ", " + list(c.rotation + 6, 3) + "]," + indent +
         "\"translation\": " + list(c.translation, 3);
}

// By rising frame, lost ones in their places.
std::string per_frame_text(const Camera &camera) {
  std::map<int64_t, std::string> entries;
  for (const auto &[frame, calibration] : camera.per_frame)
    entries[frame] = calibration_text(calibration, " ");
  for (const int64_t frame : camera.lost) entries[frame] = " \"calibrated\": false";
  std::string out;
  for (const auto &[frame, entry] : entries)
    out += (out.empty() ? "" : ",\n       ") + ("{\"frame\": " + std::to_string(frame) + ",") + entry + "}";
  return out;
}

std::string camera_text(const Camera &camera) {
  const fvv_camera &c = camera.calibration;
  std::string out = "    {\n      \"id\": " + std::to_string(c.id) +
                    ",\n      \"name\": " + text(std::string(c.name ? c.name : "", c.name_size)) +
                    ",\n      \"width\": " + std::to_string(c.width) +
                    ",\n      \"height\": " + std::to_string(c.height) + "," +
                    calibration_text(c, "\n      ");
  if (camera.moves()) out += ",\n      \"per_frame\": [" + per_frame_text(camera) + "]";
  if (!camera.texture) out += ",\n      \"texture\": false";
  if (camera.pictures) out += ",\n      \"pictures\": " + format_picture_source(*camera.pictures, text);
  if (camera.masks) out += ",\n      \"masks\": " + format_picture_source(*camera.masks, text);
  return out + "\n    }";
}

// ", "KEY": [3, [10, 14]]" of frame numbers; nothing of none.
std::string numbers_text(const char *key, const std::set<int64_t> &numbers, int64_t step) {
  if (numbers.empty()) return "";
  Gaps ranges(step);
  for (const int64_t number : numbers) ranges.add(number);
  std::string out;
  for (const FrameRange &range : ranges.ranges()) {
    const std::string first = std::to_string(range.first);
    out += (out.empty() ? "" : ", ") +
           (range.first == range.last ? first : "[" + first + ", " + std::to_string(range.last) + "]");
  }
  return std::string(", \"") + key + "\": [" + out + "]";
}

std::string meshes_text(const Capture &capture) {
  const std::string empty = numbers_text("empty", capture.empty, capture.frames.step);
  if (!capture.animation) return "{\"pattern\": " + text(capture.meshes->text()) + empty + "}";
  const MeshAnimation &animation = *capture.animation;
  // The animation counts its time from the first frame it was described with.
  if (animation.first != capture.frames.first)
    throw Error(capture.path + ": expected a capture that begins with frame " +
                std::to_string(animation.first) + " as its animation does, found " +
                std::to_string(capture.frames.first));
  std::string out = "{\"file\": " + text(capture.meshes->file(capture.frames.first));
  if (animation.name) {
    const int64_t *index = std::get_if<int64_t>(&*animation.name);
    out +=
        ", \"animation\": " + (index ? std::to_string(*index) : text(std::get<std::string>(*animation.name)));
  }
  return out + ", \"start\": \"" + std::to_string(animation.start.numerator) + "/" +
         std::to_string(animation.start.denominator) + "\"" + empty + "}";
}

std::string left_out_text(const Frames &frames) {
  std::set<int64_t> numbers;
  for (const int64_t place : frames.left_out) numbers.insert(frames.number_at(place));
  return numbers_text("left_out", numbers, frames.step);
}

std::string atlas_text(const Atlas &atlas) {
  std::string out = atlas.pictures ? "{\"pictures\": " + format_picture_source(*atlas.pictures, text)
                                   : "{\"embedded\": true";
  if (atlas.texture_bits) out += ", \"texture_bits\": " + std::to_string(*atlas.texture_bits);
  if (atlas.bake_repeats) out += ", \"bake_repeats\": true";
  return out + "}";
}

std::string lattice_text(const Lattice &lattice) {
  return "{\"origin\": " + list(lattice.origin, 3) + ", \"step\": " + number(lattice.step) + "}";
}

std::string environment_text(const EnvironmentSource &environment) {
  const double *m = environment.transform.m.data();
  std::string out = "{\"file\": " + text(environment.file);
  if (environment.transform.m != gltf::Transform().m)
    out += ", \"transform\": [" + list(m, 4) + ", " + list(m + 4, 4) + ", " + list(m + 8, 4) + "]";
  if (environment.lattice) out += ", \"lattice\": " + lattice_text(*environment.lattice);
  return out + "}";
}

// A video counts its time from the first frame it was described with.
void check_start(const Capture &capture, const std::string &subject,
                 const std::optional<PictureSource> &source) {
  if (source && source->video && source->video->first != capture.frames.first)
    throw Error(capture.path + ": " + subject + ": expected a capture that begins with frame " +
                std::to_string(source->video->first) + " as its video does, found " +
                std::to_string(capture.frames.first));
}

} // namespace

std::string format_capture(const Capture &capture) {
  if (capture.metres_per_unit != 1)
    throw Error(capture.path + ": expected a capture in metres to write, found " +
                number(capture.metres_per_unit) + " metres per unit");
  return format_capture(capture, text(capture.scale_unknown ? unknown_units : "metres"));
}

std::string format_capture(const Capture &capture, const std::string &units) {
  for (const Camera &camera : capture.cameras) {
    fvv_diagnostic diagnostic = {};
    if (fvv_camera_validate(&camera.calibration, &diagnostic) != FVV_OK)
      throw Error(capture.path + ": camera " + std::to_string(camera.calibration.id) + ": " +
                  diagnostic.message);
    for (const auto &source : {camera.pictures, camera.masks})
      check_start(capture, "camera " + std::to_string(camera.calibration.id), source);
  }
  if (capture.atlas) check_start(capture, "atlas", capture.atlas->pictures);
  const fvv_rational &duration = capture.frame_duration;
  std::string rate = std::to_string(duration.denominator);
  if (duration.numerator != 1) rate += "/" + std::to_string(duration.numerator);
  std::string out =
      "{\n  \"fvv_capture\": 1,\n  \"name\": " + text(capture.name) + ",\n  \"frame_rate\": " + text(rate) +
      ",\n  \"frames\": {\"first\": " + std::to_string(capture.frames.first) +
      ", \"count\": " + std::to_string(capture.frames.places()) +
      ", \"step\": " + std::to_string(capture.frames.step) + left_out_text(capture.frames) +
      "},\n  \"units\": " + units + ",\n  \"up\": " +
      text(lookup(std::begin(named_axes), std::end(named_axes), &NamedAxis::up, capture.up).name) +
      ",\n  \"conventions\": {\"pixel_centre\": 0.5}";
  if (capture.lattice) out += ",\n  \"lattice\": " + lattice_text(*capture.lattice);
  if (capture.meshes) out += ",\n  \"meshes\": " + meshes_text(capture);
  if (capture.environment) out += ",\n  \"environment\": " + environment_text(*capture.environment);
  if (capture.atlas) out += ",\n  \"atlas\": " + atlas_text(*capture.atlas);
  std::string sounds;
  for (const SoundSource &sound : capture.sounds) {
    if (sound.first != capture.frames.first)
      throw Error(capture.path + ": audio: expected a capture that begins with frame " +
                  std::to_string(sound.first) + " as its sound does, found " +
                  std::to_string(capture.frames.first));
    sounds += (sounds.empty() ? "" : ",") + ("\n    " + format_sound(sound, text, list));
  }
  if (!sounds.empty()) out += ",\n  \"audio\": [" + sounds + "\n  ]";
  out += ",\n  \"cameras\": [";
  for (size_t i = 0; i < capture.cameras.size(); i++)
    out += (i ? ",\n" : "\n") + camera_text(capture.cameras[i]);
  return out + (capture.cameras.empty() ? "]\n}\n" : "\n  ]\n}\n");
}

void write_capture(const Capture &capture, const std::string &path) {
  write_file(path, format_capture(capture));
}

} // namespace fvv::scene
