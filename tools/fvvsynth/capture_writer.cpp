// The files of a capture folder.
#include "fvvsynth/capture_writer.h"

#include "cli/cli.h"
#include "fvv_cxx/parallel.h"
#include "fvv_geometry/hull.h"
#include "fvv_media/exr.h"
#include "fvv_media/image.h"
#include "fvv_media/sound.h"
#include "fvv_render/ray_visibility.h"
#include "fvv_scene/environment.h"
#include "fvv_scene/file_io.h"
#include "fvvsynth/atlas.h"
#include "fvvsynth/look.h"
#include "fvvsynth/remesh.h"
#include "fvvsynth/scene.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string>

namespace fvv::synth {

namespace {

// The head of a .npy file, version 1.0, whose Booleans follow row by row:
// https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
std::vector<uint8_t> npy_head(size_t rows, size_t columns) {
  std::string text = "{'descr': '|b1', 'fortran_order': False, 'shape': (" + std::to_string(rows) + ", " +
                     std::to_string(columns) + "), }";
  constexpr size_t before = 10, alignment = 64;
  text.append(alignment - 1 - (before + text.size()) % alignment, ' ');
  text += '\n';
  const std::string magic("\x93NUMPY\x01\x00", 8);
  std::vector<uint8_t> bytes(magic.begin(), magic.end());
  bytes.push_back(uint8_t(text.size()));
  bytes.push_back(uint8_t(text.size() >> 8));
  bytes.insert(bytes.end(), text.begin(), text.end());
  return bytes;
}

} // namespace

std::vector<uint8_t> depth_exr(const render::Picture &picture) {
  media::FloatImage image;
  image.width = picture.width;
  image.height = picture.height;
  image.channels = {"Z"};
  image.samples = picture.depth;
  return media::encode_exr(image);
}

VisibilityFiles visibility_files(const std::vector<fvv_camera> &cameras, const std::vector<float> &positions,
                                 const std::vector<uint32_t> &faces, const std::vector<uint32_t> *copies) {
  const render::Mesh mesh = {positions.data(), positions.size() / 3, faces.data(), faces.size() / 3};
  const render::RayCaster rays(mesh);
  VisibilityFiles files = {npy_head(cameras.size(), mesh.face_count),
                           npy_head(cameras.size(), copies ? copies->size() : mesh.vertex_count)};
  const auto append = [](std::vector<uint8_t> &to, const std::vector<uint8_t> &row) {
    to.insert(to.end(), row.begin(), row.end());
  };
  for (const fvv_camera &camera : cameras) {
    append(files.faces, render::visible_faces(camera, mesh, rays));
    const std::vector<uint8_t> seen = render::visible_vertices(camera, mesh, rays);
    if (copies)
      for (const uint32_t vertex : *copies) files.vertices.push_back(seen[vertex]);
    else
      append(files.vertices, seen);
  }
  return files;
}

namespace {

constexpr uint32_t floor_columns = 768, wall_columns = 640;
constexpr int quality = 80;
constexpr double lux = 1000; // of all lamps together, about

// A painted rectangle of width x height metres into rows of a picture; t grows with the rows, or against
// them.
void paint(const Texture &texture, double width, double height, bool upwards, uint32_t top, uint32_t rows,
           media::Image &picture) {
  const double across = width / picture.width, along = height / rows;
  for (uint32_t y = 0; y < rows; y++)
    for (uint32_t x = 0; x < picture.width; x++) {
      const double t = (y + 0.5) * along;
      const Rgb light = texture.at((x + 0.5) * across, upwards ? height - t : t, std::max(across, along));
      uint8_t *pixel = &picture.pixels[3 * (size_t(top + y) * picture.width + x)];
      pixel[0] = render::to_display(light.x);
      pixel[1] = render::to_display(light.y);
      pixel[2] = render::to_display(light.z);
    }
}

std::string jpeg(const media::Image &picture) {
  const std::vector<uint8_t> bytes = media::encode_jpeg(picture, quality, media::Subsampling::yuv420);
  return {bytes.begin(), bytes.end()};
}

// Corners counter-clockwise as seen, the first at the top left of its rectangle of the picture.
void add_quad(geometry::Mesh &mesh, const Vec3 (&corners)[4], double top, double bottom) {
  const uint32_t base = uint32_t(mesh.vertex_count());
  const double uv[4][2] = {{0, top}, {0, bottom}, {1, bottom}, {1, top}};
  for (size_t i = 0; i < 4; i++) {
    mesh.positions.insert(mesh.positions.end(), {corners[i].x, corners[i].y, corners[i].z});
    mesh.texture.insert(mesh.texture.end(), {uv[i][0], uv[i][1]});
  }
  mesh.faces.insert(mesh.faces.end(), {base, base + 1, base + 2, base, base + 2, base + 3});
}

void add_box(geometry::Mesh &mesh, Vec3 centre, Vec3 half) {
  const uint32_t base = uint32_t(mesh.vertex_count());
  for (int corner = 0; corner < 8; corner++)
    mesh.positions.insert(mesh.positions.end(), {centre.x + (corner & 1 ? half.x : -half.x),
                                                 centre.y + (corner & 2 ? half.y : -half.y),
                                                 centre.z + (corner & 4 ? half.z : -half.z)});
  for (const auto &side : {std::array<uint32_t, 4>{0, 4, 6, 2},
                           {1, 3, 7, 5},
                           {0, 1, 5, 4},
                           {2, 6, 7, 3},
                           {0, 2, 3, 1},
                           {4, 5, 7, 6}})
    for (const size_t c : {0, 1, 2, 0, 2, 3}) mesh.faces.push_back(base + side[c]);
}

constexpr double x = room_length / 2, z = room_width / 2, h = room_height;

scene::EnvironmentPart shown_as_it_is(size_t picture) {
  scene::EnvironmentPart part;
  part.picture = picture;
  part.unlit = part.clamped = true;
  return part;
}

void add_floor(uint32_t key, uint32_t threads, scene::Environment &out) {
  const auto row = [key](double t) { return [=](double s) { return floor_colour(s - x, t - z, key); }; };
  const double texel = room_length / floor_columns / 2;
  media::Image picture =
      media::make_image<uint8_t>(floor_columns, uint32_t(floor_columns * room_width / room_length), 3, 0);
  paint({room_length, room_width, texel, row, threads}, room_length, room_width, false, 0, picture.height,
        picture);
  scene::EnvironmentPart part = shown_as_it_is(out.pictures.size());
  add_quad(part.mesh, {{-x, 0, -z}, {-x, 0, z}, {x, 0, z}, {x, 0, -z}}, 0, 1);
  out.pictures.push_back(jpeg(picture));
  out.parts.push_back(std::move(part));
}

// One picture of four strips. A wall is written as seen from inside, left to right.
void add_walls(uint32_t key, uint32_t threads, scene::Environment &out) {
  constexpr uint32_t rows = 272;
  const Vec3 left[4] = {{x, 0, -z}, {-x, 0, z}, {x, 0, z}, {-x, 0, -z}},
             right[4] = {{x, 0, z}, {-x, 0, -z}, {-x, 0, z}, {x, 0, -z}};
  const Vec3 up{0, h, 0};
  media::Image picture = media::make_image<uint8_t>(wall_columns, 4 * rows, 3, 0);
  scene::EnvironmentPart part = shown_as_it_is(out.pictures.size());
  for (int wall = 0; wall < 4; wall++) {
    const double width = wall < 2 ? room_width : room_length;
    const auto row = [=](double t) { return [=](double s) { return wall_colour(wall, s, t, key); }; };
    const uint32_t top = rows * uint32_t(wall);
    paint({width, h, h / rows / 2, row, threads}, width, h, true, top, rows, picture);
    // Half a pixel inside, so that strips do not run into each other.
    add_quad(part.mesh, {left[wall] + up, left[wall], right[wall], right[wall] + up},
             (top + 0.5) / (4.0 * rows), (top + rows - 0.5) / (4.0 * rows));
  }
  out.pictures.push_back(jpeg(picture));
  out.parts.push_back(std::move(part));
}

void add_ceiling(uint32_t key, uint32_t threads, scene::Environment &out) {
  const auto row = [key](double t) { return [=](double s) { return ceiling_colour(s - x, t - z, key); }; };
  media::Image picture =
      media::make_image<uint8_t>(wall_columns, uint32_t(wall_columns * room_width / room_length), 3, 0);
  paint({room_length, room_width, room_length / wall_columns / 2, row, threads}, room_length, room_width,
        false, 0, picture.height, picture);
  constexpr double top = ceiling_height;
  scene::EnvironmentPart panels = shown_as_it_is(out.pictures.size());
  add_quad(panels.mesh, {{-x, top, z}, {-x, top, -z}, {x, top, -z}, {x, top, z}}, 1, 0);
  out.pictures.push_back(jpeg(picture));
  out.parts.push_back(std::move(panels));
  // Beams and lamps, a part for each colour.
  const auto same = [](Rgb a, Rgb b) { return a.x == b.x && a.y == b.y && a.z == b.z; };
  std::vector<Rgb> colours;
  for (const CeilingPart &box : ceiling_parts())
    if (std::none_of(colours.begin(), colours.end(), [&](Rgb c) { return same(c, box.colour); }))
      colours.push_back(box.colour);
  for (const Rgb colour : colours) {
    scene::EnvironmentPart part;
    part.unlit = true;
    // What does not glow sends on some of the light from below.
    const double lit = colour.x > 1 ? 1 : 0.25;
    part.colour[0] = std::min(1.0, colour.x * lit);
    part.colour[1] = std::min(1.0, colour.y * lit);
    part.colour[2] = std::min(1.0, colour.z * lit);
    for (const CeilingPart &box : ceiling_parts())
      if (same(colour, box.colour)) add_box(part.mesh, box.centre, box.half);
    out.parts.push_back(std::move(part));
  }
}

// A GLB of floor and walls, and in the game a ceiling, that show what they send out (unlit), and a
// directional light for each lamp. The same bytes for any number of threads.
std::string environment_glb(const Scene &scene, uint32_t threads) {
  scene::Environment out;
  add_floor(scene.paint_key(), threads, out);
  add_walls(scene.paint_key(), threads, out);
  if (scene.game()) add_ceiling(scene.paint_key(), threads, out);
  for (const Lamp &lamp : studio_lamps()) {
    fvv_light light = {};
    light.type = FVV_LIGHT_DIRECTIONAL;
    light.flags = FVV_LIGHT_CASTS_SHADOWS;
    const Vec3 direction = -lamp.towards;
    light.direction[0] = direction.x;
    light.direction[1] = direction.y;
    light.direction[2] = direction.z;
    for (double &part : light.colour) part = 1;
    light.intensity = lux * lamp.share;
    out.lights.push_back(light);
  }
  return scene::format_environment(out, {{0, 0, 0}, 0.001}, "environment.glb");
}

constexpr uint32_t samples = 3;
constexpr const char *atlas_file = "atlas.png"; // one for all frames
constexpr const char *environment_file = "environment.glb", *clap_file = "claps.wav",
                     *shoe_file = "shoes.wav", *ball_file = "ball.wav";
constexpr double remesh_cell = 0.0203; // metres: about as many triangles as the tracked mesh
using Json = nlohmann::ordered_json;

std::string dumped(const Json &json) {
  return json.dump(2) + "\n";
}

void append(std::vector<uint8_t> &out, uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) out.push_back(uint8_t(value >> shift));
}

void append(std::vector<uint8_t> &out, float value) {
  uint32_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  append(out, bits);
}

std::vector<float> positions(const Surface &surface) {
  std::vector<float> out;
  out.reserve(surface.vertices.size() * 3);
  for (const Vec3 p : surface.vertices)
    for (const double value : {p.x, p.y, p.z}) out.push_back(float(value));
  return out;
}

Surface remeshed(const Scene &scene, const Moment &moment, size_t frame) {
  const uint64_t key = scene.settings().seed * 0x9e3779b97f4a7c15u ^ (frame + 1);
  return remesh(remesh_grid(moment.positions, remesh_cell, key), moment.positions, scene.faces());
}

Json description(const Grid &grid) {
  return {{"origin", {grid.origin.x, grid.origin.y, grid.origin.z}},
          {"cell", grid.cell},
          {"dimensions", {grid.count[0], grid.count[1], grid.count[2]}},
          {"edge_margin", hull::edge_margin}};
}

Json lens(const fvv_camera &camera) {
  const double *d = camera.distortion;
  if (camera.lens == FVV_LENS_NONE) return {{"model", "none"}, {"coefficients", Json::array()}};
  return {{"model", "radtan"}, {"coefficients", {d[0], d[1], d[2], d[3]}}, {"r_max", camera.r_max}};
}

// What may change from frame to frame.
Json calibration(const fvv_camera &camera) {
  const double *r = camera.rotation, *t = camera.translation;
  return {
      {"intrinsics",
       {{"fx", camera.fx}, {"fy", camera.fy}, {"cx", camera.cx}, {"cy", camera.cy}, {"skew", camera.skew}}},
      {"rotation", {{r[0], r[1], r[2]}, {r[3], r[4], r[5]}, {r[6], r[7], r[8]}}},
      {"translation", {t[0], t[1], t[2]}}};
}

} // namespace

