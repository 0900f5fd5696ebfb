#include "fvvdemux/animations.h"
#include "fvv_cxx/owned.h"
#include "fvv_demux/meshes.h"
#include "fvv_demux/views.h"
#include "fvv_scene/file_io.h"

#include <algorithm>
#include <filesystem>
#include <optional>

namespace fvv::demux {

namespace {

// WebGL 2 promises a vertex shader 256 vectors of uniforms. A player such as three.js takes one for the
// weight of each morph target, and needs others.
constexpr size_t most_frames = 128;
// Of a run's positions and normals in float32. It bounds the memory that this tool takes, about three times
// as much, and the file that a browser loads at once.
constexpr uint64_t most_bytes = uint64_t(64) << 20;

bool is_same_place(const fvv_scene &a, const fvv_scene &b) {
  return std::equal(a.lattice_origin, a.lattice_origin + 3, b.lattice_origin) &&
         a.lattice_step == b.lattice_step && a.up_axis == b.up_axis &&
         a.time_base.numerator == b.time_base.numerator && a.time_base.denominator == b.time_base.denominator;
}

class Animations {
public:
  Animations(fvv_stream *opened, const Options &chosen, const FileName &file_name, cli::OutputFolder &to)
      : stream(opened), options(chosen), name(file_name), folder(to) {}

  void write(const Plan &plan, const std::vector<WrittenFrame> &frames) {
    size_t next = 0;
    for (const GroupPlan &group : plan.groups) {
      for (; next < frames.size() && frames[next].number < group.number + group.count; next++)
        add(group, frames[next], next && goes_on_to(frames[next - 1], frames[next]));
    }
    finish();
  }
  uint64_t files() const { return file_count; }
  bool are_local() const { return any_local; }
  uint64_t shared_pictures() const { return shared; } // frames that have the picture of another

private:
  // Whether no frame is missing between two, and the stage is not empty: its mesh is valid until the end of
  // the group, and no frame need say that there is none.
  static bool goes_on_to(const WrittenFrame &before, const WrittenFrame &frame) {
    return before.number + 1 == frame.number && before.valid_until >= frame.time;
  }

  // follows: nothing is missing since the frame before.
  void add(const GroupPlan &group, const WrittenFrame &frame, bool follows) {
    if (!follows || frame.empty) finish();
    if (!frame.mesh) { // nothing is shown, or still the mesh before
      if (!run.frames.empty()) run.frames.back().held_until = seconds(frame);
      return;
    }
    const fvv_configuration *configuration;
    fvv_diagnostic diagnostic = {};
    fvv::check(fvv_stream_configuration(stream, group.group, &configuration, &diagnostic), "configuration",
               diagnostic);
    const fvv_track *track = mesh_track_of(*configuration, options.rung, nullptr);
    if (!track)
      throw fvv::Error("frame " + std::to_string(frame.number) +
                       ": it has a mesh, and the configuration of its group no track of meshes");
    OwnedMesh mesh;
    const size_t place = group.frame + size_t(frame.number - group.number);
    fvv::check(fvv_stream_mesh(stream, place, track->id, &mesh, &diagnostic),
               "frame " + std::to_string(frame.number), diagnostic);
    std::vector<uint8_t> colours;
    fvv::check(colours_of(stream, *configuration, place, track->id, colours, diagnostic),
               "frame " + std::to_string(frame.number), diagnostic);
    const fvv_scene &now = configuration->scene;
    if (!run.frames.empty() && (!is_same_place(scene, now) || !goes_on(mesh, colours, seconds(frame))))
      finish();
    if (run.frames.empty()) {
      scene = now;
      start = frame.time;
      first = frame.number;
      find_picture(*configuration, frame.number);
    }
    append_frame(mesh, colours, seconds(frame), digits(frame.number), run);
    last = frame.number;
  }

  double seconds(const WrittenFrame &frame) const {
    return double(uint64_t(frame.time) - uint64_t(start)) * scene.time_base.numerator /
           scene.time_base.denominator;
  }

  bool goes_on(const fvv_mesh &mesh, const std::vector<uint8_t> &colours, double time) const {
    const uint64_t bytes = uint64_t(mesh.vertex_count) * 3 * sizeof(float) * (mesh.normals ? 2 : 1);
    return run.frames.size() < most_frames && bytes * (run.frames.size() + 1) <= most_bytes &&
           float(time) > float(std::max(run.frames.back().time, run.frames.back().held_until)) &&
           is_of_run(mesh, colours, run);
  }

  // The picture of the atlas that the run's first frame has in the folder.
  void find_picture(const fvv_configuration &configuration, int64_t number) {
    picture.clear();
    if (options.pictures == Pictures::none) return;
    for (const VideoViews &track : views_of(configuration, options.rung, options.cameras, nullptr))
      for (const View &view : track.views) {
        if (view.tile.camera_id != no_camera || !picture.empty()) continue;
        const Pictures files = files_of(options.pictures, track.video->config);
        const std::string file = name(view.folder, number, extension_of(files));
        if (files != Pictures::exr && std::filesystem::exists(folder.path(file))) picture = file;
      }
  }

  void finish() {
    if (run.frames.empty()) return;
    std::string bytes; // of the picture
    if (!picture.empty() && !run.texture.empty()) {
      bytes = scene::read_file(folder.path(picture), UINT32_MAX);
      shared += run.frames.size() - 1;
    }
    const std::string file = "meshes/" + digits(first) + (first == last ? "" : "-" + digits(last)) + ".glb";
    const geometry::Lattice lattice = lattice_of(scene.lattice_origin, scene.lattice_step);
    bool is_local = false;
    folder.write(file, format_glb(std::move(run), lattice, scene.up_axis, bytes, options.compression,
                                  folder.shown(file), &is_local));
    any_local = any_local || is_local;
    run = {};
    file_count++;
  }

  // A frame's number as in the names of files.
  std::string digits(int64_t number) const {
    return std::filesystem::path(name("meshes", number, "glb")).stem().string();
  }

  fvv_stream *stream;
  const Options &options;
  const FileName &name;
  cli::OutputFolder &folder;
  scene::MeshRun run; // not written yet
  fvv_scene scene = {};
  int64_t start = 0;           // ticks
  int64_t first = 0, last = 0; // frames with a mesh
  std::string picture;         // file in the folder, or none
  uint64_t file_count = 0, shared = 0;
  bool any_local = false;
};

} // namespace

uint64_t write_animations(fvv_stream *stream, const Plan &plan, const std::vector<WrittenFrame> &frames,
                          const Options &options, const FileName &name, cli::OutputFolder &folder,
                          Result &result) {
  Animations animations(stream, options, name, folder);
  animations.write(plan, frames);
  if (animations.shared_pictures())
    result.warnings.push_back(
        "a glTF animation has one picture: " + std::to_string(animations.shared_pictures()) +
        " frames show that of the first frame of their file; atlas/ has their own");
  result.local_origin = result.local_origin || animations.are_local();
  return animations.files();
}

} // namespace fvv::demux
