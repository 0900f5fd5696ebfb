// fvvimport: a calibration of another program as the cameras of a capture.json. Argument parsing and the
// order of work; the formats are fvv_scene's.
#include "cli/cli.h"
#include "cli/help.h"
#include "cli/max_memory.h"
#include "cli/output.h"
#include "fvv_scene/import.h"
#include "fvv_scene/inputs.h"
#include "fvvimport/options.h"
#include "fvvimport/sheet.h"
#include "fvvimport/summary.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <thread>

using namespace fvv;

namespace {

struct Arguments {
  std::string format, output, size, units, up = "unknown", rate = "25", pictures, videos, masks, meshes,
                                           points;
  std::optional<std::string> frames;
  std::vector<std::string> inputs;
  bool force = false, as_json = false;
  fvvimport::SheetOptions sheet;
};

[[noreturn]] void misuse(const std::string &what) {
  throw Error(what, Error::usage);
}

// Of a format with a file for each camera: these, or those of a folder.
std::vector<std::string> files_of(const std::vector<std::string> &inputs,
                                  const std::vector<const char *> &extensions) {
  std::error_code error;
  if (inputs.size() != 1 || !std::filesystem::is_directory(inputs[0], error)) return inputs;
  std::vector<std::string> files;
  std::filesystem::directory_iterator entry(inputs[0], error), end;
  for (; !error && entry != end; entry.increment(error))
    if (entry->path().filename() != "capture.json" && // of fvv, perhaps that of the run before
        std::find(extensions.begin(), extensions.end(), entry->path().extension()) != extensions.end())
      files.push_back(entry->path().string());
  if (error) throw Error(inputs[0] + ": cannot read the folder: " + error.message());
  if (files.empty()) {
    std::string names;
    for (size_t i = 0; i < extensions.size(); i++)
      names += std::string(!i ? "" : i + 1 < extensions.size() ? ", " : " or ") + extensions[i];
    throw Error(inputs[0] + ": expected files " + names + ", found none");
  }
  std::sort(files.begin(), files.end());
  return files;
}

// The files of a calibration.
std::vector<std::string> calibration_files(const Arguments &arguments) {
  const import::Format &format = *import::find_format(arguments.format);
  if (!format.extensions.empty()) return files_of(arguments.inputs, format.extensions);
  if (arguments.format == "colmap") return import::colmap_files(arguments.inputs[0]);
  if (arguments.format == "easymocap")
    return {arguments.inputs[0] + "/intri.yml", arguments.inputs[0] + "/extri.yml"};
  return arguments.inputs;
}

// A calibration's files, and points.
std::vector<std::string> files_read(const Arguments &arguments) {
  std::vector<std::string> files = calibration_files(arguments);
  if (!arguments.points.empty()) files.push_back(arguments.points);
  return files;
}

// Names of formats, as the help and messages list them: all, or those that take the size of pictures.
std::string names_of_formats(const char *between, bool with_size_alone) {
  std::string names;
  for (const import::Format &format : import::formats())
    if (!with_size_alone || format.size != import::Format::Size::stated)
      names += (names.empty() ? "" : between) + std::string(format.name);
  return names;
}

import::Calibration read(const Arguments &arguments){using Size = import::Format::Size;
const import::Format &format = *import::find_format(arguments.format);
if (!arguments.size.empty() && format.size == Size::stated)
  misuse("--size: expected for " + names_of_formats(", ", true) +
         " only, the other formats say how large pictures are");
if (arguments.size.empty() && format.size == Size::given)
  misuse("--size: expected WIDTHxHEIGHT of the pictures, which " + arguments.format + " does not say");
const fvvimport::Size size =
    arguments.size.empty() ? fvvimport::Size{0, 0} : fvvimport::parse_size(arguments.size);
if (format.extensions.empty() && arguments.inputs.size() != 1)
  misuse("INPUT: expected one for " + arguments.format + ", found " +
         std::to_string(arguments.inputs.size()));
return import::read(format, format.extensions.empty() ? arguments.inputs : calibration_files(arguments),
                    size.width, size.height);
} // namespace

// The format's own unit unless the user names another.
void set_units(const Arguments &arguments, const import::Calibration &calibration, scene::Capture &capture) {
  std::optional<double> metres;
  if (calibration.metres_per_unit > 0) metres = calibration.metres_per_unit;
  if (!arguments.units.empty()) metres = scene::parse_units(arguments.units);
  capture.scale_unknown = !metres;
  for (scene::Camera &camera : capture.cameras)
    for (double &coordinate : camera.calibration.translation) coordinate *= metres.value_or(1);
}

void set_files(const Arguments &arguments, scene::Capture &capture) {
  if (!arguments.meshes.empty())
    capture.meshes = fvvimport::parse_pattern("meshes", arguments.meshes, capture.frames);
  for (scene::Camera &camera : capture.cameras) {
    if (!arguments.pictures.empty())
      camera.pictures = fvvimport::parse_pattern("pictures", arguments.pictures, camera, capture.frames);
    if (!arguments.videos.empty())
      camera.pictures = fvvimport::parse_video("videos", arguments.videos, camera, capture.frames);
    if (!arguments.masks.empty())
      camera.masks = fvvimport::parse_pattern("masks", arguments.masks, camera, capture.frames);
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
  scene::Capture capture;
  capture.path = arguments.output;
  capture.frame_duration = scene::parse_frame_rate("frame-rate", arguments.rate);
  capture.frames = fvvimport::parse_frames(arguments.frames.value_or("0"));
  capture.up = scene::parse_up(arguments.up);
  const import::Calibration calibration = read(arguments);
  capture.cameras = calibration.cameras;
  set_units(arguments, calibration, capture);
  set_files(arguments, capture);
  fvvimport::Result result = {arguments.format, arguments.output, &capture, std::nullopt};
  if (!arguments.points.empty())
    result.diagnosis =
        import::diagnose(capture.cameras, import::read_observations(arguments.points, capture.cameras));
  if (!arguments.output.empty()) {
    const std::string text = scene::format_capture(capture);
    cli::OutputFile file(arguments.output, arguments.force, cli::inputs(files_read(arguments)));
    file.write(text.data(), text.size());
    file.commit();
  }
  if (arguments.as_json)
    std::printf("%s\n", fvvimport::json_summary(result).c_str());
  else if (arguments.output != "-")
    std::fputs(fvvimport::text_summary(result).c_str(), stdout);
  for (const std::string &note : calibration.notes)
    std::fprintf(stderr, "fvvimport: warning: %s: %s\n", arguments.inputs[0].c_str(), note.c_str());
  const bool suspected = result.diagnosis && result.diagnosis->suspected;
  return suspected || !calibration.notes.empty() ? cli::loss : cli::done;
}

// PATH of capture.json: what its cameras see, as a picture.
cli::Exit write_sheet(Arguments &arguments) {
  fvvimport::SheetOptions &sheet = arguments.sheet;
  if (arguments.inputs.size() != 1) misuse("INPUT: expected one capture");
  if (sheet.output.empty()) misuse("capture: expected --sheet FILE");
  if (!arguments.output.empty() || !arguments.points.empty())
    misuse("capture: expected neither -o nor --check");
  const bool piped = sheet.output == "-";
  if (piped && arguments.as_json) misuse("--json: standard output is taken by the sheet (--sheet -)");
  sheet.capture = arguments.inputs[0];
  sheet.force = arguments.force;
  if (arguments.frames) sheet.frames = fvv::parse_range("frames", *arguments.frames);
  const fvvimport::SheetReport report = fvvimport::check_calibration(sheet);
  const std::string text = arguments.as_json
                               ? fvvimport::sheet_json(report).dump(
                                     2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) +
                                     "\n"
                               : fvvimport::sheet_text(report);
  if (!piped) std::fputs(text.c_str(), stdout);
  return report.warnings.empty() ? cli::done : cli::loss;
}

} // namespace

int main(int argc, char **argv) {
  CLI::App app("Reads a calibration of another program and writes its cameras as a capture.json.");
  Arguments a;
  a.sheet.threads = std::clamp(std::thread::hardware_concurrency(), 1u, 256u);
  std::vector<std::string> names = {"capture"};
  for (const import::Format &format : import::formats()) names.push_back(format.name);
  app.add_option("FORMAT", a.format,
                 names_of_formats(", ", false) + ", or capture: a capture.json to look at (--sheet)")
      ->required()
      ->check(CLI::IsMember(names).description(""))
      ->type_name(names_of_formats("|", false) + "|capture");
  app.add_option("INPUT", a.inputs,
                 "colmap: folder of a model, binary or text, or of a project; easymocap: folder of intri.yml "
                 "and extri.yml; opencv, krt, realitycapture: a file for each camera, or their folder; "
                 "capture: capture.json "
                 "or its folder; others: a file")
      ->required()
      ->type_name("FILE");
  app.add_option("-o,--output", a.output, "capture.json to write")->type_name("FILE.json");
  auto *pictures = app.add_option("--pictures", a.pictures,
                                  "pictures of a camera, with {name} or {id}, and %d or %0Nd for the frame")
                       ->type_name("PATTERN");
  app.add_option("--videos", a.videos,
                 "instead: a video of each camera, with {name} or {id}, which begins with the first frame")
      ->type_name("FILE")
      ->excludes(pictures);
  app.add_option("--masks", a.masks, "silhouettes: a pattern, or videos, as of --pictures and --videos")
      ->type_name("PATTERN");
  app.add_option("--meshes", a.meshes,
                 "meshes, in metres; with units unknown, in the units of the calibration")
      ->type_name("PATTERN");
  app.add_option(
         "--units", a.units,
         "of the calibration: metres, centimetres, millimetres, inches, feet, metres per unit as a number, "
         "or unknown (default, but qualisys: millimetres, panoptic: centimetres, kalibr and scaled "
         "metashape: metres); cameras are written in metres")
      ->type_name("UNIT");
  app.add_option("--up", a.up, "world axis that points up: +x, -x, +y, -y, +z, -z; default unknown")
      ->type_name("AXIS");
  app.add_option("--frame-rate", a.rate, "frames per second; default 25")->type_name("N[/D]");
  app.add_option("--frames", a.frames, "first and last frame number, like 0-49; default 0")->type_name("A-B");
  app.add_option("--size", a.size,
                 "width and height of the pictures, for middlebury, krt, realitycapture and easymocap")
      ->type_name("WxH");
  app.add_option("--check", a.points, "lines X Y Z CAMERA_ID U V: tell how well the cameras explain them")
      ->type_name("FILE");
  auto *sheet =
      app.add_option(
             "--sheet", a.sheet.output,
             "of a capture: write this PNG, every camera's picture of the middle frame (of --frames), with "
             "the outline of the mesh, or of the hull of the masks")
          ->type_name("FILE.png");
  app.add_option("--sheet-width", a.sheet.width, "longest side of its panels, at most, in pixels")
      ->check(CLI::Range(120, 2048))
      ->capture_default_str()
      ->needs(sheet);
  a.sheet.memory = {cli::max_memory_default, cli::max_memory_option};
  cli::add_max_memory(app, a.sheet.memory.bytes, "that decoding one file for the sheet may take")
      ->needs(sheet);
  app.add_flag("!--no-meshes", a.sheet.meshes, "outline the hull of the masks in place of the mesh")
      ->needs(sheet);
  app.add_option("--cameras", a.sheet.cameras,
                 "cameras of the sheet, by identifier, range or name: 0-3,7,overhead")
      ->delimiter(',')
      ->needs(sheet);
  app.add_option("--threads", a.sheet.threads,
                 "threads for the sheet; the picture is the same for any number")
      ->check(CLI::Range(1, 256))
      ->needs(sheet);
  app.add_flag("--json", a.as_json, "print a summary as JSON");
  app.add_flag("--force", a.force, "replace the file when it exists (docs/tools/outputs.md)");
  app.footer(
      "--check takes points in the units that are written (metres unless unknown), and pixels with the\n"
      "centre of the top left one at (0.5, 0.5).\n"
      "Exit code: 0 done, 1 failed, 2 usage, 3 done, but --check suspects a mistake in the calibration.\n"
      "spec/fvvimport.schema.json describes the output of --json.");
  cli::set_help(
      app, "fvvimport",
      {
          "fvvimport colmap sparse/0 --pictures 'images/{name}/%04d.png' --frames 0-49 -o capture.json",
          "fvvimport capture players --sheet sheet.png",
      });
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError &error) {
    return cli::end_of_parsing(app, error);
  }
  return cli::run("fvvimport", [&] { return a.format == "capture" ? write_sheet(a) : work(a); });
}
