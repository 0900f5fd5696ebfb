#include "fvvimport/panel.h"
#include "fvv_geometry/mesh.h"
#include "fvv_geometry/outline.h"
#include "fvv_geometry/rig.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <optional>
#include <stb/stb_easy_font.h>

namespace fvv::fvvimport {

namespace {

constexpr double rim = 1; // pixels

} // namespace

void blend(media::Image &image, uint32_t x, uint32_t y, Colour colour, double alpha) {
  if (x >= image.width || y >= image.height) return;
  uint8_t *p = &image.pixels[3 * (static_cast<size_t>(y) * image.width + x)];
  const uint8_t to[3] = {colour.red, colour.green, colour.blue};
  for (int i = 0; i < 3; i++) p[i] = static_cast<uint8_t>(std::lround(p[i] + (to[i] - p[i]) * alpha));
}

void fill(media::Image &image, const Box &box, Colour colour, double alpha) {
  for (uint32_t y = box.top; y < std::min(box.bottom, image.height); y++)
    for (uint32_t x = box.left; x < std::min(box.right, image.width); x++) blend(image, x, y, colour, alpha);
}

void frame(media::Image &image, const Box &box, uint32_t thickness, Colour colour) {
  fill(image, {box.left, box.top, box.right, box.top + thickness}, colour, 1);
  fill(image, {box.left, box.bottom - thickness, box.right, box.bottom}, colour, 1);
  fill(image, {box.left, box.top, box.left + thickness, box.bottom}, colour, 1);
  fill(image, {box.right - thickness, box.top, box.right, box.bottom}, colour, 1);
}

void tint(media::Image &image, const media::Image &shares, Colour colour, double alpha) {
  for (uint32_t y = 0; y < image.height; y++)
    for (uint32_t x = 0; x < image.width; x++)
      if (const uint8_t share = shares.pixels[static_cast<size_t>(y) * image.width + x])
        blend(image, x, y, colour, alpha * share / 255);
}

Lines::Lines(uint32_t w, uint32_t h)
    : width(w), height(h), inner(static_cast<size_t>(w) * h), outer(inner.size()) {}

void Lines::add(Pixel a, Pixel b, double core) {
  for (const Pixel &end : {a, b})
    if (!(end[0] >= -double(width) && end[0] <= 2.0 * width && end[1] >= -double(height) &&
          end[1] <= 2.0 * height))
      return;
  cover(inner, a, b, core / 2);
  cover(outer, a, b, core / 2 + rim);
}

// What lies within radius of the line, softened over one pixel.
void Lines::cover(std::vector<float> &share, Pixel a, Pixel b, double radius) const {
  const double dx = b[0] - a[0], dy = b[1] - a[1], squared = dx * dx + dy * dy, reach = radius + 1;
  const auto first = [&](double u) { return static_cast<uint32_t>(std::max(0.0, std::floor(u - reach))); };
  const auto last = [&](double u, uint32_t size) {
    return static_cast<uint32_t>(std::clamp(std::ceil(u + reach), 0.0, static_cast<double>(size)));
  };
  for (uint32_t y = first(std::min(a[1], b[1])); y < last(std::max(a[1], b[1]), height); y++)
    for (uint32_t x = first(std::min(a[0], b[0])); x < last(std::max(a[0], b[0]), width); x++) {
      const double px = x + 0.5 - a[0], py = y + 0.5 - a[1];
      const double along = squared > 0 ? std::clamp((px * dx + py * dy) / squared, 0.0, 1.0) : 0;
      const double ex = px - along * dx, ey = py - along * dy;
      float &value = share[static_cast<size_t>(y) * width + x];
      value = std::max(value,
                       static_cast<float>(std::clamp(radius + 0.5 - std::sqrt(ex * ex + ey * ey), 0.0, 1.0)));
    }
}

void Lines::draw(media::Image &image, Colour colour, double alpha) const {
  for (uint32_t y = 0; y < height; y++)
    for (uint32_t x = 0; x < width; x++) {
      const size_t i = static_cast<size_t>(y) * width + x;
      if (outer[i] > 0) blend(image, x, y, dark, 0.7 * alpha * outer[i]);
      if (inner[i] > 0) blend(image, x, y, colour, alpha * inner[i]);
    }
}

void paste(media::Image &image, const media::Image &part, uint32_t x, uint32_t y) {
  for (uint32_t row = 0; row < part.height; row++)
    std::copy_n(&part.pixels[size_t(3) * row * part.width], size_t(3) * part.width,
                &image.pixels[3 * (static_cast<size_t>(y + row) * image.width + x)]);
}

namespace {

// As stb_easy_font writes them.
struct Vertex {
  float x, y, z;
  unsigned char colour[4];
};
constexpr size_t quads_per_character = 32; // more than any glyph has

std::string printable(const std::string &text) {
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if ((byte & 0xc0) == 0x80) continue; // the rest of a character of several bytes
    out += byte >= 32 && byte < 127 ? c : '?';
  }
  return out;
}

} // namespace

