// fvvdemux: a stream as the files of a capture: meshes, pictures, calibration.
#include "cli/cli.h"
#include "cli/help.h"
#include "cli/max_memory.h"
#include "fvvdemux/demux.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

using namespace fvv;

namespace {

std::string summary(const std::string &file, const demux::Result &result) {
  nlohmann::ordered_json pictures = nlohmann::ordered_json::object();
  for (const auto &[camera, count] : result.pictures) pictures[std::to_string(camera)] = count;
  const nlohmann::ordered_json document = {
      {"fvvdemux", 1},
      {"file", file},
      {"frames", {{"in_stream", result.frames_in_stream}, {"written", result.frames_written}}},
      {"meshes", result.meshes},
      {"mesh_files", result.mesh_files},
      {"pictures", pictures},
      {"atlas", result.atlases},
      {"capture", result.capture},
      {"environment", result.environment},
      {"audio", result.sounds},
      {"data", result.data},
      {"films", result.films},
      {"losses", result.losses},
      {"warnings", result.warnings}};
  return document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

void tell(const std::string &file, const demux::Result &result) {
  for (const std::string &text : result.warnings) cli::warn(file + ": " + text);
  for (const std::string &line : result.losses) std::fprintf(stderr, "%s\n", line.c_str());
}

} // namespace

int main(int argc, char **argv) {
  CLI::App app{"Unpack an fvv file into meshes, pictures and capture.json."};
  std::string input, output;
  std::optional<std::string> frames, cameras;
  demux::Options options;
  options.threads = std::max(1u, std::thread::hardware_concurrency());
  options.memory = {cli::max_memory_default, cli::max_memory_option};
  bool as_json = false;
  const std::map<std::string, demux::Meshes> meshes = {
      {"ply", demux::Meshes::ply}, {"obj", demux::Meshes::obj},   {"drc", demux::Meshes::drc},
      {"glb", demux::Meshes::glb}, {"gltf", demux::Meshes::gltf}, {"none", demux::Meshes::none}};
  const std::map<std::string, scene::Compression> compressions = {{"draco", scene::Compression::draco},
                                                                  {"meshopt", scene::Compression::meshopt}};
  const std::map<std::string, demux::Pictures> pictures = {{"png", demux::Pictures::png},
                                                           {"jpg", demux::Pictures::jpg},
                                                           {"exr", demux::Pictures::exr},
                                                           {"none", demux::Pictures::none}};
  app.add_option("IN", input, "fvv file")->required()->type_name("FILE.fvv");
  app.add_option("-o,--output", output, "folder to write")->required()->type_name("FOLDER");
  app.add_option("--frames", frames, "numbers in the stream, from 0: 25 or 0-9,25; default: all");
  app.add_option("--cameras", cameras, "identifiers: 3 or 0-9,25; default: all");
  app.add_option("--rung", options.rung,
                 "of a stream with several rungs: 0 is the best, a number beyond the last means the last")
      ->check(CLI::Range(0, 65535))
      ->capture_default_str();
  app.add_option(
         "--meshes,--format", options.meshes,
         "ply (default), obj, drc; glb (glTF 2.0, +y up, with its texture); gltf (animated: one glb of "
         "frames that share their faces); none")
      ->transform(CLI::CheckedTransformer(meshes).description(""))
      ->type_name("ply|obj|drc|glb|gltf|none");
  app.add_option("--compress", options.compression, "of glb: draco or meshopt; of gltf: meshopt; lossless")
      ->transform(CLI::CheckedTransformer(compressions).description(""))
      ->type_name("draco|meshopt");
  app.add_option("--pictures", options.pictures,
                 "png (of 16 bits where the video has more than 8), jpg, exr (half floats, linear light) or "
                 "none. Default: exr for video in OpenEXR, else png")
      ->transform(CLI::CheckedTransformer(pictures).description(""))
      ->type_name("png|jpg|exr|none");
  app.add_option("--quality", options.quality, "of jpg, 1 to 100; default 95")->check(CLI::Range(1, 100));
  auto *no_environment = app.add_flag("!--no-environment", options.environment,
                                      "do not write the static environment, environment.glb");
  auto *no_background = app.add_flag("--no-background");
  cli::make_former(*no_background);
  auto *no_sound =
      app.add_flag("!--no-sound", options.sound, "do not write the sound, audio/TRACK.opus or .m4a");
  app.add_flag("!--no-data", options.data, "do not write the payloads of data tracks, data/TRACK/NUMBER.EXT");
  auto *no_audio = app.add_flag("--no-audio");
  cli::make_former(*no_audio);
  app.add_flag(
      "--mp4", options.mp4,
      "also write the video tracks as they are, video/TRACK.mp4 (H.264, HEVC); --frames then selects "
      "whole groups");
  app.add_option("--threads", options.threads, "groups at a time; default: one for each processor")
      ->check(CLI::Range(1, 256));
  cli::add_max_memory(app, options.memory.bytes);
  app.add_flag("--force", options.force, "replace the folder if fvvdemux wrote it (docs/tools/outputs.md)");
  app.add_flag("--json", as_json, "print a summary as JSON");
  app.footer("Pictures are whole: what the stream has of them where it was, grey around it.\n"
             "Sound is that of the groups that the frames are in, with the packets of the stream.\n"
             "Visibility is left out: it describes the mesh as it was coded, and fvvmux computes it again.\n"
             "A frame is written with all its files, or not at all when a part of it is lost.\n"
             "Exit code: 0 done, 1 nothing written, 2 usage, 3 written, and the file is damaged or has lost "
             "something.\n"
             "spec/fvvdemux.schema.json describes the output of --json.");
  cli::set_help(app, "fvvdemux",
                {
                    "fvvdemux players.fvv -o players",
                    "fvvdemux players.fvv -o frame25 --frames 25 --meshes obj",
                    "fvvdemux players.fvv -o animated --format gltf --compress meshopt",
                });
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError &error) {
    return cli::end_of_parsing(app, error);
  }
  return cli::run("fvvdemux", [&] {
    if (frames) options.frames = demux::Selection::parse("frames", *frames);
    if (cameras) options.cameras = demux::Selection::parse("cameras", *cameras);
    if (cli::is_given_formerly(*no_background, *no_environment)) options.environment = false;
    if (cli::is_given_formerly(*no_audio, *no_sound)) options.sound = false;
    demux::Result result;
    try {
      demux::demux(input, output, options, result);
    } catch (...) {
      tell(input, result);
      throw;
    }
    tell(input, result);
    if (as_json) std::printf("%s\n", summary(input, result).c_str());
    return result.losses.empty() ? cli::done : cli::loss;
  });
}
