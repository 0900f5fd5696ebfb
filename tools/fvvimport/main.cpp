// fvvimport: a calibration of another program as the cameras of a capture.json. Argument parsing and the
// order of work; the formats are tools/import's.
#include "cli/cli.h"
#include "fvvimport/options.h"
#include "fvvimport/summary.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>

using namespace fvv;

namespace {

struct Arguments {
  std::string format, output, size, units, up = "unknown", rate = "25", frames = "0", pictures, videos, masks,
                                           meshes, points;
  std::vector<std::string> inputs;
  bool force = false, as_json = false;
};

[[noreturn]] void misuse(const std::string &what) {
  throw cli::Failure(what, cli::usage);
}

// OpenCV: files, or a folder with them.
std::vector<std::string> files_of(const std::vector<std::string> &inputs) {
  if (inputs.size() != 1 || !std::filesystem::is_directory(inputs[0])) return inputs;
  std::vector<std::string> files;
  for (const auto &entry : std::filesystem::directory_iterator(inputs[0])) {
    const std::string extension = entry.path().extension().string();
    if (extension == ".yml" || extension == ".yaml" || extension == ".xml")
      files.push_back(entry.path().string());
  }
  if (files.empty()) throw cli::Failure(inputs[0] + ": expected files .yml, .yaml or .xml, found none");
  std::sort(files.begin(), files.end());
  return files;
}

import::Calibration read(const Arguments &arguments){
    if (!arguments.size.empty() && arguments.format != "middlebury")
        misuse("--size: expected for middlebury only, the other formats say how large pictures are");
if (arguments.format == "opencv") return import::read_opencv(files_of(arguments.inputs));
if (arguments.inputs.size() != 1)
  misuse("INPUT: expected one for " + arguments.format + ", found " +
         std::to_string(arguments.inputs.size()));
const std::string &input = arguments.inputs[0];
if (arguments.format == "colmap") return import::read_colmap(input);
if (arguments.format == "nerfstudio") return import::read_nerfstudio(input);
if (arguments.format == "qualisys") return import::read_qualisys(input);
if (arguments.size.empty())
  misuse("--size: expected WIDTHxHEIGHT of the pictures, which middlebury does not say");
const fvvimport::Size size = fvvimport::parse_size(arguments.size);
return import::read_middlebury(input, size.width, size.height);
} // namespace

// The format's own unit unless the user names another.
void set_units(const Arguments &arguments, const import::Calibration &calibration,
               capture::Capture &capture) {
  std::optional<double> metres;
  if (calibration.metres_per_unit > 0) metres = calibration.metres_per_unit;
  if (!arguments.units.empty()) metres = fvvimport::parse_units(arguments.units);
  capture.scale_unknown = !metres;
  for (capture::Camera &camera : capture.cameras)
    for (double &coordinate : camera.calibration.translation) coordinate *= metres.value_or(1);
}

void set_files(const Arguments &arguments, capture::Capture &capture) {
  if (!arguments.meshes.empty())
    capture.meshes = fvvimport::parse_pattern("--meshes", arguments.meshes, capture.frames);
  for (capture::Camera &camera : capture.cameras) {
    if (!arguments.pictures.empty())
      camera.pictures = fvvimport::parse_pattern("--pictures", arguments.pictures, camera, capture.frames);
    if (!arguments.videos.empty())
      camera.pictures = fvvimport::parse_video("--videos", arguments.videos, camera, capture.frames);
    if (!arguments.masks.empty())
      camera.masks = fvvimport::parse_pattern("--masks", arguments.masks, camera, capture.frames);
  }
  const bool pictures = !arguments.pictures.empty(), videos = !arguments.videos.empty();
  for (size_t i = 0; i < capture.cameras.size() && (pictures || videos); i++)
    for (size_t j = 0; j < i; j++)
      if (capture.cameras[i].pictures->text() == capture.cameras[j].pictures->text())
        misuse(std::string(pictures ? "--pictures" : "--videos") +
               ": expected {name} or {id} to tell the cameras apart, found \"" +
               capture.cameras[i].pictures->text() + "\" for two of them");
}

void check_usage(const Arguments &arguments) {
  if (arguments.output.empty() && arguments.points.empty())
    misuse("expected -o FILE, --check POINTS or both");
  const bool pictures = !arguments.pictures.empty() || !arguments.videos.empty();
  if (!arguments.output.empty() && !pictures && arguments.meshes.empty())
    misuse("-o: expected --pictures, --videos or --meshes too, because a capture has one of them at least");
  if (!arguments.masks.empty() && !pictures) misuse("--masks: expected --pictures or --videos too");
  if (arguments.output == "-" && arguments.as_json)
    misuse("--json: standard output is taken by the capture (-o -)");
  if (arguments.output == "-" && !arguments.points.empty())
    misuse("--check: standard output is taken by the capture (-o -)");
}

cli::Exit work(const Arguments &arguments) {
  check_usage(arguments);
  capture::Capture capture;
  capture.path = arguments.output;
  capture.frame_duration = fvvimport::parse_frame_rate(arguments.rate);
  capture.frames = fvvimport::parse_frames(arguments.frames);
  capture.up = fvvimport::parse_up(arguments.up);
  const import::Calibration calibration = read(arguments);
  capture.cameras = calibration.cameras;
  set_units(arguments, calibration, capture);
  set_files(arguments, capture);
  fvvimport::Result result = {arguments.format, arguments.output, &capture, std::nullopt};
  if (!arguments.points.empty())
    result.diagnosis =
        import::diagnose(capture.cameras, import::read_observations(arguments.points, capture.cameras));
  if (!arguments.output.empty()) {
    const std::string text = capture::format_capture(capture);
    cli::OutputFile file(arguments.output, arguments.force);
    file.write(text.data(), text.size());
    file.commit();
  }
  if (arguments.as_json)
    std::printf("%s\n", fvvimport::json_summary(result).c_str());
  else if (arguments.output != "-")
    std::fputs(fvvimport::text_summary(result).c_str(), stdout);
  return result.diagnosis && result.diagnosis->suspected ? cli::loss : cli::done;
}

} // namespace

