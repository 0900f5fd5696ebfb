/* Video files for tests, written by libavformat and libavcodec directly, without fvv_media. Each picture is
 * of one luma that identifies its number, so that a wrong picture is noticed; its top left quarter is
 * brighter. */
#ifndef FVV_TESTS_MEDIA_MAKE_VIDEO_H
#define FVV_TESTS_MEDIA_MAKE_VIDEO_H

extern "C" {
#include <libavcodec/avcodec.h>
}

#include "fvv_media/image.h"

#include <optional>
#include <string>
#include <vector>

struct Clip {
  std::vector<int64_t> times; /* in time_base, one for each picture */
  AVRational time_base = {1, 90000};
  const char *encoder = "libx264";
  const char *options = "crf=4"; /* "key=value:key=value" */
  AVPixelFormat format = AV_PIX_FMT_YUV420P;
  int width = 64, height = 48, gop = 12, b_frames = 0;
  std::optional<int> display_rotation; /* clockwise */
  AVRational pixel = {0, 1};
  AVColorTransferCharacteristic transfer = AVCOL_TRC_UNSPECIFIED;
  AVColorSpace matrix = AVCOL_SPC_UNSPECIFIED;
};

/* times of count pictures, one every step */
std::vector<int64_t> steady(int count, int64_t step);

/* The container by the name's extension. */
void write_video(const std::string &path, const Clip &clip);

/* 8-bit luma of picture n < 40 at limited range, away from and in the bright quarter. */
constexpr int luma_of(int n) {
  return 30 + 4 * n;
}
constexpr int bright = 24;

/* The number that a picture which was written so carries, by a pixel (x, y) outside the bright quarter; -1
 * when the level is no picture's. */
int number_in(const fvv::media::Image &image, uint32_t x, uint32_t y);

#endif
