#include "live/reader.h"

#include "arrays.h"
#include "fvv/frames.h"
#include "fvv_cxx/rung.h"
#include "live/sound.h"
#include "live/visibility.h"
#include "source.h"
#include "stream.h"
#include "values.h"

#include <atomic>
#include <map>
#include <pybind11/stl.h>

namespace fvv::python {

namespace {

struct Destroy {
  void operator()(fvv_frames *p) const { fvv_frames_destroy(p); }
  void operator()(fvv_calibration *p) const { fvv_calibration_destroy(p); }
  void operator()(fvv_mesh_sequence *p) const { fvv_mesh_sequence_close(p); }
};

// A whole frame, decoded.
struct LiveFrame {
  int64_t ticks = 0;
  uint64_t number = 0;
  Meshes meshes;
  std::map<uint16_t, std::shared_ptr<Camera>> cameras; // NULL: it moves and is not calibrated
  Weights visibility;
  std::map<uint16_t, std::shared_ptr<Picture>> pictures;
};

// What to decode besides meshes and cameras.
struct Wanted {
  bool pictures, visibility, sound;
};

// A mesh track: the key mesh and, from the first delta or patched frame on, the sequence that follows it.
struct LiveMeshes {
  std::shared_ptr<Mesh> key;
  std::unique_ptr<fvv_mesh_sequence, Destroy> sequence;
  std::vector<uint8_t> colours; // of the current frame; empty: it has none

  const fvv_mesh *patch() const { return sequence ? fvv_mesh_sequence_patch(sequence.get()) : nullptr; }
};

struct LiveVideo {
  demux::VideoViews views;
  std::optional<demux::PictureDecoder> decoder;
  std::map<uint16_t, fvv_tile> tiles; // by camera, in this group
};

// What decoding frames needs of a configuration and of the frames before. Pointers are into the
// configuration.
class LiveDecoder {
public:
  LiveDecoder(const fvv_configuration &the_configuration, size_t the_rung, const Wanted &parts,
              const Limits &the_limits, const std::string &file_name)
      : configuration(the_configuration), rung(the_rung), wanted(parts), limits(the_limits), file(file_name),
        visibility(the_configuration, the_limits, file), sounds(the_configuration, file) {
    fvv_calibration *created = nullptr;
    require(fvv_calibration_create(configuration.cameras, configuration.camera_count, nullptr, &created), {},
            file);
    calibration.reset(created);
    if (!wanted.pictures) return;
    auto views = demux::views_of(configuration, rung, demux::Selection(), nullptr);
    check_video(views, limits, file);
    for (demux::VideoViews &view : views) videos[view.video->track].views = std::move(view);
  }

  void begin_group(int64_t start, int64_t end) {
    fvv_calibration_reset(calibration.get());
    visibility.begin_group();
    sounds.begin_group(start, end);
    for (auto &[track, video] : videos) {
      video.tiles.clear();
      if (video.decoder) video.decoder->begin_group();
      for (const demux::View &view : video.views.views) video.tiles[view.tile.camera_id] = view.tile;
    }
  }

  std::shared_ptr<LiveFrame> decode(const fvv_frames_event &event) {
    auto frame = std::make_shared<LiveFrame>();
    frame->ticks = event.time;
    // Calibrations and layouts are needed by what may come before them.
    for (size_t i = 0; i < event.chunk_count; i++) {
      const fvv_frame_chunk &chunk = event.chunks[i];
      if (chunk.header.type == FVV_CHUNK_CALIBRATION) add_calibration(chunk);
      if (chunk.header.type == FVV_CHUNK_TILES) add_tiles(chunk);
      if (chunk.header.type == FVV_CHUNK_MESH) add_mesh(chunk, *frame);
    }
    for (size_t i = 0; i < configuration.camera_count; i++)
      frame->cameras[configuration.cameras[i].id] = camera_now(configuration.cameras[i]);
    for (size_t i = 0; i < event.chunk_count; i++) {
      const fvv_frame_chunk &chunk = event.chunks[i];
      if (chunk.header.type == FVV_CHUNK_COLOURS) add_colours(chunk);
      if (chunk.header.type == FVV_CHUNK_VIDEO_PACKET) add_pictures(chunk, *frame);
      if (chunk.header.type == FVV_CHUNK_VISIBILITY)
        visibility.decode(chunk, frame->meshes, calibration.get(), frame->visibility);
    }
    for (auto &[track, mesh] : frame->meshes) mesh->colours = meshes[track].colours;
    return frame;
  }

