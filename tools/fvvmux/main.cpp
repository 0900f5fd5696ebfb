// fvvmux: packs a capture into a fvv stream. Argument parsing only.
#include "cli/cli.h"
#include "cli/help.h"
#include "cli/output.h"
#include "fvv_mux/option_texts.h"
#include "fvv_mux/report.h"
#include "fvv_mux/segments.h"
#include "fvv_scene/inputs.h"
#include "fvvmux/parts.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <thread>
#include <unistd.h>

using namespace fvv;

namespace {

constexpr const char *footer =
    "Exit code: 0 done, 1 failed, 2 usage, 3 done with warnings. A run that fails, also by --verify, leaves\n"
    "no file and no folder behind (docs/tools/outputs.md).\n"
    "spec/fvvmux.schema.json describes the output of --json.";

struct Outputs {
  std::string stream;   // "-": standard output
  std::string segments; // folder
  std::string capture;  // capture.json
  bool force = false;
};

template <class T> CLI::Range within(const mux::Bounds<T> &bounds) {
  return CLI::Range(bounds.least, bounds.most);
}

// In place of a capture.json.
void add_input_options(CLI::App &app, Outputs &outputs, mux::OptionTexts &texts) {
  app.add_option("--meshes", texts.meshes,
                 "meshes with %d or %0Nd for the number of the frame ('f/%04d.obj'), from the lowest that is "
                 "there; or one for all frames: .obj, .ply, .drc, .draco, .glb, .gltf")
      ->type_name("PATTERN");
  app.add_option("--atlas", texts.atlas,
                 "pictures of their texture coordinates, likewise, or a video; none; embedded: those that "
                 ".glb, .gltf and .obj files bring (default, where there are no cameras)")
      ->type_name("PATTERN");
  app.add_option("--pictures", texts.pictures,
                 "pictures of the cameras of a COLMAP model or transforms.json, with {name} or {id}, and %d; "
                 "or videos. Default: those that it names")
      ->type_name("PATTERN");
  app.add_option("--masks", texts.masks, "silhouettes of the cameras, in the same way")->type_name("PATTERN");
  app.add_option("--fps", texts.fps, "frames per second: 30, 30000/1001. Default: 25")->type_name("RATE");
  app.add_option("--units", texts.units,
                 "of meshes and cameras: metres, centimetres, millimetres, inches, feet, metres per unit, or "
                 "unknown. Default: unknown, but of glTF without cameras metres")
      ->type_name("UNIT");
  app.add_option("--up", texts.up,
                 "axis that points up: +x, -x, +y, -y, +z, -z or unknown. Default: unknown, but of glTF "
                 "without cameras +y")
      ->type_name("AXIS");
  app.add_option("--write-capture", outputs.capture,
                 "write the capture.json that these inputs stand for; -o may be left out then")
      ->type_name("FILE.json");
}

void add_options(CLI::App &app, mux::Options &options, Outputs &outputs, mux::OptionTexts &texts) {
  app.add_option("CAPTURE", options.capture,
                 "capture.json (spec/capture.md) or its folder; or the folder of a COLMAP model or of "
                 "nerfstudio's transforms.json; or left out, with --meshes (docs/tools/fvvmux-inputs.md)")
      ->type_name("FILE.json|fvv");
  app.add_option("-o,--output", outputs.stream, "file to write; - is standard output")->type_name("FILE.fvv");
  app.add_option(
         "--codec", texts.codec,
         "jpeg, h264, hevc, vp9, av1, or exr: light beyond white stays as it is, from pictures in OpenEXR")
      ->capture_default_str()
      ->type_name("jpeg|h264|hevc|vp9|av1|exr");
  app.add_option("--bit-depth", texts.bit_depth,
                 "8, or 10 (hevc, vp9, av1): smooth shades without bands, from pictures of 16 bits above "
                 "all; exr has 16. Default: the least that the codec has")
      ->type_name("8|10");
  auto *quality = app.add_option(
      "--quality", texts.quality,
      "luma PSNR to reach (42dB), over the foreground when there are masks, or the codec's own "
      "number: JPEG 1 to 100, CRF 1 to 51 (H.264, HEVC) or 63 (VP9, AV1); OpenEXR has lossless alone. "
      "Default: 42dB, of exr lossless");
  app.add_option("--bitrate", texts.bit_rate,
                 "bits a second for all pictures (4M, 800k) in place of a quality: every group has its share "
                 "and gets the finest quality that keeps it; tracks share by their pixels")
      ->excludes(quality);
  auto *ladder = app.add_option(
      "--ladder", texts.ladder,
      "send the pictures at several sizes, of which a player takes one, and changes by the bandwidth "
      "that it has: factors of the size, best first (1,0.75,0.5), each with a PSNR of 9 dB less for "
      "half the size, or bits a second of each (8M,2M,500k) (docs/encoding/ladder.md)");
  app.add_option("--mesh-ladder", texts.mesh_ladder,
                 "coarser meshes for lower rungs, whose pixels are larger: auto where they save 5 % of a "
                 "rung, on or off")
      ->needs(ladder)
      ->type_name("auto|on|off");
  auto *tile = app.add_option("--tile", texts.tile, "size of every camera's picture in the stream: 480x270");
  app.add_option("--scale", texts.scale, "the same as a factor, above 0 and at most 1")->excludes(tile);
  app.add_option("--atlas-scale", texts.atlas_scale,
                 "size of the atlas in the stream as a factor, above 0 and at most 1; rounded to even sides "
                 "but for JPEG");
  app.add_option("--texture-bits", options.texture_bits,
                 "of each texture coordinate, 1 to 16. Default: the capture's, else 12")
      ->check(within(mux::texture_bits_bounds));
  app.add_option(
         "--background", texts.background,
         "around the silhouette, where there are masks: keep, flat (its colours for 8 px, then grey), smooth "
         "(its colours run on everywhere), or auto: smooth for av1, flat for the others")
      ->capture_default_str()
      ->type_name("auto|keep|flat|smooth");
  app.add_option(
         "--crop", texts.crop,
         "auto: of each camera's picture what is seen of the scene in a group of frames, by its masks, else "
         "by the mesh; none: whole pictures (docs/encoding/tiles.md)")
      ->capture_default_str()
      ->type_name("auto|none");
  auto *undistort = app.add_flag(
      "--undistort", options.undistort,
      "resample the pictures of cameras with a lens to cameras without (docs/tools/calibration.md)");
  app.add_option("--undistort-alpha", options.undistort_alpha,
                 "how much they show: 0, the most that leaves no pixel blank; 1, all that the lens shows")
      ->check(within(mux::undistort_alpha_bounds))
      ->capture_default_str()
      ->needs(undistort);
  auto *pixels = app.add_option(
      "--video-pixels", texts.video_pixels,
      "of the one frame in which all cropped pictures are packed, at most (300k, 2M): cameras share them by "
      "their usefulness, none gets more than --tile or --scale gives. Without it, cameras are spread over "
      "several video tracks when a frame would exceed what decoders take");
  auto *sides =
      app.add_option("--video-size", texts.video_size, "the same by the sides of the frame: 1920x1088")
          ->excludes(pixels);
  app.add_option(
         "--video-tracks", texts.video_tracks,
         "spread the cameras over this number of video tracks, neighbours together, or camera: one for "
         "each. Players "
         "can then leave out what a viewpoint does not need (docs/encoding/tiles.md)")
      ->capture_default_str()
      ->excludes(pixels)
      ->excludes(sides);
  app.add_option(
      "--max-error", texts.max_error,
      "error of the geometry in pixels of the transmitted pictures, at the camera that sees a place "
      "sharpest, or as a length (1mm, 0.1cm): decides the lattice step, motion and how far meshes are "
      "decimated (docs/encoding/budget.md). Default: 0.15; without cameras 1/8192 of a mesh's diagonal, and "
      "no "
      "decimation");
  app.add_option("--step", texts.step,
                 "step of the lattice of vertex positions: 1.5mm, 0.002m; plain numbers are metres or the "
                 "capture's units. Default: the capture's, else by --max-error");
  auto *triangles =
      app.add_option("--triangles", options.triangles, "decimate every frame to this number, at any error")
          ->check(within(mux::triangles_bounds));
  app.add_flag("--keep-geometry", options.keep_geometry, "decimate nothing")->excludes(triangles);
  app.add_option("--group", options.group, "frames in a group; default: one second")
      ->check(within(mux::group_bounds));
  app.add_option("--mesh-level", options.mesh_level, "Draco: 0 is fastest, 10 is smallest")
      ->check(within(mux::mesh_level_bounds))
      ->capture_default_str();
  app.add_option("--mesh-profile", texts.mesh_profile, "draco, raw or fast (more bytes, quick to decode)")
      ->capture_default_str()
      ->type_name("draco|raw|fast");
  app.add_option(
         "--normals", texts.normals,
         "send the source's: auto (where more than 1 % of the first mesh's vertices lie on hard edges: "
         "computed from all faces around, their normals are off by more than 20 degrees), always or never")
      ->capture_default_str()
      ->type_name("auto|always|never");
  app.add_option("--winding", texts.winding,
                 "of faces: keep, flip (turn all of them round), or auto (flip when most of what cameras see "
                 "has its back to them: they are inside out). Default: keep, with a warning in that case")
      ->type_name("keep|flip|auto");
  app.add_option(
         "--visibility", texts.visibility,
         "send what cameras see: auto (weight, unless it takes more than a tenth of the pictures' bytes, or "
         "one camera is alone), weight (a visibility weight of each vertex and camera) or none "
         "(docs/encoding/visibility.md)")
      ->capture_default_str()
      ->type_name("auto|weight|none");
  app.add_option(
         "--colours", texts.colours,
         "send a colour of low resolution for all of the surface, which is shown where no camera sees it, "
         "and "
         "by players that cannot decode the pictures: auto (where there are meshes and pictures of cameras, "
         "and no atlas), on, off, or about how many cells of one colour the first mesh has "
         "(docs/encoding/colours.md)")
      ->capture_default_str();
  app.add_option("--match-colours", texts.match_colours,
                 "correct the pictures of cameras whose exposure or white balance differs, by the surface "
                 "that they see in "
                 "common: auto (where two cameras differ by more than 3 % and gains take away at least half "
                 "of that), on "
                 "or off (docs/encoding/match.md)")
      ->capture_default_str()
      ->type_name("auto|on|off");
  app.add_option(
         "--texture-threshold", options.texture_threshold,
         "tell players the least cosine between normal and ray for which they take a camera's colour; "
         "visibility is found for it. Players' default: that of the blend, 0.05 or 0.25")
      ->check(within(mux::texture_threshold_bounds));
  app.add_option("--texture-best", options.texture_best,
                 "tell players how many cameras to mix at a place, at most. Players' default: 3")
      ->check(within(mux::texture_best_bounds));
  app.add_option(
         "--texture-blend", texts.texture_blend,
         "tell players how to weight cameras: viewer (by the viewer's direction, players' default) or "
         "paper (by the normal alone, as WHP 235)")
      ->type_name("viewer|paper");
  app.add_option("--texture-unseen", texts.texture_unseen,
                 "tell players the colour of surface that no camera shows, R,G,B. Players' default: "
                 "128,128,128");
  app.add_option("--texture-depth-bias", options.texture_depth_bias,
                 "tell players that make depth maps by how much a place may lie behind one and still be "
                 "seen, in widths of a pixel. Players' default: 0.2")
      ->check(within(mux::texture_depth_bounds));
  app.add_option("--texture-depth-slope", options.texture_depth_slope,
                 "the same, times what the surface recedes from one pixel to the next. Players' default: 0.5")
      ->check(within(mux::texture_depth_bounds));
  app.add_option("--texture-inset", texts.texture_inset,
                 "tell players how far inside the mesh the surface lies that cameras show: auto (found by "
                 "drawing cameras from the others), off, or a length such as 3mm (docs/encoding/inset.md)")
      ->capture_default_str();
  app.add_flag("!--no-delta", options.delta,
               "every mesh a key frame, also where the faces are those of the frame before");
  app.add_option("--min-component", options.min_component, "drop connected pieces with fewer faces")
      ->check(within(mux::min_component_bounds));
  app.add_option("--threads", options.threads, "threads; the bytes are the same for any number")
      ->check(within(mux::threads_bounds));
  app.add_option("--frames", texts.frames, "frame numbers to take: 10-19 or 10..19");
  app.add_flag(
      "--skip-bad-frames", options.skip_bad_frames,
      "leave out frames with a mesh, picture or mask that cannot be used, and name them; exit code 3. All "
      "files are read once more for it (docs/encoding/frames.md)");
  app.add_option("--cameras", options.cameras,
                 "cameras to take, by identifier, range or name: 0-3,7,overhead")
      ->delimiter(',');
  app.add_flag("!--no-pictures", options.pictures, "leave the pictures out, those of the atlas too");
  app.add_flag("!--no-meshes", options.meshes, "leave the meshes out");
  app.add_flag("!--no-background", options.environment, "leave the static environment out, lights and all");
  auto *no_audio = app.add_flag("!--no-audio", options.sound, "leave the sound out");
  app.add_option("--audio-bitrate", texts.audio_bit_rate,
                 "bits a second of each audio track (96k), encoded as Opus. Default: Opus and AAC-LC stay as "
                 "they are; "
                 "other sound has 64k for one channel, 48k a channel for more (docs/encoding/sound.md)")
      ->excludes(no_audio);
  app.add_option(
         "--audio-channels", options.sound_channels,
         "of sound that is encoded, at most: more are mixed down; sound with a place in the scene has one")
      ->check(within(mux::audio_channels_bounds))
      ->capture_default_str()
      ->excludes(no_audio);
  app.add_flag("--repeat-configuration", options.repeat_configuration,
               "in front of every group, for those who join late; the environment in every group too");
  app.add_flag("--live", options.live, "no index and no footer");
  app.add_flag("--verify", options.verify, "read the file back and compare everything with the capture");
  app.add_option(
         "--segments", outputs.segments,
         "write the stream as a folder besides: configuration, a file for each group, manifest.json, for "
         "hosts that break ranges (docs/tools/fvvserve.md). CAPTURE may be a .fvv file then: it is cut up as "
         "it "
         "is, and -o is left out")
      ->type_name("FOLDER");
  app.add_flag(
      "--force", outputs.force,
      "replace an existing file, and a folder of segments that fvvmux wrote (docs/tools/outputs.md)");
}

// What --help shows; --help-all has everything.
const std::vector<cli::HelpSection> shown = {
    {"Files",
     {{"CAPTURE", "capture.json or its folder, or one of COLMAP or nerfstudio"},
      {"-o, --output FILE", "the stream; - is standard output"},
      {"--frames A-B", "frame numbers to take"},
      {"--cameras A,B-C,NAME", "cameras to take"},
      {"--segments FOLDER", "also as files for hosts without range requests"},
      {"--verify", "read the file back and compare everything with the capture"},
      {"--force", "replace what exists (docs/tools/outputs.md)"},
      {"--json", "print the summary as JSON"}}},
    {"Without a capture.json (docs/tools/fvvmux-inputs.md)",
     {{"--meshes PATTERN", "files by frame number: 'f/%04d.obj'"},
      {"--atlas PATTERN", "their textures: 'f/%04d.png'"},
      {"--fps RATE", "frames per second. Default: 25"},
      {"--units UNIT", "of meshes and cameras; --up AXIS"},
      {"--write-capture FILE", "the capture.json that was understood"}}},
    {"Meshes",
     {{"--max-error ERROR", "pixels of the transmitted pictures, or a length: 1mm. Default: 0.15"},
      {"--keep-geometry", "decimate nothing"},
      {"--triangles N", "decimate every frame to this number"},
      {"--mesh-profile NAME", "draco (default), fast (quick to decode) or raw"},
      {"--group N", "frames in a group: where players can begin. Default: one second"},
      {"--winding HOW", "keep, flip or auto: for meshes that are inside out"}}},
    {"Pictures",
     {{"--codec NAME", "h264 (default), hevc, vp9, av1, jpeg, exr"},
      {"--quality Q", "PSNR of the foreground (42dB, the default), or the codec's number"},
      {"--bitrate RATE", "bits a second (4M), in place of a quality"},
      {"--scale F", "size of the pictures, above 0 and at most 1; or --tile WxH"},
      {"--ladder F,F", "several sizes, for players to choose by bandwidth: 1,0.75,0.5"},
      {"--background HOW", "around the silhouette: auto, keep, flat, smooth"},
      {"--bit-depth N", "8, or 10 for smooth shades"},
      {"--video-pixels N", "of the frame that all cameras share: 2M"}}},
    {"What is left out",
     {{"--no-pictures", "and --no-meshes, --no-background, --no-audio"},
      {"--skip-bad-frames", "frames that cannot be used are left out and named, with exit code 3"}}},
    {"Running",
     {{"--threads N", "the bytes are the same for any number"},
      {"--live", "no index and no footer"},
      {"--plan FOLDER", "encode on many machines; --part, --merge (docs/encoding/parts.md)"},
      {"--help-all", "all options, also for players' texturing, tiles, sound and ladders"},
      {"--version", "of fvvmux"}}}};
const std::vector<std::string> examples = {
    "fvvmux players -o players.fvv",
    "fvvmux --meshes 'f/%04d.obj' --atlas 'f/%04d.png' --fps 30 -o f.fvv",
    "fvvmux players -o players.fvv --quality 38dB --max-error 0.3 --codec hevc",
    "fvvmux players -o players.fvv --scale 0.75 --background flat --ladder 1,0.75,0.5",
};

struct WrittenSegments {
  std::string folder;
  mux::Segments sums;

