#include "fvvmux/guides.h"

#include "fvvmux/body.h"
#include "fvvmux/label.h"
#include "fvvmux/plan.h"
#include "fvvmux/rig_space.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace fvv::mux {

namespace {

using render::Vec3;

constexpr int pieces = 64;     // of a line, for lenses and for what is behind the camera
constexpr int ground_half = 8; // squares from the middle of the grid to its border

std::optional<Pixel> seen(const fvv_camera &camera, Vec3 p) {
  const double world[3] = {p.x, p.y, p.z};
  Pixel pixel;
  if (!fvv_camera_project(&camera, world, pixel.data(), nullptr)) return std::nullopt;
  return pixel;
}

bool within(const media::Image &image, const Pixel &p) {
  return p[0] >= 0 && p[1] >= 0 && p[0] < image.width && p[1] < image.height;
}

void add_segment(Lines &lines, const fvv_camera &camera, Vec3 a, Vec3 b, double core) {
  std::optional<Pixel> last = seen(camera, a);
  for (int i = 1; i <= pieces; i++) {
    const std::optional<Pixel> next = seen(camera, mix(a, b, double(i) / pieces));
    if (last && next) lines.add(*last, *next, core);
    last = next;
  }
}

// Text with a dark shadow, beside a point.
void annotate(media::Image &image, const Pixel &p, const std::string &text, Colour colour) {
  const uint32_t x = uint32_t(p[0]) + 4, y = uint32_t(std::max(0.0, p[1] - 4));
  draw_text(image, x + 1, y + 1, text, 1, dark);
  draw_text(image, x, y, text, 1, colour);
}

} // namespace

double guide_step(const std::vector<fvv_camera> &cameras) {
  return round_down_125(rig_space(cameras).radius / 5);
}

void draw_axes(const std::vector<fvv_camera> &cameras, size_t which, media::Image &image) {
  const fvv_camera camera = resized(cameras[which], image.width, image.height);
  const double step = guide_step(cameras);
  const struct {
    Vec3 end;
    Colour colour;
    const char *name;
  } axes[] = {{{step, 0, 0}, vermillion, "x"}, {{0, step, 0}, bluish_green, "y"}, {{0, 0, step}, blue, "z"}};
  for (const auto &axis : axes) {
    Lines lines(image.width, image.height);
    add_segment(lines, camera, {}, axis.end, 2);
    lines.draw(image, axis.colour, 1);
    const std::optional<Pixel> end = seen(camera, axis.end);
    if (end && within(image, *end)) annotate(image, *end, axis.name, light);
  }
}

void draw_ground(const std::vector<fvv_camera> &cameras, size_t which, uint8_t up, media::Image &image) {
  if (up == FVV_UP_UNKNOWN) return;
  const fvv_camera camera = resized(cameras[which], image.width, image.height);
  const double step = guide_step(cameras);
  const Vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, centre = rig_space(cameras).centre;
  const int vertical = up == FVV_UP_X || up == FVV_UP_MINUS_X   ? 0
                       : up == FVV_UP_Y || up == FVV_UP_MINUS_Y ? 1
                                                                : 2;
  const Vec3 a = axes[(vertical + 1) % 3], b = axes[(vertical + 2) % 3];
  const double along_a = std::round(dot(a, centre) / step), along_b = std::round(dot(b, centre) / step);
  Lines lines(image.width, image.height);
  for (int i = -ground_half; i <= ground_half; i++)
    for (const bool turned : {false, true}) {
      const auto at = [&](int end) {
        return a * ((along_a + (turned ? end : i)) * step) + b * ((along_b + (turned ? i : end)) * step);
      };
      add_segment(lines, camera, at(-ground_half), at(ground_half), 1);
    }
  lines.draw(image, light, 0.5);
}

void draw_cameras(const std::vector<fvv_camera> &cameras, size_t which, media::Image &image) {
  const fvv_camera camera = resized(cameras[which], image.width, image.height);
  Lines dots(image.width, image.height);
  for (size_t i = 0; i < cameras.size(); i++) {
    double centre[3];
    fvv_camera_centre(&cameras[i], centre);
    const std::optional<Pixel> p =
        i == which ? std::nullopt : seen(camera, {centre[0], centre[1], centre[2]});
    if (!p || !within(image, *p)) continue;
    dots.add(*p, *p, camera_dot);
    annotate(image, *p, std::to_string(cameras[i].id), light);
  }
  dots.draw(image, light, 1);
}

} // namespace fvv::mux
