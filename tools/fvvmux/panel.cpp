#include "fvvmux/panel.h"

#include "fvvmux/guides.h"
#include "fvvmux/label.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace fvv::mux {

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
  if (camera.fit.iou && camera.fit.distance)
    std::snprintf(text, sizeof text, "IoU %.3f  %.2f px", *camera.fit.iou, *camera.fit.distance);
  else if (camera.fit.iou)
    std::snprintf(text, sizeof text, "IoU %.3f", *camera.fit.iou);
  return text;
}

void draw_label(media::Image &image, const SheetCamera &camera, bool stands_out, uint32_t x, uint32_t y,
                const Layout &layout) {
  const uint32_t width = layout.panel_width - gap, scale = layout.scale;
  const Colour ink = stands_out ? yellow : light;
  const std::string size = std::to_string(camera.width) + "x" + std::to_string(camera.height);
  const std::string id = std::to_string(camera.id), who = camera.name.empty() ? id : id + " " + camera.name;
  const uint32_t room = text_width("  " + size, scale);
  const std::string kept = shortened(who, scale, width > room ? width - room : 0);
  draw_text(image, x, y, kept, scale, ink);
  draw_text(image, x + text_width(kept + "  ", scale), y, size, scale, grey);
  std::string below = numbers(camera);
  if (stands_out) below += "  stands out";
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
  subject.body.draw_outline(calibration, image);
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
    const auto &out = report.standing_out;
    const bool stands_out = std::find(out.begin(), out.end(), i) != out.end();
    const uint32_t x = gap + uint32_t(i) % layout.columns * layout.panel_width,
                   y = top + gap + uint32_t(i) / layout.columns * layout.panel_height;
    draw_label(sheet, report.cameras[i], stands_out, x, y, layout);
    const media::Image &picture = pictures[i];
    const uint32_t left = x + (layout.panel_width - gap - picture.width) / 2;
    paste(sheet, picture, left, y + layout.label);
    if (stands_out)
      frame(sheet, {left, y + layout.label, left + picture.width, y + layout.label + picture.height},
            2 * layout.scale, yellow);
  }
  return sheet;
}

} // namespace fvv::mux
