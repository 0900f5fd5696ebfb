// fvv_media/exr.h, srgb.h, and OpenEXR as pictures. Files are written and read back by OpenEXR itself.
#include "exr_files.h"

#include "fvv_media/colour.h"

#include <boost/multiprecision/cpp_int.hpp>

#include <cstring>
#include <limits>

using namespace fvv::media;

namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

// Whether the sRGB curve at x, times largest, is at least code - 1/2: integers throughout.
bool reaches(float x, uint32_t code, uint32_t largest) {
  using Integer = boost::multiprecision::cpp_int;
  int exponent = 0;
  const Integer mantissa =
      int64_t(std::ldexp(std::frexp(x, &exponent), 24)); // x = mantissa 2^(exponent - 24)
  const int shift = 24 - exponent;
  REQUIRE(shift >= 0);
  const Integer half = 2 * Integer(code) - 1, whole = 2 * Integer(largest); // v = half / whole
  const bool linear = 100000 * half <= 4045 * whole;
  if (linear) return 1292 * mantissa * whole >= ((100 * half) << shift);
  // (200 v + 11) / 211 to the 12th against x to the 5th.
  const Integer above = 200 * half + 11 * whole, below = 211 * whole;
  return boost::multiprecision::pow(mantissa, 5) * boost::multiprecision::pow(below, 12) >=
         (boost::multiprecision::pow(above, 12) << (5 * shift));
}

// Linear light of a display value, and back, by the formula of IEC 61966-2-1.
double linear_of(double display) {
  return display <= 0.04045 ? display / 12.92 : std::pow((display + 0.055) / 1.055, 2.4);
}
double display_of(double linear) {
  return linear <= 0.0031308 ? linear * 12.92 : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
}

} // namespace

TEST_CASE("thresholds of the sRGB curve are the exact ones, for 8 and for 16 bits") {
  for (const uint32_t largest : {255u, 65535u}) {
    const std::vector<float> table = srgb_thresholds(largest);
    REQUIRE(table.size() == largest);
    size_t wrong = 0;
    for (uint32_t code = 1; code <= largest; code++) {
      const float least = table[code - 1];
      wrong += !reaches(least, code, largest) || reaches(std::nextafter(least, 0.0f), code, largest);
    }
    CHECK(wrong == 0);
  }
}

TEST_CASE("linear light becomes display values, clipped at both ends") {
  FloatImage linear;
  linear.width = 300;
  linear.height = 2;
  linear.channels = {"R", "G", "B"};
  for (int i = 0; i < 600; i++)
    for (const double v : {i / 500.0 - 0.05, i / 599.0, i < 256 ? linear_of(i / 255.0) : 1000.0 * i})
      linear.samples.push_back(float(v));
  const std::vector<uint8_t> file = encode_exr(linear);
  const Image image = decode_image(file.data(), file.size(), 3, "ramp");
  REQUIRE(image.pixels.size() == linear.samples.size());
  int worst = 0;
  for (size_t i = 0; i < image.pixels.size(); i++) {
    const double exact = 255 * display_of(std::clamp(double(linear.samples[i]), 0.0, 1.0));
    if (std::abs(exact - image.pixels[i]) > 0.500001) worst++;
  }
  CHECK(worst == 0);
  for (int i = 0; i < 600; i++) CHECK(int(image.pixels[size_t(3 * i + 2)]) == std::min(i, 255));
}

