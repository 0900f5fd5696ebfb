// Reading one input, and the two ways to show it.
#include "fvv_info/report.h"

#include "fvv_cxx/error.h"
#include "fvv_cxx/format.h"
#include "fvv_cxx/rung.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace fvv::info {

namespace {

void take_event(void *user, const fvv_event *event) {
  auto &report = *static_cast<Report *>(user);
  const bool whole = event->kind == FVV_EVENT_CHUNK;
  if (whole && event->chunk.type == FVV_CHUNK_INDEX) report.has_index = true;
  if (!report.options.chunks || !(whole || (event->kind == FVV_EVENT_DAMAGE && event->has_chunk))) return;
  report.chunks.push_back({event->offset, event->chunk, whole && event->group_intact});
}

void read_all(const Input &input, Report &report) {
  fvv_checker *checker = report.checker.get();
  report.chunks.clear();
  report.has_index = false;
  constexpr size_t block = 1 << 20;
  std::vector<uint8_t> bytes(block);
  while (const size_t n = input.read(bytes.data(), block)) {
    report.status = fvv_checker_push(checker, bytes.data(), n);
    if (report.status < 0) break;
    const fvv_check_summary &summary = report.summary();
    if (summary.has_footer && input.size > summary.bytes) {
      report.status = fvv_checker_push(checker, nullptr, size_t(input.size - summary.bytes));
      break;
    }
    if (input.settle && summary.whole_frames && summary.whole_frames == summary.frames) input.settle();
  }
  if (report.status >= 0) report.status = fvv_checker_finish(checker);
}

} // namespace

Report inspect(const Input &input, const Options &options) {
  Report report;
  report.name = input.name;
  report.options = options;
  fvv_check_options check;
  fvv_check_options_default(&check);
  check.decode = options.check;
  check.event = take_event;
  check.user = &report;
  fvv_checker *checker = nullptr;
  if (fvv_checker_create(&check, nullptr, nullptr, &checker) != FVV_OK) throw std::bad_alloc();
  report.checker.reset(checker);
  read_all(input, report);
  // A repetition of a damaged configuration block may come after the groups that need it.
  if (report.status == FVV_NEED_DATA && input.seekable && input.rewind()) read_all(input, report);
  // The callback refers to this local report: no more bytes are pushed.
  return report;
}

const char *Report::integrity() const {
  if (status < 0) return "unreadable";
  const auto &s = summary();
  for (size_t i = 0; i < fvv_checker_problem_count(checker.get()); i++)
    if (fvv_checker_problem(checker.get(), i)->status != FVV_ERROR_TRUNCATED) return "damaged";
  return s.truncated || s.problems ? "truncated" : "complete";
}

double pixel_share(const Report &report, const fvv_video_layout &video) {
  double pixels = 0;
  for (size_t i = 0; i < video.tile_count; i++)
    if (const fvv_camera *camera = fvv_configuration_camera(report.configuration(), video.tiles[i].camera_id))
      pixels += double(camera->width) * camera->height;
  return pixels > 0 ? double(video.config.width) * video.config.height / pixels : 0;
}

std::string type_name(uint32_t code) {
  std::string out;
  for (int i = 0; i < 4; i++) {
    const char c = char(code >> (8 * i) & 255);
    out += c >= 0x20 && c <= 0x7e ? c : '?';
  }
  return out;
}

std::string codec_name(uint32_t codec) {
  switch (codec) {
  case FVV_CODEC_JPEG:
    return "JPEG";
  case FVV_CODEC_AVC1:
    return "H.264";
  case FVV_CODEC_HVC1:
    return "HEVC";
  case FVV_CODEC_VP09:
    return "VP9";
  case FVV_CODEC_AV01:
    return "AV1";
  case FVV_CODEC_OEXR:
    return "OpenEXR";
  case FVV_CODEC_OPUS:
    return "Opus";
  case FVV_CODEC_MP4A:
    return "AAC";
  default:
    return type_name(codec);
  }
}

const char *kind_name(uint8_t kind) {
  switch (kind) {
  case FVV_TRACK_MESH:
    return "mesh";
  case FVV_TRACK_VIDEO:
    return "video";
  case FVV_TRACK_CALIBRATION:
    return "calibration";
  case FVV_TRACK_VISIBILITY:
    return "visibility";
  case FVV_TRACK_ENVIRONMENT:
    return "environment";
  case FVV_TRACK_DATA:
    return "data";
  case FVV_TRACK_AUDIO:
    return "audio";
  case FVV_TRACK_COLOURS:
    return "colours";
  default:
    return "unknown";
  }
}

