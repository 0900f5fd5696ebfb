// A ball before nine cameras with lenses, its masks by the geometry of rays: what a contact sheet is tested
// with. The masks owe nothing to the rasteriser.
#pragma once

#include "../mux_fixture.h"

#include "fvvimport/sheet.h"

constexpr double ball_radius = 0.5;
constexpr double ball_centre[3] = {0.1, 0.2, -0.1};
constexpr size_t ring_cameras = 9;

// 48 x 96 cells: the sphere is nowhere more than 0.0011 above its faces.
inline geometry::Mesh sheet_ball() {
  constexpr uint32_t rows = 48, columns = 96;
  geometry::Mesh mesh;
  for (uint32_t r = 0; r <= rows; r++)
    for (uint32_t c = 0; c < columns; c++) {
      const double polar = M_PI * r / rows, around = 2 * M_PI * c / columns;
      mesh.positions.push_back(ball_centre[0] + ball_radius * std::sin(polar) * std::cos(around));
      mesh.positions.push_back(ball_centre[1] + ball_radius * std::cos(polar));
      mesh.positions.push_back(ball_centre[2] + ball_radius * std::sin(polar) * std::sin(around));
    }
  for (uint32_t r = 0; r < rows; r++)
    for (uint32_t c = 0; c < columns; c++) {
      const uint32_t a = r * columns + c, b = r * columns + (c + 1) % columns;
      if (r > 0) mesh.faces.insert(mesh.faces.end(), {a, b, a + columns});
      if (r + 1 < rows) mesh.faces.insert(mesh.faces.end(), {b, b + columns, a + columns});
    }
  return mesh;
}

// On a ring of 3 m at changing heights, looking at the origin, with barrel distortion and unlike sizes.
inline fvv_camera ring_camera(size_t k) {
  fvv_camera c = {};
  c.id = uint16_t(k + 1);
  c.width = k % 2 ? 160 : 200;
  c.height = k % 2 ? 120 : 150;
  c.fx = c.fy = k % 2 ? 170 : 215;
  c.cx = c.width / 2.0 + 3;
  c.cy = c.height / 2.0 - 2;
  c.lens = FVV_LENS_RADTAN;
  c.distortion[0] = -0.15;
  c.distortion[2] = 0.002;
  const double around = 2 * M_PI * double(k) / ring_cameras, up = k % 3 ? 0.3 : -0.4;
  const double s = std::sin(around), co = std::cos(around), n = std::hypot(1, up);
  // Rows: right, down, forward; the camera is at -3 forward.
  const double forward[3] = {-s / n, -up / n, -co / n};
  const double right[3] = {co, 0, -s};
  const double down[3] = {forward[1] * right[2] - forward[2] * right[1],
                          forward[2] * right[0] - forward[0] * right[2],
                          forward[0] * right[1] - forward[1] * right[0]};
  std::copy_n(right, 3, c.rotation);
  std::copy_n(down, 3, c.rotation + 3);
  std::copy_n(forward, 3, c.rotation + 6);
  c.translation[2] = 3;
  c.r_max = fvv_camera_r_max(&c);
  return c;
}

// Whether the ray through a pixel position meets the ball.
inline bool ball_seen(const fvv_camera &c, double u, double v) {
  const double pixel[2] = {u, v};
  double ray[3], centre[3];
  if (!fvv_camera_unproject(&c, pixel, ray)) return false;
  for (int row = 0; row < 3; row++) {
    centre[row] = c.translation[row];
    for (int k = 0; k < 3; k++) centre[row] += c.rotation[3 * row + k] * ball_centre[k];
  }
  const double rr = ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2];
  const double rc = ray[0] * centre[0] + ray[1] * centre[1] + ray[2] * centre[2];
  const double cc = centre[0] * centre[0] + centre[1] * centre[1] + centre[2] * centre[2];
  return cc - rc * rc / rr < ball_radius * ball_radius;
}

inline media::Image ball_mask(const fvv_camera &c) {
  media::Image mask = media::make_image(c.width, c.height, 1, 0);
  for (uint32_t y = 0; y < c.height; y++)
    for (uint32_t x = 0; x < c.width; x++)
      if (ball_seen(c, x + 0.5, y + 0.5)) mask.pixels[size_t(y) * c.width + x] = 255;
  return mask;
}

struct SheetShape {
  bool meshes = true, masks = true;
  size_t cameras = ring_cameras;
  // Changes camera k in capture.json after its masks were drawn.
  std::function<void(size_t k, fvv_camera &)> mistake = [](size_t, fvv_camera &) {};
};

// Writes folder/in with three frames, all alike, and returns its description.
inline scene::Capture make_sheet_capture(const Folder &folder, const SheetShape &shape = {}) {
  scene::Capture capture;
  capture.path = folder.path("in/capture.json");
  capture.name = "one ball";
  capture.frames = {10, 3, 1};
  capture.up = FVV_UP_Y;
  fs::create_directories(folder.path("in"));
  if (shape.meshes) capture.meshes = scene::Pattern::parse("mesh%d.ply", nullptr);
  for (size_t k = 0; k < shape.cameras; k++) {
    const std::string id = std::to_string(k + 1);
    scene::Camera camera;
    camera.calibration = ring_camera(k);
    camera.set_name("ring " + id);
    camera.pictures = scene::Pattern::parse("p" + id + "_%d.png", nullptr);
    if (shape.masks) camera.masks = scene::Pattern::parse("m" + id + "_%d.png", nullptr);
    const media::Image mask = ball_mask(camera.calibration);
    media::Image picture = media::make_image(mask.width, mask.height, 3, 90);
    for (size_t i = 0; i < mask.pixels.size(); i++)
      if (mask.pixels[i]) picture.pixels[3 * i] = 150;
    capture.cameras.push_back(camera);
    for (const int64_t frame : capture.frames.numbers()) {
      write_png(capture.picture_path(camera, frame), picture);
      if (shape.masks) write_png(capture.mask_path(camera, frame), mask);
    }
    shape.mistake(k, capture.cameras.back().calibration);
  }
  if (shape.meshes)
    for (const int64_t frame : capture.frames.numbers())
      scene::write_mesh(sheet_ball(), {}, capture.mesh_path(frame));
  scene::write_capture(capture, capture.path);
  return capture;
}

inline fvvimport::SheetOptions sheet_options(const Folder &folder) {
  fvvimport::SheetOptions options;
  options.capture = folder.path("in");
  options.output = folder.path("sheet.png");
  options.threads = 2;
  options.force = true;
  return options;
}
