#include "fvvmux/decimation_report.h"

#include "cli/cli.h"
#include "cli/format.h"

namespace fvv::mux {

namespace {

// A length for people: millimetres where the scale is known.
std::string length_text(const Plan &plan, double length) {
  return plan.capture.scale_unknown ? cli::format("%.3g units", length)
                                    : cli::format("%.3g mm", length * 1000);
}

std::string area_text(const Plan &plan, double area) {
  return plan.capture.scale_unknown ? cli::format("%.3g square units", area)
                                    : cli::format("%.3g cm2", area * 1e4);
}

} // namespace

void DecimationSums::add(const decimate::Report &report) {
  frames++;
  kept += report.kept;
  faces_before += report.faces_before;
  faces_after += report.faces_after;
  held_faces += report.held_faces;
  squares += report.error.rms * report.error.rms;
  max = std::max(max, report.error.max);
  max_pixels = std::max(max_pixels, report.error.max_pixels);
  rms_pixels = std::max(rms_pixels, report.error.rms_pixels);
  volume_before += report.volume_before;
  volume_after += report.volume_after;
  vanished.pieces += report.vanished.pieces;
  vanished.area += report.vanished.area;
  thin_area += report.thin_area;
}

double DecimationSums::rms() const {
  return frames > kept ? std::sqrt(squares / double(frames - kept)) : 0;
}

double DecimationSums::volume_change() const {
  return volume_before != 0 ? volume_after / volume_before - 1 : 0;
}

bool warn_of_losses(const Plan &plan, int64_t frame, const decimate::Report &report) {
  const std::string name = plan.capture.mesh_path(frame) + ": frame " + std::to_string(frame) + ": ";
  if (report.vanished.pieces)
    cli::warn(name + std::to_string(report.vanished.pieces) + " pieces of " +
              area_text(plan, report.vanished.area) + " together vanish in decimation");
  if (report.thin_area > 0)
    cli::warn(name + area_text(plan, report.thin_area) + " of the surface are further off than " +
              cli::format("%g px", decimate::max_over_rms * plan.decimation.budget.pixels) +
              " after decimation");
  return report.vanished.pieces || report.thin_area > 0;
}

std::string decimation_text(const Plan &plan, const DecimationSums &sums) {
  const DecimationChoice &choice = plan.decimation;
  std::string out = cli::format("  budget    %g px", choice.budget.pixels);
  if (std::isfinite(choice.pixel))
    out += (choice.budget.pixels == 1 ? " is " : " are ") +
           length_text(plan, choice.budget.pixels * choice.pixel) + " where cameras see sharpest";
  if (!choice.on) return out + "; all triangles are kept: " + choice.reason + "\n";
  const double frames = double(sums.frames);
  out += cli::format(": %.0f -> %.0f triangles a frame ", double(sums.faces_before) / frames,
                     double(sums.faces_after) / frames) +
         choice.reason + "\n";
  if (sums.kept < sums.frames) {
    out += "            off by " + length_text(plan, sums.rms()) + " rms, " + length_text(plan, sums.max) +
           " at most, lattice included; the worst frame";
    if (std::isfinite(choice.pixel))
      out += cli::format(" %.3f px rms, %.2f px at most;", sums.rms_pixels, sums.max_pixels);
    out += cli::format(" volume %+.2f %%\n", 100 * sums.volume_change());
  }
  if (sums.held_faces)
    out +=
        cli::format("            %.0f triangles a frame stay, or silhouettes would move by more than %g px\n",
                    double(sums.held_faces) / frames, decimate::max_over_rms * choice.budget.pixels);
  if (sums.kept)
    out += cli::format("            %llu frames are as they were: fewer triangles would break the budget\n",
                       (unsigned long long)sums.kept);
  return out;
}

nlohmann::ordered_json decimation_json(const Plan &plan, const DecimationSums &sums) {
  const DecimationChoice &choice = plan.decimation;
  const bool seen = std::isfinite(choice.pixel);
  nlohmann::ordered_json out = {{"max_error", choice.budget.pixels},
                                {"pixel", nullptr},
                                {"reason", choice.reason},
                                {"decimated_frames", sums.frames - sums.kept},
                                {"kept_frames", sums.kept}};
  if (seen) out["pixel"] = choice.pixel;
  if (sums.frames == sums.kept) return out;
  const double frames = double(sums.frames);
  out["triangles_before"] = double(sums.faces_before) / frames;
  out["triangles"] = double(sums.faces_after) / frames;
  out["rms"] = sums.rms();
  out["max"] = sums.max;
  out["rms_pixels"] = seen ? nlohmann::ordered_json(sums.rms_pixels) : nullptr;
  out["max_pixels"] = seen ? nlohmann::ordered_json(sums.max_pixels) : nullptr;
  out["volume_change"] = sums.volume_change();
  out["locked_triangles"] = double(sums.held_faces) / frames;
  out["vanished_pieces"] = sums.vanished.pieces;
  out["vanished_area"] = sums.vanished.area;
  out["thin_area"] = sums.thin_area;
  return out;
}

} // namespace fvv::mux
