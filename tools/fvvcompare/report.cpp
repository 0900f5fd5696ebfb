#include "fvvcompare/report.h"

#include "fvv_cxx/format.h"

#include <nlohmann/json.hpp>

namespace fvv::compare {

namespace {

using Json = nlohmann::ordered_json;

std::string frames_of(size_t count) {
  return std::to_string(count) + (count == 1 ? " frame" : " frames");
}

const char *const direction_names[direction_count] = {"a_to_b", "b_to_a", "symmetric"};

// Widths of names and values of the table.
std::string row(const char *label, const std::array<std::string, direction_count> &values) {
  std::string out = fvv::format("  %-24s", label);
  for (const std::string &value : values) out += fvv::format(" %14s", value.c_str());
  return out + "\n";
}

class Table {
public:
  explicit Table(const Result &from) : result(from) {}

  std::string length(double value) const {
    return result.scale_unknown ? fvv::format("%.6g", value) : fvv::format("%.4f mm", value * 1000);
  }
  std::string decibel(double mse) const {
    return mse > 0 ? fvv::format("%.2f dB", psnr(result.peak, mse)) : "equal";
  }

  std::string all() const {
    const Errors &e = result.errors;
    std::string out = row("", {"A to B", "B to A", "symmetric"});
    const auto figures = [&](const char *label, const std::array<Figures, direction_count> &of,
                             double Figures::*which, bool lengths) {
      std::array<std::string, direction_count> cells;
      for (size_t w = 0; w < direction_count; w++)
        cells[w] = lengths ? length(of[w].*which) : fvv::format("%.3f deg", of[w].*which);
      out += row(label, cells);
    };
    figures("distance, rms", e.distance, &Figures::rms, true);
    figures("distance, mean", e.distance, &Figures::mean, true);
    figures("distance, p99", e.distance, &Figures::p99, true);
    figures("distance, Hausdorff", e.distance, &Figures::max, true);
    const auto cells = [&](const std::array<double, direction_count> &of, const auto &as_text) {
      return std::array<std::string, direction_count>{as_text(of[0]), as_text(of[1]), as_text(of[2])};
    };
    const auto decibels = [&](double mse) { return decibel(mse); };
    out += row("D1 PSNR, point to point", cells(e.d1, decibels));
    out += row("D2 PSNR, point to plane", cells(e.d2, decibels));
    figures("normals, mean", e.angle, &Figures::mean, false);
    figures("normals, p99", e.angle, &Figures::p99, false);
    out += row("faces turned over",
               cells(e.turned, [](double share) { return fvv::format("%.3f %%", 100 * share); }));
    return out + temporal();
  }

private:
  std::string temporal() const {
    if (!result.temporal) return "  temporal: no two frames with constant topology on both sides\n";
    const Temporal &t = *result.temporal;
    std::string out = "  temporal: rms " + length(t.rms) + ", max " + length(t.max) + " in " +
                      std::to_string(t.pairs) + " pairs of frames; motion of A: rms " + length(t.motion) +
                      "\n";
    if (t.by_order < t.pairs)
      out += "  temporal: vertices matched by nearness in " + std::to_string(t.pairs - t.by_order) +
             " pairs, at most " + length(t.furthest) + " apart\n";
    return out;
  }

