// fvv_media/image.h: reading, writing, scaling, comparing still pictures.
#include "fvv_catch.h"
#include "fvv_media/packed_image.h"
#include "pictures.h"

#include <png.h>

#include <cstring>
#include <limits>

using namespace fvv::media;

namespace {

struct PngKind {
  const char *name;
  int type, depth;
  bool interlaced;
};

// 257 times the 8-bit value, and more by less than half a step: rounding must bring the value back.
uint16_t wide_sample(uint32_t value) {
  return uint16_t((value & 255) * 257 + ((value & 255) < 255 ? 100 : 0));
}

// Row-packed samples of the kind, as libpng takes them. The picture is 23 x 9: x * 11 + y in the first
// channel.
std::vector<uint8_t> write_png(const PngKind &kind) {
  constexpr uint32_t width = 23, height = 9;
  std::vector<uint8_t> out;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(
      png, &out,
      [](png_structp p, png_bytep bytes, size_t size) {
        auto *to = static_cast<std::vector<uint8_t> *>(png_get_io_ptr(p));
        to->insert(to->end(), bytes, bytes + size);
      },
      nullptr);
  png_set_IHDR(png, info, width, height, kind.depth, kind.type,
               kind.interlaced ? PNG_INTERLACE_ADAM7 : PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  if (kind.type == PNG_COLOR_TYPE_PALETTE) {
    png_color palette[256];
    png_byte alpha[256];
    for (int i = 0; i < 256; i++) {
      palette[i] = {png_byte(i), png_byte(255 - i), png_byte(i / 2)};
      alpha[i] = png_byte(i);
    }
    png_set_PLTE(png, info, palette, 1 << kind.depth);
    png_set_tRNS(png, info, alpha, 1 << kind.depth, nullptr);
  }
  png_write_info(png, info);
  const int channels = png_get_channels(png, info);
  std::vector<std::vector<uint8_t>> rows(height, std::vector<uint8_t>(png_get_rowbytes(png, info)));
  std::vector<png_bytep> pointers;
  for (uint32_t y = 0; y < height; y++) {
    for (uint32_t i = 0; i < width * uint32_t(channels); i++) {
      const uint32_t value = i / uint32_t(channels) * 11 + y + 40 * (i % uint32_t(channels));
      if (kind.depth == 16) {
        const uint32_t wide = wide_sample(value);
        rows[y][2 * i] = uint8_t(wide >> 8);
        rows[y][2 * i + 1] = uint8_t(wide);
      } else if (kind.depth == 8) {
        rows[y][i] = uint8_t(value);
      } else {
        const uint32_t per_byte = 8 / uint32_t(kind.depth), mask = (1u << kind.depth) - 1;
        rows[y][i / per_byte] |= uint8_t((value & mask) << (8 - uint32_t(kind.depth) * (i % per_byte + 1)));
      }
    }
    pointers.push_back(rows[y].data());
  }
  png_write_image(png, pointers.data());
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  return out;
}

// What the picture of write_png must be after decoding.
uint8_t expected_sample(const PngKind &kind, uint32_t x, uint32_t y, uint32_t channel) {
  const uint32_t value = x * 11 + y + 40 * channel, mask = (1u << kind.depth) - 1;
  if (kind.type == PNG_COLOR_TYPE_PALETTE) {
    const uint32_t index = (x * 11 + y) & mask & 255;
    return uint8_t(channel == 0 ? index : channel == 1 ? 255 - index : index / 2);
  }
  if (kind.depth < 8) return uint8_t((value & mask) * 255 / mask);
  return uint8_t(value);
}

} // namespace

TEST_CASE("PNG of every kind comes out as grey or RGB of 8 or 16 bits") {
  const PngKind kinds[] = {
      {"grey 1", PNG_COLOR_TYPE_GRAY, 1, false},
      {"grey 2", PNG_COLOR_TYPE_GRAY, 2, true},
      {"grey 4", PNG_COLOR_TYPE_GRAY, 4, false},
      {"grey 8", PNG_COLOR_TYPE_GRAY, 8, true},
      {"grey 16", PNG_COLOR_TYPE_GRAY, 16, false},
      {"grey alpha 8", PNG_COLOR_TYPE_GRAY_ALPHA, 8, false},
      {"grey alpha 16", PNG_COLOR_TYPE_GRAY_ALPHA, 16, true},
      {"palette 2", PNG_COLOR_TYPE_PALETTE, 2, false},
      {"palette 8", PNG_COLOR_TYPE_PALETTE, 8, true},
      {"RGB 8", PNG_COLOR_TYPE_RGB, 8, true},
      {"RGB 16", PNG_COLOR_TYPE_RGB, 16, false},
      {"RGBA 8", PNG_COLOR_TYPE_RGBA, 8, false},
      {"RGBA 16", PNG_COLOR_TYPE_RGBA, 16, true},
  };
  for (const PngKind &kind : kinds) {
    CAPTURE(kind.name);
    const std::vector<uint8_t> file = write_png(kind);
    const int channels = kind.type & PNG_COLOR_MASK_COLOR ? 3 : 1;
    const ImageInfo info = probe_image(write_file("kind.png", file));
    CHECK(info.width == 23);
    CHECK(info.height == 9);
    CHECK(info.channels == channels);
    CHECK(info.format == ImageFormat::png);
    const Image image = decode_image(file.data(), file.size(), channels, "kind");
    REQUIRE(image.pixels.size() == size_t(23 * 9 * channels));
    size_t wrong = 0, at = 0;
    for (uint32_t y = 0; y < 9; y++)
      for (uint32_t x = 0; x < 23; x++)
        for (uint32_t c = 0; c < uint32_t(channels); c++)
          wrong += image.pixels[at++] != expected_sample(kind, x, y, c);
    CHECK(wrong == 0);
    const DeepImage deep = decode_image<uint16_t>(file.data(), file.size(), channels, "kind");
    REQUIRE(deep.pixels.size() == image.pixels.size());
    for (size_t i = 0; i < deep.pixels.size(); i++)
      wrong += deep.pixels[i] != (kind.depth == 16 ? wide_sample(image.pixels[i]) : 257 * image.pixels[i]);
    CHECK(wrong == 0);
  }
}

TEST_CASE("PNG and JPEG come back from what was written, the same bytes every time") {
  const Image picture = scene(97, 61, 2);
  const Image grey = decode_image(encode_png(picture).data(), encode_png(picture).size(), 1, "grey");
  for (const Image &image : {picture, grey}) {
    const std::vector<uint8_t> png = encode_png(image);
    CHECK(png == encode_png(image));
    const std::vector<uint8_t> fast = encode_png(image, PngEffort::fast);
    CHECK(fast != png);
    CHECK(read_image(write_file("fast.png", fast), image.channels).pixels == image.pixels);
    CHECK(read_image(write_file("round.png", png), image.channels).pixels == image.pixels);
    const std::vector<uint8_t> jpeg = encode_jpeg(image, 92, Subsampling::yuv420);
    CHECK(jpeg == encode_jpeg(image, 92, Subsampling::yuv420));
    // The name says PNG, the content decides.
    CHECK(probe_image(write_file("jpeg.png", jpeg)).format == ImageFormat::jpeg);
    CHECK(probe_image("jpeg.png").channels == image.channels);
    CHECK(psnr_luma(read_image("jpeg.png", image.channels), image) > 38);
  }
  const std::vector<uint8_t> fine = encode_jpeg(picture, 100, Subsampling::yuv444);
  CHECK(largest_difference(decode_image(fine.data(), fine.size(), 3, "fine"), picture) <= 4);
}

TEST_CASE("grey from RGB is BT.709 luma and RGB from grey repeats it") {
  Image image = make_image(4, 1, 3, 0);
  const uint8_t pixels[] = {255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255};
  memcpy(image.pixels.data(), pixels, sizeof pixels);
  const std::vector<uint8_t> file = encode_png(image);
  CHECK(decode_image(file.data(), file.size(), 1, "").pixels == std::vector<uint8_t>{54, 182, 18, 255});
  Image grey = make_image(1, 1, 1, 77);
  const std::vector<uint8_t> grey_file = encode_png(grey);
  CHECK(decode_image(grey_file.data(), grey_file.size(), 3, "").pixels == std::vector<uint8_t>{77, 77, 77});
}

TEST_CASE("a packed picture is the same again, and small where it is flat") {
  const auto packed = [](const auto &image) {
    using Sample = typename std::decay_t<decltype(image)>::Value;
    const PackedImage<Sample> kept(image);
    const BasicImage<Sample> again = kept.image();
    CHECK(again.width == image.width);
    CHECK(again.height == image.height);
    CHECK(again.channels == image.channels);
    CHECK(again.pixels == image.pixels);
    return kept.bytes();
  };
  packed(scene(40, 30, 0));
  packed(Image());
  // Runs of either kind that are longer than one can be: 90,000 pixels.
  CHECK(packed(make_image(300, 300, 1, 77)) < 200);
  CHECK(packed(make_image<uint16_t>(300, 300, 3, 5)) < 200);
  LinearImage varied = make_image<float>(300, 300, 3, 0);
  for (size_t i = 0; i < varied.pixels.size(); i++) varied.pixels[i] = float(i);
  packed(varied);
  Image mask = make_image(300, 300, 1, 0);
  for (uint32_t y = 100; y < 200; y++) std::fill_n(&mask.pixels[300 * y + 120], 50, uint8_t(255));
  CHECK(packed(mask) < 2000);
}

TEST_CASE("every cut of a PNG or JPEG file is an error that names the file") {
  const Image image = scene(40, 30, 0);
  for (const std::vector<uint8_t> &file : {encode_png(image), encode_jpeg(image, 80, Subsampling::yuv420)}) {
    for (size_t size = 0; size < file.size(); size += size < file.size() - 20 ? 7 : 1) {
      CAPTURE(size, file.size());
      const std::vector<uint8_t> cut(file.begin(), file.begin() + std::ptrdiff_t(size));
      CHECK_THAT(error_of([&] { decode_image(cut.data(), cut.size(), 3, "cut.bin"); }),
                 Contains("cut.bin: "));
    }
  }
  const std::vector<uint8_t> png = encode_png(image);
  CHECK_THAT(error_of([&] { decode_image(png.data(), 300, 3, "a"); }), Contains("cut at byte 300"));
}

TEST_CASE("damage in a PNG file is found by its CRCs") {
  const std::vector<uint8_t> file = encode_png(scene(40, 30, 0));
  size_t passed = 0;
  for (size_t at = 45; at < file.size(); at += 13) {
    std::vector<uint8_t> bad = file;
    bad[at] ^= 0x10;
    const std::string error =
        error_of([&] { passed += decode_image(bad.data(), bad.size(), 3, "bad").width == 40; });
    if (!error.empty()) CHECK_THAT(error, Contains("byte "));
  }
  // Only chunks that do not concern the pixels (sRGB, gAMA, their CRCs) may be damaged without notice.
  CHECK(passed <= 4);
}

TEST_CASE("files that are no pictures, or too large, are refused before anything is allocated") {
  CHECK_THAT(error_of([] { read_image("no/such/file.png", 3); }),
             Contains("no/such/file.png: cannot be opened: No such file"));
  CHECK_THAT(error_of([] { read_image(".", 3); }), Contains(".: is a folder"));
  CHECK_THAT(error_of([] { probe_image(write_file("empty", {})); }), Contains("empty: is empty"));
  CHECK_THAT(error_of([] {
               probe_image(write_file("text", {'h', 'e', 'l', 'l', 'o'}));
             }),
             Contains("neither a PNG nor a JPEG nor a WebP nor an OpenEXR"));
  CHECK_THAT(error_of([] { decode_image(nullptr, 0, 2, "x"); }), Contains("2 channels"));

  // Declared 16384 x 16384 in 100 bytes: a JPEG whose frame header lies, and a PNG likewise.
  std::vector<uint8_t> jpeg = encode_jpeg(scene(16, 16, 0), 50, Subsampling::yuv420);
  size_t frame_header = 0;
  for (size_t i = 0; i + 1 < jpeg.size() && !frame_header; i++)
    if (jpeg[i] == 0xff && jpeg[i + 1] == 0xc0) frame_header = i;
  REQUIRE(frame_header > 0);
  jpeg[frame_header + 5] = jpeg[frame_header + 7] = 0x40;
  jpeg[frame_header + 6] = jpeg[frame_header + 8] = 0;
  CHECK_THAT(error_of([&] { decode_image(jpeg.data(), jpeg.size(), 3, "big"); }), Contains("cannot hold"));
  jpeg[frame_header + 8] = 1;
  CHECK_THAT(error_of([&] { decode_image(jpeg.data(), jpeg.size(), 3, "big"); }),
             Contains("is 16385 x 16384 pixels, expected 1 to 16384"));

  CHECK_THAT(error_of([] { make_image(16385, 1, 3, 0); }), Contains("16385"));
  Image broken = make_image(4, 4, 3, 0);
  broken.pixels.pop_back();
  for (const PngEffort effort : {PngEffort::small, PngEffort::fast})
    CHECK_THAT(error_of([&] { encode_png(broken, effort); }), Contains("47 samples, expected 48"));
  CHECK_THAT(error_of([] { encode_jpeg(make_image(4, 4, 3, 0), 101, Subsampling::yuv420); }),
             Contains("quality is 101"));
}

TEST_CASE("a header after much other data is found") {
  // JPEG: an APP1 segment of 64 kB three times before the frame header.
  const std::vector<uint8_t> jpeg = encode_jpeg(scene(33, 21, 0), 80, Subsampling::yuv420);
  std::vector<uint8_t> padded(jpeg.begin(), jpeg.begin() + 2);
  for (int i = 0; i < 3; i++) {
    padded.insert(padded.end(), {0xff, 0xe1, 0xff, 0xff});
    padded.insert(padded.end(), 0xfffd, 0);
  }
  padded.insert(padded.end(), jpeg.begin() + 2, jpeg.end());
  const ImageInfo info = probe_image(write_file("padded.jpg", padded));
  CHECK(info.width == 33);
  CHECK(info.height == 21);
  CHECK(read_image("padded.jpg", 3).pixels == decode_image(jpeg.data(), jpeg.size(), 3, "").pixels);
}

TEST_CASE("scaling averages areas exactly") {
  Image image = make_image(4, 2, 1, 0);
  image.pixels = {0, 10, 20, 31, 100, 110, 120, 130};
  CHECK(scale(image, 2, 1).pixels == std::vector<uint8_t>{55, 75}); // 220/4, 301/4 = 75.25
  CHECK(scale(image, 4, 2).pixels == image.pixels);
  // 4 -> 3: thirds of 4/3 pixels; (0 * 3 + 10) / 4 = 2.5 rounds up to 3.
  CHECK(scale(crop(image, 0, 0, 4, 1), 3, 1).pixels == std::vector<uint8_t>{3, 15, 28});
  CHECK(scale(crop(image, 0, 0, 2, 1), 4, 1).pixels == std::vector<uint8_t>{0, 0, 10, 10});
  // The mean survives for any factor.
  const Image large = scene(211, 157, 1);
  const auto mean = [](const Image &of) {
    double sum = 0;
    for (const uint8_t sample : of.pixels) sum += sample;
    return sum / double(of.pixels.size());
  };
  for (const uint32_t width : {1u, 7u, 100u, 211u, 300u}) {
    const Image scaled = scale(large, width, width / 2 + 1);
    CHECK(scaled.width == width);
    CHECK(mean(scaled) == Approx(mean(large)).margin(0.6));
  }
  CHECK(scale(make_image(100, 3, 3, 200), 37, 5).pixels == make_image(37, 5, 3, 200).pixels);
  CHECK_THAT(error_of([&] { scale(image, 0, 5); }), Contains("0 x 5"));
  CHECK_THAT(error_of([&] { crop(image, 3, 0, 2, 1); }), Contains("not inside"));
}

TEST_CASE("Lanczos' filter keeps what is even and coarse, removes what is too fine, and overshoots little") {
  for (const uint32_t size : {1u, 7u, 50u, 99u, 100u, 130u})
    CHECK(scale(make_image(100, 3, 3, 200), size, 2, Filter::lanczos).pixels ==
          make_image(size, 2, 3, 200).pixels);

  // The amplitude of a wave of this many periods in 240 pixels, in 80.
  const auto amplitude = [](double periods, Filter filter) {
    Image wave = make_image(240, 1, 1, 0);
    for (size_t x = 0; x < 240; x++)
      wave.pixels[x] = uint8_t(
          std::lround(128 + 100 * std::sin(2 * 3.14159265358979 * periods * (double(x) + 0.5) / 240)));
    const Image out = scale(wave, 80, 1, filter);
    const auto [low, high] = std::minmax_element(out.pixels.begin() + 10, out.pixels.end() - 10);
    return (*high - *low) / 2;
  };
  CHECK(amplitude(25, Filter::area) < 88);
  CHECK(amplitude(25, Filter::lanczos) > 94);
  CHECK(amplitude(67, Filter::area) > 15);
  CHECK(amplitude(67, Filter::lanczos) < 5);

  Image step = make_image(240, 1, 1, 50);
  std::fill(step.pixels.begin() + 120, step.pixels.end(), uint8_t(200));
  const Image out = scale(step, 120, 1, Filter::lanczos);
  const auto [low, high] = std::minmax_element(out.pixels.begin(), out.pixels.end());
  CHECK(int(*low) >= 35);
  CHECK(int(*high) <= 215);
  CHECK(int(*high) > 201);
  for (size_t x = 0; x < 120; x++)
    if (x < 57 || x > 62) CHECK(int(out.pixels[x]) == (x < 60 ? 50 : 200));
}

TEST_CASE("PSNR is that of BT.709 luma where the mask counts") {
  const Image a = make_image(10, 10, 3, 100);
  Image b = a;
  CHECK(psnr_luma(a, b) == std::numeric_limits<double>::infinity());
  for (uint8_t &sample : b.pixels) sample = 101;
  CHECK(psnr_luma(a, b) == Approx(20 * std::log10(255.0)).margin(1e-9));
  // Green alone, one code up: 0.7152 of luma.
  b = a;
  for (size_t i = 1; i < b.pixels.size(); i += 3) b.pixels[i]++;
  CHECK(psnr_luma(a, b) == Approx(20 * std::log10(255 / 0.7152)).margin(0.05));
  Image mask = make_image(10, 10, 1, 127);
  CHECK_THAT(error_of([&] { psnr_luma(a, b, &mask); }), Contains("no pixel"));
  b = a;
  b.pixels[0] = b.pixels[1] = b.pixels[2] = 255;
  mask.pixels[50] = 128;
  CHECK(psnr_luma(a, b, &mask) == std::numeric_limits<double>::infinity());
  mask.pixels[0] = 255;
  CHECK(psnr_luma(a, b, &mask) == Approx(10 * std::log10(255.0 * 255 * 2 / (155.0 * 155))).margin(1e-9));
  CHECK_THAT(error_of([&] { psnr_luma(a, make_image(10, 9, 3, 0)); }), Contains("different sizes"));
}

TEST_CASE("pictures are turned clockwise by quarters") {
  Image image = make_image(3, 2, 1, 0);
  image.pixels = {1, 2, 3, //
                  4, 5, 6};
  CHECK(rotate(image, 0).pixels == image.pixels);
  const Image quarter = rotate(image, 90);
  CHECK((quarter.width == 2 && quarter.height == 3));
  CHECK(quarter.pixels == std::vector<uint8_t>{4, 1, 5, 2, 6, 3});
  CHECK(rotate(image, 180).pixels == std::vector<uint8_t>{6, 5, 4, 3, 2, 1});
  CHECK(rotate(image, 270).pixels == std::vector<uint8_t>{3, 6, 2, 5, 1, 4});
  const Image colours = scene(40, 30, 0);
  CHECK(rotate(rotate(rotate(colours, 90), 180), 90).pixels == colours.pixels);
  CHECK_THAT(error_of([&] { rotate(image, 45); }), Contains("expected 0, 90, 180 or 270"));
}

TEST_CASE("Exif orientation of a JPEG file is reported, in either byte order, and not applied") {
  const std::vector<uint8_t> plain = encode_jpeg(scene(16, 8, 0), 90, Subsampling::yuv420);
  const auto with_exif = [&](std::vector<uint8_t> tiff) {
    std::vector<uint8_t> segment = {0xff, 0xe1, 0, uint8_t(8 + tiff.size()), 'E', 'x', 'i', 'f', 0, 0};
    segment.insert(segment.end(), tiff.begin(), tiff.end());
    std::vector<uint8_t> file = plain;
    file.insert(file.begin() + 2, segment.begin(), segment.end());
    return write_file("exif.jpg", file);
  };
  const std::vector<uint8_t> big = {'M', 'M', 0, 42, 0,  0, 0, 8, 0, 2, 1, 0, 0, 4, 0, 0, 0, 1, 0,
                                    0,   0,   9, 1,  18, 0, 3, 0, 0, 0, 1, 0, 6, 0, 0, 0, 0, 0, 0};
  const std::vector<uint8_t> little = {'I', 'I', 42, 0, 8, 0, 0, 0, 1, 0, 18,
                                       1,   3,   0,  1, 0, 0, 0, 8, 0, 0, 0};
  CHECK(probe_image(write_file("exif.jpg", plain)).orientation == 1);
  CHECK(probe_image(with_exif(big)).orientation == 6);
  CHECK(probe_image(with_exif(little)).orientation == 8);
  const ImageInfo info = probe_image("exif.jpg");
  CHECK((info.width == 16 && info.height == 8));
  CHECK(read_image("exif.jpg", 3).pixels == decode_image(plain.data(), plain.size(), 3, "").pixels);
  // Cut anywhere, it is as if there were none.
  for (size_t size = 0; size < little.size() - 3; size++)
    CHECK(probe_image(with_exif({little.begin(), little.begin() + std::ptrdiff_t(size)})).orientation == 1);
}
