/* Pictures made by arithmetic, for the tests of fvv_media. */
#ifndef FVV_TESTS_MEDIA_PICTURES_H
#define FVV_TESTS_MEDIA_PICTURES_H

#include "fvv_catch.h"
#include "fvv_media/image.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

inline uint32_t next_random(uint32_t &state) {
  return (state = state * 1664525 + 1013904223) >> 8;
}

/* The same matcher under its names in Catch2 3 and 2. */
#if __has_include(<catch2/catch_all.hpp>)
inline auto Contains(const std::string &text) {
  return Catch::Matchers::ContainsSubstring(text);
}
#else
using Catch::Matchers::Contains;
#endif

/* Gradients, a smooth texture and a square that moves 3 pixels a frame; colourful, and nowhere saturated. */
inline fvv::media::Image scene(uint32_t width, uint32_t height, int time) {
  fvv::media::Image image = fvv::media::make_image(width, height, 3, 0);
  for (uint32_t y = 0; y < height; y++)
    for (uint32_t x = 0; x < width; x++) {
      uint8_t *rgb = &image.pixels[(size_t(y) * width + x) * 3];
      const double wave = 25 * std::sin(x * 0.31 + y * 0.17) + 15 * std::sin(x * 0.05 * y * 0.03);
      rgb[0] = uint8_t(60 + 120 * x / width + wave);
      rgb[1] = uint8_t(60 + 120 * y / height + wave);
      rgb[2] = uint8_t(120 + wave);
      const uint32_t left = width / 8 + 3 * uint32_t(time);
      if (x >= left && x < left + width / 6 && y >= height / 3 && y < height / 3 + height / 5) {
        rgb[0] = uint8_t(220 - (x - left) % 64);
        rgb[1] = uint8_t(((x - left) & 8) ? 10 : 250);
        rgb[2] = 90;
      }
    }
  return image;
}

inline std::vector<fvv::media::Image> clip(uint32_t width, uint32_t height, int frames) {
  std::vector<fvv::media::Image> out;
  for (int time = 0; time < frames; time++) out.push_back(scene(width, height, time));
  return out;
}

/* Largest difference of any two samples. */
inline int largest_difference(const fvv::media::Image &a, const fvv::media::Image &b) {
  int largest = a.pixels.size() == b.pixels.size() ? 0 : 256;
  for (size_t i = 0; i < a.pixels.size() && i < b.pixels.size(); i++)
    largest = std::max(largest, std::abs(int(a.pixels[i]) - int(b.pixels[i])));
  return largest;
}

inline std::string write_file(const std::string &name, const std::vector<uint8_t> &bytes) {
  std::ofstream(name, std::ios::binary)
      .write(reinterpret_cast<const char *>(bytes.data()), std::streamsize(bytes.size()));
  return name;
}

/* The message of the Error that call throws; empty when it throws none. */
template <typename Call> std::string error_of(Call call) {
  try {
    call();
  } catch (const fvv::Error &error) {
    return error.what();
  }
  return "";
}

#endif
