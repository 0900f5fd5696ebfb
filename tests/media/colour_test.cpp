// fvv_media/colour.h: the matrices, and that all codecs and their readers agree on them.
#include "display_codecs.h"
#include "fvv_catch.h"
#include "fvv_media/video.h"
#include "pictures.h"

#include <turbojpeg.h>

extern "C" {
#include <libavcodec/avcodec.h>
}

#include <cstring>

using namespace fvv::media;

namespace {

// 16 x 16 blocks of one colour each: the eight corners of the cube, then greys.
constexpr uint32_t blocks = 16;
Image chart() {
  Image image = make_image(16 * blocks, 16, 3, 0);
  for (uint32_t y = 0; y < 16; y++)
    for (uint32_t x = 0; x < image.width; x++) {
      const uint32_t block = x / 16;
      uint8_t *rgb = &image.pixels[(size_t(y) * image.width + x) * 3];
      for (uint32_t c = 0; c < 3; c++)
        rgb[c] = block < 8 ? (block >> c & 1 ? 255 : 0) : uint8_t((block - 8) * 255 / 7);
    }
  return image;
}

// Largest difference in the middle of the blocks, where chroma is not interpolated across borders.
int chart_difference(const Image &a, const Image &b) {
  int largest = 0;
  for (uint32_t block = 0; block < blocks; block++)
    largest = std::max(
        largest, largest_difference(crop(a, block * 16 + 4, 4, 8, 8), crop(b, block * 16 + 4, 4, 8, 8)));
  return largest;
}

// ITU-T H.273 equations 8.3 in double precision: what the codes of a colour must be, rounded.
void codes_of(const uint8_t *rgb, const Colour &colour, double out[3]) {
  const double kr = colour.matrix == 1 ? 0.2126 : 0.299, kb = colour.matrix == 1 ? 0.0722 : 0.114;
  const double r = rgb[0] / 255.0, g = rgb[1] / 255.0, b = rgb[2] / 255.0;
  const double y = kr * r + (1 - kr - kb) * g + kb * b;
  const double cb = (b - y) / (1 - kb) / 2, cr = (r - y) / (1 - kr) / 2;
  out[0] = colour.full_range ? 255 * y : 219 * y + 16;
  out[1] = std::min(255.0, (colour.full_range ? 255 : 224) * cb + 128);
  out[2] = std::min(255.0, (colour.full_range ? 255 : 224) * cr + 128);
}

} // namespace

TEST_CASE("codes are those of H.273, and RGB comes back") {
  const Image image = chart();
  for (const Colour colour :
       {colour_of_jpeg, colour_of_video, Colour{1, 6, 6, false}, Colour{1, 1, 1, true}}) {
    const Frame frame = to_yuv(image, colour);
    double worst = 0;
    for (uint32_t block = 0; block < blocks; block++) {
      double codes[3];
      codes_of(&image.pixels[(8 * image.width + block * 16 + 8) * 3], colour, codes);
      const size_t luma = 8 * image.width + block * 16 + 8, chroma = 4 * (image.width / 2) + block * 8 + 4;
      worst = std::max({worst, std::abs(frame.y[luma] - codes[0]), std::abs(frame.u[chroma] - codes[1]),
                        std::abs(frame.v[chroma] - codes[2])});
    }
    CHECK(worst < 0.51);
    CHECK(chart_difference(to_rgb(frame, colour), image) <= 2);
  }
  // White, black and grey do not move at all.
  for (const Colour colour : {colour_of_jpeg, colour_of_video})
    for (int value = 0; value < 256; value++) {
      const Frame frame = to_yuv(make_image(2, 2, 3, uint8_t(value)), colour);
      REQUIRE(frame.u[0] == 128);
      REQUIRE(frame.v[0] == 128);
      const int back = to_rgb(frame, colour).pixels[0];
      REQUIRE(std::abs(back - value) <= (colour.full_range ? 0 : 1));
      if (value == 0 || value == 255) REQUIRE(back == value);
    }
}

TEST_CASE("odd sizes and smooth colour survive 4:2:0") {
  for (const uint32_t width : {1u, 2u, 33u}) {
    const Image image = scene(width, 27, 0);
    const Frame frame = to_yuv(image, colour_of_video);
    CHECK(frame.u.size() == size_t(width + 1) / 2 * 14);
    CHECK(psnr_luma(to_rgb(frame, colour_of_video), image) > 45);
  }
  Frame frame = to_yuv(scene(8, 8, 0), colour_of_jpeg);
  frame.v.pop_back();
  CHECK_THAT(error_of([&] { to_rgb(frame, colour_of_jpeg); }), Contains("planes"));
  CHECK_THAT(error_of([] { to_yuv(make_image(2, 2, 1, 0), colour_of_jpeg); }), Contains("grey"));
  CHECK_THAT(error_of([] { check_colour({9, 16, 9, false}); }), Contains("primaries (ITU-T H.273) are 9"));
  CHECK_THAT(error_of([] { check_colour({1, 13, 2, false}); }), Contains("matrix coefficients"));
}