TEST_CASE("OpenEXR comes back as it was written, infinities and NaN too, the same bytes every time") {
  FloatImage image;
  image.width = 37;
  image.height = 41; // two blocks of 16 lines and a part of one
  image.channels = {"Z"};
  uint32_t state = 5;
  for (uint32_t i = 0; i < 37 * 41; i++)
    image.samples.push_back(i % 7 ? float(next_random(state)) / 1000 : infinity);
  image.samples[9] = std::numeric_limits<float>::quiet_NaN();
  const std::vector<uint8_t> file = encode_exr(image);
  CHECK(file == encode_exr(image));
  const FloatImage back = read_exr(write_file("depth.exr", file));
  CHECK(back.width == 37);
  CHECK(back.height == 41);
  CHECK(back.channels == std::vector<std::string>{"Z"});
  REQUIRE(back.samples.size() == image.samples.size());
  CHECK(memcmp(back.samples.data(), image.samples.data(), 4 * image.samples.size()) == 0);
  const std::vector<float> witness = read_channel("depth.exr", "Z", 37, 41);
  CHECK(memcmp(witness.data(), image.samples.data(), 4 * image.samples.size()) == 0);
  CHECK_THAT(error_of([] { read_image("depth.exr", 3); }),
             Contains("depth.exr: has the depth channel Z alone"));

  image.channels = {"R", "A"};
  CHECK_THAT(error_of([&] { encode_exr(image); }), Contains("holds 1517 samples, expected 3034"));
  image.channels = {"Z", "Z"};
  CHECK_THAT(error_of([&] { encode_exr(image); }), Contains("channels that OpenEXR has no names for"));
}

TEST_CASE("OpenEXR of every kind is read") {
  using namespace OPENEXR_IMF_NAMESPACE;
  for (const Compression compression :
       {NO_COMPRESSION, RLE_COMPRESSION, ZIPS_COMPRESSION, ZIP_COMPRESSION, PIZ_COMPRESSION,
        PXR24_COMPRESSION, B44_COMPRESSION, B44A_COMPRESSION})
    for (const PixelType type : {HALF, FLOAT})
      for (const int tile : {0, 16})
        for (const std::vector<std::string> &channels : {std::vector<std::string>{"R", "G", "B"},
                                                         {"R", "G", "B", "A"},
                                                         {"R", "G", "B", "A", "N.x", "depth"},
                                                         {"Y"},
                                                         {"Y", "A"},
                                                         {"Z"},
                                                         {"A", "Z"}}) {
          CAPTURE(int(compression), int(type), tile, channels.size(), channels[0]);
          ExrKind kind;
          kind.compression = compression;
          kind.type = type;
          kind.tile = tile;
          kind.channels = channels;
          kind.decreasing = tile == 0 && channels.size() == 1;
          kind.first_x = -3;
          kind.first_y = channels.size() == 3 ? 11 : 0;
          const FloatImage image = read_exr(write_exr("kind.exr", kind));
          REQUIRE(image.width == exr_width);
          REQUIRE(image.height == exr_height);
          std::vector<std::string> expected = channels;
          if (channels.size() > 4) expected = {"R", "G", "B", "A"};
          if (channels.back() == "Z") expected = {"Z"};
          REQUIRE(image.channels == expected);
          const bool lossy = compression >= PXR24_COMPRESSION;
          float worst = 0;
          for (uint32_t y = 0; y < exr_height; y++)
            for (uint32_t x = 0; x < exr_width; x++)
              for (size_t c = 0; c < expected.size(); c++) {
                const float value = image.samples[(y * exr_width + x) * expected.size() + c];
                worst = std::max(worst, std::abs(value - exr_sample(expected[c], x, y)));
              }
          if (lossy)
            CHECK(worst < (compression == PXR24_COMPRESSION ? 1e-4f : 0.1f));
          else
            CHECK(worst == 0);
        }
}

