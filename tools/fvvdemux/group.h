// One group: decodes its frames one after the other and writes those that are whole and chosen. A frame is
// written with all its files or not at all. Holds one frame's meshes and pictures at a time.
#pragma once

#include "fvvdemux/demux.h"
#include "fvvdemux/plan.h"

#include <functional>
#include <map>

namespace fvv::demux {

struct WrittenFrame {
  int64_t number; // in the stream
  int64_t time;   // ticks
  bool mesh;
  uint8_t texture_bits; // of the mesh; 0: without texture coordinates
  bool complete;        // has what capture.json promises for every frame
  // By identifier, those that move and are calibrated in this frame, as in the stream, without names.
  std::map<uint16_t, fvv_camera> moving;
};

struct GroupResult {
  std::vector<WrittenFrame> frames;
  std::vector<Loss> losses;
  std::map<uint16_t, uint64_t> pictures; // written, by camera; those of the atlas as no_camera
};

// The path to write a file of a frame to: folder "meshes", frame's number in the stream, extension.
using FilePath = std::function<std::string(const std::string &folder, int64_t number, const char *extension)>;

// What the pictures of a video track become: not automatic. And the end of their names.
Pictures files_of(Pictures wanted, const fvv_video_config &config);
const char *extension_of(Pictures pictures);

// plan: one whose stream is opened from the same file. cli::Failure or FileError when a file can't be
// written.
GroupResult unpack_group(fvv_stream *stream, const GroupPlan &plan, const Options &options,
                         LazySurvey &survey, const FilePath &path);

} // namespace fvv::demux
