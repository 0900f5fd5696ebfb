// Visibility of a file as players use it: how often its weights, or depth maps in their place, differ from
// rays, and the time that weights take.
#include "visibility_places.h"

#include "fvv_render/visibility_fit.h"

#include <memory>

namespace {

using namespace visibility_bench;

constexpr size_t most_cameras = 3; // that a place is textured from
constexpr size_t most_frames = 10;

// Pairs of a camera and a place of the surface that camera might be used for.
struct Pairs {
  double all = 0, shown = 0, hidden = 0; // of all: shown wrongly, hidden wrongly
  void add(bool says, bool truth) {
    all++;
    shown += says && !truth;
    hidden += !says && truth;
  }
  void report(nlohmann::ordered_json &out, const std::string &name, double everything) const {
    out[name + "error_percent"] = 100 * (shown + hidden) / all;
    out[name + "error_of_all_percent"] = 100 * (shown + hidden) / everything;
    out[name + "shown_wrongly_percent"] = 100 * shown / all;
    out[name + "hidden_wrongly_percent"] = 100 * hidden / all;
  }
};

// A camera that a place may be textured from.
struct Candidate {
  double weight;
  bool given, map, truth;
};

struct Sums {
  Pairs given, map;
  double pairs = 0;                // of place and camera, also where the camera is no candidate
  double face_pairs = 0;           // of face and camera
  double coloured = 0;             // places that some camera shows
  double by_given = 0, by_map = 0; // the part of their colour that comes from other cameras than by rays
  double frames = 0, look = 0, order = 0, encode = 0, decode = 0; // seconds
};

// The contribution of each candidate to the colour of its place.
std::vector<double> given(const std::vector<Candidate> &candidates, bool Candidate::*seen) {
  std::vector<size_t> order;
  for (size_t i = 0; i < candidates.size(); i++)
    if (candidates[i].*seen) order.push_back(i);
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return candidates[a].weight > candidates[b].weight; });
  order.resize(std::min(order.size(), most_cameras));
  double sum = 0;
  for (const size_t i : order) sum += candidates[i].weight;
  std::vector<double> out(candidates.size());
  for (const size_t i : order) out[i] = candidates[i].weight / sum;
  return out;
}

// A place without colour differs entirely.
double elsewhere(const std::vector<double> &ours, const std::vector<double> &theirs) {
  double more = 0, less = 0;
  for (size_t i = 0; i < ours.size(); i++) {
    more += std::max(0.0, ours[i] - theirs[i]);
    less += std::max(0.0, theirs[i] - ours[i]);
  }
  return std::max(more, less);
}

void compare_colours(const std::vector<std::vector<Candidate>> &places, Sums &sums) {
  for (const std::vector<Candidate> &candidates : places) {
    const std::vector<double> truth = given(candidates, &Candidate::truth);
    sums.coloured += std::any_of(truth.begin(), truth.end(), [](double weight) { return weight > 0; });
    sums.by_given += elsewhere(given(candidates, &Candidate::given), truth);
    sums.by_map += elsewhere(given(candidates, &Candidate::map), truth);
  }
}

// Weights as players use them, and a depth map, against rays.
void compare(const Frame &frame, const View &view, std::vector<std::vector<Candidate>> &candidates,
             Sums &sums) {
  const DepthMap map(view.camera, frame.surface.view(), {});
  sums.pairs += double(frame.places.size());
  sums.face_pairs += frame.surface.mesh.face_count;
  for (size_t i = 0; i < frame.places.size(); i++) {
    const Place &place = frame.places[i];
    const auto found = view.judge(frame.surface, frame.rays, place);
    if (!found) continue;
    const bool by_map = found->front && !map.hidden(found->where, frame.surface.face_normal(place.face));
    candidates[i].push_back({found->weight, found->given, by_map, found->truth});
    sums.given.add(found->given, found->truth);
    sums.map.add(by_map, found->truth);
  }
}

