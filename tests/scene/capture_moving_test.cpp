// tools/capture: cameras that move or zoom.
#include "fvv_catch.h"

#include "fvv_scene/capture.h"

#include <cstring>
#include <nlohmann/json.hpp>

using namespace fvv::scene;
using nlohmann::json;

namespace {

// Two frames, 4 and 6; a camera that zooms, pans by a quarter turn, and a still one.
json good() {
  return json::parse(R"({
    "fvv_capture": 1, "frame_rate": 25, "frames": {"first": 4, "count": 2, "step": 2}, "units": "centimetres",
    "conventions": {"pixel_centre": 0}, "meshes": {"pattern": "%d.ply"},
    "cameras": [
      {"id": 3, "name": "crane", "width": 640, "height": 480, "texture": false,
       "intrinsics": {"fx": 600, "fy": 601, "cx": 319.5, "cy": 239.5, "skew": 0.5},
       "lens": {"model": "radtan", "coefficients": [-0.1, 0.01, 0, 0]},
       "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "translation": [0, 10, 300],
       "per_frame": [
         {"frame": 6, "rotation": [[0, 0, -1], [0, 1, 0], [1, 0, 0]]},
         {"frame": 4, "intrinsics": {"fx": 900, "fy": 901, "cx": 318, "cy": 240}, "translation": [1, 2, 3]},
         {"frame": 99, "lens": {"model": "radtan", "coefficients": [-0.05, 0, 0, 0], "r_max": 0.5}}]},
      {"id": 4, "width": 640, "height": 480, "intrinsics": {"fx": 600, "fy": 600, "cx": 320, "cy": 240},
       "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "translation": [0, 0, 0]}]})");
}

std::string complaint(const json &document) {
  try {
    parse_capture(document.dump(), "c.json");
    return "";
  } catch (const fvv::Error &error) {
    return error.what();
  }
}

bool same(fvv_camera a, fvv_camera b) {
  const bool names =
      std::string(a.name ? a.name : "", a.name_size) == std::string(b.name ? b.name : "", b.name_size);
  a.name = b.name = nullptr;
  return names && std::memcmp(a.rotation, b.rotation, sizeof a.rotation) == 0 &&
         std::memcmp(a.translation, b.translation, sizeof a.translation) == 0 &&
         std::memcmp(a.distortion, b.distortion, sizeof a.distortion) == 0 && a.fx == b.fx && a.fy == b.fy &&
         a.cx == b.cx && a.cy == b.cy && a.skew == b.skew && a.r_max == b.r_max && a.lens == b.lens &&
         a.id == b.id && a.width == b.width && a.height == b.height;
}

} // namespace

TEST_CASE("a camera that moves has a calibration for each frame") {
  const Capture capture = parse_capture(good().dump(), "c.json");
  const Camera &crane = capture.cameras[0];
  CHECK(crane.moves());
  CHECK_FALSE(crane.texture);
  CHECK(capture.cameras[1].texture);
  CHECK_FALSE(capture.cameras[1].moves());

  const fvv_camera zoomed = crane.calibration_at(4), turned = crane.calibration_at(6);
  CHECK(std::string(zoomed.name, zoomed.name_size) == "crane");
  CHECK(zoomed.fx == 900);
  CHECK(zoomed.cx == 318.5);
  CHECK(zoomed.skew == 0); // intrinsics come whole
  CHECK(zoomed.translation[2] == 3 * 0.01);
  CHECK(zoomed.rotation[0] == 1);
  CHECK(zoomed.distortion[0] == -0.1);
  CHECK(turned.fx == 600);
  CHECK(turned.cx == 320);
  CHECK(turned.skew == 0.5);
  CHECK(turned.rotation[2] == -1);
  CHECK(turned.translation[2] == 300 * 0.01);
  // No r_max was given: it follows from each frame's focal lengths.
  CHECK(zoomed.r_max == fvv_camera_r_max(&zoomed));
  CHECK(turned.r_max > zoomed.r_max);
  CHECK(crane.calibration_at(99).r_max == 0.5);
  CHECK(same(capture.cameras[1].calibration_at(4), capture.cameras[1].calibration));
}

TEST_CASE("a written capture with a moving camera loads the same") {
  json document = good();
  document["units"] = "metres";
  const Capture capture = parse_capture(document.dump(), "c.json");
  const Capture again = parse_capture(format_capture(capture), "c.json");
  REQUIRE(again.cameras.size() == 2);
  CHECK_FALSE(again.cameras[0].texture);
  CHECK(again.cameras[0].per_frame.size() == 3);
  for (const int64_t frame : {4, 6, 99})
    CHECK(same(again.cameras[0].calibration_at(frame), capture.cameras[0].calibration_at(frame)));
  CHECK(format_capture(again) == format_capture(capture));
}

TEST_CASE("what is wrong with a moving camera is named") {
  json document = good();
  json &entries = document["cameras"][0]["per_frame"];
  const auto with = [&](const char *pointer, const json &value) {
    json changed = document;
    changed[json::json_pointer(std::string("/cameras/0/per_frame") + pointer)] = value;
    return complaint(changed);
  };
  CHECK(with("/0/frame", 4) ==
        "c.json: /cameras/0/per_frame/1/frame: expected one entry for each frame, found a second one for 4");
  CHECK(with("/0/frame", 5) == "c.json: /cameras/0/per_frame: expected an entry for each of the capture's 2 "
                               "frames, found none for frame 6");
  CHECK(with("/0/pose", 5).find("/cameras/0/per_frame/0/pose: unknown key") != std::string::npos);
  CHECK(with("/0/frame", -1).find("/cameras/0/per_frame/0/frame: ") != std::string::npos);
  CHECK(with("/0/rotation", json::parse("[[1, 0, 0], [0, 1, 0], [0, 0, 2]]"))
            .find("/cameras/0/per_frame/0: rows 2") != std::string::npos);
  CHECK(with("", json::array()) ==
        "c.json: /cameras/0/per_frame: expected an entry for each of the capture's 2 frames, found none for "
        "frame 4");
  entries.erase(1);
  CHECK(complaint(document).find("found none for frame 4") != std::string::npos);
}

TEST_CASE("frames without calibration are stated, and not merely left out") {
  json document = good();
  document["units"] = "metres";
  json &entries = document["cameras"][0]["per_frame"];
  entries[0] = {{"frame", 6}, {"calibrated", false}};
  const Capture capture = parse_capture(document.dump(), "c.json");
  const Camera &crane = capture.cameras[0];
  CHECK(crane.moves());
  CHECK(crane.is_calibrated(4));
  CHECK_FALSE(crane.is_calibrated(6));
  CHECK(crane.per_frame.size() == 2);
  const Capture again = parse_capture(format_capture(capture), "c.json");
  CHECK(again.cameras[0].lost == crane.lost);
  CHECK(format_capture(again) == format_capture(capture));
  // Nowhere at all is a camera that moves, too.
  entries = {{{"frame", 4}, {"calibrated", false}}, {{"frame", 6}, {"calibrated", false}}};
  CHECK(parse_capture(document.dump(), "c.json").cameras[0].moves());
  entries[1] = {{"frame", 4}, {"calibrated", false}};
  CHECK(complaint(document).find("/per_frame/1/frame: expected one entry for each frame") !=
        std::string::npos);
  entries[1] = {{"frame", 6}, {"calibrated", true}};
  CHECK(complaint(document).find("/per_frame/1/calibrated: expected false") != std::string::npos);
  entries[1] = {{"frame", 6}, {"calibrated", false}, {"translation", {0, 0, 0}}};
  CHECK(complaint(document).find("/per_frame/1/translation: unknown key") != std::string::npos);
}