std::string numbered(const char *before, size_t number, const char *after) {
  char digits[24];
  std::snprintf(digits, sizeof digits, "%04zu", number);
  return std::string(before) + digits + after;
}

std::string_view text_of(const std::vector<uint8_t> &bytes) {
  return {reinterpret_cast<const char *>(bytes.data()), bytes.size()};
}

std::vector<uint8_t> ply(const std::vector<float> &positions, const std::vector<uint32_t> &faces,
                         const Layout *layout) {
  const std::string header =
      "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(positions.size() / 3) +
      "\nproperty float x\nproperty float y\nproperty float z\n" +
      (layout ? "property float s\nproperty float t\n" : "") + "element face " +
      std::to_string(faces.size() / 3) + "\nproperty list uchar int vertex_indices\nend_header\n";
  std::vector<uint8_t> out(header.begin(), header.end());
  out.reserve(out.size() + positions.size() / 3 * (layout ? 20 : 12) + faces.size() / 3 * 13);
  for (size_t vertex = 0; vertex < positions.size() / 3; vertex++) {
    for (size_t axis = 0; axis < 3; axis++) append(out, positions[3 * vertex + axis]);
    if (!layout) continue;
    // t points up.
    append(out, float(layout->texels[vertex][0] / layout->size));
    append(out, float(1 - layout->texels[vertex][1] / layout->size));
  }
  for (size_t i = 0; i < faces.size(); i += 3) {
    out.push_back(3);
    for (size_t c = 0; c < 3; c++) append(out, faces[i + c]);
  }
  return out;
}

