// fvvmux as a program: exit codes, messages, and that a failed run leaves no files.
#include "mux_fixture.h"

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

namespace {

// CAPTURE -o OUT and more; small and quick.
std::vector<std::string> arguments(const Folder &folder, std::vector<std::string> more = {}) {
  std::vector<std::string> words = {folder.path("in"), "-o", folder.path("out.fvv"), "--quality", "30"};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

void check_refused(const Folder &folder, const std::vector<std::string> &words, int exit,
                   const std::string &message) {
  const ToolResult run = run_tool(words);
  CHECK(run.exit == exit);
  CHECK(run.err == message);
  CHECK(run.out.empty());
  CHECK(folder.entries() == 1); // the capture
}

} // namespace

TEST_CASE("success: a summary on standard output, nothing on standard error") {
  const Folder folder;
  make_capture(folder);
  const ToolResult run = run_tool(arguments(folder, {"--verify"}));
  CHECK(run.exit == 0);
  CHECK(run.err.empty());
  CHECK(run.out.find(folder.path("out.fvv") + ": ") == 0);
  for (const char *part : {"H.264 CRF 30, 8 bits, 3 tiles", "lattice   step 2 mm", "frames    1 key, ",
                           "frames/s", "verified  5 meshes"})
    CHECK(run.out.find(part) != std::string::npos);
  CHECK(folder.entries() == 2);
}

TEST_CASE("standard output as a stream, and --json") {
  const Folder folder;
  make_capture(folder);
  const ToolResult run = run_tool(arguments(folder, {"--json", "--verify", "--codec", "jpeg"}));
  CHECK(run.exit == 0);
  const nlohmann::json summary = nlohmann::json::parse(run.out);
  CHECK(summary.at("fvvmux") == 1);
  CHECK(summary.at("frames") == 5);
  const uint64_t bytes = summary.at("bytes");
  CHECK(bytes == fs::file_size(folder.path("out.fvv")));
  CHECK(summary.at("container_bytes").get<uint64_t>() + summary.at("mesh").at("bytes").get<uint64_t>() +
            summary.at("video").at("bytes").get<uint64_t>() +
            summary.at("visibility").at("bytes").get<uint64_t>() +
            summary.at("colours").at("bytes").get<uint64_t>() ==
        bytes);
  CHECK(summary.at("verified").at("visibility") == 5);
  CHECK(summary.at("video").at("quality") == 30);
  CHECK(summary.at("lattice").at("step") == 0.002); // tracked: a third of 0.0106, rounded down
  CHECK(summary.at("mesh").at("welded_vertices").at("count") == 0);
  CHECK(summary.at("verified").at("pictures") == 5);
  const ToolResult piped = run_tool({folder.path("in"), "-o", "-", "--codec", "jpeg", "--quality", "30"});
  CHECK(piped.exit == 0);
  CHECK(piped.err.empty());
  CHECK(piped.out == read_bytes(folder.path("out.fvv")));
  CHECK(run_tool({folder.path("in"), "-o", "-", "--json"}).err ==
        "fvvmux: --json: standard output is taken by the stream (-o -)\n");
  CHECK(run_tool({folder.path("in"), "-o", "-", "--verify"}).exit == 2);
}

TEST_CASE("all problems of the files are reported before any work, one a line") {
  const Folder folder;
  const scene::Capture capture = make_capture(folder);
  fs::remove(capture.mesh_path(1));
  fs::remove(capture.mesh_path(4));
  write_png(capture.picture_path(capture.cameras[1], 2), media::make_image(63, 48, 3, 9));
  const std::string where = "fvvmux: " + capture.path + ": ";
  check_refused(
      folder, arguments(folder), 1,
      where + "2 of 5 meshes are missing: 1, 4 (first: meshes/0001.ply)\n" + where +
          "camera 13: 1 of 5 pictures is not 64 x 48, first: cam1/0002.png is 63 x 48 (cut or padded? state "
          "\"place\": [x, y] with the pixel of the calibrated picture at which it begins, [0, 0] if it was "
          "cut "
          "or padded at the right and at the bottom)\n" +
          where + "--skip-bad-frames leaves out frames whose files cannot be used\n" + where +
          "\"meshes\": {\"empty\": ...} says at which frames the stage is empty\n");
  fs::remove(capture.path);
  check_refused(
      folder, arguments(folder), 1,
      "fvvmux: " + folder.path("in") +
          ": expected capture.json, a COLMAP model (cameras.bin or cameras.txt, also in sparse/0) or "
          "transforms.json in the folder, found none\n");
}

TEST_CASE("a mesh that no decoder could show is refused by file, frame and vertex") {
  const Folder folder;
  const scene::Capture capture = make_capture(folder);
  const std::string path = capture.mesh_path(3);
  const std::string advice = "--skip-bad-frames leaves out frames whose files cannot be used";
  std::string ply = read_bytes(path);
  char *y = &ply[ply.find("end_header\n") + 11 + 24 * 17 + 8];
  const double far = 3e9, nan = std::nan("");
  memcpy(y, &far, sizeof far);
  write_bytes(path, ply.data(), ply.size());
  for (const char *threads : {"1", "3"})
    check_refused(
        folder, arguments(folder, {"--threads", threads}), 1,
        "fvvmux: " + path +
            ": frame 3: vertex 17: y = 3e+09 m lies more than 2^28 steps of 0.002 m from the origin 0 "
            "m [FVV-3006] (" +
            advice + ")\n");
  memcpy(y, &nan, sizeof nan);
  write_bytes(path, ply.data(), ply.size());
  check_refused(folder, arguments(folder), 1,
                "fvvmux: " + path +
                    ": face 1 uses vertex 17 (from 0), whose coordinates are not finite numbers (frame 3; " +
                    advice + ")\n");
  ply.resize(ply.size() - 1);
  write_bytes(path, ply.data(), ply.size());
  const ToolResult cut = run_tool(arguments(folder));
  CHECK(cut.exit == 1);
  CHECK(cut.err.find("fvvmux: " + path + ": ") == 0);
  CHECK(folder.entries() == 1);
}

TEST_CASE("a picture that is cut is found when it is read, and nothing is left") {
  const Folder folder;
  const scene::Capture capture = make_capture(folder);
  const std::string path = capture.picture_path(capture.cameras[2], 4);
  const std::string png = read_bytes(path);
  write_bytes(path, png.data(), png.size() / 2);
  const ToolResult run = run_tool(arguments(folder));
  CHECK(run.exit == 1);
  CHECK(run.err.find("fvvmux: " + path + ": ") == 0);
  CHECK(folder.entries() == 1);
}

TEST_CASE("an existing file stays unless --force is given") {
  const Folder folder;
  make_capture(folder);
  const std::string out = folder.path("out.fvv");
  write_bytes(out, "mine", 4);
  const ToolResult refused = run_tool(arguments(folder));
  CHECK(refused.exit == 1);
  CHECK(refused.err == "fvvmux: " + out + ": already exists; --force overwrites it\n");
  CHECK(read_bytes(out) == "mine");
  CHECK(run_tool(arguments(folder, {"--force"})).exit == 0);
  CHECK(fs::file_size(out) > 4);
  CHECK(folder.entries() == 2);
}

TEST_CASE("frames that are not taken give a warning and exit code 3, with --frames they are intended") {
  const Folder folder;
  const scene::Capture capture = make_capture(folder);
  scene::write_mesh(ball(5), {}, capture.mesh_path(5));
  const ToolResult run = run_tool(arguments(folder));
  CHECK(run.exit == 3);
  CHECK(run.err == "fvvmux: warning: " + capture.path +
                       ": meshes reach from frame 0 to 5, the capture takes 0 to 4 (1 not used)\n");
  CHECK(fs::exists(folder.path("out.fvv")));
  const ToolResult ranged = run_tool(arguments(folder, {"--frames", "1-3", "--force"}));
  CHECK(ranged.exit == 0);
  CHECK(ranged.err.empty());
}

TEST_CASE("a full disk is one line, and no file is left") {
  const Folder folder;
  make_capture(folder);
  const ToolResult run = run_tool(arguments(folder), [] {
    const rlimit few = {1024, 1024};
    setrlimit(RLIMIT_FSIZE, &few);
  });
  CHECK(run.exit == 1);
  CHECK(run.err == "fvvmux: " + folder.path("out.fvv") + ": cannot write: File too large\n");
  CHECK(folder.entries() == 1);
  const ToolResult full = run_tool({folder.path("in"), "-o", "-", "--quality", "30"},
                                   [] { dup2(open("/dev/full", O_WRONLY), STDOUT_FILENO); });
  CHECK(full.exit == 1);
  CHECK(full.err == "fvvmux: standard output: cannot write: No space left on device\n");
}

TEST_CASE("an interrupted run leaves no temporary file") {
  const Folder folder, logs;
  Shape shape;
  shape.count = 60;
  make_capture(folder, shape);
  for (const int signal : {SIGINT, SIGTERM}) {
    const pid_t child =
        start_tool({folder.path("in"), "-o", folder.path("out.fvv"), "--threads", "1"}, logs.path("log"));
    int status = 0;
    while (!folder.has_partial() && waitpid(child, &status, WNOHANG) == 0)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    REQUIRE(folder.has_partial()); // else the run was over before it could be interrupted
    REQUIRE(kill(child, signal) == 0);
    REQUIRE(waitpid(child, &status, 0) == child);
    REQUIRE(WIFSIGNALED(status));
    CHECK(WTERMSIG(status) == signal);
    CHECK(folder.entries() == 1);
  }
}

TEST_CASE("wrong options: exit code 2, and the option is named") {
  const Folder folder;
  make_capture(folder);
  const std::vector<std::vector<std::string>> wrong = {
      {"--codec", "vp8"},        {"--quality", "0"},      {"--quality", "42db2"},  {"--tile", "480"},
      {"--scale", "2"},          {"--tile-fill", "blue"}, {"--step", "0"},         {"--mesh-level", "11"},
      {"--mesh-profile", "obj"}, {"--group", "0"},        {"--threads", "0"},      {"--frames", "4-2"},
      {"--min-component", "-1"}, {"--frames", "0-9"},     {"--tile-fill", "flat"}, {"--nonsense"}};
  for (const auto &words : wrong) {
    const ToolResult run = run_tool(arguments(folder, words));
    CHECK(run.exit == 2);
    INFO(run.err);
    CHECK(run.err.find(words[0].substr(2)) != std::string::npos);
  }
  CHECK(run_tool(arguments(folder, {"--scale", "0.5", "--tile", "32x24"})).exit == 2);
  CHECK(run_tool({folder.path("in")}).exit == 2);
  CHECK(folder.entries() == 1);
  CHECK(run_tool({"--version"}).out == std::string("fvvmux ") + fvv_version() + "\n");
  CHECK(run_tool({"--help"}).exit == 0);
}
