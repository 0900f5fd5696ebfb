// fvv_scene: the sound that a capture names.
#include "fvv_catch.h"

#include "fvv_media/sound.h"
#include "fvv_scene/capture.h"

#include <filesystem>
#include <unistd.h>

using namespace fvv::scene;
namespace fs = std::filesystem;

namespace {

std::string with_audio(const std::string &audio) {
  return R"({"fvv_capture": 1, "frame_rate": 25, "frames": {"first": 10, "count": 3, "step": 2}, "units": "millimetres",
  "meshes": {"pattern": "%d.ply"}, "audio": )" +
         audio + "}";
}

std::string complaint(const std::string &audio) {
  try {
    parse_capture(with_audio(audio), "c.json");
    return "";
  } catch (const fvv::Error &error) {
    return error.what();
  }
}

} // namespace

TEST_CASE("a capture.json names sound") {
  const Capture capture = parse_capture(with_audio(R"([
    {"file": "hall%.wav", "stream": 1, "offset": "-6/4", "title": "hall", "language": "de-CH"},
    {"file": "/a/b.mp4", "offset": 2, "position": [0, 1500, -250]},
    {"file": "c.opus", "per_frame": [{"frame": 14, "position": [3000, 0, 0]}, {"frame": 10, "position": [1000, 0, 0]},
                                     {"frame": 12, "position": [2000, 0, 0]}]}])"),
                                        "in/c.json");
  REQUIRE(capture.sounds.size() == 3);
  const SoundSource &hall = capture.sounds[0], &placed = capture.sounds[1], &moving = capture.sounds[2];
  CHECK(hall.file == "hall%.wav");
  CHECK(capture.resolve(hall.file) == "in/hall%.wav");
  CHECK(hall.stream == 1);
  CHECK(hall.offset.numerator == -3);
  CHECK(hall.offset.denominator == 2);
  CHECK(hall.title == "hall");
  CHECK(hall.language == "de-CH");
  CHECK(!hall.is_placed());
  CHECK(hall.first == 10);
  CHECK(placed.position == Place{0, 1.5, -0.25});
  CHECK(placed.position_at(12) == Place{0, 1.5, -0.25});
  CHECK(moving.is_placed());
  CHECK(moving.position_at(12) == Place{2, 0, 0});
  CHECK(capture.resolve(placed.file) == "/a/b.mp4");

  // Written and read again; the writer takes metres only.
  Capture metres = capture;
  metres.metres_per_unit = 1;
  const Capture again = parse_capture(format_capture(metres), "c.json");
  REQUIRE(again.sounds.size() == 3);
  CHECK(again.sounds[0].offset.numerator == -3);
  CHECK(again.sounds[0].stream == 1);
  CHECK(again.sounds[0].title == "hall");
  CHECK(again.sounds[0].language == "de-CH");
  CHECK(again.sounds[1].position == placed.position);
  CHECK(again.sounds[2].per_frame == moving.per_frame);
  metres.frames.first = 12;
  CHECK_THROWS_AS(format_capture(metres), fvv::Error);
}

TEST_CASE("faulty sound is refused by its JSON pointer") {
  CHECK(complaint("[]") == "");
  CHECK(complaint("{}") == "c.json: /audio: expected an array, found an object");
  CHECK(complaint("[{}]") == "c.json: /audio/0: expected key \"file\", found none");
  CHECK(complaint(R"([{"file": ""}])") == "c.json: /audio/0/file: expected a file name, found \"\"");
  CHECK(complaint(R"([{"file": "a", "offset": 0.5}])") ==
        "c.json: /audio/0/offset: expected seconds as an integer or as text such as \"3/2\" or \"-3/2\", "
        "found 0.5");
  CHECK(complaint(R"([{"file": "a", "language": "en_GB"}])") ==
        "c.json: /audio/0/language: expected a language tag of BCP 47 such as \"en\" or \"pt-BR\", found "
        "\"en_GB\"");
  CHECK(complaint(R"([{"file": "a", "language": "e-"}])") != "");
  CHECK(complaint(R"([{"file": "a", "language": "1e"}])") != "");
  CHECK(complaint(R"([{"file": "a", "position": [1, 2]}])").find("c.json: /audio/0/position: ") == 0);
  CHECK(complaint(R"([{"file": "a", "position": [1, 2, 3], "per_frame": []}])") ==
        "c.json: /audio/0/per_frame: expected position or per_frame, found both");
  CHECK(complaint(R"([{"file": "a", "per_frame": [{"frame": 10, "position": [1, 2, 3]}]}])") ==
        "c.json: /audio/0/per_frame: expected an entry for each of the capture's 3 frames, found none for "
        "frame 12");
  CHECK(
      complaint(
          R"([{"file": "a", "per_frame": [{"frame": 10, "position": [1, 2, 3]}, {"frame": 10, "position": [1, 2, 3]}]}])") ==
      "c.json: /audio/0/per_frame/1/frame: expected one entry for each frame, found a second one for 10");
  CHECK(complaint(R"([{"file": "a", "volume": 1}])").find("c.json: /audio/0/volume: unknown key") == 0);
  std::string many;
  for (size_t i = 0; i <= max_sounds; i++) many += (i ? ", " : "") + std::string(R"({"file": "a"})");
  CHECK(complaint("[" + many + "]") == "c.json: /audio: expected at most 64 sounds, found 65");
}

TEST_CASE("sound files are checked before work starts, and protected from it") {
  const fs::path root = fs::temp_directory_path() / ("fvv_capture_sound_test_" + std::to_string(getpid()));
  fs::create_directories(root);
  const std::string name = (root / "capture.json").string();
  Capture capture = parse_capture(
      with_audio(
          R"([{"file": "good.wav"}, {"file": "none.wav"}, {"file": "text.wav"}, {"file": "good.wav", "stream": 4}])"),
      name);
  capture.meshes.reset();
  write_file((root / "good.wav").string(), fvv::media::wav_file(std::vector<int16_t>(4800), 1, 48000));
  write_file((root / "text.wav").string(), "no sound at all");
  const std::vector<std::string> problems = check_files(capture, {}).problems;
  REQUIRE(problems.size() == 3);
  CHECK(problems[0] == "audio: none.wav: is missing");
  CHECK(problems[1].find("audio: " + (root / "text.wav").string() +
                         ": is no sound file, or is cut or damaged") == 0);
  CHECK(problems[2].find("has 1 streams, stream 4 is not among them") != std::string::npos);
  std::vector<std::string> visited;
  visit_files(capture, [&](const std::string &file) { visited.push_back(file); });
  CHECK(std::count(visited.begin(), visited.end(), (root / "good.wav").string()) == 2);
  fs::remove_all(root);
}
