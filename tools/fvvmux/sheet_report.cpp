// The numbers of a contact sheet, for people and for programs.
#include "cli/format.h"
#include "fvvmux/contact_sheet.h"
#include "fvvmux/select.h"

namespace fvv::mux {

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
  if (camera.fit.iou) line += cli::format(", IoU %.4f", *camera.fit.iou);
  if (camera.fit.distance) line += cli::format(", outlines %.2f px apart", *camera.fit.distance);
  if (camera.fit.offset)
    line += cli::format(", offset (%+.2f, %+.2f) px", (*camera.fit.offset)[0], (*camera.fit.offset)[1]);
  return line + "\n";
}

std::string hint(const SheetReport &report) {
  const std::string what = report.outlined == Outlined::hull ? "hull" : "mesh";
  if (report.suspicion == Suspicion::misses_all)
    return "  hint      the " + what +
           " meets no mask, or is in no picture: units, axes, or the direction of the poses "
           "(docs/calibration.md)\n";
  if (report.suspicion == Suspicion::half_pixel)
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
  if (report.median_iou) out += cli::format("  median    IoU %.4f", *report.median_iou);
  if (report.median_distance) out += cli::format(", outlines %.2f px apart", *report.median_distance);
  if (report.median_iou) out += "\n";
  for (const size_t i : report.standing_out) {
    const SheetCamera &camera = report.cameras[i];
    out += "  hint      " + describe(camera.id, camera.name) +
           cli::format(" stands out: its outlines are %.2f px apart\n", *camera.fit.distance);
  }
  if (report.left_out)
    out += "  hint      the hull is carved without " +
           describe(report.cameras[*report.left_out].id, report.cameras[*report.left_out].name) +
           ", which alone denies much of what all others see\n";
  return out + hint(report);
}

Json sheet_json(const SheetReport &report) {
  Json cameras = Json::array(), standing_out = Json::array();
  for (const SheetCamera &camera : report.cameras) {
    const auto &offset = camera.fit.offset;
    cameras.push_back({{"id", camera.id},
                       {"name", camera.name},
                       {"width", camera.width},
                       {"height", camera.height},
                       {"picture", camera.picture},
                       {"mask", camera.mask},
                       {"covered", camera.covered},
                       {"iou", or_null(camera.fit.iou)},
                       {"distance", or_null(camera.fit.distance)},
                       {"offset", offset ? Json({(*offset)[0], (*offset)[1]}) : Json(nullptr)}});
  }
  for (const size_t i : report.standing_out) standing_out.push_back(report.cameras[i].id);
  return {{"fvvmux", 1},
          {"sheet", report.path},
          {"frame", report.frame},
          {"outline", name_of(report.outlined)},
          {"width", report.width},
          {"height", report.height},
          {"panel", report.panel},
          {"cameras", cameras},
          {"median_iou", or_null(report.median_iou)},
          {"median_distance", or_null(report.median_distance)},
          {"standing_out", standing_out},
          {"left_out", report.left_out ? Json(report.cameras[*report.left_out].id) : Json(nullptr)},
          {"suspected", report.suspicion == Suspicion::half_pixel   ? Json("half_pixel")
                        : report.suspicion == Suspicion::misses_all ? Json("misses_all")
                                                                    : Json(nullptr)},
          {"warnings", report.warnings}};
}

} // namespace fvv::mux
