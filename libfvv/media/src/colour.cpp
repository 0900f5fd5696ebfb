/* RGB <-> YCbCr 4:2:0 in integers. See fvv_media/colour.h; equations: ITU-T H.273 clause 8.3. */
#include "fvv_media/colour.h"

#include "codecs.h"

#include <algorithm>
#include <cmath>

namespace fvv::media {
namespace {

struct Luminance {
  double red, blue; /* KR, KB */
};

Luminance luminance_of(const Colour &colour) {
  if (colour.matrix == 1) return {0.2126, 0.0722};
  return {0.299, 0.114};
}

constexpr int fraction = 16;
int32_t fixed(double value) {
  return int32_t(std::lround(value * (1 << fraction)));
}

uint8_t clipped(int32_t value, int shift) {
  if (value < 0) return 0;
  return uint8_t(std::min(value >> shift, 255));
}

struct Forward {
  int32_t y[3], cb[3], cr[3], black;

  explicit Forward(const Colour &colour) {
    const Luminance k = luminance_of(colour);
    const double luma = colour.full_range ? 1 : 219.0 / 255, chroma = colour.full_range ? 1 : 224.0 / 255;
    black = colour.full_range ? 0 : 16;
    // The middle coefficient is what is left, so that grey comes out exactly grey and white exactly white.
    y[0] = fixed(luma * k.red);
    y[2] = fixed(luma * k.blue);
    y[1] = fixed(luma) - y[0] - y[2];
    cb[0] = fixed(-chroma * k.red / (2 * (1 - k.blue)));
    cb[2] = fixed(chroma / 2);
    cb[1] = -cb[0] - cb[2];
    cr[0] = fixed(chroma / 2);
    cr[2] = fixed(-chroma * k.blue / (2 * (1 - k.red)));
    cr[1] = -cr[0] - cr[2];
  }
};

struct Backward {
  int32_t luma, red_cr, green_cb, green_cr, blue_cb, black;

