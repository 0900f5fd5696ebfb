// tools/capture: what capture.json may say of an atlas.
#include "fvv_catch.h"

#include "fvv_scene/capture.h"

using namespace fvv::scene;

TEST_CASE("an atlas may be one picture for all frames, cameras' pictures may not") {
  const auto with = [](const std::string &pictures) {
    return R"({"fvv_capture": 1, "frame_rate": 25, "units": "metres", "frames": {"first": 3, "count": 4},)"
           R"( "meshes": {"pattern": "%d.ply"}, "atlas": {"pictures": )" +
           pictures + "}}";
  };
  const Capture one = parse_capture(with(R"("atlas.png")"), "c.json");
  REQUIRE(one.atlas->pictures->is_constant());
  CHECK(one.atlas_path(3) == "atlas.png");
  CHECK(one.atlas_path(6) == "atlas.png");
  const Capture turned = parse_capture(with(R"({"pattern": "%02d.png", "rotate": 90})"), "c.json");
  CHECK(!turned.atlas->pictures->is_constant());
  CHECK(turned.atlas_path(6) == "06.png");
  CHECK(turned.atlas->pictures->rotate == 90);
  const Capture film = parse_capture(with(R"({"video": "a%.mp4", "start": "1/2"})"), "c.json");
  REQUIRE(film.atlas->pictures->video);
  CHECK(!film.atlas->pictures->is_constant());
  CHECK(film.atlas_path(6) == "a%.mp4");
  for (const Capture &capture : {one, turned, film}) {
    const std::string text = format_capture(capture);
    CHECK(format_capture(parse_capture(text, "c.json")) == text);
  }
  Capture later = film;
  later.frames.first = 4;
  CHECK_THROWS_WITH(format_capture(later),
                    "c.json: atlas: expected a capture that begins with frame 3 as its "
                    "video does, found 4");
  CHECK_THROWS_WITH(parse_capture(with("7"), "c.json"),
                    "c.json: /atlas/pictures: expected a pattern as text, or an object with a pattern or a "
                    "video, found 7");
  const std::string camera =
      R"(, "cameras": [{"id": 0, "width": 4, "height": 4, "intrinsics": {"fx": 4, "fy": 4, "cx": 2, "cy": 2},)"
      R"( "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "translation": [0, 0, 0], "pictures": "a.png"}]})";
  const std::string text = with(R"("atlas.png")");
  CHECK_THROWS_WITH(
      parse_capture(text.substr(0, text.size() - 1) + camera, "c.json"),
      "c.json: /cameras/0/pictures: expected %d or %0Nd for the frame number, because there are "
      "4 frames, found \"a.png\"");
}
