#include "fvvsynth/command.h"

#include "cli/cli.h"
#include "cli/help.h"
#include "fvv_geometry/hull.h"

#include <algorithm>
#include <map>
#include <thread>

namespace fvv::synth {

namespace {

const std::map<std::string, Meshes> mesh_kinds = {
    {"tracked", Meshes::tracked}, {"remeshed", Meshes::remeshed}, {"hull", Meshes::hull}};

const std::map<std::string, RigKind> rigs = {
    {"small", RigKind::small}, {"studio", RigKind::studio}, {"arc", RigKind::arc}};

const std::map<std::string, SceneKind> scenes = {{"practice", SceneKind::practice},
                                                 {"game", SceneKind::game}};

const std::map<std::string, Pictures> picture_kinds = {
    {"png", Pictures::png}, {"jpeg", Pictures::jpeg}, {"exr", Pictures::exr}};

[[noreturn]] void refuse(const std::string &line) {
  throw Error(line, Error::usage);
}

} // namespace

Command::Command(CLI::App &app) {
  settings.threads = std::clamp(std::thread::hardware_concurrency(), 1u, 64u);
  app.add_option("-o,--output", output, "Folder to write")->required()->type_name("FOLDER");
  add_scene(app);
  add_rig(app);
  add_files(app);
  add_realism(app);
  add_footage(app);
  add_running(app);
  cli::set_help(app, "fvvsynth",
                {
                    "fvvsynth -o players",
                    "fvvsynth -o hulls --rig small --meshes hull --frames 10",
                });
}

void Command::add_scene(CLI::App &app) {
  app.add_option("--seed", settings.seed, "Chooses looks, places and cameras")->capture_default_str();
  app.add_option("--scene", scene_kind, "Two players pass a ball (4 s), or play for a shot at a hoop (10 s)")
      ->check(CLI::IsMember(scenes))
      ->capture_default_str()
      ->type_name("practice|game");
  app.add_option("--frames", recording.frames, "Number of frames")
      ->check(CLI::Range(1, 9999))
      ->capture_default_str();
}

void Command::add_rig(CLI::App &app) {
  app.add_option(
         "--rig", rig,
         "7 alike cameras, 13 unlike ones (some distort, one pans and zooms), or alike ones a degree apart")
      ->check(CLI::IsMember(rigs))
      ->capture_default_str()
      ->type_name("small|studio|arc");
  cameras = app.add_option("--cameras", settings.cameras, "Number of cameras of the rigs small and arc")
                ->check(CLI::Range(1, 64))
                ->capture_default_str();
  app.add_option(
         "--size", size,
         "Width and height of the pictures (studio: of most of them); default 480x270, studio 960x540")
      ->type_name("WxH");
  app.add_option("--fps", rate, "Frames per second, a number or a fraction")
      ->capture_default_str()
      ->type_name("N[/D]");
}

void Command::add_files(CLI::App &app) {
  app.add_option("--meshes", meshes, "Same triangles in all frames, others in each, or hulls of the masks")
      ->check(CLI::IsMember(mesh_kinds))
      ->capture_default_str()
      ->type_name("tracked|remeshed|hull");
  app.add_option("--pictures", pictures,
                 "8 bits without loss or in JPEG, or linear light as half floats in OpenEXR, with highlights "
                 "beyond white")
      ->check(CLI::IsMember(picture_kinds))
      ->capture_default_str()
      ->type_name("png|jpeg|exr");
  app.add_flag("--atlas", atlas,
               "Give tracked meshes texture coordinates, and write atlas.png, their colours without light");
  atlas_side = app.add_option("--atlas-size", atlas_size, "Width and height of atlas.png")
                   ->check(CLI::IsMember({512, 1024, 2048}))
                   ->capture_default_str();
  hull_cells = app.add_option("--hull-cells", recording.hull_cells,
                              "Cells along the longest side of the hull's grid; default 220, studio 236")
                   ->check(CLI::Range(24, 1200));
  app.add_flag("--depth", recording.depth, "Also write the depth of every picture, in OpenEXR");
  app.add_flag("--visibility", recording.visibility,
               "Also write which faces and vertices of the meshes each camera sees, by ray casting");
  app.add_flag("--environment", recording.environment,
               "Also write floor, walls and lamps as environment.glb, for players to draw around the action");
  app.add_flag(
      "--sound", recording.sound,
      "Also write sound: a clap in every second, at which the pictures of one frame flash, and the ball; of "
      "the game shoes and the ball, without flashes");
}

void Command::add_realism(CLI::App &app) {
  noise = app.add_option("--noise", recording.realism.noise, "Sensor noise, 1 as of a good camera")
              ->check(CLI::Range(0.0, 100.0))
              ->capture_default_str()
              ->type_name("STRENGTH");
  exposure = app.add_option("--exposure", recording.realism.exposure,
                            "Cameras differ in exposure by up to so much either way")
                 ->check(CLI::Range(0.0, 4.0))
                 ->capture_default_str()
                 ->type_name("STOPS");
  shutter = app.add_option("--motion-blur", recording.realism.shutter,
                           "Share of a frame for which the shutter is open; 0.5 is 180 degrees")
                ->check(CLI::Range(0.0, 1.0))
                ->capture_default_str()
                ->type_name("SHARE");
  app.add_flag("--realistic", realistic, "As --noise 1 --exposure 0.3 --motion-blur 0.5, each if not given");
  app.add_flag("--frame-numbers", recording.realism.labels,
               "Camera and frame number in the top left corner of pictures");
}

void Command::add_footage(CLI::App &app) {
  footage = app.add_flag("--footage",
                         "Instead of a capture, films of 11 cameras of the studio as for fvvcapture: a "
                         "board, the empty stage, the action; with noise and unlike exposure");
  for (const char *option :
       {"--scene", "--rig", "--cameras", "--meshes", "--pictures", "--atlas", "--hull-cells", "--depth",
        "--visibility", "--environment", "--sound", "--frame-numbers"})
    footage->excludes(option);
  app.add_option("--poses", shoot.poses, "Poses of the board")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str()
      ->needs(footage);
  app.add_option("--late", shoot.late, "Clocks of cameras are late by less than this; 0: not at all")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str()
      ->type_name("SECONDS")
      ->needs(footage);
}

void Command::add_running(CLI::App &app) {
  app.add_option("--threads", settings.threads, "Threads; the result is the same for any number")
      ->check(CLI::Range(1, 64));
  app.add_flag("--force", force, "Replace the folder if fvvsynth wrote it (docs/tools/outputs.md)");
}

void Command::settle_realism() {
  const bool real = realistic || settings.still;
  if (real && noise->count() == 0) recording.realism.noise = default_noise;
  if (real && exposure->count() == 0) recording.realism.exposure = default_exposure;
  if (realistic && shutter->count() == 0) recording.realism.shutter = default_shutter;
}

void Command::settle_files() {
  recording.meshes = mesh_kinds.at(meshes);
  if (recording.meshes == Meshes::hull && settings.rig != RigKind::studio &&
      settings.cameras < hull::hull_cameras)
    refuse("--meshes hull: expected 3 cameras or more, found --cameras " + std::to_string(settings.cameras));
  if (atlas && recording.meshes != Meshes::tracked)
    refuse("--atlas: expected with --meshes tracked only, found --meshes " + meshes);
  if (!atlas && atlas_side->count() > 0) refuse("--atlas-size: expected with --atlas only");
  if (atlas) recording.atlas = atlas_size;
  const bool game = settings.kind == SceneKind::game;
  if (game && (recording.meshes != Meshes::tracked || atlas))
    refuse("--scene game: expected with --meshes tracked and without --atlas only");
  recording.realism.claps = recording.sound && !game;
  recording.pictures = picture_kinds.at(pictures);
  if (recording.pictures == Pictures::exr && recording.realism.labels)
    refuse("--frame-numbers: expected with --pictures png or jpeg only");
}

void Command::settle_rig() {
  const bool studio = settings.rig == RigKind::studio;
  if (studio && cameras->count() > 0)
    refuse("--cameras: expected with --rig small or arc, the studio has 13");
  if (size.empty()) size = settings.still ? "1280x720" : studio ? "960x540" : "480x270";
  cli::parse_size("--size", size, settings.width, settings.height);
}

void Command::settle() {
  settings.still = footage->count() > 0;
  settings.rig = rigs.at(rig);
  settings.kind = scenes.at(scene_kind);
  // So that either rig's hulls have about 35,000 triangles.
  if (hull_cells->count() == 0 && settings.rig == RigKind::studio) recording.hull_cells = 236;
  settle_realism();
  recording.rate = parse_frame_rate(rate);
  recording.threads = settings.threads;
  settle_files();
  settle_rig();
  shoot.frames = recording.frames;
  shoot.rate = recording.rate;
  shoot.realism = recording.realism;
  shoot.threads = recording.threads;
}

} // namespace fvv::synth
