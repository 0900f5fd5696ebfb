// Cameras out of the calibration files of other programs, in the conventions of fvv.
#pragma once

#include "fvv_scene/capture.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace fvv::import {

// cameras: world -> camera with x right, y down, z forward, pixel centres at +0.5, r_max filled in, each
// validated, ids unique; at least one. Lengths are units of the file.
struct Calibration {
  std::vector<scene::Camera> cameras;
  double metres_per_unit = 0;     // 0: not in the format
  std::vector<std::string> notes; // warnings, without the path
  // Of colmap and nerfstudio, for each camera its picture as the file names it: relative to the folder of
  // pictures, or to that of the file. Else empty.
  std::vector<std::string> pictures;
  // Of nerfstudio with times: of each camera its pictures of all moments, as the file names them, in the
  // order of time; the picture is the first of them. Else empty.
  std::vector<std::vector<std::string>> moments;
};

// Every reader is strict and throws Error: "path:LINE: expected ..., found ..." for text and
// XML, "path: /JSON/POINTER: ..." for JSON. A lens or a convention that fvv cannot hold exactly is an error
// that names it, never an approximation.

// A COLMAP model: the folder with cameras.bin and images.bin, or cameras.txt and images.txt, or the folder of
// a project, whose model is in sparse or sparse/N. A camera for each image, with the image's identifier;
// named after the picture.
Calibration read_colmap(const std::string &folder);
// The folder of the model that a folder is or has; none: it has no model. Error if it has several.
std::optional<std::string> find_colmap(const std::string &folder);
// The two files that read_colmap reads.
std::vector<std::string> colmap_files(const std::string &folder);

// cv::FileStorage, a camera in each file, YAML, XML or JSON by its first characters; ids by position, named
// after the file. Also camera_info of ROS with a pose beside it, and plain lists.
Calibration read_opencv(const std::vector<std::string> &files);

// transforms.json of nerfstudio or instant-ngp; ids by position, named after file_path. Where it has no size
// of pictures, as those of Blender sets, the header of each picture has it.
Calibration read_nerfstudio(const std::string &file);
// The file that a file_path names, which may lack its extension. folder: of transforms.json.
std::string nerfstudio_picture(const std::string &folder, const std::string &file_path);

// Plain text of K, R and t (docs/tools/calibration.md), pictures all width by height (the files do not say).
// A file has one camera, named after the file, or several, each with its name before it; ids by position.
Calibration read_krt(const std::vector<std::string> &files, uint32_t width, uint32_t height);

// JSON of the CMU Panoptic Studio; ids by position, named as in the file. In centimetres. Without its
// "cameras": a list of cameras, or an object of cameras by name, in lengths of unknown unit.
Calibration read_panoptic(const std::string &file);

// The folder with intri.yml and extri.yml of EasyMocap; ids by position in "names". width, height: of files
// that do not say; 0: an error then.
Calibration read_easymocap(const std::string &folder, uint32_t width, uint32_t height);

// calibration.toml of Anipose, FreeMoCap, Caliscope and Pose2Sim; ids by position.
Calibration read_toml(const std::string &file);

// camchain.yaml of Kalibr; ids by position, the world is the first camera's. In metres.
Calibration read_kalibr(const std::string &file);

// cameras.xml of Agisoft Metashape; ids by position among the aligned cameras, named after the label. In
// metres if the chunk has a scale.
Calibration read_metashape(const std::string &file);

// Calibration exported by Qualisys Track Manager (XML, often *.qca.txt); ids by position among the active
// cameras, named after the serial number.
Calibration read_qualisys(const std::string &file);

// *_par.txt of the Middlebury multi-view data sets, whose pictures are all width by height (the file does not
// say); ids by position, named after the picture.
Calibration read_middlebury(const std::string &file, uint32_t width, uint32_t height);

// Sidecars *.xmp of RealityCapture, a camera in each, or its table of internal and external camera
// parameters; pictures all width by height (the files do not say); ids by position, named after the picture.
Calibration read_realitycapture(const std::vector<std::string> &files, uint32_t width, uint32_t height);

// What a format takes. extensions: of files, one for each camera, which a folder may hold; none: the format
// takes one file, or one folder.
struct Format {
  enum class Size { stated, given, either }; // of pictures: in the file, by the caller, by either
  const char *name;
  std::vector<const char *> extensions;
  Size size;
};
const std::vector<Format> &formats();
const Format *find_format(const std::string &name); // null: there is none of that name
// files: at least one. width, height: of pictures, for formats that do not state it; else 0.
Calibration read(const Format &format, const std::vector<std::string> &files, uint32_t width,
                 uint32_t height);

// world: in the units of the cameras. pixel: by fvv's count, the centre of the top left pixel at (0.5, 0.5).
struct Observation {
  double world[3];
  uint16_t camera;
  double pixel[2];
};

// Lines "X Y Z CAMERA_ID U V"; empty lines and those that begin with '#' are skipped. Error "path:LINE:
// ...", also for cameras that the calibration does not have and for fewer points than diagnose() wants.
std::vector<Observation> read_observations(const std::string &path,
                                           const std::vector<scene::Camera> &cameras);

enum class Mistake { axes, inverse, inverse_and_axes, half_pixel, distortion };
constexpr size_t mistake_count = 5;
// A word for JSON, and a sentence for people.
const char *name_of(Mistake mistake);
const char *description_of(Mistake mistake);

// Root mean squares of the distance between projected and observed pixel. A point that a camera cannot show
// (behind it, beyond r_max), and any distance above it, counts as the diagonal of the picture, so that one
// point cannot outweigh all others.
struct Diagnosis {
  size_t points = 0;
  double rms = 0, max = 0;                       // as given
  size_t invisible = 0;                          // as given: points that their camera cannot show
  std::vector<double> rms_of_camera;             // one for each camera, NaN without points
  std::array<double, mistake_count> undone = {}; // rms with a mistake undone, the best of its variants; NaN
                                                 // where it cannot have been made
  std::optional<Mistake> suspected;
};

constexpr size_t min_observations = 8;

// Undoes one mistake at a time in all cameras:
// - axes: the camera's y and z axes are turned round (OpenGL for OpenCV);
// - inverse: the pose goes from the camera to the world, in OpenCV's axes or, turned twice, in OpenGL's;
// - inverse_and_axes: both, in either order;
// - half_pixel: the principal point moves by half a pixel up and left, or down and right;
// - distortion: k1 k2 p1 p2 k3 read as k1 k2 k3 p1 p2 or the reverse, or p1 and p2 exchanged.
// The rule: a mistake is suspected when undoing it leaves at most half of the rms as given and at most 0.7 of
// what undoing any other leaves, and when the rms as given is above 0.1 px.
Diagnosis diagnose(const std::vector<scene::Camera> &cameras, const std::vector<Observation> &observations);

} // namespace fvv::import