uint32_t text_width(const std::string &text, uint32_t scale) {
  std::string copy = printable(text);
  return static_cast<uint32_t>(std::max(0, stb_easy_font_width(copy.data()))) * scale;
}

std::string shortened(const std::string &text, uint32_t scale, uint32_t width) {
  std::string kept = printable(text);
  if (text_width(kept, scale) <= width) return kept;
  while (!kept.empty() && text_width(kept + "...", scale) > width) kept.pop_back();
  return kept + "...";
}

void draw_text(media::Image &image, uint32_t x, uint32_t y, const std::string &text, uint32_t scale,
               Colour colour) {
  std::string copy = printable(text);
  std::vector<Vertex> corners(4 * quads_per_character * (copy.size() + 1));
  const int quads = stb_easy_font_print(0, 0, copy.data(), nullptr, corners.data(),
                                        static_cast<int>(corners.size() * sizeof(Vertex)));
  const auto at = [&](uint32_t from, float offset) {
    return from + static_cast<uint32_t>(std::lround(std::max(0.0f, offset))) * scale;
  };
  for (int i = 0; i < quads; i++) {
    const Vertex &low = corners[4 * static_cast<size_t>(i)], &high = corners[4 * static_cast<size_t>(i) + 2];
    fill(image, {at(x, low.x), at(y, low.y), at(x, high.x), at(y, high.y)}, colour, 1);
  }
}

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
  return geometry::round_down_125(geometry::rig_space(cameras).radius / 5);
}