TEST_CASE("libjpeg's codes are those of the JPEG code points") {
  const Image image = chart();
  const std::vector<uint8_t> file = encode_jpeg(image, 100, Subsampling::yuv420);
  Frame read = to_yuv(image, colour_of_jpeg);
  const Frame expected = read;
  unsigned char *planes[] = {read.y.data(), read.u.data(), read.v.data()};
  const tjhandle handle = tjInitDecompress();
  REQUIRE(tjDecompressToYUVPlanes(handle, file.data(), file.size(), planes, int(image.width), nullptr,
                                  int(image.height), TJFLAG_ACCURATEDCT) == 0);
  tjDestroy(handle);
  int worst = 0;
  for (size_t i = 0; i < read.y.size(); i++) worst = std::max(worst, std::abs(read.y[i] - expected.y[i]));
  for (size_t i = 0; i < read.u.size(); i++)
    worst = std::max({worst, std::abs(read.u[i] - expected.u[i]), std::abs(read.v[i] - expected.v[i])});
  CHECK(worst <= 2);
}

TEST_CASE("saturated colours and greys survive all codecs within a few codes") {
  const Image image = chart();
  for (const VideoCodec &codec : display_codecs()) {
    CAPTURE(codec.name);
    const bool jpeg = codec.code == FVV_CODEC_JPEG;
    const VideoSettings settings = {codec.code, image.width, image.height, jpeg ? 98 : 4, {1, 25}};
    const EncodedGroup group = encode_group(settings, {image});
    fvv_video_config config = config_of(settings, group);
    Decoder decoder(config);
    const Image decoded = decoder.decode(group.samples[0].bytes.data(), group.samples[0].bytes.size());
    CHECK(chart_difference(decoded, image) <= 5);
    if (jpeg) continue;
    // A configuration that contradicts the stream is found, not believed.
    const auto decode = [&] {
      Decoder(config).decode(group.samples[0].bytes.data(), group.samples[0].bytes.size());
    };
    config.matrix_coefficients = 6;
    CHECK_THAT(error_of(decode), Contains("states matrix coefficients 1 (ITU-T H.273), its configuration 5"));
    config.matrix_coefficients = 1;
    config.full_range = 1;
    CHECK_THAT(error_of(decode), Contains("states full range 0"));
  }
}

TEST_CASE("FFmpeg finds the code points, the range and the chroma position in the streams") {
  const Image image = chart();
  const struct {
    uint32_t codec;
    const char *decoder;
    int primaries, transfer, chroma;
  } cases[] = {{FVV_CODEC_AVC1, "h264", 1, 13, AVCHROMA_LOC_CENTER},
               {FVV_CODEC_HVC1, "hevc", 1, 13, AVCHROMA_LOC_CENTER},
               // VP9 has no place for primaries, transfer and chroma position, AV1 none for the middle.
               {FVV_CODEC_VP09, "vp9", AVCOL_PRI_UNSPECIFIED, AVCOL_TRC_UNSPECIFIED, -1},
               {FVV_CODEC_AV01, "libdav1d", 1, 13, AVCHROMA_LOC_UNSPECIFIED}};
  for (const auto &one : cases) {
    CAPTURE(one.decoder);
    const VideoSettings settings = {one.codec, image.width, image.height, 10, {1001, 30000}};
    const EncodedGroup group = encode_group(settings, {image});
    AVCodecContext *context = avcodec_alloc_context3(avcodec_find_decoder_by_name(one.decoder));
    if (one.codec != FVV_CODEC_VP09) {
      context->extradata =
          static_cast<uint8_t *>(av_mallocz(group.record.size() + AV_INPUT_BUFFER_PADDING_SIZE));
      memcpy(context->extradata, group.record.data(), group.record.size());
      context->extradata_size = int(group.record.size());
    }
    REQUIRE(avcodec_open2(context, nullptr, nullptr) == 0);
    AVPacket *packet = av_packet_alloc();
    REQUIRE(av_new_packet(packet, int(group.samples[0].bytes.size())) == 0);
    memcpy(packet->data, group.samples[0].bytes.data(), group.samples[0].bytes.size());
    AVFrame *frame = av_frame_alloc();
    REQUIRE(avcodec_send_packet(context, packet) == 0);
    REQUIRE(avcodec_send_packet(context, nullptr) == 0);
    REQUIRE(avcodec_receive_frame(context, frame) == 0);
    CHECK(frame->color_primaries == one.primaries);
    CHECK(frame->color_trc == one.transfer);
    CHECK(frame->colorspace == 1);
    CHECK(frame->color_range == AVCOL_RANGE_MPEG);
    if (one.chroma >= 0) CHECK(frame->chroma_location == one.chroma);
    CHECK(context->has_b_frames == 0);
    if (one.codec == FVV_CODEC_AVC1 || one.codec == FVV_CODEC_HVC1)
      CHECK(av_cmp_q(context->framerate, {30000, 1001}) == 0);
    // The eighth block is white: 235 at limited range.
    CHECK(std::abs(frame->data[0][8 * frame->linesize[0] + 7 * 16 + 8] - 235) <= 1);
    av_frame_free(&frame);
    av_packet_free(&packet);
    avcodec_free_context(&context);
  }
}