TEST_CASE("OpenEXR pictures are probed and made grey or RGB") {
  ExrKind kind;
  kind.channels = {"R", "G", "B", "A"};
  const ImageInfo info = probe_image(write_exr("rgba.png", kind)); // the content decides
  CHECK(info.format == ImageFormat::exr);
  CHECK(info.channels == 3);
  CHECK(info.width == exr_width);
  CHECK(info.height == exr_height);
  const Image rgb = read_image("rgba.png", 3);
  size_t wrong = 0;
  for (uint32_t y = 0; y < exr_height; y++)
    for (uint32_t x = 0; x < exr_width; x++)
      for (size_t c = 0; c < 3; c++) {
        const double exact = 255 * display_of(exr_sample(kind.channels[c], x, y));
        wrong += std::abs(rgb.pixels[(y * exr_width + x) * 3 + c] - exact) > 0.500001;
      }
  CHECK(wrong == 0);
  kind.channels = {"Y"};
  CHECK(probe_image(write_exr("grey.exr", kind)).channels == 1);
  const Image grey = read_image("grey.exr", 1);
  CHECK(grey.pixels[5] == uint8_t(std::floor(255 * display_of(exr_sample("Y", 5, 0)) + 0.5)));
  CHECK(read_image("grey.exr", 3).pixels[17] == grey.pixels[5]);
}

TEST_CASE("a header of OpenEXR after much other data is found") {
  ExrKind kind;
  kind.comment = 300000;
  CHECK(probe_image(write_exr("long.exr", kind)).width == exr_width);
  CHECK(read_image("long.exr", 3).width == exr_width);
}

TEST_CASE("OpenEXR that is no picture by exr.h is refused with a reason") {
  const auto error_with = [](auto change) {
    ExrKind kind;
    change(kind);
    write_exr("odd.exr", kind);
    const std::string error = error_of([] { read_image("odd.exr", 3); });
    CHECK_THAT(error, Contains("odd.exr: "));
    if (!error.empty()) CHECK_FALSE(error_of([] { probe_image("odd.exr"); }).empty());
    return error;
  };
  CHECK_THAT(error_with([](ExrKind &k) { k.compression = OPENEXR_IMF_NAMESPACE::DWAA_COMPRESSION; }),
             Contains("compressed with DWAA"));
  CHECK_THAT(error_with([](ExrKind &k) { k.type = OPENEXR_IMF_NAMESPACE::UINT; }), Contains("has integers"));
  CHECK_THAT(error_with([](ExrKind &k) {
               k.channels = {"R", "G"};
             }),
             Contains("has the channels G, R, expected R, G and B, or Y, or Z"));
  CHECK_THAT(error_with([](ExrKind &k) { k.channels = {"BY", "RY", "Y"}; }), Contains("has the channels BY"));
  CHECK_THAT(error_with([](ExrKind &k) { k.sampling = 23; }), Contains("is subsampled 23 x 1"));
  CHECK_THAT(error_with([](ExrKind &k) { k.overscan = 1; }),
             Contains("data window (0, 0) to (22, 37), expected the display window (1, 1) to (21, 36)"));
  CHECK_THAT(error_with([](ExrKind &k) { k.red_x = 0.708f; }),
             Contains("chromaticities (0.708, 0.33) (0.3, 0.6)"));
  CHECK(error_of([] { // three digits of the white point are enough
          ExrKind kind;
          kind.red_x = 0.6401f;
          read_image(write_exr("near.exr", kind), 3);
        })
            .empty());
  write_two_parts("parts.exr");
  CHECK_THAT(error_of([] { read_image("parts.exr", 3); }),
             Contains("parts.exr: the OpenEXR file has 2 parts"));
  write_deep("deep.exr");
  CHECK_THAT(error_of([] { read_image("deep.exr", 3); }),
             Contains("deep.exr: the OpenEXR file has deep data"));
}

TEST_CASE("NaN and infinities in an OpenEXR picture are errors that name the pixel") {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), infinity, -infinity}) {
    FloatImage image;
    image.width = 5;
    image.height = 4;
    image.channels = {"R", "G", "B"};
    image.samples.assign(60, 0.5f);
    image.samples[3 * 13 + 1] = bad;
    const std::vector<uint8_t> file = encode_exr(image);
    CHECK_THAT(error_of([&] { decode_image(file.data(), file.size(), 3, "a.exr"); }),
               Contains(std::string("a.exr: channel G of pixel (3, 2) is ") +
                        (std::isnan(bad) ? "not a number" : "infinite")));
  }
}