  // Tracks of the configuration that nothing is decoded of.
  std::vector<uint16_t> unused() const {
    std::vector<uint16_t> out;
    for (size_t i = 0; i < configuration.track_count; i++) {
      const fvv_track &track = configuration.tracks[i];
      const bool is_wanted = track.kind == FVV_TRACK_VIDEO        ? wanted.pictures
                             : track.kind == FVV_TRACK_VISIBILITY ? wanted.visibility
                             : track.kind == FVV_TRACK_AUDIO      ? wanted.sound
                                                                  : track.kind != FVV_TRACK_ENVIRONMENT;
      if (!is_wanted || !in_rung(configuration, track.id, rung)) out.push_back(track.id);
    }
    return out;
  }

  // What is heard of the chunks of a frame, or of those between frames.
  void add_sounds(const fvv_frames_event &event, std::vector<LiveSound> &out) {
    for (size_t i = 0; i < event.chunk_count; i++) {
      if (event.chunks[i].header.type != FVV_CHUNK_AUDIO) continue;
      if (auto sound = sounds.decode(event.chunks[i])) out.push_back(std::move(*sound));
    }
  }

private:
  void call(fvv_status status, fvv_diagnostic &diagnostic, const fvv_frame_chunk &chunk) const {
    if (status >= 0) return;
    diagnostic.offset += chunk.offset;
    require(status, diagnostic, file);
  }

  std::shared_ptr<Mesh> new_mesh(uint16_t track) const {
    auto mesh = std::make_shared<Mesh>();
    const fvv_scene &scene = configuration.scene;
    std::copy(scene.lattice_origin, scene.lattice_origin + 3, mesh->origin);
    mesh->step = scene.lattice_step;
    mesh->track = track;
    return mesh;
  }

  void add_mesh(const fvv_frame_chunk &chunk, LiveFrame &frame) {
    const uint16_t track = chunk.header.track;
    const auto size = size_t(chunk.header.size);
    LiveMeshes &known = meshes[track];
    fvv_diagnostic diagnostic = {};
    if (chunk.header.flags & FVV_FLAG_KEY) {
      known = {};
      auto mesh = new_mesh(track);
      call(fvv_mesh_decode(chunk.payload, size, &limits.core, nullptr, &mesh->mesh, &diagnostic), diagnostic,
           chunk);
      known.key = mesh;
      frame.meshes[track] = mesh;
      return;
    }
    if (!known.key) throw Failure(FVV_ERROR_DAMAGED, "a delta frame comes before its key mesh", file);
    fvv_mesh_header header;
    call(fvv_mesh_peek(chunk.payload, size, &limits.core, &header, &diagnostic), diagnostic, chunk);
    if (!known.sequence) {
      fvv_mesh_sequence *opened = nullptr;
      call(fvv_mesh_sequence_open(&known.key->mesh, nullptr, &opened, &diagnostic), diagnostic, chunk);
      known.sequence.reset(opened);
    }
    call(fvv_mesh_sequence_decode(known.sequence.get(), chunk.payload, size, &diagnostic), diagnostic, chunk);
    carry_colours(known);
    auto mesh = new_mesh(track);
    copy(*fvv_mesh_sequence_mesh(known.sequence.get()), mesh->mesh);
    frame.meshes[track] = mesh;
  }

  static void *resize(void *, void *pointer, size_t, size_t size) {
    if (size) return std::realloc(pointer, size);
    std::free(pointer);
    return nullptr;
  }

  template <class T> static T *copy_of(const T *values, size_t count) {
    if (!values || !count) return nullptr;
    auto *out = static_cast<T *>(resize(nullptr, nullptr, 0, count * sizeof(T)));
    if (!out) throw std::bad_alloc();
    std::copy_n(values, count, out);
    return out;
  }

