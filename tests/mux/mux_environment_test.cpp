// fvvmux --verify: the environment of a stream is compared with the capture's.
#include "mux_fixture.h"

#include "fvv_mux/report.h"
#include "mux/src/environment.h"

namespace {

// One triangle of 2 m in one colour, and a stream of it.
FileOptions with_triangle(const Folder &folder) {
  Shape shape;
  shape.pictures = false;
  scene::Capture capture = make_capture(folder, shape);
  scene::Environment environment;
  environment.parts.resize(1);
  environment.parts[0].mesh.positions = {0, 0, 0, 2, 0, 0, 0, 0, 2};
  environment.parts[0].mesh.faces = {0, 2, 1};
  const std::string file = scene::format_environment(environment, {{0, 0, 0}, 0.001}, "stage.glb");
  write_bytes(folder.path("in/stage.glb"), file.data(), file.size());
  capture.environment.emplace();
  capture.environment->file = "stage.glb";
  scene::write_capture(capture, capture.path);
  FileOptions options = options_for(folder);
  options.verify = true;
  return options;
}

} // namespace

TEST_CASE("the environment is read back for every group, and another one is found") {
  const Folder folder;
  const FileOptions options = with_triangle(folder);
  Encoded encoded = encode_file(options);
  mux::Report summary = encoded.report;
  summary.verdict = encoded.verify(options.output);
  CHECK(summary.verdict->environments == 3);
  CHECK(json_of(summary)["verified"]["environment"] == 3);
  CHECK(text_of(summary).find("the environment of 3 groups is the capture's") != std::string::npos);

  // What was packed is no longer what is in the stream.
  auto other = std::make_shared<mux::PackedEnvironment>(*encoded.plan.environment);
  other->payload.back() ^= 1;
  const auto packed = std::exchange(encoded.plan.environment, other);
  CHECK_THROWS_WITH(encoded.verify(options.output),
                    options.output + ": group 0: environment: it is not the one that was written");
  encoded.plan.environment = packed;
  CHECK(encoded.verify(options.output).environments == 3);

  // Nor is it what the capture has by now.
  scene::Environment moved;
  moved.parts.resize(1);
  moved.parts[0].mesh.positions = {9, 0, 0, 11, 0, 0, 9, 0, 2};
  moved.parts[0].mesh.faces = {0, 2, 1};
  const std::string file = scene::format_environment(moved, {{0, 0, 0}, 0.001}, "stage.glb");
  write_bytes(folder.path("in/stage.glb"), file.data(), file.size());
  CHECK_THROWS_WITH(encoded.verify(options.output),
                    options.output + ": group 0: environment: part 0 is not that of the capture");
}
