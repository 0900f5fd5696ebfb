// Reads a stream back and compares it with the capture.
#include "mux/src/verify.h"
#include "fvv/stream.h"
#include "fvv_cxx/error.h"
#include "fvv_cxx/input_file.h"
#include "fvv_cxx/owned.h"
#include "fvv_cxx/parallel.h"
#include "fvv_demux/picture_decoder.h"
#include "mux/src/environment.h"
#include "mux/src/meshes/meshes.h"
#include "mux/src/pictures.h"
#include "mux/src/sound/sound.h"
#include "mux/src/stream_writer.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace fvv::mux {

namespace {

bool is_packed(const fvv_environment &found, const std::vector<uint8_t> &payload, const std::string &name) {
  OwnedBytes again;
  fvv_diagnostic diagnostic = {};
  fvv::check(fvv_environment_encode(&found, nullptr, &again, &diagnostic), name, diagnostic);
  return std::equal(payload.begin(), payload.end(), again.data, again.data + again.size);
}

// Every vertex lies within the part's bounds, but for the lattice; faces are at most left out.
bool is_part(const fvv_mesh &mesh, const geometry::Mesh &source, const fvv_environment &environment) {
  double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (size_t i = 0; i < source.positions.size(); i++) {
    low[i % 3] = std::min(low[i % 3], source.positions[i]);
    high[i % 3] = std::max(high[i % 3], source.positions[i]);
  }
  const double slack = 0.51 * environment.lattice_step;
  for (size_t i = 0; i < 3 * size_t(mesh.vertex_count); i++) {
    const double value =
        environment.lattice_origin[i % 3] + environment.lattice_step * double(mesh.lattice[i]);
    if (!(value >= low[i % 3] - slack && value <= high[i % 3] + slack)) return false;
  }
  return mesh.face_count <= source.faces.size() / 3;
}

std::string against_capture(const fvv_environment &found, const scene::Capture &capture,
                            const std::string &name) {
  const scene::Environment source = scene::load_environment(capture);
  if (found.part_count != source.parts.size() || found.picture_count != source.pictures.size() ||
      found.light_count != source.lights.size())
    return "expected " + std::to_string(source.parts.size()) + " parts, " +
           std::to_string(source.pictures.size()) + " pictures and " + std::to_string(source.lights.size()) +
           " lights, found " + std::to_string(found.part_count) + ", " + std::to_string(found.picture_count) +
           " and " + std::to_string(found.light_count);
  for (size_t i = 0; i < found.part_count; i++) {
    OwnedMesh holder;
    fvv_diagnostic diagnostic = {};
    fvv::check(fvv_environment_mesh(&found, i, nullptr, nullptr, &holder, &diagnostic), name, diagnostic);
    const scene::EnvironmentPart &part = source.parts[i];
    const uint32_t picture = part.picture ? uint32_t(*part.picture) : FVV_NO_PICTURE;
    if (found.parts[i].picture != picture || !is_part(holder, part.mesh, found))
      return "part " + std::to_string(i) + " is not that of the capture";
  }
  for (size_t i = 0; i < found.picture_count; i++) {
    const std::string wanted = fit_picture(source.pictures[i], name, capture.memory_limit).file;
    const auto *bytes = reinterpret_cast<const char *>(found.pictures[i].data);
    if (wanted.compare(0, wanted.npos, bytes, found.pictures[i].size))
      return "picture " + std::to_string(i) + " is not that of the capture";
  }
  return "";
}

} // namespace

std::string verify_environment(fvv_stream *stream, size_t group, const Plan &plan, const std::string &name) {
  if (!plan.environment) return "";
  const fvv_environment *found = nullptr;
  fvv_diagnostic diagnostic = {};
  const fvv_status status = fvv_stream_environment(stream, group, environment_track, &found, &diagnostic);
  fvv::check(status, name, diagnostic);
  std::string wrong;
  if (status == FVV_END)
    wrong = "there is none";
  else if (group == 0)
    wrong = against_capture(*found, plan.capture, name);
  if (wrong.empty() && !is_packed(*found, plan.environment->payload, name))
    wrong = "it is not the one that was written";
  return wrong.empty() ? "" : "group " + std::to_string(group) + ": environment: " + wrong;
}

