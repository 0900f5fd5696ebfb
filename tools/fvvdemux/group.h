// One group: decodes its frames one after the other and writes those that are whole and chosen. A frame is
// written with all its files or not at all. Holds one frame's meshes and pictures at a time.
#pragma once

#include "cli/output.h"
#include "fvv_demux/frame_plan.h"
#include "fvv_media/sound.h"
#include "fvv_scene/capture.h"
#include "fvvdemux/demux.h"

#include <functional>
#include <map>
#include <optional>
#include <set>

namespace fvv::demux {

struct WrittenFrame {
  int64_t number;      // in the stream
  int64_t time;        // ticks
  int64_t valid_until; // ticks: the end of its group
  bool mesh;
  bool empty;           // no mesh is valid: the stage is empty
  uint8_t texture_bits; // of the mesh; 0: without texture coordinates
  bool complete;        // has everything that capture.json states for every frame
  // By identifier, those that move and are calibrated in this frame, as in the stream, without names.
  std::map<uint16_t, fvv_camera> moving;
};

struct GroupResult {
  std::vector<WrittenFrame> frames;
  std::vector<Loss> losses;
  std::map<uint16_t, uint64_t> pictures; // written, by camera; those of the atlas as no_camera
  bool local_origin = false;             // as Result has it
};

// The name of a frame's file in the output: folder "meshes", frame's number in the stream, extension.
using FileName = std::function<std::string(const std::string &folder, int64_t number, const char *extension)>;

// The picture format of a video track, not automatic, and the extension.
Pictures files_of(Pictures wanted, const fvv_video_config &config);
const char *extension_of(Pictures pictures);

// Whether frames of a rung have files with what a track carries.
bool writes_track(const fvv_configuration &configuration, const fvv_track &track, size_t rung);

// plan: one whose stream is opened from the same file. Error when a file can't be
// written.
GroupResult unpack_group(fvv_stream *stream, const GroupPlan &plan, const Options &options,
                         LazySurvey &survey, const FileName &name, cli::OutputFolder &folder);

// The frame at place n of the stream, which n frame durations are before, is first + step * n in file names.
struct FileNumbers {
  int64_t first = 0, step = 1;
  std::vector<int64_t> places = {}; // of the stream's frames; empty: all places have one
  int64_t end = 0;                  // with places: their number, those without a frame included

  int64_t place(int64_t frame) const { return places.empty() ? frame : places[size_t(frame)]; }
  int64_t of(int64_t frame) const { return first + step * place(frame); }
};

// The places of all frames of an undamaged stream in which some have no frame; none if all have one, or if
// frames are not at whole numbers of frame durations. end is set with them.
std::vector<int64_t> places_of(fvv_stream *stream, int64_t &end);

// From {"frame_numbers": {"first": ..., "step": ...}} in the metadata; from 0, with a warning, if that does
// not give count frames different numbers from 0 to 2147483647.
FileNumbers file_numbers(const fvv_configuration &configuration, int64_t count,
                         std::vector<std::string> &warnings);

// Scene and cameras as capture.json has them, with the patterns of the files; no frames yet.
scene::Capture describe_scene(const fvv_configuration &configuration, const Options &options);

// Gives the cameras of a capture that move, by its configuration, their calibrations by file number, and the
// frames in which they have none.
void describe_motion(const fvv_configuration &configuration, const Options &options,
                     const std::vector<WrittenFrame> &frames, const FileNumbers &numbers,
                     scene::Capture &capture);

// Time of a tick of the scene in a file with these packets (fvv_media/sound.h), exact; none if it does not
// fit.
std::optional<scene::Seconds> sound_offset(int64_t tick, const fvv_rational &base,
                                           const media::SoundPackets &packets);

// Frames of the capture; none, with the reason, if they are not regular in number and duration.
struct FrameSpan {
  scene::Frames frames;
  fvv_rational duration;
  std::set<int64_t> empty = {}; // file numbers at which the stage is empty
};
// meshes_alone: where there is no frame the capture has one without a mesh, if none is valid there.
std::optional<FrameSpan> span_of(const std::vector<WrittenFrame> &frames, const FileNumbers &numbers,
                                 const fvv_scene &scene, std::string &reason, bool meshes_alone = false);

} // namespace fvv::demux
