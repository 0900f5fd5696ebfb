#include "make_video.h"

#include "fvv_catch.h"

extern "C" {
#include <libavformat/avformat.h>
#include <libavutil/display.h>
#include <libavutil/opt.h>
}

#include <cmath>
#include <cstring>

namespace {

void draw(AVFrame *frame, int number, int depth) {
  const int shift = depth - 8;
  for (int y = 0; y < frame->height; y++)
    for (int x = 0; x < frame->width; x++) {
      const bool corner = x < frame->width / 2 && y < frame->height / 2;
      // Content to encode, beside the measured part.
      const int texture = !corner && x >= frame->width / 4 && x < frame->width * 3 / 4
                              ? (x * 37 + y * 91 + (x ^ y) * number * 13) % 64
                              : 0;
      const int luma = (luma_of(number) + (corner ? bright : texture)) << shift;
      uint8_t *row = frame->data[0] + y * frame->linesize[0];
      if (depth == 8)
        row[x] = uint8_t(luma);
      else
        reinterpret_cast<uint16_t *>(row)[x] = uint16_t(luma);
    }
  for (int plane = 1; plane < 3; plane++)
    for (int y = 0; y < frame->height / 2; y++)
      for (int x = 0; x < frame->width / 2; x++) {
        uint8_t *row = frame->data[plane] + y * frame->linesize[plane];
        if (depth == 8)
          row[x] = 128;
        else
          reinterpret_cast<uint16_t *>(row)[x] = uint16_t(128 << shift);
      }
}

} // namespace

std::vector<int64_t> steady(int count, int64_t step) {
  std::vector<int64_t> times;
  for (int i = 0; i < count; i++) times.push_back(i * step);
  return times;
}

void write_video(const std::string &path, const Clip &clip) {
  av_log_set_level(AV_LOG_ERROR);
  AVFormatContext *file = nullptr;
  REQUIRE(avformat_alloc_output_context2(&file, nullptr, nullptr, path.c_str()) >= 0);
  const AVCodec *encoder = avcodec_find_encoder_by_name(clip.encoder);
  REQUIRE(encoder);
  AVCodecContext *context = avcodec_alloc_context3(encoder);
  context->width = clip.width;
  context->height = clip.height;
  context->pix_fmt = clip.format;
  context->time_base = clip.time_base;
  context->gop_size = clip.gop;
  context->max_b_frames = clip.b_frames;
  context->sample_aspect_ratio = clip.pixel;
  context->color_trc = clip.transfer;
  context->colorspace = clip.matrix;
  context->thread_count = 1;
  if (file->oformat->flags & AVFMT_GLOBALHEADER) context->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  AVDictionary *options = nullptr;
  REQUIRE(av_dict_parse_string(&options, clip.options, "=", ";", 0) >= 0);
  REQUIRE(avcodec_open2(context, encoder, &options) >= 0);
  REQUIRE(av_dict_count(options) == 0);
  av_dict_free(&options);
  AVStream *stream = avformat_new_stream(file, nullptr);
  REQUIRE(avcodec_parameters_from_context(stream->codecpar, context) >= 0);
  stream->time_base = clip.time_base;
  stream->sample_aspect_ratio = clip.pixel;
  if (clip.display_rotation) {
    auto *matrix = reinterpret_cast<int32_t *>(
        av_stream_new_side_data(stream, AV_PKT_DATA_DISPLAYMATRIX, 9 * sizeof(int32_t)));
    av_display_rotation_set(matrix, *clip.display_rotation);
  }
  REQUIRE(avio_open(&file->pb, path.c_str(), AVIO_FLAG_WRITE) >= 0);
  REQUIRE(avformat_write_header(file, nullptr) >= 0);
  AVPacket *packet = av_packet_alloc();
  const auto drain = [&] {
    while (avcodec_receive_packet(context, packet) >= 0) {
      av_packet_rescale_ts(packet, clip.time_base, stream->time_base);
      packet->stream_index = 0;
      // Without it the last one lasts no time, and MP4 leaves it out.
      if (!packet->duration) packet->duration = 1;
      REQUIRE(av_interleaved_write_frame(file, packet) >= 0);
    }
  };
  const int depth = clip.format == AV_PIX_FMT_YUV420P10 ? 10 : 8;
  for (size_t i = 0; i < clip.times.size(); i++) {
    AVFrame *frame = av_frame_alloc();
    frame->format = clip.format;
    frame->width = clip.width;
    frame->height = clip.height;
    frame->pts = clip.times[i];
    REQUIRE(av_frame_get_buffer(frame, 0) >= 0);
    draw(frame, int(i), depth);
    REQUIRE(avcodec_send_frame(context, frame) >= 0);
    av_frame_free(&frame);
    drain();
  }
  REQUIRE(avcodec_send_frame(context, nullptr) >= 0);
  drain();
  REQUIRE(av_write_trailer(file) >= 0);
  av_packet_free(&packet);
  avcodec_free_context(&context);
  avio_closep(&file->pb);
  avformat_free_context(file);
}

int number_in(const fvv::media::Image &image, uint32_t x, uint32_t y) {
  const uint8_t *sample = &image.pixels[(size_t(y) * image.width + x) * size_t(image.channels)];
  for (int n = 0; n < 40; n++)
    if (std::abs(*sample - (luma_of(n) - 16) * 255.0 / 219) <= 2) return n;
  return -1;
}