  explicit Backward(const Colour &colour) {
    const Luminance k = luminance_of(colour);
    const double y = colour.full_range ? 1 : 255.0 / 219, c = colour.full_range ? 1 : 255.0 / 224;
    const double green = 1 - k.red - k.blue;
    black = colour.full_range ? 0 : 16;
    luma = fixed(y);
    red_cr = fixed(c * 2 * (1 - k.red));
    blue_cb = fixed(c * 2 * (1 - k.blue));
    green_cr = fixed(-c * 2 * (1 - k.red) * k.red / green);
    green_cb = fixed(-c * 2 * (1 - k.blue) * k.blue / green);
  }
};

/* One row of chroma at full width, 16 times the code: 3:1 to the nearer row, then 3:1 to the nearer column.
 */
void interpolate(const uint8_t *near, const uint8_t *far, size_t count, size_t width,
                 std::vector<int32_t> &column, int32_t *out) {
  for (size_t i = 0; i < count; i++) column[i] = 3 * near[i] + far[i];
  for (size_t x = 0; x < width; x++) {
    const size_t i = x / 2;
    const size_t other = x % 2 ? std::min(i + 1, count - 1) : (i > 0 ? i - 1 : 0);
    out[x] = 3 * column[i] + column[other];
  }
}

} // namespace

void check_colour(const Colour &colour) {
  const auto refuse = [](const char *what, int value, const char *expected) {
    throw Error(std::string(what) + " (ITU-T H.273) are " + std::to_string(value) + ", expected " + expected);
  };
  if (colour.primaries != 1) refuse("colour primaries", colour.primaries, "1");
  if (colour.transfer != 1 && colour.transfer != 6 && colour.transfer != 13)
    refuse("transfer characteristics", colour.transfer, "1, 6 or 13");
  if (colour.matrix != 1 && colour.matrix != 5 && colour.matrix != 6)
    refuse("matrix coefficients", colour.matrix, "1, 5 or 6");
}

Frame to_yuv(const Image &image, const Colour &colour) {
  check_image(image);
  check_colour(colour);
  if (image.channels != 3) throw Error("a grey picture came where an RGB picture was expected");
  const Forward k(colour);
  const size_t width = image.width, height = image.height;
  const size_t chroma_width = (width + 1) / 2, chroma_height = (height + 1) / 2;
  Frame frame;
  frame.width = image.width;
  frame.height = image.height;
  frame.y.resize(width * height);
  frame.u.resize(chroma_width * chroma_height);
  frame.v.resize(chroma_width * chroma_height);
  const uint8_t *rgb = image.pixels.data();
  const int32_t luma_offset = (k.black << fraction) + (1 << (fraction - 1));
  for (size_t i = 0; i < width * height; i++, rgb += 3)
    frame.y[i] = clipped(k.y[0] * rgb[0] + k.y[1] * rgb[1] + k.y[2] * rgb[2] + luma_offset, fraction);

  // Four samples are added up before the matrix: one rounding. A last odd row or column counts twice.
  constexpr int shift = fraction + 2;
  const int32_t chroma_offset = (128 << shift) + (1 << (shift - 1));
  for (size_t cy = 0; cy < chroma_height; cy++) {
    const uint8_t *upper = image.pixels.data() + 2 * cy * width * 3;
    const uint8_t *lower = 2 * cy + 1 < height ? upper + width * 3 : upper;
    for (size_t cx = 0; cx < chroma_width; cx++) {
      const size_t left = 6 * cx, right = 2 * cx + 1 < width ? left + 3 : left;
      int32_t sum[3];
      for (size_t c = 0; c < 3; c++)
        sum[c] = upper[left + c] + upper[right + c] + lower[left + c] + lower[right + c];
      const size_t at = cy * chroma_width + cx;
      frame.u[at] = clipped(k.cb[0] * sum[0] + k.cb[1] * sum[1] + k.cb[2] * sum[2] + chroma_offset, shift);
      frame.v[at] = clipped(k.cr[0] * sum[0] + k.cr[1] * sum[1] + k.cr[2] * sum[2] + chroma_offset, shift);
    }
  }
  return frame;
}

Image to_rgb(const Frame &frame, const Colour &colour) {
  check_colour(colour);
  Image image = make_image(frame.width, frame.height, 3, 0);
  const Backward k(colour);
  const size_t width = frame.width, height = frame.height;
  const size_t chroma_width = (width + 1) / 2, chroma_height = (height + 1) / 2;
  if (frame.y.size() != width * height || frame.u.size() != chroma_width * chroma_height ||
      frame.v.size() != frame.u.size())
    throw Error("the planes of a YCbCr frame do not have the sizes that 4:2:0 asks for");
  std::vector<int32_t> column(chroma_width), u(width), v(width);
  constexpr int shift = fraction + 4;
  uint8_t *rgb = image.pixels.data();
  for (size_t row = 0; row < height; row++) {
    const size_t near = row / 2;
    const size_t far = row % 2 ? std::min(near + 1, chroma_height - 1) : (near > 0 ? near - 1 : 0);
    const auto line = [&](const std::vector<uint8_t> &plane, std::vector<int32_t> &out) {
      interpolate(&plane[near * chroma_width], &plane[far * chroma_width], chroma_width, width, column,
                  out.data());
    };
    line(frame.u, u);
    line(frame.v, v);
    const uint8_t *y = &frame.y[row * width];
    for (size_t x = 0; x < width; x++, rgb += 3) {
      const int32_t luma = k.luma * 16 * (y[x] - k.black) + (1 << (shift - 1));
      const int32_t cb = u[x] - 16 * 128, cr = v[x] - 16 * 128;
      rgb[0] = clipped(luma + k.red_cr * cr, shift);
      rgb[1] = clipped(luma + k.green_cb * cb + k.green_cr * cr, shift);
      rgb[2] = clipped(luma + k.blue_cb * cb, shift);
    }
  }
  return image;
}

} // namespace fvv::media