std::string rate_text(FrameRate rate) {
  const std::string numerator = std::to_string(rate.numerator);
  return rate.denominator == 1 ? numerator : numerator + "/" + std::to_string(rate.denominator);
}

std::vector<uint8_t> png(const render::Picture &picture, int channels, const std::vector<uint8_t> &pixels) {
  media::Image image;
  image.width = picture.width;
  image.height = picture.height;
  image.channels = channels;
  image.pixels = pixels;
  return media::encode_png(image, media::PngEffort::fast);
}

Json describe(const fvv_camera &camera) {
  Json entry = {{"id", camera.id},
                {"name", std::string(camera.name, camera.name_size)},
                {"width", camera.width},
                {"height", camera.height}};
  entry.update(calibration(camera));
  entry["lens"] = lens(camera);
  return entry;
}

namespace {

const char *extension(Pictures kind) {
  return kind == Pictures::exr ? ".exr" : kind == Pictures::jpeg ? ".jpg" : ".png";
}

Json description(const Scene &scene, const Recording &recording) {
  Json cameras = Json::array();
  size_t number = 0;
  for (const fvv_camera &camera : scene.cameras()) {
    const std::string name(camera.name, camera.name_size);
    Json entry = describe(camera);
    if (scene.moves(number))
      for (size_t frame = 0; frame < recording.frames; frame++) {
        Json state = {{"frame", frame}};
        state.update(calibration(scene.camera(number, frame_time(recording.rate, frame))));
        entry["per_frame"].push_back(state);
      }
    if (name == overhead) entry["texture"] = false;
    entry["pictures"] = name + "/%04d" + extension(recording.pictures);
    entry["masks"] = name + "/mask_%04d.png";
    cameras.push_back(entry);
    number++;
  }
  Json out = {{"fvv_capture", 1},
              {"name", scene.game() ? "game" : "players"},
              {"frame_rate", rate_text(recording.rate)},
              {"frames", {{"first", 0}, {"count", recording.frames}}},
              {"units", "metres"},
              {"up", "+y"},
              {"conventions", {{"pixel_centre", 0.5}}},
              {"meshes", {{"pattern", "meshes/%04d.ply"}}}};
  if (recording.atlas) out["atlas"] = {{"pictures", atlas_file}};
  if (recording.environment) out["environment"] = {{"file", environment_file}};
  if (recording.sound) {
    Json places = Json::array();
    for (size_t frame = 0; frame < recording.frames; frame++) {
      const Vec3 at = scene.action().ball_position(frame_time(recording.rate, frame));
      places.push_back({{"frame", frame}, {"position", {at.x, at.y, at.z}}});
    }
    const Json others = scene.game() ? Json{{"file", shoe_file}, {"title", "shoes"}}
                                     : Json{{"file", clap_file}, {"title", "claps"}};
    out["audio"] = {others, {{"file", ball_file}, {"title", "ball"}, {"per_frame", places}}};
  }
  out["cameras"] = cameras;
  return out;
}

std::vector<uint8_t> photograph(const render::Picture &picture) {
  constexpr int best = 95;
  media::Image image;
  image.width = picture.width;
  image.height = picture.height;
  image.channels = 3;
  image.pixels = picture.rgb;
  return media::encode_jpeg(image, best, media::Subsampling::yuv444);
}

std::vector<uint8_t> exr(const render::LitPicture &lit) {
  media::LinearImage image;
  image.width = lit.width;
  image.height = lit.height;
  image.channels = 3;
  image.pixels = lit.light;
  return media::encode_half_exr(image);
}

} // namespace