namespace {

// The cameras of the stream in that frame, without those that are not calibrated.
std::vector<fvv_camera> cameras_in(fvv_stream *stream, size_t frame, const Plan &plan,
                                   const std::string &name) {
  std::vector<fvv_camera> out;
  for (const size_t index : plan.visibility.cameras) {
    fvv_camera camera;
    fvv_diagnostic diagnostic = {};
    const fvv_status status =
        fvv_stream_camera(stream, frame, plan.capture.cameras[index].calibration.id, &camera, &diagnostic);
    fvv::check(status, name, diagnostic);
    if (status == FVV_OK) out.push_back(camera);
  }
  return out;
}

} // namespace

std::string VisibilityVerifier::frame(fvv_stream *stream, size_t frame, const fvv_mesh &mesh) {
  const fvv_visibility *found = nullptr;
  fvv_diagnostic diagnostic = {};
  const fvv_status status = fvv_stream_visibility(stream, frame, track.visibility, &found, &diagnostic);
  fvv::check(status, name, diagnostic);
  if (!found || !found->header.number) previous.clear();
  const std::vector<CameraView> wanted =
      look(mesh, plan.lattice.lattice, plan.visibility, cameras_in(stream, frame, plan, name), previous);
  previous.clear();
  const size_t cameras = found ? found->header.camera_count : 0;
  if (cameras != wanted.size())
    return "expected visibility of " + std::to_string(wanted.size()) + " cameras, found " +
           std::to_string(cameras);
  for (size_t i = 0; i < cameras; i++) {
    const uint8_t *states = found->states + i * found->header.vertex_count;
    for (size_t k = 0; k < wanted[i].facing.size(); k++)
      if (found->cameras[i] != wanted[i].camera ||
          states[k] != (wanted[i].facing[k] ? wanted[i].seen[k] : uint8_t(FVV_VERTEX_BACKFACING)))
        return "what camera " + std::to_string(wanted[i].camera) + " sees of vertex " + std::to_string(k) +
               " is not what was read back";
    previous[found->cameras[i]].assign(states, states + found->header.vertex_count);
  }
  return "";
}

namespace {

// A swapped or broken picture is worse by tens of dB; content that is harder to code than the sample by a
// few.
constexpr double psnr_slack = 10;
constexpr double exact_enough = 60;         // dB: a sample better than this does not predict other frames
constexpr double reprojection_slack = 1e-6; // pixels; cameras that do not move are stored bit for bit
constexpr double moving_slack = 0.05;       // pixels, for cameras that move
constexpr double r_max_slack = 1e-3;        // of r_max, of a camera that moves: it is rounded down
constexpr double distance_in_steps = 1000;  // of the lattice, from a camera to the points that are compared

struct GroupVerdict {
  std::vector<MeshTrackVerdict> meshes;
  std::vector<VideoVerdict> videos;
  double moving_reprojection = 0; // pixels, of cameras that move
  size_t environments = 0, sounds = 0;
};

// How far a rotation is from an orthonormal one, to which a camera that moves is rounded, in pixels.
double skewed(const fvv_camera &camera) {
  const double *r = camera.rotation;
  double worst = 0;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      const double dot = r[3 * i] * r[3 * j] + r[3 * i + 1] * r[3 * j + 1] + r[3 * i + 2] * r[3 * j + 2];
      worst = std::max(worst, std::fabs(dot - (i == j)));
    }
  return worst * (std::max(camera.fx, camera.fy) + camera.width + camera.height);
}

// Pixels all over the picture go out through the capture's camera and come back through the stream's.
// distance: of the points, along the axis.
double reprojection(const fvv_camera &ours, const fvv_camera &theirs, double distance) {
  constexpr int steps = 8;
  double centre[3], worst = 0;
  fvv_camera_centre(&ours, centre);
  for (int i = 0; i < steps * steps; i++) {
    const double pixel[2] = {ours.width * double(i % steps) / (steps - 1),
                             ours.height * double(i / steps) / (steps - 1)};
    double ray[3], world[3], before[2], after[2];
    if (!fvv_camera_unproject(&ours, pixel, ray)) continue;
    for (int k = 0; k < 3; k++)
      world[k] = centre[k] + distance * (ours.rotation[k] * ray[0] + ours.rotation[3 + k] * ray[1] +
                                         ours.rotation[6 + k] * ray[2]);
    if (!fvv_camera_project(&ours, world, before, nullptr)) continue;
    if (!fvv_camera_project(&theirs, world, after, nullptr)) return INFINITY;
    worst = std::max(worst, std::hypot(before[0] - after[0], before[1] - after[1]));
  }
  return worst;
}

