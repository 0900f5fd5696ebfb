#include "fvvinfo/report.h"

#include "fvv_cxx/format.h"

#include <algorithm>
#include <cmath>

namespace fvv::info {

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

std::string duration(const Report &report, const fvv_scene &scene) {
  const auto &s = report.summary();
  const double rate = 1 / seconds(scene, scene.frame_duration);
  return fvv::format("%.3f s, %llu frames at %.6g Hz in %llu groups, ticks of %u/%u s",
                     seconds(scene, s.end - s.start), (unsigned long long)s.frames, rate,
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

std::string texturing(const fvv_texturing &t) {
  return fvv::format(
      "weights from %g, %u cameras at most, %u,%u,%u where none shows the mesh, depth maps %g px + %g",
      t.threshold, t.best, t.unseen[0], t.unseen[1], t.unseen[2], t.depth_bias, t.depth_slope);
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
  if (c.shows == FVV_SHOWS_CAMERA) out += fvv::format(", camera %u", c.camera_id);
  if (c.shows == FVV_SHOWS_ATLAS) out += ", texture atlas";
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
  if (track.kind == FVV_TRACK_MESH && found->max_vertices)
    out += ": " + range(found->min_vertices, found->max_vertices) + " vertices, " +
           range(found->min_faces, found->max_faces) + " triangles";
  if (found->parts || found->lights)
    out += fvv::format(": %u parts of %llu triangles, %u pictures, %u lights", found->parts,
                       (unsigned long long)found->faces, found->pictures, found->lights);
  if (found->max_cameras) {
    const uint64_t of_vertices = found->of_vertices + found->of_weights;
    const char *element = !of_vertices                         ? "face"
                          : found->of_weights == found->chunks ? "vertex with a weight"
                          : of_vertices == found->chunks       ? "vertex"
                                                               : "face or vertex";
    out += ": " + range(found->min_cameras, found->max_cameras) +
           fvv::format(" cameras, %.3f bits a %s and camera",
                       found->pairs ? 8 * double(found->bytes) / double(found->pairs) : 0, element);
  }
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
  if (found->layouts) out += fvv::format(", %llu layouts of groups", (unsigned long long)found->layouts);
  if (found->lost_calibrations)
    out += fvv::format(": %llu of %llu times a camera is not calibrated",
                       (unsigned long long)found->lost_calibrations,
                       (unsigned long long)(found->lost_calibrations + found->calibrations));
  out += fvv::format("; %llu chunks (%llu key), ", (unsigned long long)found->chunks,
                     (unsigned long long)found->key_chunks);
  out += bytes(double(found->bytes)) + ", " + bytes(double(found->bytes) / double(found->chunks)) + " each";
  return out + profiles_text(*found);
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
    out += row("", fvv::format("and %zu more (--json lists all)", c.camera_count - shown));
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
  const char *depth = report.options.check ? "CRCs, structure, meshes and video samples checked"
                                           : "CRCs and structure checked (--check decodes meshes as well)";
  if (state == "complete") return std::string("complete; ") + depth;
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
    if (c->has_texturing) out += row("Texturing", texturing(c->texturing));
    for (size_t i = 0; i < c->track_count; i++) {
      std::string kind = kind_name(c->tracks[i].kind);
      kind[0] = char(std::toupper(kind[0]));
      out += row(kind.c_str(), track_text(report, c->tracks[i]));
    }
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

} // namespace fvv::info