  std::string text() const {
    return folder + ": " + std::to_string(sums.bytes) + " bytes in " + std::to_string(sums.groups) +
           " groups and a configuration" +
           (sums.rungs > 1 ? " of each of " + std::to_string(sums.rungs) + " rungs" : "") + "\n";
  }
  nlohmann::ordered_json json() const {
    nlohmann::ordered_json out = {{"folder", folder}, {"groups", sums.groups}, {"bytes", sums.bytes}};
    if (sums.rungs > 1) out["rungs"] = sums.rungs;
    return out;
  }
};

// folder: opened before the work that takes time.
WrittenSegments write_segments(const InputFile &stream, const std::string &name, cli::OutputFolder &folder) {
  const mux::Segments sums = mux::write_segments(
      stream, [&](const std::string &part, const std::function<void(const mux::Sink &)> &fill) {
        const auto out = folder.create(part);
        fill([&](const void *bytes, size_t size) { out->write(bytes, size); });
        out->close();
      });
  return {name, sums};
}

// Segments of an existing stream.
cli::Exit cut_up(const mux::Options &options, const Outputs &outputs, bool as_json) {
  cli::OutputFolder folder(outputs.segments, outputs.force, cli::inputs({options.capture}));
  const WrittenSegments segments = write_segments(InputFile(options.capture), outputs.segments, folder);
  folder.commit();
  const nlohmann::ordered_json json = {{"fvvmux", 1}, {"segments", segments.json()}};
  std::fputs((as_json ? json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n"
                      : segments.text())
                 .c_str(),
             stdout);
  return cli::done;
}

// Of files that a run reads.
cli::Inputs files_of(const mux::Options &options) {
  return [&](const std::function<void(const std::string &)> &visit) {
    scene::visit_files(scene::load_capture(options.capture, options.inputs), visit);
  };
}

void write_capture(const mux::Options &options, const std::string &path, cli::OutputFile &file) {
  const std::string text = scene::describe_inputs(options.capture, options.inputs, path);
  file.write(text.data(), text.size());
}

cli::Exit describe(const mux::Options &options, const Outputs &outputs) {
  cli::OutputFile file(outputs.capture, outputs.force, files_of(options));
  write_capture(options, outputs.capture, file);
  file.commit();
  return cli::done;
}

cli::Exit pack(const mux::Options &options, const Outputs &outputs, bool as_json) {
  const bool piped = outputs.stream == "-";
  const cli::Inputs captured = files_of(options);
  if (piped && as_json) throw Error("--json: standard output is taken by the stream (-o -)", Error::usage);
  // All outputs are opened before the work that takes time.
  cli::OutputFile output(outputs.stream, outputs.force, captured);
  if (!output.is_regular() && (!outputs.segments.empty() || options.verify))
    throw Error(std::string(options.verify ? "--verify" : "--segments") + ": " +
                    (piped ? "standard output" : outputs.stream) + " cannot be read back",
                Error::usage);
  std::optional<cli::OutputFolder> folder;
  if (!outputs.segments.empty()) folder.emplace(outputs.segments, outputs.force, captured);
  std::optional<cli::OutputFile> capture;
  if (!outputs.capture.empty()) {
    capture.emplace(outputs.capture, outputs.force, captured);
    write_capture(options, outputs.capture, *capture);
  }
  std::optional<cli::Progress> progress;
  mux::Observer observer;
  observer.on_warning = cli::warn;
  observer.on_progress = [&](size_t frames) {
    if (progress) progress->step(frames);
  };
  mux::Muxer muxer(options, observer);
  progress.emplace("fvvmux: " + outputs.stream, muxer.frame_count());
  mux::Report report = muxer.run([&](const void *bytes, size_t size) { output.write(bytes, size); });
  if (options.verify) {
    progress.emplace("fvvmux: verifying " + outputs.stream, report.frames);
    report.verdict = muxer.verify(InputFile(output.written(), outputs.stream));
  }
  progress.reset();
  std::optional<WrittenSegments> segments;
  std::vector<cli::Output *> all = {&output};
  if (capture) all.push_back(&*capture);
  if (folder) {
    segments = write_segments(InputFile(output.written(), outputs.stream), outputs.segments, *folder);
    all.push_back(&*folder);
  }
  cli::commit(all);
  if (as_json) {
    nlohmann::ordered_json json = nlohmann::ordered_json::parse(mux::report_json(report, outputs.stream));
    if (segments) json["segments"] = segments->json();
    std::printf("%s\n", json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace).c_str());
  } else if (!piped || isatty(STDERR_FILENO)) {
    const std::string text = mux::report_text(report, outputs.stream) + (segments ? segments->text() : "");
    std::fputs(text.c_str(), piped ? stderr : stdout);
  }
  return report.warned ? cli::loss : cli::done;
}

} // namespace