  const Result &result;
};

Json json_of(const Figures &f) {
  return {{"rms", f.rms}, {"mean", f.mean}, {"p99", f.p99}, {"max", f.max}};
}

Json json_of(const Errors &e, double peak) {
  Json out;
  // JSON has no infinity: the PSNR of equal sets is null.
  const auto decibel = [&](double mse) { return mse > 0 ? Json(psnr(peak, mse)) : Json(nullptr); };
  for (size_t w = 0; w < direction_count; w++) {
    const char *direction = direction_names[w];
    out["distance"][direction] = json_of(e.distance[w]);
    out["d1"][direction] = {{"mse", e.d1[w]}, {"psnr", decibel(e.d1[w])}};
    out["d2"][direction] = {{"mse", e.d2[w]}, {"psnr", decibel(e.d2[w])}};
    out["normals"][direction] = json_of(e.angle[w]);
    out["turned"][direction] = e.turned[w];
  }
  return out;
}

Json json_of(const FrameResult &frame, double peak) {
  Json out = {{"a", {{"frame", frame.number_a}, {"vertices", frame.vertices_a}, {"faces", frame.faces_a}}},
              {"b", {{"frame", frame.number_b}, {"vertices", frame.vertices_b}, {"faces", frame.faces_b}}}};
  out.update(json_of(frame.errors, peak));
  out["temporal"] =
      frame.motion
          ? Json{{"rms", frame.motion->rms}, {"max", frame.motion->max}, {"motion", frame.motion->motion}}
          : Json(nullptr);
  return out;
}

Json json_of(const std::optional<Temporal> &temporal) {
  if (!temporal) return nullptr;
  return {{"pairs", temporal->pairs},   {"by_order", temporal->by_order},
          {"rms", temporal->rms},       {"max", temporal->max},
          {"motion", temporal->motion}, {"furthest_match", temporal->furthest}};
}

} // namespace

std::string text(const Command &options, const Result &result) {
  const Table table(result);
  std::string out = "A " + options.a + ": " + frames_of(result.frames_a) + "\n";
  out += "B " + options.b + ": " + frames_of(result.frames_b) + "\n";
  out += frames_of(result.frames.size()) + " compared, " + std::to_string(options.samples) +
         " samples of each surface, D1 and D2 at " +
         (options.points == Points::vertices ? "vertices" : "vertices and samples") + "\n";
  out += "peak of PSNR: " + table.length(result.peak) +
         (options.peak ? " (as given)" : " (diagonal of A's bounding box)") +
         (result.scale_unknown ? "; lengths are in units of the source\n" : "\n");
  return out + table.all();
}

std::string json(const Command &options, const Result &result) {
  Json frames = Json::array();
  for (const FrameResult &frame : result.frames) frames.push_back(json_of(frame, result.peak));
  Json document = {{"fvvcompare", 1},
                   {"a", {{"file", options.a}, {"frames", result.frames_a}}},
                   {"b", {{"file", options.b}, {"frames", result.frames_b}}},
                   {"unit", result.scale_unknown ? "unknown" : "metres"},
                   {"samples", options.samples},
                   {"points", options.points == Points::vertices ? "vertices" : "samples"},
                   {"peak", result.peak},
                   {"peak_is", options.peak ? "given" : "diagonal of A"},
                   {"compared", result.frames.size()}};
  document.update(json_of(result.errors, result.peak));
  document["temporal"] = json_of(result.temporal);
  document["frames"] = frames;
  document["losses"] = result.losses;
  document["warnings"] = result.warnings;
  return document.dump(2, ' ', false, Json::error_handler_t::replace);
}

std::string csv(const Result &result) {
  std::string out = "frame_a,frame_b,vertices_a,faces_a,vertices_b,faces_b";
  for (const char *direction : direction_names)
    for (const char *column : {"rms", "mean", "p99", "max", "d1_mse", "d1_psnr", "d2_mse", "d2_psnr",
                               "normal_mean", "normal_p99", "turned"})
      out += fvv::format(",%s_%s", direction, column);
  out += ",temporal_rms,temporal_max\n";
  const auto decibel = [&](double mse) {
    return mse > 0 ? fvv::format("%.17g", psnr(result.peak, mse)) : "inf";
  };
  for (const FrameResult &f : result.frames) {
    out += fvv::format("%lld,%lld,%zu,%zu,%zu,%zu", (long long)f.number_a, (long long)f.number_b,
                       f.vertices_a, f.faces_a, f.vertices_b, f.faces_b);
    const Errors &e = f.errors;
    for (size_t w = 0; w < direction_count; w++) {
      const Figures &d = e.distance[w];
      out += fvv::format(",%.17g,%.17g,%.17g,%.17g,%.17g,", d.rms, d.mean, d.p99, d.max, e.d1[w]) +
             decibel(e.d1[w]);
      out += fvv::format(",%.17g,", e.d2[w]) + decibel(e.d2[w]);
      out += fvv::format(",%.17g,%.17g,%.17g", e.angle[w].mean, e.angle[w].p99, e.turned[w]);
    }
    out += f.motion ? fvv::format(",%.17g,%.17g\n", f.motion->rms, f.motion->max) : ",,\n";
  }
  return out;
}

} // namespace fvv::compare