  static void copy(const fvv_mesh &from, fvv_mesh &to) {
    to.allocator = {resize, nullptr};
    to.vertex_count = from.vertex_count;
    to.face_count = from.face_count;
    to.texture_bits = from.texture_bits;
    to.normal_bits = from.normal_bits;
    to.lattice = copy_of(from.lattice, 3 * size_t(from.vertex_count));
    to.faces = copy_of(from.faces, 3 * size_t(from.face_count));
    to.texture = copy_of(from.texture, 2 * size_t(from.vertex_count));
    to.normals = copy_of(from.normals, 2 * size_t(from.vertex_count));
  }

  void add_calibration(const fvv_frame_chunk &chunk) {
    fvv_diagnostic diagnostic = {};
    call(fvv_calibration_decode(calibration.get(), chunk.payload, size_t(chunk.header.size),
                                (chunk.header.flags & FVV_FLAG_KEY) != 0, &diagnostic),
         diagnostic, chunk);
  }

  std::shared_ptr<Camera> camera_now(const fvv_camera &camera) const {
    if (!(camera.flags & FVV_CAMERA_MOVES)) return std::make_shared<Camera>(camera);
    fvv_camera now;
    if (fvv_calibration_camera(calibration.get(), camera.id, &now) != FVV_OK) return nullptr;
    return std::make_shared<Camera>(now);
  }

  void add_tiles(const fvv_frame_chunk &chunk) {
    const auto video = videos.find(chunk.header.track);
    if (video == videos.end()) return;
    std::vector<fvv_tile> tiles(configuration.camera_count);
    size_t count = 0;
    fvv_diagnostic diagnostic = {};
    call(fvv_tiles_decode(tiles.data(), tiles.size(), &count, chunk.payload, size_t(chunk.header.size),
                          &limits.core, &diagnostic),
         diagnostic, chunk);
    const fvv_video_config &config = video->second.views.video->config;
    call(fvv_tiles_validate(tiles.data(), count, config.width, config.height, &diagnostic), diagnostic,
         chunk);
    video->second.tiles.clear();
    for (size_t i = 0; i < count; i++) video->second.tiles[tiles[i].camera_id] = tiles[i];
  }

  void add_colours(const fvv_frame_chunk &chunk) {
    const auto size = size_t(chunk.header.size);
    fvv_colours_header header;
    fvv_diagnostic diagnostic = {};
    call(fvv_colours_peek(chunk.payload, size, &limits.core, &header, &diagnostic), diagnostic, chunk);
    const auto known = meshes.find(header.mesh_track);
    if (known == meshes.end() || !known->second.key) return;
    LiveMeshes &track = known->second;
    const fvv_mesh *described = track.sequence ? track.patch() : &track.key->mesh;
    if (!described || header.vertex_count != described->vertex_count)
      throw Failure(FVV_ERROR_INVALID, "colours and their mesh differ in vertices", file);
    std::vector<uint8_t> colours(3 * size_t(described->vertex_count));
    call(fvv_colours_decode(chunk.payload, size, described, &limits.core, nullptr, colours.data(),
                            &diagnostic),
         diagnostic, chunk);
    if (!track.sequence)
      track.colours = std::move(colours);
    else if (!track.colours.empty())
      std::copy(colours.begin(), colours.end(), track.colours.end() - long(colours.size()));
  }

  // Those of vertices that a patched frame keeps go with them; a patch shows what no camera shows until its
  // own come.
  void carry_colours(LiveMeshes &track) const {
    uint32_t count = 0;
    const uint32_t *kept = fvv_mesh_sequence_kept(track.sequence.get(), &count);
    if (track.colours.empty() || !kept) return;
    const uint8_t *unseen = configuration.texturing.unseen;
    std::vector<uint8_t> out;
    for (uint32_t v = 0; v < count; v++)
      out.insert(out.end(), &track.colours[3 * size_t(kept[v])], &track.colours[3 * size_t(kept[v])] + 3);
    const fvv_mesh *patch = track.patch();
    for (uint32_t v = 0; patch && v < patch->vertex_count; v++) out.insert(out.end(), unseen, unseen + 3);
    track.colours = std::move(out);
  }

