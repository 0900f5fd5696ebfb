// A recorded scene as capture.json describes it (spec/capture.md): where its meshes and pictures are, when
// they were taken, and its cameras.
#pragma once

#include "fvv/calibration.h"
#include "fvv_cxx/range.h"
#include "fvv_scene/file_io.h"
#include "fvv_scene/mesh_file.h"
#include "fvv_scene/picture_source.h"
#include "fvv_scene/sound_source.h"
#include "fvv_scene/transform.h"

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

namespace fvv::scene {

namespace gltf {
struct Scene;
enum class Texture;
} // namespace gltf

class MeshAnimation {
public:
  using Name = std::variant<int64_t, std::string>; // an index from 0, or a name

  MeshAnimation(std::optional<Name> animation, fvv_rational from, int64_t first_frame);
  ~MeshAnimation();

  // The scene at a time in seconds, in the file's units. path: the file, the same in every call. Vertices and
  // faces are the same at every time; before the first keyframe and after the last one the nearest applies.
  // texture, normals: as parse_gltf has it; bake_repeats: as Atlas has it. Error. Several threads may call
  // these two.
  Mesh mesh(const std::string &path, double time, const fvv_limits *limits, MeshReport *report, bool texture,
            bool normals, MeshExtras *extras = nullptr, bool bake_repeats = false) const;
  // Time of the last keyframe in seconds; reads the file for mesh() without normals.
  double end(const std::string &path, bool texture) const;

  const std::optional<Name> name; // none: the only one
  const fvv_rational start;       // seconds from the beginning of the animation to frame number first
  const int64_t first;

private:
  const gltf::Scene &read(const std::string &path, gltf::Texture texture, bool normals) const;

  mutable std::mutex mutex;
  // By what was read of the appearance, and with normals.
  mutable std::map<std::pair<gltf::Texture, bool>, std::unique_ptr<const gltf::Scene>> scenes;
};

// One camera. calibration is in metres (in units of the source when the scale is unknown), pixel centres at
// +0.5, validated; its name is borrowed from name, which copies of a Camera share.
struct Camera {
  fvv_camera calibration = {};
  std::shared_ptr<const std::string> name;
  // Of a camera that moves or zooms: its calibration by frame number, at least of all frames of the capture
  // that are not lost, without names. Empty, and lost as well: calibration holds for all frames.
  std::map<int64_t, fvv_camera> per_frame;
  // The camera in Capture::memory of which it is known what it sees, if it is.
  std::optional<size_t> memory_visibility;
  bool texture = true; // its pictures colour the mesh; otherwise they only show outlines
  std::optional<PictureSource> pictures, masks; // no masks without pictures
  // Frame numbers at which a camera that moves has no calibration. None of per_frame.
  std::set<int64_t> lost;

  void set_name(const std::string &text);
  bool moves() const { return !per_frame.empty() || !lost.empty(); }
  bool is_calibrated(int64_t frame) const { return !lost.count(frame); }
  // The calibration of a frame number of the capture at which there is one, its name borrowed as that of
  // calibration.
  fvv_camera calibration_at(int64_t frame) const;
};

// Pictures that the texture coordinates of the meshes address, one per frame or one for all.
struct Atlas {
  std::optional<PictureSource> pictures; // of one size; nothing: those that mesh files bring
  std::optional<uint32_t>
      texture_bits;          // of texture indices in the stream that this comes from, or is made for
  bool bake_repeats = false; // cut faces on which a picture repeats, so that each piece shows it once
};

// The static environment (environment.h).
struct EnvironmentSource {
  std::string file;               // .glb or .gltf
  gltf::Transform transform;      // from its coordinates to those of the meshes, in their units
  std::optional<Lattice> lattice; // of the stream that this comes from, or is made for; metres
};

// The frame at place k has the number first + k * step in file names, and k frame durations are before it.
// Frame i is at place i, unless some are left out.
struct Frames {
  int64_t first = 0, count = 1, step = 1;
  std::vector<int64_t> left_out = {}; // places that have no frame, rising

