#include "fvvrender/command.h"

#include "cli/cli.h"
#include "cli/help.h"
#include "cli/max_memory.h"
#include "fvv_scene/file_io.h"
#include "fvvrender/film.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <thread>

namespace fvv::rendering {

namespace {

render::Vec3 colour_of(const std::string &option, const std::vector<int> &codes) {
  for (const int code : codes)
    if (code < 0 || code > 255)
      throw Error(option + ": expected three numbers from 0 to 255, found " + std::to_string(code),
                  Error::usage);
  return {codes[0] / 255.0, codes[1] / 255.0, codes[2] / 255.0};
}

// "25" or "30000/1001".
fvv_rational rate_of(const std::string &text) {
  const std::optional<fvv_rational> rate = scene::parse_rational(text);
  if (!rate || !rate->numerator || std::max(rate->numerator, rate->denominator) > INT32_MAX)
    throw Error("--fps: expected a number like 25 or a fraction like 30000/1001, found \"" + text + "\"",
                Error::usage);
  return *rate;
}

const std::vector<cli::HelpSection> shown = {
    {"What is drawn",
     {{"IN", "fvv file"},
      {"-o, --output FILE", "a picture: .png, or .exr for linear light; a film: .mp4, or FOLDER/%04d.png"},
      {"--frame N", "number in the stream, from 0"},
      {"--rung N", "of a stream with several rungs, from 0, the best"},
      {"--size WxH", "default: the camera's, with a pose 960x540"},
      {"--samples N", "of a pixel along its side: 1 (default), 3, 5 or 7"}}},
    {"From where",
     {{"--camera N", "what the camera with this identifier sees"},
      {"--pose NUMBERS", "eye, a point to look at, up: EX,EY,EZ,TX,TY,TZ[,UX,UY,UZ], metres"},
      {"--focal N", "focal length in pixels, with a pose"}}},
    {"Films (docs/tools/fvvrender.md)",
     {{"--orbit N", "walk around the action by this angle in degrees: 360"},
      {"--target X,Y,Z", "of an orbit; and --height, --radius"},
      {"--path FILE.json", "walk along keyframes"},
      {"--frames A-B", "a range of the stream; default: all"},
      {"--count N", "pictures of one frame, while time is still"},
      {"--fps RATE", "pictures a second; default: the stream's"}}},
    {"Texture",
     {{"--sources LIST", "cameras to take it from; --exclude LIST, --leave-one-out"},
      {"--blend HOW", "viewer, or paper: as in 2012; and --threshold, --best, --inset"},
      {"--visible-by HOW", "bits, depth or rays"},
      {"--no-environment", "the action alone; --background R,G,B"}}},
    {"More",
     {{"--depth FILE.exr", "also the depth; and --weights, --visibility, --mask"},
      {"--json", "print what was drawn as JSON"},
      {"--force", "replace existing files (docs/tools/outputs.md)"},
      {"--help-all", "all options"},
      {"--version", "of fvvrender"}}}};

} // namespace

Command::Command(CLI::App &app) {
  given.draw.threads = std::clamp(std::thread::hardware_concurrency(), 1u, 256u);
  given.load.memory = {cli::max_memory_default, cli::max_memory_option};
  add_picture(app);
  add_viewpoint(app);
  add_film(app);
  add_texture(app);
  add_layers(app);
  add_running(app);
  app.footer(
      "Exit code: 0 done, 1 nothing written, 2 usage, 3 written without cameras that the file has lost.\n"
      "spec/fvvrender.schema.json describes the output of --json.");
  cli::set_help(app, "fvvrender",
                {
                    "fvvrender players.fvv --frame 25 --camera 0 -o view.png",
                    "fvvrender players.fvv --pose 1.5,1.6,3.2,0,1,0 --samples 3 -o view.png",
                    "fvvrender players.fvv --orbit 360 -o turn.mp4",
                },
                shown);
}

void Command::add_picture(CLI::App &app) {
  app.add_option("IN", given.input, "fvv file")->required()->type_name("FILE.fvv");
  app.add_option("-o,--output", given.output,
                 "picture to write: .png, or .exr for linear light, beyond white where the stream has it; a "
                 "film: .mp4 (H.264), or FOLDER/%04d.png")
      ->required()
      ->type_name("FILE.png|exr|mp4");
  frame_option = app.add_option("--frame", given.frame, "number in the stream, from 0")
                     ->check(CLI::Range(0, INT32_MAX))
                     ->capture_default_str();
  app.add_option("--rung", given.load.rung,
                 "of a stream with several rungs: 0 is the best, a number beyond the last means the last")
      ->check(CLI::Range(0, 65535))
      ->capture_default_str();
  app.add_option("--size", size, "of the picture; default: the camera's, with --pose 960x540")
      ->type_name("WxH");
  app.add_option("--samples", given.draw.view.samples, "of a pixel along its side: 1, 3, 5 or 7")
      ->check(CLI::IsMember({1, 3, 5, 7}))
      ->capture_default_str();
}

void Command::add_viewpoint(CLI::App &app) {
  app.add_option("--camera", given.draw.target.camera, "draw what the camera with this identifier sees");
  app.add_option("--pose", given.draw.target.pose,
                 "draw from here: EX,EY,EZ,TX,TY,TZ[,UX,UY,UZ], eye, a point to look at, up (default: the "
                 "stream's); metres")
      ->delimiter(',')
      ->expected(6, 9)
      ->type_name("NUMBERS");
  app.add_option("--focal", given.draw.target.focal,
                 "focal length in pixels, not with --camera; default: the width")
      ->check(CLI::Range(1e-3, 1e9));
}

void Command::add_film(CLI::App &app) {
  of_films = {
      app.add_option("--orbit", given.film.orbit,
                     "a film: walk around the action by this angle in degrees, counterclockwise from above")
          ->check(CLI::Range(-36000.0, 36000.0)),
      app.add_option("--path", given.film.path,
                     "a film: walk along these keyframes, .json (docs/tools/fvvrender.md)")
          ->type_name("FILE.json"),
      app.add_option("--frames", frames, "of a film: a range of the stream, 10-35; default: all")
          ->type_name("A-B"),
      app.add_option("--count", given.film.count,
                     "of a film: that many pictures of --frame, in which time is still")
          ->check(CLI::Range(1, 100000)),
      app.add_option("--fps", fps, "of a film: pictures a second, 25 or 30000/1001; default: the stream's")
          ->type_name("N[/D]")};
  of_orbits = {
      app.add_option("--target", film_target, "of --orbit: the point to look at; default: the middle")
          ->delimiter(',')
          ->expected(3)
          ->type_name("X,Y,Z"),
      app.add_option("--height", given.film.height, "of --orbit: metres above that point")
          ->check(CLI::Range(-1e6, 1e6)),
      app.add_option("--radius", given.film.radius, "of --orbit: metres; default: all of the action is seen")
          ->check(CLI::Range(1e-6, 1e6))};
}

void Command::add_texture(CLI::App &app) {
  const std::map<std::string, render::Visibility> tests = {{"bits", render::Visibility::given},
                                                           {"depth", render::Visibility::depth_map},
                                                           {"rays", render::Visibility::rays}};
  const std::map<std::string, render::Blend> blends = {{"viewer", render::Blend::viewer},
                                                       {"paper", render::Blend::paper}};
  app.add_option("--sources", sources, "cameras to take texture from, 0-9,25; default: all");
  app.add_option("--exclude", excluded, "cameras to leave out: 3 or 0-9,25");
  app.add_flag("!--no-pictures", given.draw.pictures,
               "show the mesh in the colours of its vertices, shaded, as a player does without pictures");
  app.add_flag("--leave-one-out", given.draw.leave_one_out, "take no texture from the camera of --camera");
  app.add_option("--blend", given.draw.blend,
                 "weight cameras by the viewer's direction (viewer), or by the normal alone, as the paper of "
                 "2012 did (paper); default: the stream's, else viewer")
      ->transform(CLI::CheckedTransformer(blends).description(""))
      ->type_name("viewer|paper");
  app.add_option("--threshold", given.draw.threshold,
                 "least cosine between normal and ray to a camera; default: the stream's, else that of the "
                 "blend, 0.05 or 0.25")
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--best", given.draw.best, "cameras that are blended at most; default: the stream's, else 3")
      ->check(CLI::Range(1u, render::max_best));
  app.add_option(
         "--inset", given.draw.inset,
         "metres from the mesh inward to the surface that cameras show; default: the stream's, else 0")
      ->check(CLI::Range(0.0, 1e6));
  visible_by =
      app.add_option("--visible-by", given.draw.view.visibility,
                     "bits of the stream, of other cameras depth maps (default where the frame has bits); "
                     "depth: depth maps of all; rays: exact")
          ->transform(CLI::CheckedTransformer(tests).description(""))
          ->type_name("bits|depth|rays");
  app.add_flag("!--no-environment", given.draw.environment,
               "draw the action alone, without the stream's environment (unlit, without shadows)");
  app.add_option("--background", background, "colour behind all, R,G,B, 0 to 255; default black")
      ->delimiter(',')
      ->expected(3)
      ->type_name("R,G,B");
  unseen_option =
      app.add_option(
             "--unseen", unseen,
             "colour of what no camera shows; default: the colours of vertices if the stream has some, else "
             "the stream's, else grey, 128,128,128")
          ->delimiter(',')
          ->expected(3)
          ->type_name("R,G,B");
}

void Command::add_layers(CLI::App &app) {
  app.add_option("--depth", given.depth, "also write the depth, z in metres: .exr")->type_name("FILE.exr");
  app.add_option("--weights", given.weights, "also write each camera's weight: .exr")->type_name("FILE.exr");
  app.add_option("--visibility", given.visibility,
                 "also write which cameras see each point well enough: .exr")
      ->type_name("FILE.exr");
  app.add_option("--mask", given.mask, "also write where the mesh is: .png")->type_name("FILE.png");
}

void Command::add_running(CLI::App &app) {
  cli::add_max_memory(app, given.load.memory.bytes);
  app.add_flag("--json", as_json, "print what was drawn as JSON");
  app.add_flag("--force", given.force, "replace existing files (docs/tools/outputs.md)");
  app.add_option("--threads", given.draw.threads, "default: one for each processor; the picture is the same")
      ->check(CLI::Range(1, 256));
}

void Command::check_film() const {
  const Film &film = given.film;
  if (film.count.has_value() != bool(*frame_option))
    throw Error("expected --frame and --count together for a film in which time is still, or neither",
                Error::usage);
  if (film.count && frames) throw Error("expected one of --frames and --count, found both", Error::usage);
  for (const std::string *file : {&given.depth, &given.weights, &given.visibility, &given.mask})
    if (!file->empty())
      throw Error("--depth, --weights, --visibility and --mask: expected with a single picture",
                  Error::usage);
  if (film.orbit) return;
  for (const CLI::Option *option : of_orbits)
    if (*option) throw Error(option->get_name() + ": expected with --orbit", Error::usage);
}

void Command::take_film() {
  if (frames) given.film.frames = demux::Selection::parse("frames", *frames);
  if (fps) given.film.fps = rate_of(*fps);
  if (film_target.empty()) return;
  for (const double value : film_target)
    if (!(std::abs(value) <= 1e6)) throw Error("--target: expected numbers within 1e6", Error::usage);
  given.film.target = render::Vec3{film_target[0], film_target[1], film_target[2]};
}

Options Command::options() {
  view::Options &draw = given.draw;
  given.load.pictures = draw.pictures;
  draw.view.keep_visibility = !given.visibility.empty();
  draw.visible_by_default = !*visible_by;
  if (size) {
    draw.target.size.emplace();
    cli::parse_size("--size", *size, draw.target.size->width, draw.target.size->height);
  }
  if (sources) draw.sources = demux::Selection::parse("sources", *sources);
  if (excluded) draw.excluded = demux::Selection::parse("exclude", *excluded);
  draw.view.background = colour_of("--background", background);
  if (*unseen_option) draw.unseen = colour_of("--unseen", unseen);
  const bool film = is_film(given.output);
  for (const auto *list : {&of_films, &of_orbits})
    for (const CLI::Option *option : *list)
      if (*option && !film)
        throw Error(option->get_name() + ": expected with a film, -o NAME.mp4 or FOLDER/%04d.png",
                    Error::usage);
  if (film) check_film();
  take_film();
  return given;
}

} // namespace fvv::rendering