void draw_axes(const std::vector<fvv_camera> &cameras, size_t which, media::Image &image) {
  const fvv_camera camera = geometry::resized(cameras[which], image.width, image.height);
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
  const fvv_camera camera = geometry::resized(cameras[which], image.width, image.height);
  const double step = guide_step(cameras);
  const Vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, centre = geometry::rig_space(cameras).centre;
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
  const fvv_camera camera = geometry::resized(cameras[which], image.width, image.height);
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

namespace {

constexpr uint32_t gap = 6;            // pixels around everything
constexpr uint32_t smallest_side = 24; // of a picture, below which a sheet shows nothing
constexpr double disagreement = 0.6;   // opacity

// Sizes of panels and text for pictures of a longest side.
Layout panels_of(const std::vector<fvv_camera> &cameras, uint32_t side) {
  Layout layout;
  layout.picture = side;
  layout.scale = std::clamp(side / 240, 1u, 4u);
  layout.label = 2 * line_height(layout.scale);
  for (const fvv_camera &camera : cameras) {
    const auto [width, height] = picture_size(camera, layout);
    layout.panel_width = std::max(layout.panel_width, width + gap);
    layout.panel_height = std::max(layout.panel_height, height + 2 * gap);
  }
  layout.panel_height += layout.label;
  return layout;
}

// The number of columns that makes the sheet's longer side shortest.
Layout squarest(Layout layout, uint32_t count) {
  Layout best;
  for (uint32_t columns = 1; columns <= count; columns++) {
    layout.columns = columns;
    layout.rows = (count + columns - 1) / columns;
    layout.width = columns * layout.panel_width + gap;
    layout.height = layout.rows * layout.panel_height + gap;
    if (columns == 1 || std::max(layout.width, layout.height) < std::max(best.width, best.height))
      best = layout;
  }
  return best;
}

enum class Swatch { line, area, dot };
struct Entry {
  Swatch swatch;
  Colour colour;
  const char *text;
};

std::vector<Entry> legend(const SheetInput &input, const SheetReport &report) {
  std::vector<Entry> entries;
  const bool hull = report.outlined == Outlined::hull;
  if (report.outlined != Outlined::nothing)
    entries.push_back({Swatch::line, light, hull ? "outline of the masks' hull" : "outline of the mesh"});
  if (report.median_iou) {
    entries.push_back({Swatch::area, orange, hull ? "hull outside mask" : "mesh outside mask"});
    entries.push_back({Swatch::area, sky_blue, hull ? "mask outside hull" : "mask outside mesh"});
  }
  entries.push_back({Swatch::line, vermillion, "x"});
  entries.push_back({Swatch::line, bluish_green, "y"});
  entries.push_back({Swatch::line, blue, "z"});
  if (input.cameras.size() > 1) entries.push_back({Swatch::dot, light, "another camera"});
  return entries;
}

void draw_swatch(media::Image &image, const Entry &entry, const Box &box) {
  const double middle = (box.top + box.bottom) / 2.0, left = box.left, right = box.right;
  Lines lines(image.width, box.bottom);
  if (entry.swatch == Swatch::area) fill(image, box, entry.colour, 1);
  if (entry.swatch == Swatch::line) lines.add({left, middle}, {right, middle}, 2);
  if (entry.swatch == Swatch::dot) lines.add({right, middle}, {right, middle}, camera_dot);
  lines.draw(image, entry.colour, 1);
}

// Title and legend, wrapped to the width; the height that they take. Drawn only where there is an image.
uint32_t header(const SheetInput &input, const SheetReport &report, const Layout &layout,
                media::Image *image) {
  const uint32_t scale = layout.scale, high = line_height(scale), width = layout.width - 2 * gap;
  uint32_t y = gap;
  std::string title = input.capture.name.empty() ? "frame " : input.capture.name + ", frame ";
  title += std::to_string(input.frame);
  if (image) draw_text(*image, gap, y, shortened(title, scale, width), scale, light);
  y += high;
  uint32_t x = gap;
  for (const Entry &entry : legend(input, report)) {
    const uint32_t swatch = 2 * high, needed = swatch + gap + text_width(entry.text, scale);
    if (x > gap && x + needed > width) x = gap, y += high;
    if (image) {
      draw_swatch(*image, entry, {x, y, x + swatch - gap, y + 2 * high / 3});
      draw_text(*image, x + swatch, y, shortened(entry.text, scale, width), scale, light);
    }
    x += needed + high;
  }
  return y + high;
}

std::string numbers(const SheetCamera &camera) {
  char text[80] = "";
  if (camera.match.iou && camera.match.distance)
    std::snprintf(text, sizeof text, "IoU %.3f  %.2f px", *camera.match.iou, *camera.match.distance);
  else if (camera.match.iou)
    std::snprintf(text, sizeof text, "IoU %.3f", *camera.match.iou);
  return text;
}

void draw_label(media::Image &image, const SheetCamera &camera, bool is_outlier, uint32_t x, uint32_t y,
                const Layout &layout) {
  const uint32_t width = layout.panel_width - gap, scale = layout.scale;
  const Colour ink = is_outlier ? yellow : light;
  const std::string size = std::to_string(camera.width) + "x" + std::to_string(camera.height);
  const std::string id = std::to_string(camera.id), who = camera.name.empty() ? id : id + " " + camera.name;
  const uint32_t room = text_width("  " + size, scale);
  const std::string kept = shortened(who, scale, width > room ? width - room : 0);
  draw_text(image, x, y, kept, scale, ink);
  draw_text(image, x + text_width(kept + "  ", scale), y, size, scale, grey);
  std::string below = numbers(camera);
  if (is_outlier) below += "  stands out";
  if (!camera.picture) below += below.empty() ? "no picture" : "  no picture";
  draw_text(image, x, y + line_height(scale), shortened(below, scale, width), scale, ink);
}

} // namespace

std::array<uint32_t, 2> picture_size(const fvv_camera &camera, const Layout &layout) {
  const uint64_t longest = std::max(camera.width, camera.height);
  const auto scaled = [&](uint64_t side) {
    return std::max(1u, uint32_t((side * layout.picture + longest / 2) / longest));
  };
  return {scaled(camera.width), scaled(camera.height)};
}

Layout arrange_panels(const std::vector<fvv_camera> &cameras, uint32_t longest_side) {
  for (uint32_t side = longest_side;; side--) {
    const Layout layout = squarest(panels_of(cameras, side), uint32_t(cameras.size()));
    // An eighth for title and legend, which wrap.
    if (side == smallest_side || (layout.width <= largest_sheet && layout.height <= largest_sheet * 7 / 8))
      return layout;
  }
}

void draw_outline(const geometry::ViewedSurface &surface, const fvv_camera &camera, media::Image &image) {
  constexpr double core = 0.7, dark_rim = 2; // pixels from the middle of the line
  constexpr uint32_t samples = geometry::outline_samples;
  if (surface.empty()) return;
  const size_t columns = size_t(image.width) * samples;
  const std::vector<float> distance = surface.outline_distance(camera, image.width, image.height);
  for (uint32_t y = 0; y < image.height; y++)
    for (uint32_t x = 0; x < image.width; x++) {
      int light_samples = 0, dark_samples = 0;
      for (uint32_t row = 0; row < samples; row++)
        for (uint32_t column = 0; column < samples; column++) {
          const float d = distance[(size_t(y) * samples + row) * columns + size_t(x) * samples + column];
          light_samples += d <= core * samples;
          dark_samples += d > core * samples && d <= dark_rim * samples;
        }
      if (dark_samples) blend(image, x, y, dark, 0.8 * dark_samples / (samples * samples));
      if (light_samples) blend(image, x, y, light, double(light_samples) / (samples * samples));
    }
}

media::Image draw_picture(const SheetInput &input, const Subject &subject, size_t camera,
                          const Layout &layout, const media::Image &picture, const media::Image &mask,
                          const std::vector<uint8_t> &cover) {
  const fvv_camera &calibration = input.cameras[camera];
  const auto [width, height] = picture_size(calibration, layout);
  media::Image image =
      picture.pixels.empty() ? media::make_image(width, height, 3, 72) : media::scale(picture, width, height);
  if (!cover.empty()) {
    media::Image beyond = mask, missed = mask;
    for (size_t i = 0; i < cover.size(); i++) {
      beyond.pixels[i] = cover[i] && !mask.pixels[i] ? 255 : 0;
      missed.pixels[i] = mask.pixels[i] && !cover[i] ? 255 : 0;
    }
    tint(image, media::scale(beyond, width, height), orange, disagreement);
    tint(image, media::scale(missed, width, height), sky_blue, disagreement);
  }
  if (subject.outlined == Outlined::nothing)
    draw_ground(input.cameras, camera,
                input.capture.scale_unknown ? uint8_t(FVV_UP_UNKNOWN) : input.capture.up, image);
  draw_outline(subject.body, calibration, image);
  draw_axes(input.cameras, camera, image);
  draw_cameras(input.cameras, camera, image);
  return image;
}

media::Image draw_sheet(const SheetInput &input, const SheetReport &report, const Layout &layout,
                        const std::vector<media::Image> &pictures) {
  const uint32_t top = header(input, report, layout, nullptr);
  media::Image sheet = media::make_image(layout.width, top + layout.height, 3, 0);
  fill(sheet, {0, 0, sheet.width, sheet.height}, paper, 1);
  header(input, report, layout, &sheet);
  for (size_t i = 0; i < pictures.size(); i++) {
    const auto &out = report.outliers;
    const bool is_outlier = std::find(out.begin(), out.end(), i) != out.end();
    const uint32_t x = gap + uint32_t(i) % layout.columns * layout.panel_width,
                   y = top + gap + uint32_t(i) / layout.columns * layout.panel_height;
    draw_label(sheet, report.cameras[i], is_outlier, x, y, layout);
    const media::Image &picture = pictures[i];
    const uint32_t left = x + (layout.panel_width - gap - picture.width) / 2;
    paste(sheet, picture, left, y + layout.label);
    if (is_outlier)
      frame(sheet, {left, y + layout.label, left + picture.width, y + layout.label + picture.height},
            2 * layout.scale, yellow);
  }
  return sheet;
}

} // namespace fvv::fvvimport