  int64_t places() const { return count + int64_t(left_out.size()); }
  int64_t place(int64_t i) const;
  int64_t number(int64_t i) const { return number_at(place(i)); }
  int64_t number_at(int64_t at) const { return first + at * step; } // at: a place
  std::vector<int64_t> numbers() const;
  // The frames with these numbers are no frames any more.
  void leave_out(const std::set<int64_t> &numbers);
};

class MeshCache;
class MemoryFrames; // memory_frames.h

struct Capture {
  std::string path; // of capture.json; patterns are relative to its folder
  std::string name;
  fvv_rational frame_duration = {1, 25}; // seconds per frame, in lowest terms
  Frames frames;
  double metres_per_unit = 1; // of positions in mesh files; cameras are in metres already
  bool scale_unknown = false; // then metres_per_unit is 1, and "metres" are units of the source
  uint8_t up = FVV_UP_UNKNOWN;
  std::optional<Lattice> lattice; // of the stream that the meshes come from, or are made for
  std::optional<Pattern> meshes;
  std::set<int64_t> empty; // numbers of frames at which the stage is empty: they have no mesh
  // Set if one file holds all meshes, which meshes then names for every frame. Copies share the read data.
  std::shared_ptr<const MeshAnimation> animation;
  std::optional<Atlas> atlas; // only with meshes
  std::vector<Camera> cameras;
  std::optional<EnvironmentSource> environment;
  std::vector<SoundSource> sounds;
  std::vector<std::string> notes; // warnings of who made this description, for check_files

  // What decoding one of its files may take; functions that take a capture throw media::MemoryError for one
  // that takes more.
  media::MemoryLimit memory_limit;

  // Recently read meshes, up to 128 MiB, shared by copies; NULL: every call of load_mesh reads. A file is
  // read once while its mesh is cached, for all threads.
  std::shared_ptr<MeshCache> mesh_cache;
  // Set if meshes and pictures are in memory in place of files; patterns then only name them in messages.
  std::shared_ptr<MemoryFrames> memory;

  // An option of load_mesh that is not in files: reverses the winding of faces; positions do not change.
  bool flip_faces = false;