// The time of encoder and decoder for one frame without the one before.
void time_coding(const Surface &surface, const fvv_visibility_header &coded,
                 const std::vector<fvv_camera> &cameras, const fvv_scene &scene, const RayCaster &rays,
                 Sums &sums) {
  const fvv_mesh &mesh = surface.mesh;
  fvv_visibility_header header = coded;
  header.number = 0;
  std::vector<std::vector<uint8_t>> seen;
  std::vector<fvv_visibility_view> views;
  fvv_diagnostic d{};
  sums.look += seconds([&] {
    const VisibilityFit fit(surface.view(), rays, {});
    for (const fvv_camera &camera : cameras) {
      fvv_visibility_view view = {};
      view.camera = camera.id;
      require(fvv_visibility_centre(&camera, &scene, view.centre, &d), d);
      std::vector<uint8_t> facing(header.vertex_count);
      fvv_visibility_facing(&mesh, view.centre, header.threshold, facing.data());
      seen.push_back(fit.states(camera, facing, nullptr));
      views.push_back(view);
    }
  });
  for (size_t i = 0; i < views.size(); i++) views[i].seen = seen[i].data();
  fvv_visibility_order *order = nullptr;
  fvv_bytes payload{};
  sums.order += seconds([&] { require(fvv_visibility_order_open(&mesh, nullptr, &order, &d), d); });
  sums.encode += seconds([&] {
    require(fvv_visibility_encode(order, &mesh, &header, views.data(), views.size(), &payload, &d), d);
  });
  std::vector<fvv_visibility_stream> streams(views.size());
  std::vector<uint8_t> states(header.vertex_count);
  sums.decode += seconds([&] {
    require(
        fvv_visibility_peek(payload.data, payload.size, nullptr, &header, streams.data(), streams.size(), &d),
        d);
    for (size_t c = 0; c < views.size(); c++)
      require(fvv_visibility_decode(order, &mesh, &header, payload.data + streams[c].offset, streams[c].size,
                                    views[c].centre, nullptr, states.data(), &d),
              d);
  });
  fvv_bytes_free(&payload);
  fvv_visibility_order_close(order);
}

// None if the frame has no visibility.
std::unique_ptr<Frame> add_frame(fvv_stream *stream, size_t number, uint16_t track, Sums &sums) {
  fvv_diagnostic d{};
  const fvv_configuration *configuration = nullptr;
  fvv_frame where;
  require(fvv_stream_frame(stream, number, &where, &d), d);
  require(fvv_stream_configuration(stream, where.group, &configuration, &d), d);
  const fvv_scene scene = configuration->scene;
  auto frame = std::make_unique<Frame>(stream, number, scene);
  const fvv_visibility *visibility = nullptr;
  require(fvv_stream_visibility(stream, number, track, &visibility, &d), d);
  if (!visibility) return nullptr;
  const fvv_visibility_header header = visibility->header;
  const std::vector<uint8_t> states(visibility->states,
                                    visibility->states + size_t(header.camera_count) * header.vertex_count);
  const std::vector<uint16_t> ids(visibility->cameras, visibility->cameras + header.camera_count);
  std::vector<fvv_camera> cameras(ids.size());
  std::vector<std::vector<Candidate>> candidates(frame->places.size());
  for (size_t i = 0; i < ids.size(); i++) {
    require(fvv_stream_camera(stream, number, ids[i], &cameras[i], &d), d);
    const uint8_t *seen = &states[i * header.vertex_count];
    frame->views.emplace_back(cameras[i], frame->surface, seen);
    compare(*frame, frame->views.back(), candidates, sums);
  }
  compare_colours(candidates, sums);
  time_coding(frame->surface, header, cameras, scene, frame->rays, sums);
  sums.frames++;
  return frame;
}

// The stream of a file in memory, and its visibility track.
struct Source {
  Bytes bytes;
  fvv_input input;
  fvv_stream *stream = nullptr;
  uint16_t track = 0;

  explicit Source(const char *path) : bytes(read_file(path)), input(input_of(bytes)) {
    fvv_diagnostic d{};
    require(fvv_stream_open(&input, nullptr, nullptr, &stream, &d), d);
    const fvv_configuration *configuration = nullptr;
    require(fvv_stream_configuration(stream, 0, &configuration, &d), d);
    for (size_t i = 0; i < configuration->track_count; i++)
      if (configuration->tracks[i].kind == FVV_TRACK_VISIBILITY) track = configuration->tracks[i].id;
    if (!track) throw std::runtime_error("the file has no visibility");
  }
  Source(const Source &) = delete;
  ~Source() { fvv_stream_close(stream); }
};

// Depth maps of a part of the picture's size, with a tolerance.
struct MapSetting {
  double size, bias;
  Pairs pairs;
  double time = 0; // seconds: of making the map, and of the lookups
};

fvv_camera scaled(fvv_camera camera, double by) {
  camera.width = uint32_t(std::lround(camera.width * by));
  camera.height = uint32_t(std::lround(camera.height * by));
  for (double *value : {&camera.fx, &camera.fy, &camera.cx, &camera.cy, &camera.skew}) *value *= by;
  return camera;
}

