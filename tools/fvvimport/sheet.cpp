#include "fvvimport/sheet.h"

#include "cli/cli.h"
#include "cli/output.h"
#include "fvv_cxx/format.h"
#include "fvv_cxx/parallel.h"
#include "fvvimport/panel.h"

#include <algorithm>
#include <cmath>

namespace fvv::fvvimport {

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
    cover = subject.body.cover(camera.mask ? input.cameras[i]
                                           : geometry::resized(input.cameras[i], width, height));
    camera.covered = covered_share(cover);
    if (camera.mask)
      camera.match = geometry::compare(cover, mask.image.pixels, camera.width, camera.height);
    else
      cover.clear();
  }
  panel.image = draw_picture(input, subject, i, layout, picture.image, mask.image, cover);
  return panel;
}

void conclude(SheetReport &report) {
  std::vector<geometry::CameraMatch> measured;
  std::vector<double> ious, distances;
  bool in_sight = report.outlined == Outlined::nothing;
  for (const SheetCamera &camera : report.cameras) {
    measured.push_back({camera.match, std::hypot(camera.width, camera.height)});
    if (camera.match.iou) ious.push_back(*camera.match.iou);
    if (camera.match.distance) distances.push_back(*camera.match.distance);
    in_sight = in_sight || camera.covered > 0;
  }
  report.median_iou = geometry::median(ious);
  report.median_distance = geometry::median(distances);
  report.outliers = geometry::outlier_cameras(measured);
  report.suspicion = in_sight ? geometry::suspect(measured) : geometry::Suspicion::misses_all;
}

} // namespace

SheetReport check_calibration(const SheetOptions &options) {
  const SheetInput input = open_capture(options);
  cli::OutputFile file(options.output, options.force,
                       [&](const auto &visit) { scene::visit_files(input.capture, visit); });
  const Subject subject = subject_of(input, options);
  const Layout layout = arrange_panels(input.cameras, options.width);
  SheetReport report;
  report.path = options.output;
  report.warnings = input.warnings;
  report.frame = input.frame;
  report.outlined = subject.outlined;
  report.excluded = subject.excluded;
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
  cli::Progress progress("fvvimport", panels.size(), "cameras");
  fvv::parallel(
      options.threads, panels.size(),
      [&](size_t i) { panels[i] = make_panel(input, subject, layout, i, report.cameras[i]); },
      [&] { progress.step(); });
  std::vector<media::Image> pictures;
  const size_t before = report.warnings.size();
  bool named = false, read = false;
  for (size_t i = 0; i < panels.size(); i++) {
    report.warnings.insert(report.warnings.end(), panels[i].problems.begin(), panels[i].problems.end());
    named = named || (input.capture.cameras[i].pictures);
    read = read || report.cameras[i].picture;
    pictures.push_back(std::move(panels[i].image));
  }
  if (named && !read)
    throw Error(input.capture.path + ": no camera's picture of frame " + std::to_string(input.frame) +
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

namespace {

using Json = nlohmann::ordered_json;

const char *name_of(Outlined outlined) {
  return outlined == Outlined::mesh ? "mesh" : outlined == Outlined::hull ? "hull" : "nothing";
}

Json or_null(const std::optional<double> &value) {
  return value ? Json(*value) : Json(nullptr);
}

std::string camera_line(const SheetCamera &camera) {
  std::string line = "  " + std::to_string(camera.id) + (camera.name.empty() ? "" : " " + camera.name) +
                     ": " + std::to_string(camera.width) + "x" + std::to_string(camera.height);
  if (!camera.picture) line += ", no picture";
  if (!camera.mask) line += ", no mask";
  if (camera.match.iou) line += fvv::format(", IoU %.4f", *camera.match.iou);
  if (camera.match.distance) line += fvv::format(", outlines %.2f px apart", *camera.match.distance);
  if (camera.match.offset)
    line += fvv::format(", offset (%+.2f, %+.2f) px", (*camera.match.offset)[0], (*camera.match.offset)[1]);
  return line + "\n";
}

std::string hint(const SheetReport &report) {
  const std::string what = report.outlined == Outlined::hull ? "hull" : "mesh";
  if (report.suspicion == geometry::Suspicion::misses_all)
    return "  hint      the " + what +
           " meets no mask, or is in no picture: units, axes, or the direction of the poses "
           "(docs/tools/calibration.md)\n";
  if (report.suspicion == geometry::Suspicion::half_pixel)
    return "  hint      all outlines lie half a pixel off: pixel_centre is 0 for 0.5, or the reverse\n";
  return "";
}

} // namespace

std::string sheet_text(const SheetReport &report) {
  std::string out = report.path + ": " + std::to_string(report.width) + "x" + std::to_string(report.height) +
                    ", frame " + std::to_string(report.frame) + " of " +
                    std::to_string(report.cameras.size()) + " cameras, ";
  out += report.outlined == Outlined::mesh ? "with the outline of the mesh\n"
         : report.outlined == Outlined::hull
             ? "with the outline of the hull of the masks\n"
             : "with axes and cameras only: there are no meshes and no hull\n";
  for (const SheetCamera &camera : report.cameras) out += camera_line(camera);
  if (report.median_iou) out += fvv::format("  median    IoU %.4f", *report.median_iou);
  if (report.median_distance) out += fvv::format(", outlines %.2f px apart", *report.median_distance);
  if (report.median_iou) out += "\n";
  for (const size_t i : report.outliers) {
    const SheetCamera &camera = report.cameras[i];
    out += "  hint      " + scene::describe(camera.id, camera.name) +
           fvv::format(" stands out: its outlines are %.2f px apart\n", *camera.match.distance);
  }
  if (report.excluded)
    out += "  hint      the hull is carved without " +
           scene::describe(report.cameras[*report.excluded].id, report.cameras[*report.excluded].name) +
           ", which alone denies much of what all others see\n";
  return out + hint(report);
}

Json sheet_json(const SheetReport &report) {
  Json cameras = Json::array(), outliers = Json::array();
  for (const SheetCamera &camera : report.cameras) {
    const auto &offset = camera.match.offset;
    cameras.push_back({{"id", camera.id},
                       {"name", camera.name},
                       {"width", camera.width},
                       {"height", camera.height},
                       {"picture", camera.picture},
                       {"mask", camera.mask},
                       {"covered", camera.covered},
                       {"iou", or_null(camera.match.iou)},
                       {"distance", or_null(camera.match.distance)},
                       {"offset", offset ? Json({(*offset)[0], (*offset)[1]}) : Json(nullptr)}});
  }
  for (const size_t i : report.outliers) outliers.push_back(report.cameras[i].id);
  return {{"fvvimport", 1},
          {"sheet", report.path},
          {"frame", report.frame},
          {"outline", name_of(report.outlined)},
          {"width", report.width},
          {"height", report.height},
          {"panel", report.panel},
          {"cameras", cameras},
          {"median_iou", or_null(report.median_iou)},
          {"median_distance", or_null(report.median_distance)},
          {"outliers", outliers},
          {"excluded", report.excluded ? Json(report.cameras[*report.excluded].id) : Json(nullptr)},
          {"suspected", report.suspicion == geometry::Suspicion::half_pixel   ? Json("half_pixel")
                        : report.suspicion == geometry::Suspicion::misses_all ? Json("misses_all")
                                                                              : Json(nullptr)},
          {"warnings", report.warnings}};
}

} // namespace fvv::fvvimport
