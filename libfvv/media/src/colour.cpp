// sRGB and linear light; RGB and YCbCr 4:2:0 in integers (ITU-T H.273 clause 8.3).
#include "fvv_media/colour.h"

#include "codecs.h"

#include <half.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

namespace fvv::media {

namespace {

float float_of(uint32_t bits) {
  float value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

// Whether the curve at x (not negative) is at least (2 code - 1) / (2 largest).
bool reaches(double x, uint32_t code, uint32_t largest) {
  const double odd = 2.0 * code - 1, both = 2.0 * largest;
  // 12.92 x up to 0.04045: 12.92 = 323 / 25, and all of this is exact.
  if (odd <= 0.04045 * both) return x * 323 * both >= odd * 25;
  // ((v + 0.055) / 1.055)^2.4 above it.
  const double root = (odd * 1000 + both * 55) / (both * 1055);
  const double square = root * root, fourth = square * square;
  return x * x * x * x * x >= fourth * fourth * fourth;
}

} // namespace

std::vector<float> srgb_thresholds(uint32_t largest) {
  constexpr uint32_t one = 0x3f800000; // bits of 1.0f; those of positive floats are in their order
  std::vector<float> thresholds;
  thresholds.reserve(largest);
  uint32_t below = 0;
  for (uint32_t code = 1; code <= largest; code++) {
    uint32_t reached = one;
    while (reached - below > 1) {
      const uint32_t middle = below + (reached - below) / 2;
      (reaches(double(float_of(middle)), code, largest) ? reached : below) = middle;
    }
    thresholds.push_back(float_of(reached));
    below = reached - 1; // the next threshold may be the same float, were codes that fine
  }
  return thresholds;
}

std::vector<float> linear_of_codes(uint32_t largest) {
  std::vector<float> values;
  values.reserve(size_t(largest) + 1);
  for (uint32_t code = 0; code <= largest; code++) {
    const double v = double(code) / largest;
    if (v <= 0.04045) {
      values.push_back(float(v / 12.92));
      continue;
    }
    // x^5 = root^12 by Newton's method, from above.
    const double root = (v + 0.055) / 1.055, square = root * root, fourth = square * square;
    const double twelfth = fourth * fourth * fourth;
    double x = 1;
    for (;;) {
      const double x4 = x * x * x * x, next = x - (x4 * x - twelfth) / (5 * x4);
      if (!(next < x)) break;
      x = next;
    }
    values.push_back(float(x));
  }
  return values;
}

double srgb_of_linear(double linear) {
  const double x = std::fabs(linear);
  const double v = x <= 0.0031308 ? x * 12.92 : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
  return std::copysign(v, linear);
}

double linear_of_srgb(double display) {
  const double v = std::fabs(display);
  const double x = v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
  return std::copysign(x, display);
}

namespace {

template <class Sample> const std::vector<float> &thresholds() {
  static const std::vector<float> table = srgb_thresholds(std::numeric_limits<Sample>::max());
  return table;
}

// A picture of the same shape, each sample made of one.
template <class To, class From, class Convert>
BasicImage<To> converted(const BasicImage<From> &image, const Convert &convert) {
  BasicImage<To> out = make_image<To>(image.width, image.height, image.channels, 0);
  std::transform(image.pixels.begin(), image.pixels.end(), out.pixels.begin(), convert);
  return out;
}

} // namespace

LinearImage linear_of(const DeepImage &image) {
  static const std::vector<float> table = linear_of_codes(65535);
  return converted<float>(image, [](uint16_t code) { return table[code]; });
}

template <class Sample> BasicImage<Sample> display_of(const LinearImage &image) {
  const std::vector<float> &table = thresholds<Sample>();
  return converted<Sample>(image, [&](float value) {
    return Sample(std::upper_bound(table.begin(), table.end(), value) - table.begin());
  });
}

template Image display_of(const LinearImage &image);
template DeepImage display_of(const LinearImage &image);

float srgb_of_half(float linear) {
  static const std::vector<float> table = [] {
    std::vector<float> values;
    for (uint32_t bits = 0; bits < 65536; bits++) {
      Imath::half value;
      value.setBits(uint16_t(bits));
      values.push_back(float(srgb_of_linear(double(float(value)))));
    }
    return values;
  }();
  return table[Imath::half(linear).bits()];
}

void check_finite(const LinearImage &image, const std::string &name) {
  const auto found = std::find_if_not(image.pixels.begin(), image.pixels.end(),
                                      [](float value) { return std::isfinite(value); });
  if (found == image.pixels.end()) return;
  const size_t index = size_t(found - image.pixels.begin()), channels = size_t(image.channels);
  const size_t pixel = index / channels;
  throw Error(name, std::string("channel ") + (channels == 1 ? 'Y' : "RGB"[index % channels]) +
                        " of pixel (" + std::to_string(pixel % image.width) + ", " +
                        std::to_string(pixel / image.width) + ") is " +
                        (std::isnan(*found) ? "not a number" : "infinite"));
}

namespace {

struct Luminance {
  double red, blue; // KR, KB
};

Luminance luminance_of(const Colour &colour) {
  if (colour.matrix == 1) return {0.2126, 0.0722};
  return {0.299, 0.114};
}

// Fixed point between two kinds of samples. 16 fractional bits in 32-bit integers do for 8 bits on both
// sides. With more on either, an error of half a unit in a coefficient must stay far below one code when
// multiplied by the largest sample: 2^-33 * 65535 forwards, 2^-33 * 1023 backwards. Sums stay below 2^54.
template <class From, class To> struct Fixed {
  using Wide = std::conditional_t<sizeof(From) == 1 && sizeof(To) == 1, int32_t, int64_t>;
  static constexpr int fraction = sizeof(Wide) == 4 ? 16 : 32;
  static Wide of(double value) { return Wide(std::llround(value * double(Wide(1) << fraction))); }
};

template <class Sample, class Wide> Sample clipped(Wide value, int shift, int most) {
  if (value < 0) return 0;
  return Sample(std::min<Wide>(value >> shift, most));
}

// Codes of YCbCr, from the definitions for 8 bits (ITU-T H.273 equations 20 to 25 and 29 to 31).
struct Codes {
  int most, black, middle;
  double luma, chroma; // from black to white, and from the bluest to the yellowest

