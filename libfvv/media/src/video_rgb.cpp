#include "video_rgb.h"

#include "codecs.h"

extern "C" {
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
#include <libswscale/swscale.h>
}

#include <cstring>

namespace fvv::media {
namespace {

constexpr int high_definition = 720; // lines from which unspecified video is taken as BT.709

// libswscale's name of a matrix; the one of RGB is never used.
int matrix_of(const AVFrame &frame) {
  switch (frame.colorspace) {
  case AVCOL_SPC_UNSPECIFIED:
    return frame.height >= high_definition ? SWS_CS_ITU709 : SWS_CS_ITU601;
  case AVCOL_SPC_RGB:
  case AVCOL_SPC_BT709:
    return SWS_CS_ITU709;
  case AVCOL_SPC_BT470BG:
  case AVCOL_SPC_SMPTE170M:
    return SWS_CS_ITU601;
  case AVCOL_SPC_FCC:
    return SWS_CS_FCC;
  case AVCOL_SPC_SMPTE240M:
    return SWS_CS_SMPTE240M;
  case AVCOL_SPC_BT2020_NCL:
    return SWS_CS_BT2020;
  default:
    throw Error("the stream has the matrix coefficients " + std::to_string(frame.colorspace) +
                " (ITU-T H.273), which cannot be converted");
  }
}

// YUVJ formats imply full range; libswscale expects the range in place of them.
AVPixelFormat plain_format(int format, bool &full_range) {
  full_range = true;
  switch (format) {
  case AV_PIX_FMT_YUVJ420P:
    return AV_PIX_FMT_YUV420P;
  case AV_PIX_FMT_YUVJ422P:
    return AV_PIX_FMT_YUV422P;
  case AV_PIX_FMT_YUVJ444P:
    return AV_PIX_FMT_YUV444P;
  case AV_PIX_FMT_YUVJ440P:
    return AV_PIX_FMT_YUV440P;
  case AV_PIX_FMT_YUVJ411P:
    return AV_PIX_FMT_YUV411P;
  default:
    full_range = false;
    return AVPixelFormat(format);
  }
}

// The position of chroma, in 1/256 of the distance of two luma samples; -513: libswscale's default, for
// formats without subsampling.
struct Siting {
  int x = -513, y = -513;
};
Siting siting_of(const AVPixFmtDescriptor &format, const AVFrame &frame, bool full_range) {
  if (format.log2_chroma_w != 1 || format.log2_chroma_h > 1) return {};
  const bool centred = frame.chroma_location == AVCHROMA_LOC_CENTER ||
                       frame.chroma_location == AVCHROMA_LOC_TOP ||
                       (frame.chroma_location == AVCHROMA_LOC_UNSPECIFIED && full_range);
  const bool top = frame.chroma_location == AVCHROMA_LOC_TOPLEFT || frame.chroma_location == AVCHROMA_LOC_TOP;
  return {centred ? 128 : 0, format.log2_chroma_h == 0 ? -513 : top ? 0 : 128};
}

struct Setup {
  AVPixelFormat rgb, format;
  int width, height, matrix;
  bool full_range;
  Siting siting;
};

std::string text_of(const Setup &s) {
  std::string text;
  for (const int value :
       {int(s.rgb), int(s.format), s.width, s.height, s.matrix, int(s.full_range), s.siting.x, s.siting.y})
    text += std::to_string(value) + " ";
  return text;
}

SwsContext *make_scaler(const Setup &s) {
  SwsContext *context = sws_alloc_context();
  if (!context) throw std::bad_alloc();
  const auto set = [&](const char *name, int value) { av_opt_set_int(context, name, value, 0); };
  set("srcw", s.width);
  set("srch", s.height);
  set("src_format", s.format);
  set("dstw", s.width);
  set("dsth", s.height);
  set("dst_format", s.rgb);
  set("sws_flags", SWS_BILINEAR | SWS_BITEXACT | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP);
  set("src_h_chr_pos", s.siting.x);
  set("src_v_chr_pos", s.siting.y);
  set("threads", 1);
  av_opt_set(context, "sws_dither", "none", 0);
  const int *coefficients = sws_getCoefficients(s.matrix);
  // Formats without a range return an error, which is ignored.
  sws_setColorspaceDetails(context, coefficients, s.full_range, coefficients, 1, 0, 1 << 16, 1 << 16);
  const int code = sws_init_context(context, nullptr, nullptr);
  if (code >= 0) return context;
  sws_freeContext(context);
  fail("its pictures cannot be converted to RGB", code);
}

} // namespace

RgbConverter::~RgbConverter() {
  sws_freeContext(context_);
}

template <class Sample> BasicImage<Sample> RgbConverter::convert(const AVFrame &frame) {
  check_dimensions(uint32_t(frame.width), uint32_t(frame.height), "");
  bool full_range;
  Setup setup = {sizeof(Sample) == 1 ? AV_PIX_FMT_RGB24 : AV_PIX_FMT_RGB48,
                 plain_format(frame.format, full_range),
                 frame.width,
                 frame.height,
                 matrix_of(frame),
                 false,
                 {}};
  const AVPixFmtDescriptor *format = av_pix_fmt_desc_get(setup.format);
  if (!format || !sws_isSupportedInput(setup.format))
    throw Error(std::string("the pixel format ") + (format ? format->name : "") +
                " cannot be converted to RGB");
  setup.full_range = full_range || frame.color_range == AVCOL_RANGE_JPEG;
  setup.siting = siting_of(*format, frame, setup.full_range);
  if (const std::string text = text_of(setup); text != made_for_) {
    sws_freeContext(context_);
    context_ = nullptr;
    made_for_.clear();
    context_ = make_scaler(setup);
    made_for_ = text;
  }
  // libswscale may write beyond the end of a row: into padding, not into the next row.
  const AvFrame rgb = make_frame();
  rgb->format = setup.rgb;
  rgb->width = frame.width;
  rgb->height = frame.height;
  int code = av_frame_get_buffer(rgb.get(), 0);
  if (code < 0) fail("a picture cannot be made", code);
  code = sws_scale(context_, frame.data, frame.linesize, 0, frame.height, rgb->data, rgb->linesize);
  if (code != frame.height) fail("its pictures cannot be converted to RGB", code);
  BasicImage<Sample> image = make_image<Sample>(uint32_t(frame.width), uint32_t(frame.height), 3, 0);
  const size_t row_size = size_t(image.width) * 3;
  for (size_t y = 0; y < image.height; y++)
    memcpy(&image.pixels[y * row_size], rgb->data[0] + ptrdiff_t(y) * rgb->linesize[0],
           row_size * sizeof(Sample));
  return image;
}

template Image RgbConverter::convert(const AVFrame &frame);
template DeepImage RgbConverter::convert(const AVFrame &frame);

} // namespace fvv::media
