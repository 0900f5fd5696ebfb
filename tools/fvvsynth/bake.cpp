#include "fvvsynth/bake.h"

#include "fvv_cxx/parallel.h"

#include <algorithm>
#include <cmath>

namespace fvv::synth {

namespace {

using render::Rgb;

constexpr uint32_t fine = 4; // samples of a texel, each way

// A square picture some of whose texels have a colour yet: sums of linear light and their weights.
struct Sheet {
  uint32_t size;
  std::vector<Rgb> sum;
  std::vector<double> weight;

  explicit Sheet(uint32_t side) : size(side), sum(size_t(side) * side), weight(sum.size()) {}
  size_t at(size_t x, size_t y) const { return y * size + x; }
};

// Calls visit(face, column, row, weights) for every fine sample of the chart's place that lies in a face; one
// on an edge belongs to the first.
template <class Visit>
void for_samples(const Chart &chart, const Layout &layout, const ChartBox &place, const Visit &visit) {
  const int64_t columns = int64_t(place.width) * fine, rows = int64_t(place.height) * fine;
  std::vector<bool> taken(size_t(columns * rows));
  for (const uint32_t face : chart.faces) {
    Flat p[3]; // in samples from the place's corner, the first sample at 0
    for (size_t c = 0; c < 3; c++) {
      const Flat &texel = layout.texels[layout.faces[3 * face + c]];
      p[c] = {(texel[0] - place.x) * fine - 0.5, (texel[1] - place.y) * fine - 0.5};
    }
    const auto area = [](const Flat &a, const Flat &b, const Flat &c) {
      return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    };
    const double whole = area(p[0], p[1], p[2]);
    const auto [left, right] = std::minmax({p[0][0], p[1][0], p[2][0]});
    const auto [top, bottom] = std::minmax({p[0][1], p[1][1], p[2][1]});
    for (int64_t row = std::max<int64_t>(0, int64_t(std::ceil(top))); row < rows && double(row) <= bottom;
         row++)
      for (int64_t column = std::max<int64_t>(0, int64_t(std::ceil(left)));
           column < columns && double(column) <= right; column++) {
        const Flat at = {double(column), double(row)};
        const std::array<double, 3> weights = {area(p[1], p[2], at) / whole, area(p[2], p[0], at) / whole,
                                               area(p[0], p[1], at) / whole};
        const size_t index = size_t(row * columns + column);
        if (taken[index] || *std::min_element(weights.begin(), weights.end()) < 0) continue;
        taken[index] = true;
        visit(face, size_t(column), size_t(row), weights);
      }
  }
}

// Colours that have one go on into texels beside them, one texel further each time.
void spread(Sheet &sheet, uint32_t texels) {
  for (uint32_t round = 0; round < texels; round++) {
    const Sheet before = sheet;
    for (size_t y = 0; y < sheet.size; y++)
      for (size_t x = 0; x < sheet.size; x++) {
        if (before.weight[sheet.at(x, y)] > 0) continue;
        Rgb sum;
        double count = 0;
        for (size_t j = y - (y > 0); j <= std::min<size_t>(y + 1, sheet.size - 1); j++)
          for (size_t i = x - (x > 0); i <= std::min<size_t>(x + 1, sheet.size - 1); i++) {
            const double weight = before.weight[sheet.at(i, j)];
            if (!(weight > 0)) continue;
            sum += before.sum[sheet.at(i, j)] * (1 / weight);
            count++;
          }
        sheet.sum[sheet.at(x, y)] = sum;
        sheet.weight[sheet.at(x, y)] = count;
      }
  }
}

// Gives every texel a colour: that of the finest level of a pyramid that has one there, between its texels
// bilinear (pull and push; Gortler et al., "The lumigraph", 1996). All weights are then above 0.
void fill(Sheet &sheet) {
  if (sheet.size == 1) return;
  Sheet coarse(sheet.size / 2);
  const auto parent = [&](size_t x, size_t y) {
    return coarse.at(std::min<size_t>(x / 2, coarse.size - 1), std::min<size_t>(y / 2, coarse.size - 1));
  };
  for (size_t y = 0; y < sheet.size; y++)
    for (size_t x = 0; x < sheet.size; x++) {
      const size_t i = sheet.at(x, y);
      if (!(sheet.weight[i] > 0)) continue;
      coarse.sum[parent(x, y)] += sheet.sum[i] * (1 / sheet.weight[i]);
      coarse.weight[parent(x, y)] += 1;
    }
  fill(coarse);
  for (size_t y = 0; y < sheet.size; y++)
    for (size_t x = 0; x < sheet.size; x++) {
      const size_t i = sheet.at(x, y);
      if (sheet.weight[i] > 0) continue;
      // The four coarse texels around the middle of this one.
      Rgb colour;
      for (const auto &[column, share] : {std::pair(x, 0.75), std::pair(x % 2 ? x + 1 : x - (x > 0), 0.25)})
        for (const auto &[row, part] : {std::pair(y, 0.75), std::pair(y % 2 ? y + 1 : y - (y > 0), 0.25)})
          colour += coarse.sum[parent(column, row)] * (share * part / coarse.weight[parent(column, row)]);
      sheet.sum[i] = colour;
      sheet.weight[i] = 1;
    }
}

} // namespace

media::Image bake(const std::vector<Chart> &charts, const Layout &layout, const Paint &paint,
                  uint32_t threads) {
  Sheet sheet(layout.size);
  fvv::parallel(threads, charts.size(), [&](size_t i) {
    const ChartBox &place = layout.places[i];
    for_samples(charts[i], layout, place,
                [&](uint32_t face, size_t column, size_t row, const std::array<double, 3> &weights) {
                  const size_t texel = sheet.at(place.x + column / fine, place.y + row / fine);
                  sheet.sum[texel] += paint(face, weights);
                  sheet.weight[texel] += 1;
                });
  });
  spread(sheet, chart_margin);
  fill(sheet);
  media::Image image = media::make_image(layout.size, layout.size, 3, 0);
  for (size_t i = 0; i < sheet.sum.size(); i++) {
    const Rgb colour = sheet.sum[i] * (1 / sheet.weight[i]);
    size_t channel = 3 * i;
    for (const double value : {colour.x, colour.y, colour.z})
      image.pixels[channel++] = render::to_display(value);
  }
  return image;
}

} // namespace fvv::synth