  // The path of a file of a frame number; of a video, the same for every frame. The pattern must be set
  // (meshes, pictures, masks).
  std::string mesh_path(int64_t frame) const;
  std::string picture_path(const Camera &camera, int64_t frame) const;
  std::string mask_path(const Camera &camera, int64_t frame) const;
  // Of the picture of the atlas, which must be there; where it is in the mesh's file, of that.
  std::string atlas_path(int64_t frame) const;
  bool has_mesh(int64_t frame) const { return meshes && !empty.count(frame); }
  double frame_seconds() const { return double(frame_duration.numerator) / frame_duration.denominator; }
  // Numbers of the frames that have a mesh.
  std::vector<int64_t> mesh_frames() const;
  // Seconds from the beginning of the animation, which must be there, to a frame number.
  double animation_time(int64_t frame) const;
  // A name that a pattern yields, resolved against the folder of capture.json.
  std::string resolve(const std::string &file) const;
};

// The capture.json that a user names: its path, or that of its folder.
std::string description_file(const std::string &given);

// Reads a capture.json. Strict: Error for malformed JSON ("path:LINE:COLUMN: ..."), for unknown, missing and
// duplicate keys, wrong types and values out of range ("path: /JSON/POINTER: ..."), for cameras that
// fvv_camera_validate refuses. Reads no other file.
Capture load_capture(const std::string &path);
Capture parse_capture(std::string_view bytes, const std::string &path);

// The text of a capture.json. Loading it gives the same cameras bit for bit. Refuses a capture whose
// metres_per_unit is not 1 (dividing and multiplying again would move the cameras) and cameras that
// fvv_camera_validate refuses.
std::string format_capture(const Capture &capture);
void write_capture(const Capture &capture, const std::string &path);

// The mesh of a frame number, in metres, with texture coordinates when the capture has an atlas, and with
// normals, if the file has them and normals is set. Several threads may call it for one capture.
Mesh load_mesh(const Capture &capture, int64_t frame, const fvv_limits *limits = nullptr,
               MeshReport *report = nullptr, bool normals = false);

// The same in metres, without texture coordinates and normals. colours: R G B of each vertex, display values;
// empty if the file has none.
Mesh load_coloured_mesh(const Capture &capture, int64_t frame, std::vector<uint8_t> &colours);

// Adds to Capture::empty the frames whose mesh files are there and have neither vertices nor faces
// (is_empty_mesh).
void find_empty_meshes(Capture &capture);

std::shared_ptr<MeshCache> make_mesh_cache();
// Drops cached meshes, so that files are read again.
void clear(MeshCache &cache);
// How often a mesh file was read through it.
uint64_t mesh_reads(const MeshCache &cache);

// The picture that the mesh file of a frame number brings along.
MeshPicture load_embedded_atlas(const Capture &capture, int64_t frame);
// Of the picture of a frame number that has a mesh, without decoding it.
AtlasSize embedded_atlas_size(const Capture &capture, int64_t frame);

// The environment, which must be there, in metres and in the world of the meshes.
struct Environment;
Environment load_environment(const Capture &capture, const fvv_limits *limits = nullptr);

// Width and height of a picture, from its header. Throws any std::exception for a file that is no picture.
struct PictureSize {
  uint32_t width, height;
  uint8_t orientation = 1; // of Exif, 1 (upright) to 8
};
using PictureProbe = std::function<PictureSize(const std::string &path)>;

// The content of a video file, with all of its pictures. Throws any std::exception if it is not a video.
using VideoProbe = std::function<VideoFacts(const std::string &path, std::optional<uint32_t> stream)>;

// Errors that prevent work, and warnings; sentences without the path of capture.json, in the order meshes,
// cameras as listed. Options in them are named by option_name().
struct Findings {
  std::vector<std::string> problems;
  bool of_frames = false;      // some of these are about files that belong to single frames
  bool missing_meshes = false; // some of these files are missing meshes
  std::vector<std::string> warnings;
  std::vector<std::string> unused; // unused frames among the files: a warning unless a part was selected
  std::vector<VideoReport> videos; // of every video that could be read, cameras as listed, masks last
};

// Checks every file that a capture names, before any work starts: missing or empty files, pictures and masks
// whose size is not the camera's (probe empty: not checked), files of frames before the first or after the
// last (unused), two cameras with the same pictures, pictures of an atlas that differ in size. An animated
// file is read: its errors are problems, frames after its end are a warning. Sound has to be readable by its
// headers. So is every video (video_probe empty: only whether it is there); frames for which it has no
// picture are a warning.
Findings check_files(const Capture &capture, const PictureProbe &probe, const VideoProbe &video_probe = {});

// Calls visit with the path of every file that the capture may read: capture.json, meshes, pictures, masks,
// environment, sound, and the files that those in glTF refer to.
void visit_files(const Capture &capture, const std::function<void(const std::string &)> &visit);

// A camera with a part of its picture beyond r_max, where nothing is projected: mostly because the lens folds
// there (fvv.md, clause 9.3).
struct LensGap {
  uint16_t camera;
  double r_max; // tangent of the angle to the axis, or of a fisheye the angle, in radians
  double share; // of the picture's area, about; of a camera that moves the largest of its frames
};

// Cameras without such a part are left out.
std::vector<LensGap> lens_gaps(const Capture &capture);

// Only the frames of a range of numbers. Throws Error (usage) when the capture does not have both ends.
void restrict_frames(Capture &capture, const Range &range);
// Only the cameras that items name, each by identifier, range of identifiers, or name; no items: all. Throws
// Error (usage) for an item that names none.
void restrict_cameras(Capture &capture, const std::vector<std::string> &items);

// "camera 3 (left)", for messages.
std::string describe(uint16_t id, const std::string &name);
std::string describe(const Camera &camera);

} // namespace fvv::scene