  void add_pictures(const fvv_frame_chunk &chunk, LiveFrame &frame) {
    const auto found = videos.find(chunk.header.track);
    if (found == videos.end()) return;
    LiveVideo &video = found->second;
    const fvv_video_config &config = video.views.video->config;
    const bool key = (chunk.header.flags & FVV_FLAG_KEY) != 0;
    const auto size = size_t(chunk.header.size);
    fvv_diagnostic diagnostic = {};
    call(fvv_video_sample_check(&config, key, chunk.payload, size, &diagnostic), diagnostic, chunk);
    if (!video.decoder) video.decoder.emplace(*video.views.video);
    const auto decoded =
        require_picture(*video.decoder, video.decoder->decode(chunk.payload, size, key), file);
    for (const demux::View &view : video.views.views) {
      const auto tile = video.tiles.find(view.tile.camera_id);
      if (tile == video.tiles.end()) continue;
      const fvv_camera *camera = fvv_configuration_camera(&configuration, view.tile.camera_id);
      fvv_camera now;
      if (camera && camera->flags & FVV_CAMERA_MOVES)
        camera = fvv_calibration_camera(calibration.get(), camera->id, &now) == FVV_OK ? &now : nullptr;
      frame.pictures[view.tile.camera_id] = picture_of(decoded, tile->second, view, camera);
    }
  }

  const fvv_configuration &configuration;
  const size_t rung;
  const Wanted wanted;
  const Limits &limits;
  const std::string &file;
  std::unique_ptr<fvv_calibration, Destroy> calibration;
  LiveVisibility visibility;
  LiveSounds sounds;
  std::map<uint16_t, LiveMeshes> meshes;
  std::map<uint16_t, LiveVideo> videos;
};

class LiveReader {
public:
  LiveReader(const std::string &file_name, size_t the_rung, bool pictures, bool visibility, bool sound,
             bool join, const py::dict &given)
      : file(file_name), rung(the_rung), wanted{pictures, visibility, sound}, limits(given) {
    fvv_frames *created = nullptr;
    require(fvv_frames_create(nullptr, &limits.core, nullptr, &created), {}, file);
    frames.reset(created);
    if (join) require(fvv_frames_join(created), {}, file);
  }

  py::list feed(const py::buffer &bytes) {
    const Busy now(*this);
    if (finished) throw Failure(FVV_ERROR_STATE, "the reader is finished", file);
    if (failure) throw Failure(*failure);
    Py_buffer view = {};
    if (PyObject_GetBuffer(bytes.ptr(), &view, PyBUF_SIMPLE)) throw py::error_already_set();
    const fvv_status status = fvv_frames_push(frames.get(), view.buf, size_t(view.len));
    PyBuffer_Release(&view);
    require(status, {}, file);
    return events();
  }

  py::list finish() {
    const Busy now(*this);
    if (failure) throw Failure(*failure);
    if (!finished) fvv_frames_finish(frames.get());
    finished = true;
    return events();
  }

private:
  // A reader belongs to one thread at a time.
  struct Busy {
    explicit Busy(LiveReader &the_reader) : reader(the_reader) {
      if (reader.busy.exchange(true))
        throw Failure(FVV_ERROR_STATE, "two threads feed one reader at the same time", reader.file);
    }
    ~Busy() { reader.busy = false; }
    LiveReader &reader;
  };

  py::list events() {
    py::list out;
    try {
      while (next(out)) {}
    } catch (const Failure &error) {
      // What came before it is not lost.
      if (!py::len(out)) throw;
      failure.emplace(error);
    }
    return out;
  }