  Codes(const Colour &colour, int bit_depth) {
    const int unit = 1 << (bit_depth - 8);
    most = 256 * unit - 1;
    black = colour.full_range ? 0 : 16 * unit;
    middle = 128 * unit;
    luma = colour.full_range ? most : 219 * unit;
    chroma = colour.full_range ? most : 224 * unit;
  }
};

template <class Sample> struct Forward {
  using Number = Fixed<Sample, Sample>;
  using Wide = typename Number::Wide;
  Wide y[3], cb[3], cr[3];
  Codes codes;

  explicit Forward(const Colour &colour) : codes(colour, BasicFrame<Sample>::bit_depth) {
    const Luminance k = luminance_of(colour);
    constexpr double white = std::numeric_limits<Sample>::max();
    const double luma = codes.luma / white, chroma = codes.chroma / white;
    const auto fixed = Number::of;
    // The middle coefficient is the remainder, so that grey stays exactly grey and white exactly white.
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

template <class Sample, class Wanted> struct Backward {
  using Number = Fixed<Sample, Wanted>;
  using Wide = typename Number::Wide;
  Wide luma, red_cr, green_cb, green_cr, blue_cb;
  Codes codes;

  explicit Backward(const Colour &colour) : codes(colour, BasicFrame<Sample>::bit_depth) {
    const Luminance k = luminance_of(colour);
    constexpr double white = std::numeric_limits<Wanted>::max();
    const double y = white / codes.luma, c = white / codes.chroma;
    const double green = 1 - k.red - k.blue;
    const auto fixed = Number::of;
    luma = fixed(y);
    red_cr = fixed(c * 2 * (1 - k.red));
    blue_cb = fixed(c * 2 * (1 - k.blue));
    green_cr = fixed(-c * 2 * (1 - k.red) * k.red / green);
    green_cb = fixed(-c * 2 * (1 - k.blue) * k.blue / green);
  }
};

// One row of chroma at full width, 16 times the code: 3:1 to the nearer row, then 3:1 to the nearer column.
template <class Sample>
void interpolate(const Sample *near, const Sample *far, size_t count, size_t width,
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

template <class Sample> BasicFrame<Sample> to_yuv(const BasicImage<Sample> &image, const Colour &colour) {
  check_image(image);
  check_colour(colour);
  if (image.channels != 3) throw Error("a grey picture came where an RGB picture was expected");
  const Forward<Sample> k(colour);
  using Wide = typename Forward<Sample>::Wide;
  constexpr int fraction = Forward<Sample>::Number::fraction;
  const size_t width = image.width, height = image.height;
  const size_t chroma_width = (width + 1) / 2, chroma_height = (height + 1) / 2;
  BasicFrame<Sample> frame;
  frame.width = image.width;
  frame.height = image.height;
  frame.y.resize(width * height);
  frame.u.resize(chroma_width * chroma_height);
  frame.v.resize(chroma_width * chroma_height);
  const Sample *rgb = image.pixels.data();
  const int most = k.codes.most;
  const Wide luma_offset = (Wide(k.codes.black) << fraction) + (Wide(1) << (fraction - 1));
  for (size_t i = 0; i < width * height; i++, rgb += 3)
    frame.y[i] =
        clipped<Sample>(k.y[0] * rgb[0] + k.y[1] * rgb[1] + k.y[2] * rgb[2] + luma_offset, fraction, most);

  // Four samples are added up before the matrix: one rounding. A last odd row or column counts twice.
  constexpr int shift = fraction + 2;
  const Wide chroma_offset = (Wide(k.codes.middle) << shift) + (Wide(1) << (shift - 1));
  for (size_t cy = 0; cy < chroma_height; cy++) {
    const Sample *upper = image.pixels.data() + 2 * cy * width * 3;
    const Sample *lower = 2 * cy + 1 < height ? upper + width * 3 : upper;
    for (size_t cx = 0; cx < chroma_width; cx++) {
      const size_t left = 6 * cx, right = 2 * cx + 1 < width ? left + 3 : left;
      Wide sum[3];
      for (size_t c = 0; c < 3; c++)
        sum[c] = upper[left + c] + upper[right + c] + lower[left + c] + lower[right + c];
      const size_t at = cy * chroma_width + cx;
      const auto chroma = [&](const Wide *c) {
        return clipped<Sample>(c[0] * sum[0] + c[1] * sum[1] + c[2] * sum[2] + chroma_offset, shift, most);
      };
      frame.u[at] = chroma(k.cb);
      frame.v[at] = chroma(k.cr);
    }
  }
  return frame;
}

template <class Wanted, class Sample>
BasicImage<Wanted> to_rgb(const BasicFrame<Sample> &frame, const Colour &colour) {
  check_colour(colour);
  BasicImage<Wanted> image = make_image<Wanted>(frame.width, frame.height, 3, 0);
  const Backward<Sample, Wanted> k(colour);
  using Wide = typename Backward<Sample, Wanted>::Wide;
  const size_t width = frame.width, height = frame.height;
  const size_t chroma_width = (width + 1) / 2, chroma_height = (height + 1) / 2;
  if (frame.y.size() != width * height || frame.u.size() != chroma_width * chroma_height ||
      frame.v.size() != frame.u.size())
    throw Error("the planes of a YCbCr frame do not have the sizes of 4:2:0");
  std::vector<int32_t> column(chroma_width), u(width), v(width);
  constexpr int shift = Backward<Sample, Wanted>::Number::fraction + 4;
  constexpr int white = std::numeric_limits<Wanted>::max();
  Wanted *rgb = image.pixels.data();
  for (size_t row = 0; row < height; row++) {
    const size_t near = row / 2;
    const size_t far = row % 2 ? std::min(near + 1, chroma_height - 1) : (near > 0 ? near - 1 : 0);
    const auto line = [&](const std::vector<Sample> &plane, std::vector<int32_t> &out) {
      interpolate(&plane[near * chroma_width], &plane[far * chroma_width], chroma_width, width, column,
                  out.data());
    };
    line(frame.u, u);
    line(frame.v, v);
    const Sample *y = &frame.y[row * width];
    for (size_t x = 0; x < width; x++, rgb += 3) {
      const Wide luma = k.luma * 16 * (y[x] - k.codes.black) + (Wide(1) << (shift - 1));
      const int32_t cb = u[x] - 16 * k.codes.middle, cr = v[x] - 16 * k.codes.middle;
      rgb[0] = clipped<Wanted>(luma + k.red_cr * cr, shift, white);
      rgb[1] = clipped<Wanted>(luma + k.green_cb * cb + k.green_cr * cr, shift, white);
      rgb[2] = clipped<Wanted>(luma + k.blue_cb * cb, shift, white);
    }
  }
  return image;
}

template Frame to_yuv(const Image &, const Colour &);
template DeepFrame to_yuv(const DeepImage &, const Colour &);
template Image to_rgb(const Frame &, const Colour &);
template Image to_rgb(const DeepFrame &, const Colour &);
template DeepImage to_rgb(const Frame &, const Colour &);
template DeepImage to_rgb(const DeepFrame &, const Colour &);

} // namespace fvv::media