void try_maps(const Frame &frame, const View &view, std::vector<MapSetting> &settings, double &pairs) {
  std::vector<std::pair<View::Judgement, Vec3>> places;
  for (const Place &place : frame.places)
    if (const auto found = view.judge(frame.surface, frame.rays, place))
      places.emplace_back(*found, frame.surface.face_normal(place.face));
  pairs += double(frame.places.size());
  for (MapSetting &setting : settings)
    setting.time += seconds([&] {
      DepthTest test;
      test.bias = setting.bias;
      const DepthMap map(scaled(view.camera, setting.size), frame.surface.view(), test);
      for (const auto &[found, normal] : places)
        setting.pairs.add(found.front && !map.hidden(found.where, normal), found.truth);
    });
}

} // namespace

// error_percent: of the pairs of a camera and a place, with places spread over the surface by area, that lie
// in the picture and whose weight reaches 0.25, those where a player would show the camera's picture though
// something hides the place, or not show it though nothing does. The reference is the ray to that place.
// error_of_all_percent: the same beside all pairs of a camera and a place, as bits are counted beside all
// pairs of a camera and a face; a pair that is not tested cannot be wrong. colour_elsewhere_percent: of the
// colour of the places that some camera shows, by the three best of those that see them, the fraction that
// comes from other cameras than by rays. depth_map: the same with the reference's depth map at the size of
// the picture.
nlohmann::ordered_json visibility(const char *path) {
  const Source source(path);
  Sums sums;
  Flicker flicker;
  std::unique_ptr<Frame> before;
  for (size_t f = 0; f < std::min(fvv_stream_frame_count(source.stream), most_frames); f++) {
    std::unique_ptr<Frame> now = add_frame(source.stream, f, source.track, sums);
    if (before && now) flicker.add(*before, *now);
    before = std::move(now);
  }
  nlohmann::ordered_json out;
  sums.given.report(out, "", sums.pairs);
  out["colour_elsewhere_percent"] = 100 * sums.by_given / sums.coloured;
  sums.map.report(out, "depth_map_", sums.pairs);
  out["depth_map_colour_elsewhere_percent"] = 100 * sums.by_map / sums.coloured;
  flicker.report(out);
  out["face_pairs_per_frame"] = sums.face_pairs / sums.frames;
  out["look_ms"] = sums.look / sums.frames * 1e3;
  out["order_ms"] = sums.order / sums.frames * 1e3;
  out["encode_ms"] = sums.encode / sums.frames * 1e3;
  out["decode_ms"] = sums.decode / sums.frames * 1e3;
  return out;
}

// Rows of depth maps by their size, as a factor of the picture's, and their bias (DepthTest): errors as
// above, and the time for one camera and frame.
nlohmann::ordered_json depth_maps(const char *path) {
  constexpr size_t frames = 3;
  const Source source(path);
  std::vector<MapSetting> settings;
  for (const double size : {0.25, 0.5, 1.0})
    for (const double bias : {0.0, 0.1, 0.2, 0.5, 1.0, 2.0}) settings.push_back({size, bias, {}});
  double pairs = 0, maps = 0;
  for (size_t f = 0; f < std::min(fvv_stream_frame_count(source.stream), frames); f++) {
    fvv_diagnostic d{};
    const fvv_configuration *configuration = nullptr;
    fvv_frame where;
    require(fvv_stream_frame(source.stream, f, &where, &d), d);
    require(fvv_stream_configuration(source.stream, where.group, &configuration, &d), d);
    const Frame frame(source.stream, f, configuration->scene);
    const fvv_visibility *visibility = nullptr;
    require(fvv_stream_visibility(source.stream, f, source.track, &visibility, &d), d);
    if (!visibility) continue;
    const std::vector<uint16_t> ids(visibility->cameras,
                                    visibility->cameras + visibility->header.camera_count);
    const std::vector<uint8_t> states(frame.surface.mesh.vertex_count);
    for (const uint16_t id : ids) {
      fvv_camera camera;
      require(fvv_stream_camera(source.stream, f, id, &camera, &d), d);
      try_maps(frame, View(camera, frame.surface, states.data()), settings, pairs);
      maps++;
    }
  }
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const MapSetting &setting : settings) {
    nlohmann::ordered_json row = {{"size", setting.size}, {"bias", setting.bias}};
    setting.pairs.report(row, "", pairs);
    row["map_ms"] = setting.time / maps * 1e3;
    rows.push_back(row);
  }
  return rows;
}
