// A clip with random access. One lock for all of it: threads that use one clip take turns, threads with a
// clip each run at the same time.
#pragma once

#include "fvv_demux/frame_plan.h"
#include "fvv_demux/picture_decoder.h"
#include "fvv_demux/views.h"
#include "fvv_view/frame.h"
#include "source.h"
#include "values.h"

#include <atomic>
#include <cstring>
#include <map>
#include <mutex>
#include <thread>

namespace fvv::python {

// What a decoder's call left; NULL: the frame has no picture. Throws Failure when status is an error.
std::shared_ptr<const demux::VideoFrame> require_picture(const demux::PictureDecoder &decoder,
                                                         fvv_status status, const std::string &file);

// Throws Failure if decoding these tracks takes more than limits allow, or a codec is not known.
void check_video(const std::vector<demux::VideoViews> &tracks, const Limits &limits, const std::string &file);

// What Python needs of a configuration: a dict of plain values.
py::dict describe(const fvv_configuration &configuration, size_t rung);
// (status, issue, chunk, offset, text).
py::tuple describe(const fvv_diagnostic &diagnostic, const std::string &file);

// The picture of a tile; frame is not NULL. calibration: of the camera in the frame, NULL: none.
std::shared_ptr<Picture> picture_of(const std::shared_ptr<const demux::VideoFrame> &frame,
                                    const fvv_tile &tile, const demux::View &view,
                                    const fvv_camera *calibration);

class Stream {
public:
  Stream(const py::object &object, const std::string &name, size_t rung, const py::dict &limits);

  void close();
  bool closed() const { return is_closed; }
  size_t size() const { return places.empty() ? 0 : places.back().begin + places.back().count; }
  py::tuple frame(size_t i); // (ticks, number, group)
  int64_t number(size_t i);  // in the undamaged stream
  size_t at(int64_t ticks);  // the last frame that begins no later
  py::tuple span();          // ticks: start and end
  // Of a group; without one, the first that can be read.
  py::dict configuration(std::optional<size_t> group);
  uint64_t configuration_offset(size_t group); // where it is in the stream: groups with one share it
  std::shared_ptr<Mesh> mesh(size_t i, uint16_t track);
  std::shared_ptr<Camera> camera(size_t i, uint16_t id);
  py::object visibility(size_t i, uint16_t mesh_track, uint16_t camera);
  std::vector<uint16_t> picture_cameras(size_t i);
  std::shared_ptr<Picture> picture(size_t i, uint16_t camera);
  py::object environment(size_t i); // None: there is none in the frame's group
  std::vector<std::shared_ptr<Sound>> sounds();
  py::list problems();
  // Of a group, or of all whose tables can be read: a structured array, see ChunkRow.
  py::array chunks(std::optional<size_t> group);
  uint64_t bytes_in_all() const { return byte_count; }
  py::bytes read_at(uint64_t offset, size_t size);

  // The bytes of the clip for another reader in C++: reads take turns with this object's, and fail when the
  // clip is closed. Valid as long as this object.
  fvv_input reading();
  // With the GIL, after such a reader: raises what made its reads fail.
  void check_reading();
  // Throws Failure when the pictures of a frame are beyond the limits.
  void check_pictures(size_t i);
  // A frame to be drawn; the last one is kept, until close. Without the GIL. Throws as view::load_frame.
  std::shared_ptr<const view::Frame> loaded(int64_t frame_number, bool pictures);
  const fvv_limits &core_limits() const { return limits.core; }
  size_t chosen_rung() const { return rung; }
  const std::string &name() const { return source.name(); }

private:
  struct Place {
    size_t begin, count; // frames of the clip
    demux::GroupPlan plan;
  };
  struct Located {
    size_t frame, first, group; // of fvv_stream; first: of the group
    int64_t ticks, number;
  };
  static fvv_status read_in_turn(void *user, uint64_t offset, void *out, size_t size);
  template <class Work> auto run(const Work &work);
  void meet(const fvv_diagnostic &damage); // it becomes one of the problems
  const Place &place_of(size_t i) const;
  Located locate(size_t i);
  const fvv_configuration &configuration_of(size_t group);
  void call(fvv_status status, const fvv_diagnostic &diagnostic) const;

  const Limits limits;
  const size_t rung;
  Source source;
  const uint64_t total; // bytes of it
  std::mutex lock;
  std::atomic<std::thread::id> owner{};
  std::atomic<bool> is_closed{false};
  demux::LazySurvey survey;
  demux::Stream stream;
  demux::Plan plan;
  std::vector<Place> places;
  uint64_t byte_count = 0;
  std::map<uint16_t, demux::PictureDecoder> videos; // by track, of the configuration at video_configuration
  uint64_t video_configuration = 0;
  std::vector<fvv_diagnostic> met; // damage that reading ran into
  std::vector<std::string> sound_losses;
  std::mutex kept_lock; // of all below
  std::shared_ptr<const view::Frame> kept;
  bool kept_pictures = false;
};

void register_stream(py::module_ &module);

} // namespace fvv::python
