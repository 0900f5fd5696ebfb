// fvvsynth: writes a made-up capture, so that a fresh machine needs no data. Argument parsing only.
#include "cli/cli.h"
#include "cli/help.h"
#include "cli/output.h"
#include "fvv_geometry/hull.h"
#include "fvvsynth/atlas.h"
#include "fvvsynth/capture_writer.h"
#include "fvvsynth/footage/footage.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <map>
#include <thread>

namespace {

const std::map<std::string, fvv::synth::Meshes> mesh_kinds = {{"tracked", fvv::synth::Meshes::tracked},
                                                              {"remeshed", fvv::synth::Meshes::remeshed},
                                                              {"hull", fvv::synth::Meshes::hull}};

const std::map<std::string, fvv::synth::RigKind> rigs = {{"small", fvv::synth::RigKind::small},
                                                         {"studio", fvv::synth::RigKind::studio},
                                                         {"arc", fvv::synth::RigKind::arc}};

const std::map<std::string, fvv::synth::SceneKind> scenes = {{"practice", fvv::synth::SceneKind::practice},
                                                             {"game", fvv::synth::SceneKind::game}};

const std::map<std::string, fvv::synth::Pictures> picture_kinds = {{"png", fvv::synth::Pictures::png},
                                                                   {"jpeg", fvv::synth::Pictures::jpeg},
                                                                   {"exr", fvv::synth::Pictures::exr}};

} // namespace