// Reads with a handle of its own, so that several may run at once.
class Reader {
public:
  Reader(const Plan &chosen, const Decisions &decided, const std::vector<std::vector<MeshOrigins>> &reported,
         const InputFile &source)
      : plan(chosen), decisions(decided), origins(reported), name(source.path()),
        stream(nullptr, fvv_stream_close) {
    for (const MeshTrack &track : plan.meshes) visibility.emplace_back(plan, track, name);
    const fvv_input input = source.input();
    fvv_stream *opened = nullptr;
    const fvv_status status = fvv_stream_open(&input, nullptr, nullptr, &opened, &diagnostic);
    stream.reset(opened);
    fvv::check(status, name, diagnostic);
  }

  // Groups, frames and index are there. Returns the configuration, which lives as long as this object.
  const fvv_configuration &whole() {
    if (fvv_stream_index_state(stream.get()) != (plan.options.live ? FVV_INDEX_REBUILT : FVV_INDEX_PRESENT))
      throw Error(name + ": the index differs from what was written");
    if (fvv_stream_damage_count(stream.get())) fvv::fail(name, *fvv_stream_damage(stream.get(), 0));
    expect(fvv_stream_group_count(stream.get()), plan.group_count() + (plan.groups.back().end < plan.end()),
           "groups");
    expect(fvv_stream_frame_count(stream.get()), plan.frame_count(), "frames");
    return configuration(0);
  }

  GroupVerdict group(size_t index) {
    GroupVerdict verdict;
    for (const VideoTrack &track : plan.tracks) verdict.videos.push_back(pictures(index, track));
    verdict.meshes.resize(plan.meshes.size());
    for (size_t track = 0; track < plan.meshes.size(); track++)
      for (size_t i = 0; decisions.meshes[track].sent && i < plan.frames_of(index); i++)
        mesh(track, plan.first_of(index) + i, verdict.meshes[track]);
    for (size_t i = 0; i < plan.frames_of(index); i++) moving(plan.first_of(index) + i, verdict);
    const std::string wrong = verify_environment(stream.get(), index, plan, name);
    if (!wrong.empty()) throw Error(name + ": " + wrong);
    verdict.environments += plan.environment != nullptr;
    sound(index);
    verdict.sounds += !plan.sounds.empty();
    return verdict;
  }

private:
  const fvv_configuration &configuration(size_t group) {
    const fvv_configuration *found = nullptr;
    fvv::check(fvv_stream_configuration(stream.get(), group, &found, &diagnostic), name, diagnostic);
    return *found;
  }

  void expect(size_t found, size_t expected, const char *what) const {
    if (found != expected)
      throw Error(name + ": expected " + std::to_string(expected) + " " + what + ", found " +
                  std::to_string(found));
  }

  [[noreturn]] void fail(size_t frame, const std::string &what) const {
    throw Error(name + ": frame " + std::to_string(plan.capture.frames.number(int64_t(frame))) + ": " + what);
  }

  // FVV_END is allowed: there is none.
  void check(fvv_status status, size_t frame, const char *what) const {
    if (status == FVV_END) fail(frame, std::string("there is no ") + what);
    fvv::check(status, name, diagnostic);
  }

  void mesh(size_t track, size_t frame, MeshTrackVerdict &verdict) {
    OwnedMesh decoded;
    const MeshTrack &of = plan.meshes[track];
    const fvv_status status = fvv_stream_mesh(stream.get(), frame, of.id, &decoded, &diagnostic);
    if (!plan.has_mesh(frame)) {
      if (status != FVV_END) fail(frame, "there is a mesh, and none in the capture");
      return;
    }
    check(status, frame, "mesh");
    try {
      verdict.mesh.add(verify_mesh(plan, of, frame, decoded, origins[track][frame]));
    } catch (const MeshMismatch &mismatch) {
      fail(frame, mismatch.what());
    }
    verdict.meshes++;
    if (plan.colours.on) colours(of, frame, decoded.vertex_count);
    if (!decisions.visibility.on) return;
    const std::string wrong = visibility[track].frame(stream.get(), frame, decoded);
    if (!wrong.empty()) fail(frame, wrong);
    verdict.visible++;
  }