int main(int argc, char **argv) {
  CLI::App app("Reads a calibration of another program and writes its cameras as a capture.json.");
  Arguments a;
  app.add_option("FORMAT", a.format, "colmap, opencv, nerfstudio, qualisys or middlebury")
      ->required()
      ->check(CLI::IsMember({"colmap", "opencv", "nerfstudio", "qualisys", "middlebury"}).description(""));
  app.add_option(
         "INPUT", a.inputs,
         "colmap: folder of cameras.txt and images.txt; opencv: a file for each camera, or their folder; "
         "others: a file")
      ->required();
  app.add_option("-o,--output", a.output, "capture.json to write")->type_name("FILE");
  auto *pictures = app.add_option("--pictures", a.pictures,
                                  "pictures of a camera, with {name} or {id}, and %d or %0Nd for the frame")
                       ->type_name("PATTERN");
  app.add_option("--videos", a.videos,
                 "instead: a video of each camera, with {name} or {id}, which begins with the first frame")
      ->type_name("FILE")
      ->excludes(pictures);
  app.add_option("--masks", a.masks, "silhouettes, in the same way")->type_name("PATTERN");
  app.add_option("--meshes", a.meshes,
                 "meshes, in metres; with units unknown, in the units of the calibration")
      ->type_name("PATTERN");
  app.add_option(
         "--units", a.units,
         "of the calibration: metres, centimetres, millimetres, inches, feet, metres per unit as a number, "
         "or unknown (default, but qualisys: millimetres); cameras are written in metres")
      ->type_name("UNIT");
  app.add_option("--up", a.up, "world axis that points up: +x, -x, +y, -y, +z, -z; default unknown")
      ->type_name("AXIS");
  app.add_option("--frame-rate", a.rate, "frames per second; default 25")->type_name("N[/D]");
  app.add_option("--frames", a.frames, "first and last frame number, like 0-49; default 0")->type_name("A-B");
  app.add_option("--size", a.size, "width and height of the pictures, for middlebury")->type_name("WxH");
  app.add_option("--check", a.points, "lines X Y Z CAMERA_ID U V: tell how well the cameras explain them")
      ->type_name("POINTS");
  app.add_flag("--json", a.as_json, "print a summary as JSON");
  app.add_flag("--force", a.force, "replace the file when it exists");
  app.set_version_flag("--version", std::string("fvvimport ") + fvv_version());
  app.footer(
      "--check takes points in the units that are written (metres unless unknown), and pixels with the\n"
      "centre of the top left one at (0.5, 0.5).\n"
      "Exit code: 0 done, 1 failed, 2 usage, 3 done, but --check suspects a mistake in the calibration.\n"
      "spec/fvvimport.schema.json describes the output of --json.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError &error) {
    return app.exit(error) ? cli::usage : cli::done;
  }
  return cli::run("fvvimport", [&] { return work(a); });
}
