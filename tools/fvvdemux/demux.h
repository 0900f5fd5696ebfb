// fvvdemux as a library: a stream as the files of a capture.
#pragma once

#include "fvv_demux/selection.h"
#include "fvv_media/video.h"
#include "fvv_scene/mesh_run.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace fvv::demux {

// glb, gltf: for other programs, +y up, and no part of capture.json. glb is a file of each frame, gltf one of
// the frames that share their faces, animated.
enum class Meshes { none, ply, obj, drc, glb, gltf };
// automatic: exr for video in OpenEXR, else png.
enum class Pictures { none, png, jpg, exr, automatic };

struct Options {
  Selection frames;  // numbers in the stream, from 0
  Selection cameras; // identifiers
  size_t rung = 0;   // of a ladder of quality (fvv_cxx/rung.h)
  Meshes meshes = Meshes::ply;
  scene::Compression compression = scene::Compression::none; // of glb and gltf
  Pictures pictures = Pictures::automatic;
  int quality = 95;     // of jpg
  uint32_t threads = 1; // groups at a time; the files are the same for any number
  bool force = false;
  bool environment = true;   // the environment as environment.glb
  bool sound = true;         // in files of its codec
  bool data = true;          // payloads of data tracks, in files of their own
  bool mp4 = false;          // video tracks as films too, not decoded
  media::MemoryLimit memory; // of all pictures that are decoded at once: fewer groups at a time keep it
};

struct Result {
  int64_t frames_in_stream = 0;
  int64_t frames_written = 0;
  uint64_t meshes = 0;
  uint64_t mesh_files = 0;               // of meshes: fewer with Meshes::gltf
  std::map<uint16_t, uint64_t> pictures; // by camera
  uint64_t atlases = 0;                  // pictures of the atlas
  bool capture = false;                  // capture.json was written
  bool environment = false;              // environment.glb was written
  bool local_origin = false;             // glTF files have positions relative to an origin of their own
  uint64_t sounds = 0;                   // files of sound
  uint64_t data = 0;                     // files of payloads of data tracks
  uint64_t films = 0;                    // files of video tracks
  // "IN: frame 4 is lost: 0x1a2b: MESH: ... [FVV-1103]", in order of frames; not empty: exit code 3.
  std::vector<std::string> losses;
  std::vector<std::string> warnings;
};

// Error, and no folder, when nothing could be written; result then has the losses all the same.
// result: a fresh one.
void demux(const std::string &input, const std::string &folder, const Options &options, Result &result);

} // namespace fvv::demux
