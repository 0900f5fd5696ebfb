// The report as a page for browsers: charts as SVG, no scripts, nothing that is loaded.
#include "fvv_cxx/format.h"
#include "fvv_mux/report.h"
#include "mux/src/report/report_names.h"
#include "mux/src/terms.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace fvv::mux {

namespace {

constexpr const char *style = R"(
:root { color-scheme: light dark; --ink: #1b1b1b; --faint: #6b6b6b; --grid: #dddddd; --paper: #ffffff;
  --c0: #0072b2; --c1: #d55e00; --c2: #007a5a; --c3: #a8497f; --c4: #8a6d00; --c5: #3f6fd1; --c6: #7d4fb0; --c7: #b03a3a; }
@media (prefers-color-scheme: dark) { :root { --ink: #ececec; --faint: #a0a0a0; --grid: #3a3a3a; --paper: #161616;
  --c0: #56b4e9; --c1: #ff9a4d; --c2: #3fc79a; --c3: #e08fbb; --c4: #e2c044; --c5: #8fb0ff; --c6: #c39bee; --c7: #f08080; } }
body { max-width: 60rem; margin: 2rem auto; padding: 0 1rem; color: var(--ink); background: var(--paper);
  font: 16px/1.5 system-ui, sans-serif; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2rem; }
svg { width: 100%; height: auto; font: 13px system-ui, sans-serif; }
svg text { fill: var(--ink); paint-order: stroke; stroke: var(--paper); stroke-width: 4px; } svg .faint { fill: var(--faint); }
.grid { stroke: var(--grid); } .axis { stroke: var(--faint); }
.goal { stroke: var(--faint); stroke-dasharray: 6 4; }
.curve { fill: none; stroke: currentColor; stroke-width: 2; }
.dot { fill: currentColor; }
.ring { fill: none; stroke: var(--ink); stroke-width: 2; } .ring.full { fill: var(--ink); }
.c0 { color: var(--c0); } .c1 { color: var(--c1); } .c2 { color: var(--c2); } .c3 { color: var(--c3); }
.c4 { color: var(--c4); } .c5 { color: var(--c5); } .c6 { color: var(--c6); } .c7 { color: var(--c7); }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: 0.2rem 0.9rem 0.2rem 0; text-align: right; border-bottom: 1px solid var(--grid); }
th:first-child, td:first-child { text-align: left; }
.chosen { font-weight: bold; }
pre { overflow-x: auto; font-size: 0.8rem; line-height: 1.4; }
)";

std::string escaped(const std::string &text) {
  std::string out;
  for (const char c : text)
    out += c == '&'   ? "&amp;"
           : c == '<' ? "&lt;"
           : c == '>' ? "&gt;"
           : c == '"' ? "&quot;"
                      : std::string(1, c);
  return out;
}

// The values of an axis and their place in the picture.
struct Axis {
  double low, high;     // values
  double begin, length; // pixels; upwards where it is negative

  double at(double value) const { return begin + length * (value - low) / (high - low); }
  double step() const { // of its marks: 1, 2 or 5 times a power of ten
    const double rough = (high - low) / 6, power = std::pow(10, std::floor(std::log10(rough)));
    const double times = rough / power;
    return power * (times < 1.5 ? 1 : times < 3.5 ? 2 : times < 7.5 ? 5 : 10);
  }
  std::vector<double> marks() const {
    std::vector<double> out;
    for (double k = std::ceil(low / step()); k * step() <= high; k++) out.push_back(k * step());
    return out;
  }
};

// With some room on both sides.
Axis axis_over(double low, double high, double begin, double length) {
  const double room = std::max(0.06 * (high - low), 1e-3 * std::max(1.0, std::abs(high)));
  return {low - room, high + room, begin, length};
}

std::string error_text(const Report &r, const ViewReport &view, double max_error) {
  return view.is_length ? length_text(r.scale_unknown, max_error) : fvv::format("%g px", max_error);
}

bool is_chosen(const ViewReport &view, const ViewCandidate &one) {
  return one.max_error == view.max_error && one.step == view.step && one.psnr == view.psnr;
}

// Candidates with the same meshes, by rising quality of their pictures.
using Curve = std::vector<ViewCandidate>;

std::vector<Curve> curves_of(const ViewReport &view) {
  std::vector<Curve> out;
  for (const ViewCandidate &one : view.candidates) {
    if (out.empty() || out.back()[0].max_error != one.max_error || out.back()[0].step != one.step)
      out.emplace_back();
    out.back().push_back(one);
  }
  return out;
}

std::string name_of(const Report &r, const ViewReport &view, const Curve &curve) {
  const std::string error = error_text(r, view, curve[0].max_error);
  for (const ViewCandidate &one : view.candidates)
    if (one.max_error == curve[0].max_error && one.step != curve[0].step)
      return error + " on " + length_text(r.scale_unknown, curve[0].step);
  return error;
}

// Bytes of a group and PSNR of what a viewer sees.
class ViewChart {
public:
  ViewChart(const Report &of, const ViewReport &chosen)
      : r(of), view(chosen), curves(curves_of(chosen)), x(kilobytes_axis()), y(psnr_axis()) {}

  std::string svg() const {
    std::string out =
        fvv::format("<svg viewBox=\"0 0 %g %g\" role=\"img\" aria-label=\"PSNR of what a viewer "
                    "sees over bytes of a group\">\n",
                    width, height);
    out += grid();
    const double goal = y.at(view.psnr_without - view.goal);
    if (goal < bottom && goal > top)
      out += fvv::format(
          "<line class=\"goal\" x1=\"%g\" x2=\"%g\" y1=\"%.1f\" y2=\"%.1f\"/><text class=\"faint\" "
          "x=\"%g\" y=\"%.1f\" text-anchor=\"end\">%g dB below that without a choice</text>\n",
          left, right, goal, goal, right, goal - 5, view.goal);
    for (size_t k = 0; k < curves.size(); k++) out += curve(k);
    out += ring(view.bytes_without, view.psnr_without, "ring", "without a choice");
    out += ring(view.bytes, view.held_out_psnr, "ring full", "chosen");
    return out + legend() + "</svg>\n";
  }

private:
  static constexpr double width = 820, height = 440, left = 76, right = 620, top = 20, bottom = 390;

  double psnr_of(const ViewCandidate &one) const { return view.psnr_without - one.loss; }

  template <class Value>
  std::pair<double, double> range(const Value &value, double first, double second) const {
    std::pair<double, double> out = std::minmax(first, second);
    for (const ViewCandidate &one : view.candidates) {
      out.first = std::min(out.first, value(one));
      out.second = std::max(out.second, value(one));
    }
    return out;
  }
  Axis kilobytes_axis() const {
    const auto [low, high] =
        range([](const ViewCandidate &one) { return one.bytes; }, view.bytes, view.bytes_without);
    return axis_over(low / 1000, high / 1000, left, right - left);
  }
  Axis psnr_axis() const {
    const auto [low, high] = range([this](const ViewCandidate &one) { return psnr_of(one); },
                                   view.held_out_psnr, view.psnr_without);
    return axis_over(low, high, bottom, top - bottom);
  }

  std::string grid() const {
    std::string out;
    for (const double kilobytes : x.marks())
      out += fvv::format(
          "<line class=\"grid\" x1=\"%.1f\" x2=\"%.1f\" y1=\"%g\" y2=\"%g\"/><text class=\"faint\" "
          "x=\"%.1f\" y=\"%g\" text-anchor=\"middle\">%g</text>\n",
          x.at(kilobytes), x.at(kilobytes), top, bottom, x.at(kilobytes), bottom + 18, kilobytes);
    for (const double psnr : y.marks())
      out += fvv::format(
          "<line class=\"grid\" x1=\"%g\" x2=\"%g\" y1=\"%.1f\" y2=\"%.1f\"/><text class=\"faint\" "
          "x=\"%g\" y=\"%.1f\" text-anchor=\"end\">%.6g</text>\n",
          left, right, y.at(psnr), y.at(psnr), left - 8, y.at(psnr) + 4, psnr);
    out += fvv::format("<path class=\"axis\" fill=\"none\" d=\"M%g %gV%gH%g\"/>\n", left, top, bottom, right);
    out += fvv::format(
        "<text class=\"faint\" x=\"%g\" y=\"%g\" text-anchor=\"middle\">kB of a group, meshes and "
        "pictures</text>\n",
        (left + right) / 2, height - 12);
    return out + fvv::format("<text class=\"faint\" transform=\"translate(14 %g) rotate(-90)\" "
                             "text-anchor=\"middle\">PSNR of cameras drawn from the others, dB</text>\n",
                             (top + bottom) / 2);
  }

  static std::string colour(size_t curve) { return fvv::format("c%zu", curve % 8); }

  std::string curve(size_t k) const {
    std::string points, dots;
    for (const ViewCandidate &one : curves[k]) {
      const double at_x = x.at(one.bytes / 1000), at_y = y.at(psnr_of(one));
      points += fvv::format("%.1f,%.1f ", at_x, at_y);
      dots += fvv::format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%g\" class=\"dot %s\"><title>", at_x, at_y,
                          one.is_measured ? 4.5 : 2.5, colour(k).c_str()) +
              escaped(fvv::format("meshes %s, pictures %g dB: %.1f kB, %+.3f dB%s",
                                  name_of(r, view, curves[k]).c_str(), one.psnr, one.bytes / 1000, -one.loss,
                                  one.is_measured ? ", measured" : "")) +
              "</title></circle>\n";
    }
    return "<polyline class=\"curve " + colour(k) + "\" points=\"" + points + "\"/>\n" + dots;
  }

  std::string ring(double bytes, double psnr, const char *look, const char *what) const {
    const double at_x = x.at(bytes / 1000), at_y = y.at(psnr);
    const bool is_right = at_x > (left + right) / 2;
    return fvv::format("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"7\" class=\"%s\"/><text x=\"%.1f\" y=\"%.1f\" "
                       "text-anchor=\"%s\" "
                       "font-weight=\"bold\">%s</text>\n",
                       at_x, at_y, look, at_x + (is_right ? -12 : 12), at_y - 10, is_right ? "end" : "start",
                       what);
  }

  std::string legend() const {
    std::string out =
        fvv::format("<text class=\"faint\" x=\"%g\" y=\"%g\">error of meshes</text>\n", right + 24, top + 10);
    for (size_t k = 0; k < curves.size(); k++) {
      const double at = top + 34 + 22 * double(k);
      out += fvv::format("<line class=\"curve %s\" x1=\"%g\" x2=\"%g\" y1=\"%g\" y2=\"%g\"/><text x=\"%g\" "
                         "y=\"%g\">",
                         colour(k).c_str(), right + 24, right + 46, at - 4, at - 4, right + 54, at) +
             escaped(name_of(r, view, curves[k])) + "</text>\n";
    }
    return out;
  }

  const Report &r;
  const ViewReport &view;
  const std::vector<Curve> curves;
  const Axis x, y;
};

struct Part {
  std::string name;
  uint64_t bytes;
};

// What the bytes of the stream are of; those that there are none of are left out.
std::vector<Part> parts_of(const Report &r) {
  std::vector<Part> out = {{"meshes", r.mesh.payload},
                           {"visibility", r.visibility.bytes},
                           {"colours of vertices", r.colours.track.payload},
                           {"calibration", r.calibration.payload},
                           {"environment", r.environment_chunks.payload},
                           {"container", overhead(r)}};
  for (const LowerMeshes &meshes : r.lower_meshes)
    if (meshes.sent) out.push_back({fvv::format("meshes of rung %zu", meshes.rung), meshes.payload()});
  for (const VideoTrackReport &video : r.videos) {
    const std::string name = name_of(r, video);
    out.push_back({name == "video" ? "pictures" : name, video.payload});
  }
  for (const SoundReport &sound : r.sounds) out.push_back({"sound, " + sound.file, sound.payload});
  out.erase(std::remove_if(out.begin(), out.end(), [](const Part &part) { return !part.bytes; }), out.end());
  std::stable_sort(out.begin(), out.end(), [](const Part &a, const Part &b) { return a.bytes > b.bytes; });
  return out;
}

std::string bars(const Report &r) {
  const std::vector<Part> parts = parts_of(r);
  const double left = 190, longest = 440, row = 26, most = double(parts[0].bytes);
  std::string out =
      fvv::format("<svg viewBox=\"0 0 820 %g\" role=\"img\" aria-label=\"Bytes of the stream by "
                  "what they are of\">\n",
                  row * double(parts.size()) + 6);
  for (size_t k = 0; k < parts.size(); k++) {
    const double at = row * double(k), length = longest * double(parts[k].bytes) / most;
    out += fvv::format("<text x=\"%g\" y=\"%g\" text-anchor=\"end\">", left - 10, at + 17) +
           escaped(parts[k].name) +
           fvv::format("</text><rect x=\"%g\" y=\"%g\" width=\"%.1f\" height=\"18\" class=\"dot c0\"/><text "
                       "x=\"%.1f\" y=\"%g\">%.1f kB, %.1f %%</text>\n",
                       left, at + 4, std::max(length, 1.0), left + length + 8, at + 17,
                       double(parts[k].bytes) / 1000, 100 * double(parts[k].bytes) / double(r.bytes));
  }
  return out + "</svg>\n";
}

std::string view_summary(const Report &r, const ViewReport &view) {
  return escaped(
      fvv::format("Pictures of %.4g dB, meshes with an error of %s and the threshold %g were chosen: about "
                  "%.0f %% of the bytes without the choice. Cameras that are drawn from the others "
                  "%s %.2f dB against that, where the goal allows to lose %g dB: they have %.2f dB, "
                  "%.2f dB without the choice, and %.2f dB by the source's own meshes and pictures.",
                  view.psnr, error_text(r, view, view.max_error).c_str(), view.threshold,
                  100 * view.bytes / view.bytes_without, view.loss > 0 ? "lose" : "gain", std::abs(view.loss),
                  view.goal, view.held_out_psnr, view.psnr_without, view.finest_psnr));
}

// The cheapest and the finest pictures of each curve, and what was measured.
std::string candidate_table(const Report &r, const ViewReport &view) {
  std::string out =
      "<table><tr><th>meshes</th><th>pictures</th><th>kB of a group</th><th>of those without a choice</th>"
      "<th>against views without a choice</th><th></th></tr>\n";
  for (const Curve &curve : curves_of(view))
    for (const ViewCandidate &one : curve) {
      const bool chosen = is_chosen(view, one), end = &one == &curve.front() || &one == &curve.back();
      if (!chosen && !end && !one.is_measured) continue;
      out +=
          std::string(chosen ? "<tr class=\"chosen\"><td>" : "<tr><td>") + escaped(name_of(r, view, curve)) +
          fvv::format("</td><td>%g dB</td><td>%.1f</td><td>%.0f %%</td><td>%+.3f dB</td><td>%s</td></tr>\n",
                      one.psnr, one.bytes / 1000, 100 * one.bytes / view.bytes_without, -one.loss,
                      chosen            ? "chosen"
                      : one.is_measured ? "measured: loses too much"
                                        : "");
    }
  return out + "</table>\n";
}

std::string blend_table(const ViewReport &view) {
  std::string out = "<table><tr><th>threshold</th><th>cameras at a place</th><th>gain</th><th></th></tr>\n";
  for (const BlendCandidate &one : view.blends) {
    const bool chosen = one.threshold == view.threshold && one.best == view.best;
    out += fvv::format("<tr%s><td>%g</td><td>%u</td><td>%+.3f dB</td><td>%s</td></tr>\n",
                       chosen ? " class=\"chosen\"" : "", one.threshold, one.best, one.gain,
                       chosen ? "chosen" : "");
  }
  return out + "</table>\n";
}

std::string view_section(const Report &r, const ViewReport &view) {
  if (!view.is_measured) return "<p>Nothing was chosen by views: " + escaped(view.reason) + ".</p>\n";
  std::string out =
      "<p>" + view_summary(r, view) + "</p>\n<h2>Bytes and what a viewer sees</h2>\n" +
      ViewChart(r, view).svg() +
      "<p>Each line has meshes with one error, and pictures of rising quality from left to "
      "right. Large dots were measured as a whole; elsewhere the losses of meshes and of pictures are "
      "added up.</p>\n" +
      candidate_table(r, view);
  if (view.blends.size() > 1)
    out += "<h2>How players blend cameras</h2>\n" + blend_table(view) +
           "<p>Of the pixels that all of them show, with the meshes and pictures of the source.</p>\n";
  return out;
}

} // namespace

std::string report_html(const Report &r, const std::string &output, Spelling spelling) {
  std::string out = "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
                    "content=\"width=device-width\">\n<title>" +
                    escaped(output) + "</title>\n<style>" + style + "</style>\n<h1>" + escaped(output) +
                    "</h1>\n";
  if (r.view) out += view_section(r, *r.view);
  out += "<h2>What the bytes are of</h2>\n" + bars(r) + "<h2>Summary</h2>\n<pre>" +
         escaped(report_text(r, output, spelling)) + "</pre>\n</html>\n";
  return spell(out, spelling);
}

} // namespace fvv::mux
