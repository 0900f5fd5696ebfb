// fvv_media/image.h: WebP, with libwebp's encoder as the witness, and files of formats that are not read.
#include "fvv_catch.h"
#include "pictures.h"

#include <webp/encode.h>

#include <cstring>

using namespace fvv::media;

namespace {

std::vector<uint8_t> taken(uint8_t *bytes, size_t size) {
  std::vector<uint8_t> out(bytes, bytes + size);
  WebPFree(bytes);
  return out;
}

std::vector<uint8_t> lossless(const Image &image) {
  uint8_t *bytes = nullptr;
  const size_t size = WebPEncodeLosslessRGB(image.pixels.data(), int(image.width), int(image.height),
                                            int(3 * image.width), &bytes);
  return taken(bytes, size);
}

} // namespace

TEST_CASE("WebP files are read: exact if lossless, close if lossy, grey and with more bits") {
  const Image image = scene(75, 41, 3);
  const std::vector<uint8_t> file = lossless(image);
  const Image found = decode_image(file.data(), file.size(), 3, "a.webp");
  CHECK(found.pixels == image.pixels);
  const DeepImage deep = decode_image<uint16_t>(file.data(), file.size(), 3, "a.webp");
  CHECK(std::equal(deep.pixels.begin(), deep.pixels.end(), image.pixels.begin(),
                   [](uint16_t a, uint8_t b) { return a == 257 * b; }));
  CHECK(decode_image(file.data(), file.size(), 1, "a.webp").channels == 1);
  const std::string path = write_file("a.webp", file);
  const ImageInfo info = probe_image(path);
  CHECK((info.width == 75 && info.height == 41 && info.channels == 3 && info.format == ImageFormat::webp));
  CHECK(read_image(path, 3).pixels == image.pixels);

  uint8_t *bytes = nullptr;
  const size_t size = WebPEncodeRGB(image.pixels.data(), 75, 41, 3 * 75, 90, &bytes);
  const std::vector<uint8_t> lossy = taken(bytes, size);
  CHECK(psnr_luma(decode_image(lossy.data(), lossy.size(), 3, "b.webp"), image) > 30);
}

TEST_CASE("alpha of WebP is dropped, and colour under it stays") {
  std::vector<uint8_t> pixels;
  for (int i = 0; i < 16 * 16; i++) pixels.insert(pixels.end(), {200, 100, 50, uint8_t(i)});
  WebPConfig config;
  REQUIRE((WebPConfigInit(&config) && WebPConfigLosslessPreset(&config, 0)));
  config.exact = 1;
  WebPPicture picture;
  REQUIRE(WebPPictureInit(&picture));
  picture.use_argb = 1;
  picture.width = picture.height = 16;
  WebPMemoryWriter writer;
  WebPMemoryWriterInit(&writer);
  picture.writer = WebPMemoryWrite;
  picture.custom_ptr = &writer;
  REQUIRE(WebPPictureImportRGBA(&picture, pixels.data(), 64));
  REQUIRE(WebPEncode(&config, &picture));
  const Image found = decode_image(writer.mem, writer.size, 3, "a.webp");
  for (size_t i = 0; i < found.pixels.size(); i += 3)
    REQUIRE((found.pixels[i] == 200 && found.pixels[i + 1] == 100 && found.pixels[i + 2] == 50));
  WebPPictureFree(&picture);
  WebPMemoryWriterClear(&writer);
}

TEST_CASE("a WebP file that is cut anywhere is refused") {
  const std::vector<uint8_t> file = lossless(scene(24, 16, 0));
  for (size_t size = 12; size < file.size() - 1; size++) { // the last byte may be padding
    const std::vector<uint8_t> cut(file.begin(), file.begin() + ptrdiff_t(size));
    CAPTURE(size);
    CHECK_THAT(error_of([&] { decode_image(cut.data(), cut.size(), 3, "cut.webp"); }),
               Contains("cut.webp: the WebP file is cut or damaged"));
  }
}

TEST_CASE("a file of another format is named") {
  const auto why = [](const std::string &bytes) {
    return why_no_picture(reinterpret_cast<const uint8_t *>(bytes.data()), bytes.size());
  };
  using namespace std::string_literals;
  const std::string rest(40, 'x');
  CHECK(why("\xabKTX 20\xbb\r\n\x1a\n"s + rest) ==
        "is a KTX2 file ('ktx extract' makes a PNG file of it), expected PNG, JPEG, WebP or OpenEXR");
  CHECK_THAT(why("BM"s + rest), Contains("is a BMP file"));
  CHECK_THAT(why("II*\0"s + rest), Contains("is a TIFF file"));
  CHECK_THAT(why("MM\0*"s + rest), Contains("is a TIFF file"));
  CHECK_THAT(why("GIF89a"s + rest), Contains("is a GIF file"));
  CHECK_THAT(why("DDS |"s + rest), Contains("is a DDS file"));
  CHECK_THAT(why("\0\0\0 ftypavif"s + rest), Contains("is an AVIF file"));
  CHECK_THAT(why("\0\0\0 ftypheic"s + rest), Contains("is a HEIC file"));
  CHECK_THAT(why("\0\0\0\x0cJXL \r\n"s + rest), Contains("is a JPEG XL file"));
  CHECK_THAT(why("version https://git-lfs.github.com/spec/v1\n"), Contains("Git LFS"));
  CHECK_THAT(why("hello"), Contains("is neither a PNG"));
  CHECK_THAT(why("B"), Contains("is neither a PNG"));
  CHECK(why("") == "is empty");
}