int main(int argc, char **argv) {
  CLI::App app{"Pack meshes, pictures and cameras of a capture into a fvv stream."};
  mux::Options options;
  options.threads = std::clamp(std::thread::hardware_concurrency(), 1u, 256u);
  Outputs outputs;
  mux::OptionTexts texts;
  PartCommand command;
  bool as_json = false;
  add_options(app, options, outputs, texts);
  add_input_options(app, outputs, texts);
  add_part_options(app, command);
  app.add_flag("--json", as_json, "print the summary as JSON");
  app.footer(footer);
  cli::set_help(app, "fvvmux", examples, shown);
  try {
    app.parse(argc, argv);
    if (command.is_given()) check_part_options(app, command);
    const bool cuts = !outputs.segments.empty() && mux::is_stream(options.capture);
    const bool describes = !outputs.capture.empty();
    if (options.capture.empty() && texts.meshes.empty()) throw CLI::RequiredError("CAPTURE or --meshes");
    if (outputs.stream.empty() && !cuts && !describes && !command.is_given())
      throw CLI::RequiredError("--output");
    if (!outputs.stream.empty() && cuts) throw CLI::ExcludesError("--output", "--segments of a .fvv file");
  } catch (const CLI::ParseError &error) {
    return cli::end_of_parsing(app, error);
  }
  return cli::run("fvvmux", [&] {
    cli::keep_freed_memory();
    mux::take_texts(options, texts);
    if (command.is_given()) return run_part_command(command, options, outputs.stream, outputs.force, as_json);
    if (outputs.stream.empty() && !outputs.capture.empty()) return describe(options, outputs);
    return outputs.stream.empty() ? cut_up(options, outputs, as_json) : pack(options, outputs, as_json);
  });
}