const char *lens_name(uint8_t lens) {
  return lens == FVV_LENS_RADTAN ? "radtan" : lens == FVV_LENS_FISHEYE ? "fisheye" : "none";
}

const char *up_name(uint8_t up) {
  static const char *const names[] = {"unknown", "+x", "+y", "+z", "-x", "-y", "-z"};
  return up <= FVV_UP_MINUS_Z ? names[up] : names[0];
}

namespace {

std::string bytes(double n) {
  if (n < 10e3) return fvv::format("%.0f B", n);
  if (n < 10e6) return fvv::format("%.1f kB", n / 1e3);
  if (n < 10e9) return fvv::format("%.1f MB", n / 1e6);
  return fvv::format("%.1f GB", n / 1e9);
}

// Control characters in a name never reach a terminal: C0, DEL, and C1, which UTF-8 writes as C2 80 to C2 9F.
// A long name is cut between characters. Names are valid UTF-8: libfvv has checked them.
std::string printable(const char *text, size_t size) {
  constexpr size_t longest = 60;
  std::string out;
  for (size_t i = 0; i < size; i++) {
    const auto c = static_cast<unsigned char>(text[i]);
    const bool continues = (c & 0xc0) == 0x80;
    if (out.size() >= longest && !continues) return out + "...";
    const bool c1 = c == 0xc2 && i + 1 < size && static_cast<unsigned char>(text[i + 1]) < 0xa0;
    if (c1) i++;
    out += c < 0x20 || c == 0x7f || c1 ? '?' : text[i];
  }
  return out;
}

std::string row(const char *label, const std::string &value) {
  return fvv::format("  %-11s ", label) + value + "\n";
}

std::string range(uint64_t low, uint64_t high) {
  return low == high ? std::to_string(low) : std::to_string(low) + " to " + std::to_string(high);
}

double seconds(const fvv_scene &scene, int64_t ticks) {
  return double(ticks) * scene.time_base.numerator / scene.time_base.denominator;
}

std::string length_text(const fvv_scene &scene, double metres) {
  if (scene.flags & FVV_SCENE_SCALE_UNKNOWN) return fvv::format("%.6g units", metres);
  return metres < 1 ? fvv::format("%.4g mm", metres * 1000) : fvv::format("%.4g m", metres);
}

// Times of the stream's nominal rate, from its beginning to its end, at which there is no frame; 0 where
// times are not those of that rate.
uint64_t times_without(const Report &report, const fvv_scene &scene) {
  const auto &s = report.summary();
  if (s.end <= s.start || s.truncated || s.problems) return 0;
  const uint64_t span = uint64_t(s.end) - uint64_t(s.start), duration = uint64_t(scene.frame_duration);
  return span % duration == 0 && span / duration > s.frames ? span / duration - s.frames : 0;
}

std::string duration(const Report &report, const fvv_scene &scene) {
  const auto &s = report.summary();
  const double rate = 1 / seconds(scene, scene.frame_duration);
  // Of hostile times the difference takes 64 bits without a sign.
  const double ticks = double(uint64_t(s.end) - uint64_t(s.start));
  const double length = ticks * scene.time_base.numerator / scene.time_base.denominator;
  const std::string text = s.groups && s.end <= s.start ? "unknown (cut)" : fvv::format("%.3f s", length);
  const uint64_t missing = times_without(report, scene);
  return fvv::format("%s, %llu frames at %.6g Hz%s in %llu groups, ticks of %u/%u s", text.c_str(),
                     (unsigned long long)s.frames, rate,
                     missing ? fvv::format(" (none at %llu times)", (unsigned long long)missing).c_str() : "",
                     (unsigned long long)s.groups, scene.time_base.numerator, scene.time_base.denominator);
}

std::string world(const fvv_scene &scene) {
  const double *o = scene.lattice_origin;
  const bool unknown = scene.flags & FVV_SCENE_SCALE_UNKNOWN;
  return std::string(unknown ? "units of the source (scale unknown)" : "metres") + ", " +
         (scene.up_axis ? std::string(up_name(scene.up_axis)) + " is up" : "up axis not stated") +
         ", lattice step " + length_text(scene, scene.lattice_step) +
         fvv::format(" from (%.4g, %.4g, %.4g)", o[0], o[1], o[2]);
}

std::string texturing(const fvv_scene &scene, const fvv_texturing &t) {
  std::string out = fvv::format(
      "by %s, cosines from %g, %u cameras at most, %u,%u,%u where none shows the mesh, depth maps %g px + %g",
      t.blend == FVV_BLEND_PAPER ? "the normal (paper)" : "the viewer's direction", t.threshold, t.best,
      t.unseen[0], t.unseen[1], t.unseen[2], t.depth_bias, t.depth_slope);
  if (t.inset > 0) out += ", looked up " + length_text(scene, t.inset) + " inside the mesh";
  return out;
}

std::string video_text(const Report &report, const fvv_video_layout &video) {
  const auto &c = video.config;
  std::string out = codec_name(c.codec);
  if (c.codec_string_size) out += " (" + printable(c.codec_string, c.codec_string_size) + ")";
  out += fvv::format(" %ux%u", c.width, c.height);
  if (c.bit_depth != 8) out += fvv::format(", %u bits", c.bit_depth);
  if (c.shows == FVV_SHOWS_TILES)
    out += fvv::format(", %zu tiles, %.1f %% of their cameras' pixels", video.tile_count,
                       100 * pixel_share(report, video));
  if (c.shows == FVV_SHOWS_ATLAS) out += ", texture atlas";
  return out;
}

double sound_seconds(const fvv_audio_config &c, const fvv_track_summary &summary) {
  const uint32_t rate = fvv_audio_sample_rate(&c);
  return rate ? double(summary.packets) * c.packet_duration / rate : 0;
}

std::string audio_text(const Report &report, const fvv_audio_config &c, const fvv_track_summary &summary) {
  std::string out =
      codec_name(c.codec) + fvv::format(", %u channel%s", c.channels, c.channels == 1 ? "" : "s");
  const double length = sound_seconds(c, summary);
  if (length > 0)
    out += fvv::format(" at %u Hz, %.3f s, %.1f kbit/s", fvv_audio_sample_rate(&c), length,
                       8 * double(summary.bytes) / length / 1000);
  if (c.language_size) out += ", language " + printable(c.language, c.language_size);
  if (c.flags & FVV_AUDIO_MOVES) return out + ", from a place that moves";
  if (c.flags & FVV_AUDIO_PLACED)
    out += fvv::format(", from (%.3f, %.3f, %.3f)%s", c.position[0], c.position[1], c.position[2],
                       report.configuration()->scene.flags & FVV_SCENE_SCALE_UNKNOWN ? " units" : " m");
  return out;
}

// ": 2 draco of 31.2 kB, 48 delta of 4053 B"
std::string profiles_text(const fvv_track_summary &summary) {
  std::string out;
  for (uint8_t p = 0; p < FVV_MESH_PROFILE_COUNT; p++) {
    const uint64_t chunks = summary.profile_chunks[p];
    if (!chunks) continue;
    out += fvv::format("%s%llu %s of ", out.empty() ? ": " : ", ", (unsigned long long)chunks,
                       fvv_mesh_profile_name(p)) +
           bytes(double(summary.profile_bytes[p]) / double(chunks));
  }
  return out;
}

// Of a mesh track: frames at which it has no mesh.
uint64_t frames_without(const Report &report, const fvv_track_summary &track) {
  const uint64_t frames = report.summary().frames;
  return track.kind == FVV_TRACK_MESH && frames > track.chunks ? frames - track.chunks : 0;
}

std::string track_text(const Report &report, const fvv_track &track) {
  std::string out = fvv::format("track %u", track.id);
  if (track.name_size) out += " \"" + printable(track.name, track.name_size) + "\"";
  const fvv_track_summary *found = nullptr;
  for (size_t i = 0; i < fvv_checker_track_count(report.checker.get()); i++) {
    const auto *t = fvv_checker_track(report.checker.get(), i);
    if (t->track == track.id) found = t;
  }
  if (!found || !found->chunks) return out + ": no chunks";
  if (track.kind == FVV_TRACK_VIDEO)
    if (const auto *video = fvv_configuration_video(report.configuration(), track.id))
      out += ": " + video_text(report, *video);
  if (track.kind == FVV_TRACK_AUDIO)
    if (const auto *audio = fvv_configuration_audio(report.configuration(), track.id))
      out += ": " + audio_text(report, *audio, *found);
  if (const auto *data = fvv_configuration_data(report.configuration(), track.id)) {
    out += ": " + printable(data->media_type, data->media_type_size);
    if (data->codec_size) out += ", " + printable(data->codec, data->codec_size);
  }
  if (track.kind == FVV_TRACK_MESH && found->max_vertices)
    out += ": " + range(found->min_vertices, found->max_vertices) + " vertices, " +
           range(found->min_faces, found->max_faces) + " triangles";
  if (found->parts || found->lights)
    out += fvv::format(": %u parts of %llu triangles, %u pictures, %u lights", found->parts,
                       (unsigned long long)found->faces, found->pictures, found->lights);
  if (found->max_cameras)
    out += ": " + range(found->min_cameras, found->max_cameras) +
           fvv::format(" cameras, %.3f bits a vertex and camera",
                       found->pairs ? 8 * double(found->bytes) / double(found->pairs) : 0);
  if (found->textured) {
    out += ", texture coordinates of " + range(found->min_texture_bits, found->max_texture_bits) + " bits";
    if (found->textured != found->chunks)
      out += fvv::format(" in %llu chunks", (unsigned long long)found->textured);
  }
  if (found->with_normals) {
    out += ", normals of " + range(found->min_normal_bits, found->max_normal_bits) + " bits";
    if (found->with_normals != found->chunks)
      out += fvv::format(" in %llu chunks", (unsigned long long)found->with_normals);
  }
  if (found->cells) {
    const fvv_scene &scene = report.configuration()->scene;
    const double step = scene.lattice_step;
    const char *unit = scene.flags & FVV_SCENE_SCALE_UNKNOWN ? "units" : "m";
    const std::string least = fvv::format("%.3g", found->min_cell_size * step),
                      most = fvv::format("%.3g", found->max_cell_size * step);
    out += fvv::format(": %.0f cells of %s %s, %.3g bits each", double(found->cells) / double(found->chunks),
                       (least == most ? least : least + " to " + most).c_str(), unit,
                       8 * double(found->bytes) / double(found->cells));
  }
  if (found->layouts)
    out += fvv::format(", %llu layout%s of groups", (unsigned long long)found->layouts,
                       found->layouts == 1 ? "" : "s");
  if (found->lost_calibrations)
    out += fvv::format(": %llu of %llu times a camera is not calibrated",
                       (unsigned long long)found->lost_calibrations,
                       (unsigned long long)(found->lost_calibrations + found->calibrations));
  if (const uint64_t without = frames_without(report, *found))
    out += fvv::format(", none in %llu frames", (unsigned long long)without);
  out += fvv::format("; %llu chunk%s (%llu key), ", (unsigned long long)found->chunks,
                     found->chunks == 1 ? "" : "s", (unsigned long long)found->key_chunks);
  out += bytes(double(found->bytes)) + ", " + bytes(double(found->bytes) / double(found->chunks)) + " each";
  return out + profiles_text(*found);
}

// Payload of the tracks of a rung.
uint64_t bytes_of(const Report &report, const RungInfo &rung) {
  uint64_t sum = 0;
  for (size_t i = 0; i < fvv_checker_track_count(report.checker.get()); i++) {
    const fvv_track_summary *track = fvv_checker_track(report.checker.get(), i);
    if (std::find(rung.tracks.begin(), rung.tracks.end(), track->track) != rung.tracks.end())
      sum += track->bytes;
  }
  return sum;
}

// Bits a second of that payload; 0: the duration is not known.
double rate_of(const Report &report, uint64_t payload) {
  const auto &s = report.summary();
  const double length =
      seconds(report.configuration()->scene, s.end) - seconds(report.configuration()->scene, s.start);
  return length > 0 ? 8 * double(payload) / length : 0;
}

// Nominal, of a frame's meshes; 0: not stated.
uint64_t triangles_of(const Report &report, const RungInfo &rung) {
  uint64_t sum = 0;
  for (const uint16_t id : rung.tracks) {
    const fvv_track *track = fvv_configuration_track(report.configuration(), id);
    if (track && track->kind == FVV_TRACK_MESH) sum += track->size;
  }
  return sum;
}

std::string ladder(const Report &report) {
  const std::vector<RungInfo> rungs = rungs_of(*report.configuration());
  std::string out;
  for (const RungInfo &rung : rungs) {
    if (rungs.size() < 2) break;
    const uint64_t payload = bytes_of(report, rung);
    std::string tracks;
    for (const uint16_t track : rung.tracks) tracks += (tracks.empty() ? "" : ", ") + std::to_string(track);
    std::string text = fvv::format("rung %zu: ", rung.rung) + bytes(double(payload)) +
                       fvv::format(", %.1f kbit/s", rate_of(report, payload) / 1000);
    if (rung.bit_rate) text += fvv::format(" (nominal %.1f)", double(rung.bit_rate) / 1000);
    if (rung.size) text += fvv::format(", pictures of %llu pixels", (unsigned long long)rung.size);
    if (rung.scale > 0) text += fvv::format(" at scale %.3g", rung.scale);
    if (const uint64_t triangles = triangles_of(report, rung))
      text += fvv::format(", meshes of %llu triangles", (unsigned long long)triangles);
    out += row(rung.rung ? "" : "Ladder", text + ", tracks " + tracks);
  }
  return out;
}

std::string camera_table(const fvv_configuration &c) {
  std::string out;
  constexpr size_t shown = 12;
  for (size_t i = 0; i < std::min(c.camera_count, shown); i++) {
    const fvv_camera &camera = c.cameras[i];
    double centre[3];
    fvv_camera_centre(&camera, centre);
    const std::string label = i ? "" : fvv::format("Cameras %zu", c.camera_count);
    out += row(label.c_str(),
               fvv::format("%3u %-10s %ux%u, f %.1f px, lens %s, at (%.3f, %.3f, %.3f)%s", camera.id,
                           printable(camera.name, camera.name_size).c_str(), camera.width, camera.height,
                           camera.fx, lens_name(camera.lens), centre[0], centre[1], centre[2],
                           camera.flags & FVV_CAMERA_MOVES ? " at first: it moves" : ""));
  }
  if (c.camera_count > shown)
    out +=
        row("", fvv::format("and %zu more (", c.camera_count - shown) + option_name("json") + " lists all)");
  return out;
}

std::string shares(const Report &report) {
  const auto &s = report.summary();
  std::string out;
  for (size_t i = 0; i < fvv_checker_track_count(report.checker.get()); i++) {
    const auto *t = fvv_checker_track(report.checker.get(), i);
    out += fvv::format("%s %.1f %%, ", kind_name(t->kind), 100.0 * double(t->bytes) / double(s.bytes));
  }
  out += fvv::format("container %.2f %%", 100.0 * double(s.bytes - s.payload_bytes) / double(s.bytes));
  if (s.frames) out += "; " + bytes(double(s.bytes) / double(s.frames)) + " a frame";
  return out;
}

std::string whole_frames(const Report &report) {
  const auto &s = report.summary();
  std::string out = fvv::format("%llu of %llu frames are whole", (unsigned long long)s.whole_frames,
                                (unsigned long long)s.frames);
  const size_t runs = fvv_checker_run_count(report.checker.get());
  for (size_t i = 0; i < std::min<size_t>(runs, 8); i++) {
    const auto *run = fvv_checker_run(report.checker.get(), i);
    out += (i ? ", " : ": ") + range(run->first, run->first + run->count - 1);
  }
  return runs > 8 ? out + ", ..." : out;
}

std::string integrity_text(const Report &report) {
  const auto &s = report.summary();
  const std::string state = report.integrity();
  const std::string depth = report.options.check ? "CRCs, structure, meshes and video samples checked"
                                                 : "CRCs and structure checked (" + option_name("check") +
                                                       " decodes meshes as well)";
  if (state == "complete") return "complete; " + depth;
  if (state == "truncated")
    return std::string(s.problems ? "truncated" : "no footer: live or truncated") + "; " +
           whole_frames(report);
  if (state == "damaged")
    return fvv::format("damaged in %llu places; ", (unsigned long long)s.problems) + whole_frames(report);
  return "unreadable from there on";
}

std::string chunk_list(const Report &report) {
  std::string out = "      offset  type  track         time         size  flags\n";
  for (const auto &chunk : report.chunks) {
    const auto &h = chunk.header;
    out += fvv::format("%12llu  %s  %5u %12lld %12llu  %c%c%c%s\n", (unsigned long long)chunk.offset,
                       type_name(h.type).c_str(), h.track, (long long)h.time, (unsigned long long)h.size,
                       h.flags & FVV_FLAG_CRITICAL ? 'C' : '-', h.flags & FVV_FLAG_KEY ? 'K' : '-',
                       h.flags & FVV_FLAG_LAST ? 'L' : '-', chunk.intact ? "" : "  not intact");
  }
  return out;
}

} // namespace