  void colours(const MeshTrack &track, size_t frame, uint32_t vertices) {
    const uint8_t *found = nullptr;
    uint32_t count = 0;
    check(fvv_stream_colours(stream.get(), frame, track.id, &found, &count, &diagnostic), frame,
          "colour of vertices");
    if (count != vertices)
      fail(frame,
           "expected colours of " + std::to_string(vertices) + " vertices, found " + std::to_string(count));
  }

  void moving(size_t frame, GroupVerdict &verdict) {
    for (const scene::Camera &camera : plan.capture.cameras) {
      if (!camera.moves()) continue;
      const int64_t number = plan.capture.frames.number(int64_t(frame));
      const uint16_t id = camera.calibration.id;
      fvv_camera theirs;
      const fvv_status found = fvv_stream_camera(stream.get(), frame, id, &theirs, &diagnostic);
      if (!camera.is_calibrated(number)) {
        if (found != FVV_END)
          fail(frame, "camera " + std::to_string(id) + " is calibrated, and lost in the capture");
        continue;
      }
      fvv_camera ours = camera.calibration_at(number);
      check(found, frame, "calibration");
      const bool reaches =
          std::isinf(ours.r_max) ? std::isinf(theirs.r_max) : theirs.r_max >= ours.r_max * (1 - r_max_slack);
      ours.r_max = theirs.r_max;
      const double pixels =
          reaches ? reprojection(ours, theirs, distance_in_steps * plan.lattice.lattice.step) : INFINITY;
      if (!(pixels <= moving_slack + skewed(ours)))
        fail(frame, "camera " + std::to_string(ours.id) + " is not the camera of the capture");
      verdict.moving_reprojection = std::max(verdict.moving_reprojection, pixels);
    }
  }

  // The chunks of a group are those of the plan, byte for byte.
  void sound(size_t index) {
    if (plan.sounds.empty()) return;
    const std::vector<SoundChunk> wanted = sound_chunks(plan, plan.groups[index]);
    const fvv_chunk_info *chunks = nullptr;
    size_t count = 0, found = 0;
    fvv::check(fvv_stream_group_chunks(stream.get(), index, &chunks, &count, &diagnostic), name, diagnostic);
    for (size_t i = 0; i < count; i++) {
      if (chunks[i].type != FVV_CHUNK_AUDIO) continue;
      const uint8_t *payload = nullptr;
      fvv::check(fvv_stream_read_chunk(stream.get(), &chunks[i], &payload, &diagnostic), name, diagnostic);
      const SoundChunk *chunk = found < wanted.size() ? &wanted[found] : nullptr;
      if (!chunk || chunks[i].track != sound_track_id(chunk->track) || chunks[i].time != chunk->time ||
          !std::equal(chunk->payload.begin(), chunk->payload.end(), payload, payload + chunks[i].size))
        throw Error(name + ": group " + std::to_string(index) + ": sound is not what was written");
      found++;
    }
    expect(found, wanted.size(), "chunks of sound");
  }

  const VideoDecision &decision_of(const VideoTrack &track) const {
    return decisions.videos[size_t(&track - plan.tracks.data())];
  }

  // Tiles are stored exactly.
  void layout(size_t index, const VideoTrack &track) {
    if (track.is_atlas()) return;
    const std::vector<fvv_tile> &ours = track.tiles_of(index);
    const fvv_tile *theirs = nullptr;
    size_t count = 0;
    check(fvv_stream_tiles(stream.get(), index, track.id, &theirs, &count, &diagnostic), plan.first_of(index),
          "tile layout");
    const auto same = [](const fvv_rect &a, const fvv_rect &b) {
      return a.x == b.x && a.y == b.y && a.width == b.width && a.height == b.height;
    };
    bool equal = count == ours.size();
    for (size_t i = 0; i < count && equal; i++)
      equal = theirs[i].camera_id == ours[i].camera_id && same(theirs[i].source, ours[i].source) &&
              same(theirs[i].destination, ours[i].destination);
    if (!equal) fail(plan.first_of(index), "the tile layout is not the one that was written");
  }