hull::Grid hull_grid(size_t cells) {
  const Vec3 low{-2.4, 0, -1.2}, high{2.4, 2.3, 1.2};
  const double cell = (high.x - low.x) / double(cells);
  return hull::grid_over({low.x, -0.5 * cell, low.z}, high, cell);
}

FrameRate parse_frame_rate(const std::string &text) {
  const std::optional<fvv_rational> rate = scene::parse_rational(text);
  if (!rate || !rate->numerator)
    throw Error("--fps: expected a number like 25 or a fraction like 30000/1001, found " + scene::quote(text),
                Error::usage);
  return {rate->numerator, rate->denominator};
}

void write_capture(const Scene &scene, const Recording &recording, cli::OutputFolder &folder) {
  const Grid grid = hull_grid(recording.hull_cells);
  std::optional<Atlas> atlas;
  if (recording.atlas) {
    atlas = make_atlas(scene, recording.atlas, recording.threads);
    folder.write(atlas_file, text_of(media::encode_png(atlas->picture)));
  }
  if (recording.environment) {
    folder.write(environment_file, environment_glb(scene, recording.threads));
  }
  if (recording.sound) {
    const auto wav = [](const std::vector<int16_t> &samples) {
      return media::wav_file(samples, 1, sound_rate);
    };
    if (scene.game())
      folder.write(shoe_file, wav(shoe_sound(*scene.game(), recording.rate, recording.frames)));
    else
      folder.write(clap_file, wav(clap_sound(recording.rate, recording.frames)));
    folder.write(ball_file, wav(ball_sound(scene.action(), recording.rate, recording.frames, scene.game())));
  }
  cli::Progress progress("fvvsynth", recording.frames);
  hull::Options carving;
  carving.floor = hull::Floor{{0, 1, 0}, 0};
  const auto frame = [&](size_t number) {
    const Filming filming(scene, recording.realism, recording.rate, number);
    const Moment &moment = filming.moment();
    render::SampleBuffer buffer(1, 1, samples);
    std::vector<fvv_camera> cameras;
    std::vector<hull::Silhouette> silhouettes;
    for (size_t i = 0; i < scene.cameras().size(); i++) {
      const fvv_camera camera = scene.camera(i, moment.seconds);
      cameras.push_back(camera);
      const std::string name = std::string(camera.name, camera.name_size) + "/";
      const std::string path = numbered(name.c_str(), number, extension(recording.pictures));
      render::Picture picture;
      if (recording.pictures == Pictures::exr) {
        render::LitPicture lit = filming.shoot_linear(i, buffer);
        folder.write(path, text_of(exr(lit)));
        picture = {lit.width, lit.height, {}, std::move(lit.mask), std::move(lit.depth)};
      } else {
        picture = filming.shoot(i, buffer);
        folder.write(path, text_of(recording.pictures == Pictures::jpeg ? photograph(picture)
                                                                        : png(picture, 3, picture.rgb)));
      }
      folder.write(numbered((name + "mask_").c_str(), number, ".png"),
                   text_of(png(picture, 1, picture.mask)));
      if (recording.depth)
        folder.write(numbered((name + "depth_").c_str(), number, ".exr"), text_of(depth_exr(picture)));
      if (recording.meshes == Meshes::hull) silhouettes.emplace_back(camera, picture.mask);
    }
    const std::string path = numbered("meshes/", number, ".ply");
    const auto write_mesh = [&](const std::vector<float> &points, const std::vector<uint32_t> &faces) {
      if (atlas)
        folder.write(path, text_of(ply(atlas->opened(points, 3), atlas->layout.faces, &atlas->layout)));
      else
        folder.write(path, text_of(ply(points, faces, nullptr)));
      if (!recording.visibility) return;
      const VisibilityFiles seen =
          visibility_files(cameras, points, faces, atlas ? &atlas->layout.source : nullptr);
      folder.write(numbered("visibility/faces_", number, ".npy"), text_of(seen.faces));
      folder.write(numbered("visibility/vertices_", number, ".npy"), text_of(seen.vertices));
    };
    if (recording.meshes == Meshes::tracked) {
      write_mesh(moment.positions, scene.faces());
    } else {
      const Surface surface = recording.meshes == Meshes::hull
                                  ? hull::carve(grid, silhouettes, carving).surface
                                  : remeshed(scene, moment, number);
      if (surface.faces.empty()) throw Error(folder.shown(path) + ": the masks of this frame leave no hull");
      write_mesh(positions(surface), surface.faces);
    }
  };
  fvv::parallel(recording.threads, recording.frames, frame, [&] { progress.step(); });
  if (recording.meshes == Meshes::hull) folder.write("hull.json", dumped(description(grid)));
  folder.write("capture.json", dumped(description(scene, recording)));
}

} // namespace fvv::synth