std::string text(const Report &report) {
  const auto &s = report.summary();
  std::string out = report.name + ": " + bytes(double(s.bytes));
  if (s.written_major || s.written_minor)
    out += fvv::format(", format %u.%u", s.written_major, s.written_minor);
  out += "\n";
  if (const fvv_configuration *c = report.configuration()) {
    out += row("Duration", duration(report, c->scene));
    out += row("World", world(c->scene));
    if (c->has_texturing) out += row("Texturing", texturing(c->scene, c->texturing));
    for (size_t i = 0; i < c->track_count; i++) {
      std::string kind = kind_name(c->tracks[i].kind);
      kind[0] = char(std::toupper(kind[0]));
      out += row(kind.c_str(), track_text(report, c->tracks[i]));
    }
    out += ladder(report);
    out += camera_table(*c);
    if (s.frames) out += row("Bytes", shares(report));
  }
  out += row("Index", s.has_footer && report.has_index
                          ? fvv::format("present, %llu groups", (unsigned long long)s.groups)
                          : std::string("none: readers rebuild it by scanning"));
  out += row("Integrity", integrity_text(report));
  if (report.options.chunks) out += chunk_list(report);
  return out;
}

namespace {

using Json = nlohmann::ordered_json;

// Ticks are strings: they use all 64 bits, which JSON readers may not hold in numbers.
std::string ticks(int64_t value) {
  return std::to_string(value);
}

Json scene_json(const fvv_scene &scene) {
  return {{"time_base", {scene.time_base.numerator, scene.time_base.denominator}},
          {"frame_duration", ticks(scene.frame_duration)},
          {"lattice_origin", {scene.lattice_origin[0], scene.lattice_origin[1], scene.lattice_origin[2]}},
          {"lattice_step", scene.lattice_step},
          {"up", up_name(scene.up_axis)},
          {"scale_known", !(scene.flags & FVV_SCENE_SCALE_UNKNOWN)}};
}

Json rect_json(const fvv_rect &r) {
  return {r.x, r.y, r.width, r.height};
}

Json video_json(const Report &report, const fvv_video_layout &video) {
  const auto &c = video.config;
  Json out = {
      {"codec", type_name(c.codec)},
      {"codec_string", std::string(c.codec_string, c.codec_string_size)},
      {"width", c.width},
      {"height", c.height},
      {"bit_depth", c.bit_depth},
      {"shows", c.shows == FVV_SHOWS_TILES ? "tiles" : "atlas"},
      {"colour", {c.colour_primaries, c.transfer_characteristics, c.matrix_coefficients, c.full_range}}};
  if (c.shows != FVV_SHOWS_TILES) return out;
  out["pixel_share"] = pixel_share(report, video);
  out["tiles"] = Json::array();
  for (size_t i = 0; i < video.tile_count; i++) {
    const auto &tile = video.tiles[i];
    out["tiles"].push_back({{"camera", tile.camera_id},
                            {"source", rect_json(tile.source)},
                            {"destination", rect_json(tile.destination)}});
  }
  return out;
}

Json profiles_json(const fvv_track_summary &summary) {
  Json out = Json::object();
  for (uint8_t p = 0; p < FVV_MESH_PROFILE_COUNT; p++)
    if (summary.profile_chunks[p])
      out[fvv_mesh_profile_name(p)] = {{"chunks", summary.profile_chunks[p]},
                                       {"bytes", summary.profile_bytes[p]}};
  return out;
}

Json audio_json(const fvv_audio_config &c, const fvv_track &track, const fvv_track_summary *summary) {
  Json out = {{"codec", type_name(c.codec)},
              {"channels", c.channels},
              {"rate", fvv_audio_sample_rate(&c)},
              {"packet_duration", c.packet_duration},
              {"preroll", c.preroll},
              {"packets", summary ? summary->packets : 0},
              {"seconds", summary ? sound_seconds(c, *summary) : 0.0},
              {"bit_rate", track.bit_rate},
              {"language", std::string(c.language, c.language_size)},
              {"moves", (c.flags & FVV_AUDIO_MOVES) != 0},
              {"position", nullptr}};
  if (c.flags & FVV_AUDIO_PLACED) out["position"] = {c.position[0], c.position[1], c.position[2]};
  return out;
}

Json tracks_json(const Report &report, const fvv_configuration &c) {
  Json out = Json::array();
  for (size_t i = 0; i < c.track_count; i++) {
    const auto &track = c.tracks[i];
    Json t = {{"track", track.id},
              {"kind", kind_name(track.kind)},
              {"name", std::string(track.name, track.name_size)},
              {"chunks", 0},
              {"key_chunks", 0},
              {"bytes", 0}};
    const fvv_track_summary *found = nullptr;
    for (size_t k = 0; k < fvv_checker_track_count(report.checker.get()); k++) {
      const auto *s = fvv_checker_track(report.checker.get(), k);
      if (s->track != track.id) continue;
      found = s;
      t["chunks"] = s->chunks;
      t["key_chunks"] = s->key_chunks;
      t["bytes"] = s->bytes;
      if (s->layouts)
        t["layouts"] = {{"groups", s->layouts}, {"tile_pixels", {s->least_tile_pixels, s->most_tile_pixels}}};
      if (!s->chunks) continue;
      t["smallest"] = s->smallest;
      t["largest"] = s->largest;
      if (track.kind == FVV_TRACK_MESH && s->max_vertices)
        t["mesh"] = {{"vertices", {s->min_vertices, s->max_vertices}},
                     {"triangles", {s->min_faces, s->max_faces}},
                     {"frames_without", frames_without(report, *s)},
                     {"vertices_sum", s->vertices},
                     {"triangles_sum", s->faces},
                     {"profiles", profiles_json(*s)}};
      if (s->parts || s->lights)
        t["environment"] = {{"parts", s->parts},
                            {"vertices", s->vertices},
                            {"triangles", s->faces},
                            {"pictures", s->pictures},
                            {"lights", s->lights}};
      if (s->textured)
        t["mesh"]["texture"] = {{"chunks", s->textured},
                                {"bits", {s->min_texture_bits, s->max_texture_bits}}};
      if (s->with_normals)
        t["mesh"]["normals"] = {{"chunks", s->with_normals},
                                {"bits", {s->min_normal_bits, s->max_normal_bits}}};
      if (track.kind == FVV_TRACK_CALIBRATION)
        t["calibration"] = {{"entries", s->calibrations}, {"lost", s->lost_calibrations}};
      if (s->cells)
        t["colours"] = {{"cells", s->cells},
                        {"cell_size", {s->min_cell_size, s->max_cell_size}},
                        {"bits_per_cell", 8 * double(s->bytes) / double(s->cells)}};
      if (s->max_cameras)
        t["visibility"] = {{"cameras", {s->min_cameras, s->max_cameras}},
                           {"pairs", s->pairs},
                           {"bits_per_pair", s->pairs ? 8 * double(s->bytes) / double(s->pairs) : 0}};
    }
    if (track.alternate_group)
      t["alternate"] = {{"group", track.alternate_group},
                        {"rank", track.rank},
                        {"bit_rate", track.bit_rate},
                        {"size", track.size}};
    if (const auto *audio = fvv_configuration_audio(&c, track.id))
      t["audio"] = audio_json(*audio, track, found);
    if (const auto *video = fvv_configuration_video(&c, track.id)) t["video"] = video_json(report, *video);
    if (const auto *data = fvv_configuration_data(&c, track.id))
      t["data"] = {{"media_type", std::string(data->media_type, data->media_type_size)},
                   {"codec", std::string(data->codec, data->codec_size)}};
    out.push_back(t);
  }
  return out;
}

Json cameras_json(const fvv_configuration &c) {
  Json out = Json::array();
  for (size_t i = 0; i < c.camera_count; i++) {
    const fvv_camera &camera = c.cameras[i];
    double centre[3];
    fvv_camera_centre(&camera, centre);
    Json one = {{"id", camera.id},
                {"name", std::string(camera.name, camera.name_size)},
                {"width", camera.width},
                {"height", camera.height},
                {"fx", camera.fx},
                {"fy", camera.fy},
                {"cx", camera.cx},
                {"cy", camera.cy},
                {"skew", camera.skew},
                {"lens", lens_name(camera.lens)},
                {"distortion", std::vector<double>(camera.distortion, camera.distortion + 8)},
                {"rotation", std::vector<double>(camera.rotation, camera.rotation + 9)},
                {"translation", std::vector<double>(camera.translation, camera.translation + 3)},
                {"centre", std::vector<double>(centre, centre + 3)}};
    // JSON has no infinity: a lens that is valid everywhere has no r_max.
    if (camera.r_max < 1e300) one["r_max"] = camera.r_max;
    if (camera.flags & FVV_CAMERA_MOVES) one["moves"] = true;
    out.push_back(one);
  }
  return out;
}

Json rungs_json(const Report &report, const std::vector<RungInfo> &rungs) {
  Json out = Json::array();
  for (const RungInfo &rung : rungs) {
    Json one = json_of<Json>(rung);
    if (const uint64_t triangles = triangles_of(report, rung)) one["triangles"] = triangles;
    const uint64_t payload = bytes_of(report, rung);
    one["bytes"] = payload;
    one["measured_rate"] = rate_of(report, payload);
    out.push_back(std::move(one));
  }
  return out;
}

Json problems_json(const Report &report) {
  Json out = Json::array();
  for (size_t i = 0; i < fvv_checker_problem_count(report.checker.get()); i++) {
    const auto *p = fvv_checker_problem(report.checker.get(), i);
    Json one = {{"status", fvv_status_text(p->status)},
                {"offset", p->offset},
                {"chunk_offset", p->chunk_offset},
                {"message", p->message}};
    if (p->chunk_type) one["chunk"] = type_name(p->chunk_type);
    if (p->issue) one["issue"] = "FVV-" + std::to_string(p->issue);
    out.push_back(one);
  }
  return out;
}

Json texturing_json(const fvv_texturing &t) {
  return {{"threshold", t.threshold},
          {"best", t.best},
          {"unseen", {t.unseen[0], t.unseen[1], t.unseen[2]}},
          {"blend", t.blend == FVV_BLEND_PAPER ? "paper" : "viewer"},
          {"depth_bias", t.depth_bias},
          {"depth_slope", t.depth_slope},
          {"inset", t.inset}};
}

Json chunks_json(const Report &report) {
  Json out = Json::array();
  for (const auto &chunk : report.chunks) {
    const auto &h = chunk.header;
    out.push_back({{"offset", chunk.offset},
                   {"type", type_name(h.type)},
                   {"flags", h.flags},
                   {"track", h.track},
                   {"time", ticks(h.time)},
                   {"size", h.size},
                   {"intact", chunk.intact}});
  }
  return out;
}

} // namespace

