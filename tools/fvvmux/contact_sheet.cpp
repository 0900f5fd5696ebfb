#include "fvvmux/contact_sheet.h"

#include "cli/parallel.h"
#include "fvvmux/panel.h"

#include <algorithm>
#include <cmath>

namespace fvv::mux {

namespace {

struct Panel {
  media::Image image;
  std::vector<std::string> problems;
};

double covered_share(const std::vector<uint8_t> &cover) {
  const auto inside = std::count_if(cover.begin(), cover.end(), [](uint8_t c) { return c != 0; });
  return double(inside) / double(cover.size());
}

Panel make_panel(const SheetInput &input, const Subject &subject, const Layout &layout, size_t i,
                 SheetCamera &camera) {
  Panel panel;
  Loaded picture = picture_of(input, i), mask = mask_of(input, i);
  for (const Loaded *loaded : {&picture, &mask})
    if (!loaded->problem.empty()) panel.problems.push_back(loaded->problem);
  camera.picture = !picture.image.pixels.empty();
  camera.mask = !mask.image.pixels.empty();
  std::vector<uint8_t> cover;
  if (subject.outlined != Outlined::nothing) {
    const auto [width, height] = picture_size(input.cameras[i], layout);
    cover = subject.body.cover(camera.mask ? input.cameras[i] : resized(input.cameras[i], width, height));
    camera.covered = covered_share(cover);
    if (camera.mask)
      camera.fit = compare(cover, mask.image.pixels, camera.width, camera.height);
    else
      cover.clear();
  }
  panel.image = draw_picture(input, subject, i, layout, picture.image, mask.image, cover);
  return panel;
}

void conclude(SheetReport &report) {
  std::vector<Measured> measured;
  std::vector<double> ious, distances;
  bool in_sight = report.outlined == Outlined::nothing;
  for (const SheetCamera &camera : report.cameras) {
    measured.push_back({camera.fit, std::hypot(camera.width, camera.height)});
    if (camera.fit.iou) ious.push_back(*camera.fit.iou);
    if (camera.fit.distance) distances.push_back(*camera.fit.distance);
    in_sight = in_sight || camera.covered > 0;
  }
  report.median_iou = median(ious);
  report.median_distance = median(distances);
  report.standing_out = standing_out(measured);
  report.suspicion = in_sight ? suspect(measured) : Suspicion::misses_all;
}

} // namespace

SheetReport check_calibration(const Options &options) {
  const SheetInput input = open_capture(options);
  cli::OutputFile file(options.sheet, options.force);
  const Subject subject = subject_of(input, options);
  const Layout layout = arrange_panels(input.cameras, options.sheet_width);
  SheetReport report;
  report.path = options.sheet;
  report.warnings = input.warnings;
  report.frame = input.frame;
  report.outlined = subject.outlined;
  report.left_out = subject.left_out;
  report.panel = layout.picture;
  for (size_t i = 0; i < input.cameras.size(); i++) {
    const fvv_camera &c = input.cameras[i];
    SheetCamera camera;
    camera.id = c.id;
    camera.name = *input.capture.cameras[i].name;
    camera.width = c.width;
    camera.height = c.height;
    report.cameras.push_back(std::move(camera));
  }
  std::vector<Panel> panels(input.cameras.size());
  cli::Progress progress("cameras", panels.size());
  cli::parallel(
      options.threads, panels.size(),
      [&](size_t i) { panels[i] = make_panel(input, subject, layout, i, report.cameras[i]); },
      [&] { progress.step(); });
  std::vector<media::Image> pictures;
  const size_t before = report.warnings.size();
  bool named = false, read = false;
  for (size_t i = 0; i < panels.size(); i++) {
    report.warnings.insert(report.warnings.end(), panels[i].problems.begin(), panels[i].problems.end());
    named = named || (input.pictures && input.capture.cameras[i].pictures);
    read = read || report.cameras[i].picture;
    pictures.push_back(std::move(panels[i].image));
  }
  if (named && !read)
    throw cli::Failure(input.capture.path + ": no camera's picture of frame " + std::to_string(input.frame) +
                       " can be read; the first problem is: " + report.warnings[before]);
  conclude(report);
  const media::Image sheet = draw_sheet(input, report, layout, pictures);
  report.width = sheet.width;
  report.height = sheet.height;
  const std::vector<uint8_t> bytes = media::encode_png(sheet);
  file.write(bytes.data(), bytes.size());
  file.commit();
  for (const std::string &warning : report.warnings) cli::warn(warning);
  return report;
}

} // namespace fvv::mux