int main(int argc, char **argv) {
  CLI::App app("Writes a made-up capture of two basketball players: meshes, calibrated pictures and masks.");
  std::string output, size, scene_kind = "practice", rig = "studio", rate = "25", meshes = "tracked",
                            pictures = "png";
  fvv::synth::Settings settings;
  fvv::synth::Recording recording;
  fvv::synth::Shoot shoot;
  bool force = false, realistic = false, atlas = false;
  uint32_t atlas_size = fvv::synth::default_atlas_size;
  settings.threads = std::clamp(std::thread::hardware_concurrency(), 1u, 64u);
  app.add_option("-o,--output", output, "Folder to write")->required()->type_name("FOLDER");
  app.add_option("--seed", settings.seed, "Chooses looks, places and cameras")->capture_default_str();
  app.add_option("--scene", scene_kind, "Two players pass a ball (4 s), or play for a shot at a hoop (10 s)")
      ->check(CLI::IsMember(scenes))
      ->capture_default_str()
      ->type_name("practice|game");
  app.add_option("--frames", recording.frames, "Number of frames")
      ->check(CLI::Range(1, 9999))
      ->capture_default_str();
  app.add_option(
         "--rig", rig,
         "7 alike cameras, 13 unlike ones (some distort, one pans and zooms), or alike ones a degree apart")
      ->check(CLI::IsMember(rigs))
      ->capture_default_str()
      ->type_name("small|studio|arc");
  const auto *cameras =
      app.add_option("--cameras", settings.cameras, "Number of cameras of the rigs small and arc")
          ->check(CLI::Range(1, 64))
          ->capture_default_str();
  app.add_option(
         "--size", size,
         "Width and height of the pictures (studio: of most of them); default 480x270, studio 960x540")
      ->type_name("WxH");
  app.add_option("--fps", rate, "Frames per second, a number or a fraction")
      ->capture_default_str()
      ->type_name("N[/D]");
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
  const auto *atlas_side = app.add_option("--atlas-size", atlas_size, "Width and height of atlas.png")
                               ->check(CLI::IsMember({512, 1024, 2048}))
                               ->capture_default_str();
  const auto *hull_cells =
      app.add_option("--hull-cells", recording.hull_cells,
                     "Cells along the longest side of the hull's grid; default 220, studio 236")
          ->check(CLI::Range(24, 1200));
  app.add_flag("--depth", recording.depth, "Also write the depth of every picture, in OpenEXR");
  app.add_flag("--visibility", recording.visibility,
               "Also write which faces and vertices of the meshes each camera sees, by ray casting");
  app.add_flag("--environment", recording.environment,
               "Also write floor, walls and lamps as background.glb, for players to draw around the action");
  app.add_flag(
      "--sound", recording.sound,
      "Also write sound: a clap in every second, at which the pictures of one frame flash, and the ball; of "
      "the game shoes and the ball, without flashes");
  app.add_option("--threads", settings.threads, "Threads; the result is the same for any number")
      ->check(CLI::Range(1, 64));
  auto &film = recording.realism;
  const auto *noise = app.add_option("--noise", film.noise, "Sensor noise, 1 as of a good camera")
                          ->check(CLI::Range(0.0, 100.0))
                          ->capture_default_str()
                          ->type_name("STRENGTH");
  const auto *exposure =
      app.add_option("--exposure", film.exposure, "Cameras differ in exposure by up to so much either way")
          ->check(CLI::Range(0.0, 4.0))
          ->capture_default_str()
          ->type_name("STOPS");
  const auto *shutter = app.add_option("--motion-blur", film.shutter,
                                       "Share of a frame for which the shutter is open; 0.5 is 180 degrees")
                            ->check(CLI::Range(0.0, 1.0))
                            ->capture_default_str()
                            ->type_name("SHARE");
  app.add_flag("--realistic", realistic, "As --noise 1 --exposure 0.3 --motion-blur 0.5, each if not given");
  app.add_flag("--frame-numbers", film.labels, "Camera and frame number in the top left corner of pictures");
  auto *footage = app.add_flag("--footage",
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
  app.add_flag("--force", force, "Replace the folder if fvvsynth wrote it (docs/tools/outputs.md)");
  fvv::cli::set_help(app, "fvvsynth",
                     {
                         "fvvsynth -o players",
                         "fvvsynth -o hulls --rig small --meshes hull --frames 10",
                     });
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError &error) {
    return fvv::cli::end_of_parsing(app, error);
  }
  return fvv::cli::run("fvvsynth", [&] {
    settings.still = footage->count() > 0;
    // So that either rig's hulls have about 35,000 triangles.
    settings.rig = rigs.at(rig);
    settings.kind = scenes.at(scene_kind);
    if (hull_cells->count() == 0 && settings.rig == fvv::synth::RigKind::studio) recording.hull_cells = 236;
    const bool real = realistic || settings.still;
    if (real && noise->count() == 0) film.noise = fvv::synth::default_noise;
    if (real && exposure->count() == 0) film.exposure = fvv::synth::default_exposure;
    if (realistic && shutter->count() == 0) film.shutter = fvv::synth::default_shutter;
    recording.rate = fvv::synth::parse_frame_rate(rate);
    recording.threads = settings.threads;
    recording.meshes = mesh_kinds.at(meshes);
    if (recording.meshes == fvv::synth::Meshes::hull && settings.rig != fvv::synth::RigKind::studio &&
        settings.cameras < fvv::hull::hull_cameras)
      throw fvv::Error("--meshes hull: expected 3 cameras or more, found --cameras " +
                           std::to_string(settings.cameras),
                       fvv::Error::usage);
    if (atlas && recording.meshes != fvv::synth::Meshes::tracked)
      throw fvv::Error("--atlas: expected with --meshes tracked only, found --meshes " + meshes,
                       fvv::Error::usage);
    if (!atlas && atlas_side->count() > 0)
      throw fvv::Error("--atlas-size: expected with --atlas only", fvv::Error::usage);
    if (atlas) recording.atlas = atlas_size;
    const bool game = settings.kind == fvv::synth::SceneKind::game;
    if (game && (recording.meshes != fvv::synth::Meshes::tracked || atlas))
      throw fvv::Error("--scene game: expected with --meshes tracked and without --atlas only",
                       fvv::Error::usage);
    film.claps = recording.sound && !game;
    recording.pictures = picture_kinds.at(pictures);
    if (recording.pictures == fvv::synth::Pictures::exr && film.labels)
      throw fvv::Error("--frame-numbers: expected with --pictures png or jpeg only", fvv::Error::usage);
    if (settings.rig == fvv::synth::RigKind::studio && cameras->count() > 0)
      throw fvv::Error("--cameras: expected with --rig small or arc, the studio has 13", fvv::Error::usage);
    if (size.empty())
      size = settings.still                                ? "1280x720"
             : settings.rig == fvv::synth::RigKind::studio ? "960x540"
                                                           : "480x270";
    fvv::cli::parse_size("--size", size, settings.width, settings.height);
    fvv::cli::OutputFolder folder(output, force);
    try {
      const fvv::synth::Scene scene(settings);
      if (settings.still) {
        shoot.frames = recording.frames;
        shoot.rate = recording.rate;
        shoot.realism = recording.realism;
        shoot.threads = recording.threads;
        fvv::synth::write_footage(scene, shoot, folder);
      } else {
        fvv::synth::write_capture(scene, recording, folder);
      }
    } catch (const std::invalid_argument &error) {
      throw fvv::Error(error.what(), fvv::Error::usage);
    }
    folder.commit();
    return fvv::cli::done;
  });
}