std::string document(const std::vector<Json> &files) {
  const Json out = {{"fvvinfo", 1}, {"files", files}};
  // A file's name need not be UTF-8; JSON must be.
  return out.dump(2, ' ', false, Json::error_handler_t::replace);
}

Json json(const Report &report) {
  const auto &s = report.summary();
  Json out = {{"name", report.name},
              {"bytes", s.bytes},
              {"integrity", report.integrity()},
              {"decoded", report.options.check},
              {"written_version", {s.written_major, s.written_minor}},
              {"chunk_count", s.chunks},
              {"groups", s.groups},
              {"frames", s.frames},
              {"times_without_frame",
               report.configuration() ? times_without(report, report.configuration()->scene) : 0},
              {"whole_frames", s.whole_frames},
              {"whole", Json::array()},
              {"start", ticks(s.start)},
              {"end", ticks(s.end)},
              {"index", s.has_footer && report.has_index},
              {"container_bytes", s.bytes - s.payload_bytes},
              {"problem_count", s.problems},
              {"problems", problems_json(report)}};
  for (size_t i = 0; i < fvv_checker_run_count(report.checker.get()); i++) {
    const auto *run = fvv_checker_run(report.checker.get(), i);
    out["whole"].push_back({{"first", run->first},
                            {"count", run->count},
                            {"first_time", ticks(run->first_time)},
                            {"last_time", ticks(run->last_time)}});
  }
  if (const fvv_configuration *c = report.configuration()) {
    out["scene"] = scene_json(c->scene);
    out["tracks"] = tracks_json(report, *c);
    if (const std::vector<RungInfo> rungs = rungs_of(*c); rungs.size() > 1)
      out["rungs"] = rungs_json(report, rungs);
    out["cameras"] = cameras_json(*c);
    if (c->has_texturing) out["texturing"] = texturing_json(c->texturing);
    out["metadata"] = Json::array();
    for (size_t i = 0; i < c->metadata_count; i++)
      out["metadata"].push_back(std::string(c->metadata[i].text, c->metadata[i].size));
  }
  if (report.options.chunks) out["chunks"] = chunks_json(report);
  return out;
}

} // namespace fvv::info