  // Appends what one event of the stream gives; false: there is none yet.
  bool next(py::list &out) {
    fvv_frames_event event;
    fvv_diagnostic diagnostic = {};
    std::shared_ptr<LiveFrame> frame;
    std::vector<LiveSound> heard;
    std::optional<Failure> undecodable;
    {
      const py::gil_scoped_release release;
      const fvv_status status = fvv_frames_next(frames.get(), &event, &diagnostic);
      if (status == FVV_NEED_DATA || status == FVV_END) return false;
      require(status, diagnostic, file);
      try {
        follow(event, frame, heard);
      } catch (const Failure &error) {
        if (error.diagnostic.status > FVV_ERROR_DAMAGED || error.diagnostic.status == FVV_ERROR_LIMIT ||
            error.diagnostic.status == FVV_ERROR_UNSUPPORTED)
          throw;
        undecodable.emplace(error);
        fvv_frames_drop_group(frames.get());
      }
    }
    for (LiveSound &sound : heard) out.append(described(std::move(sound)));
    if (undecodable) {
      out.append(py::make_tuple("damage", describe(undecodable->diagnostic, file), 0));
    } else if (frame) {
      out.append(py::make_tuple("frame", frame));
    } else if (event.kind == FVV_FRAMES_CONFIGURATION && !event.repeated) {
      out.append(py::make_tuple("configuration", describe(*event.configuration, rung)));
    } else if (event.kind == FVV_FRAMES_DAMAGE) {
      out.append(py::make_tuple("damage", describe(event.diagnostic, file), event.skipped));
    } else if (event.kind == FVV_FRAMES_END) {
      out.append(py::make_tuple("end"));
    }
    return true;
  }

  static py::tuple described(LiveSound &&sound) {
    py::object position = py::none();
    if (sound.position) {
      const auto &place = *sound.position;
      position = py::make_tuple(place[0], place[1], place[2]);
    }
    const auto count = py::ssize_t(sound.samples.size() / sound.channels);
    return py::make_tuple("sound", sound.track, sound.rate, sound.start,
                          owning(std::move(sound.samples), {count, py::ssize_t(sound.channels)}), position);
  }

  void follow(const fvv_frames_event &event, std::shared_ptr<LiveFrame> &frame,
              std::vector<LiveSound> &heard) {
    if (event.kind == FVV_FRAMES_CONFIGURATION) {
      // Pointers into the former one are not valid any more, even when its chunks are the same.
      decoder.reset();
      decoder.emplace(*event.configuration, rung, wanted, limits, file);
      const std::vector<uint16_t> unused = decoder->unused();
      require(fvv_frames_leave_out(frames.get(), unused.data(), unused.size()), {}, file);
    } else if (event.kind == FVV_FRAMES_GROUP && decoder) {
      decoder->begin_group(event.time, event.end);
    } else if (event.kind == FVV_FRAMES_BETWEEN && decoder) {
      decoder->add_sounds(event, heard);
    } else if (event.kind == FVV_FRAMES_FRAME && decoder) {
      decoder->add_sounds(event, heard);
      frame = decoder->decode(event);
      frame->number = count++;
    }
  }

  const std::string file;
  const size_t rung;
  const Wanted wanted;
  const Limits limits;
  std::unique_ptr<fvv_frames, Destroy> frames;
  std::optional<LiveDecoder> decoder;
  std::optional<Failure> failure;
  std::atomic<bool> busy{false};
  bool finished = false;
  uint64_t count = 0;
};

py::object visibility_of(const py::object &self, uint16_t mesh_track, uint16_t camera) {
  const auto &frame = self.cast<const LiveFrame &>();
  const auto found = frame.visibility.find({mesh_track, camera});
  if (found == frame.visibility.end()) return py::none();
  py::array_t<uint8_t> out(py::ssize_t(found->second.size()), found->second.data(), self);
  out.attr("flags").attr("writeable") = false;
  return std::move(out);
}

} // namespace

void register_live(py::module_ &module) {
  py::class_<LiveFrame, std::shared_ptr<LiveFrame>>(module, "LiveFrame")
      .def_readonly("ticks", &LiveFrame::ticks)
      .def_readonly("number", &LiveFrame::number)
      .def_readonly("meshes", &LiveFrame::meshes)
      .def_readonly("cameras", &LiveFrame::cameras)
      .def_readonly("pictures", &LiveFrame::pictures)
      .def("visibility", visibility_of, py::arg("mesh_track"), py::arg("camera"));
  py::class_<LiveReader>(module, "LiveReader")
      .def(py::init<const std::string &, size_t, bool, bool, bool, bool, const py::dict &>(), py::arg("name"),
           py::arg("rung"), py::arg("pictures"), py::arg("visibility"), py::arg("sound"), py::arg("join"),
           py::arg("limits"))
      .def("feed", &LiveReader::feed, py::arg("bytes"))
      .def("finish", &LiveReader::finish);
}

} // namespace fvv::python