  VideoVerdict pictures(size_t index, const VideoTrack &track) {
    const fvv_video_layout *video = fvv_configuration_video(&configuration(index), track.id);
    if (!video) throw Error(name + ": a video track has no configuration");
    if (video->config.shows != track.shows) throw Error(name + ": a video track shows something else");
    layout(index, track);
    const VideoDecision &decision = decision_of(track);
    const bool lossless = decision.settings.codec == FVV_CODEC_OEXR;
    const double floor = lossless ? INFINITY : std::min(decision.sample_psnr, exact_enough) - psnr_slack;
    VideoVerdict verdict;
    demux::PictureDecoder decoder(*video);
    for (size_t i = 0; i < plan.frames_of(index); i++) {
      const size_t frame = plan.first_of(index) + i;
      const fvv_status status = decoder.decode(stream.get(), plan.first_of(index), frame);
      if (status < 0 && !decoder.diagnostic().status) fail(frame, decoder.why());
      diagnostic = decoder.diagnostic();
      check(status, frame, "picture");
      const double psnr = std::visit(
          [&](const auto &picture) { return compare(track, frame, picture, verdict); }, *decoder.frame());
      if (psnr < floor) {
        char text[120];
        std::snprintf(text, sizeof text, "%.2f dB of luma PSNR, expected at least %.2f dB", psnr, floor);
        fail(frame, text);
      }
      verdict.min_psnr = std::min(verdict.min_psnr, psnr);
      verdict.pictures++;
    }
    return verdict;
  }

  template <class Sample>
  double compare(const VideoTrack &track, size_t frame, const media::BasicImage<Sample> &decoded,
                 VideoVerdict &verdict) const {
    const Picture<Sample> source = load_picture<Sample>(plan, track, frame, decision_of(track).masks);
    const media::LumaError error =
        media::luma_error(source.image, decoded, source.mask.pixels.empty() ? nullptr : &source.mask);
    verdict.squares += error.squares;
    verdict.pixels += error.pixels;
    return error.pixels ? error.psnr() : INFINITY; // the mask is empty: nothing to compare
  }

  const Plan &plan;
  const Decisions &decisions;
  const std::vector<std::vector<MeshOrigins>> &origins;
  const std::string name;
  std::vector<VisibilityVerifier> visibility; // of each mesh track
  fvv_diagnostic diagnostic = {};
  std::unique_ptr<fvv_stream, void (*)(fvv_stream *)> stream;
};

} // namespace

Verdict verify(const Plan &plan, const Decisions &decisions,
               const std::vector<std::vector<MeshOrigins>> &origins, const InputFile &file) {
  if (plan.capture.mesh_cache) scene::clear(*plan.capture.mesh_cache);
  Verdict verdict;
  verdict.videos.resize(plan.tracks.size());
  if (plan.has_meshes()) verdict.lower_meshes.resize(plan.meshes.size() - 1);
  Reader reader(plan, decisions, origins, file);
  const fvv_configuration &configuration = reader.whole();
  for (const scene::Camera &camera : plan.capture.cameras) {
    verdict.cameras++;
    if (camera.moves()) continue; // with its frames
    const fvv_camera &ours = camera.calibration;
    const fvv_camera *theirs = fvv_configuration_camera(&configuration, ours.id);
    const double pixels = theirs ? reprojection(ours, *theirs, 1) : INFINITY;
    if (!(pixels <= reprojection_slack))
      throw Error(file.path() + ": camera " + std::to_string(ours.id) + " is not the camera of the capture");
    verdict.max_reprojection = std::max(verdict.max_reprojection, pixels);
  }
  std::vector<size_t> group_of;
  for (size_t group = 0; group < plan.group_count(); group++) group_of.push_back(group);
  std::vector<GroupVerdict> groups(plan.group_count());
  run_ordered(
      plan.options.threads, group_of,
      [&](size_t i) { groups[i] = Reader(plan, decisions, origins, file).group(i); },
      [&](size_t i) {
        for (size_t k = 0; k < plan.meshes.size(); k++) {
          MeshTrackVerdict &whole = k ? verdict.lower_meshes[k - 1] : verdict;
          whole.add(groups[i].meshes[k]);
        }
        verdict.environments += groups[i].environments;
        verdict.sounds += groups[i].sounds;
        verdict.moving_reprojection = std::max(verdict.moving_reprojection, groups[i].moving_reprojection);
        for (size_t k = 0; k < plan.tracks.size(); k++) verdict.videos[k].add(groups[i].videos[k]);
        plan.observer.progress(plan.frames_of(i));
      });
  return verdict;
}

} // namespace fvv::mux
