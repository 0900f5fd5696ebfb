/* Prints what the installed libavcodec decodes of a stream's video, for the test of the same decoders in
 * wasm: for every picture a line "planes TRACK SIZE", and then Y, U and V, row by row. usage: picture_bytes
 * FILE */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <libavcodec/avcodec.h>
#include <libavutil/pixdesc.h>

#include "fvv/stream.h"

static fvv_status read_at(void *user, uint64_t offset, void *out, size_t size) {
  FILE *file = user;
  return !fseek(file, (long)offset, SEEK_SET) && fread(out, 1, size, file) == size ? FVV_OK : FVV_ERROR_IO;
}

static AVCodecContext *open_decoder(const fvv_video_config *config) {
  const AVCodec *codec = avcodec_find_decoder(config->codec == FVV_CODEC_AVC1   ? AV_CODEC_ID_H264
                                              : config->codec == FVV_CODEC_HVC1 ? AV_CODEC_ID_HEVC
                                                                                : AV_CODEC_ID_VP9);
  AVCodecContext *context = avcodec_alloc_context3(codec);
  if (!context) exit(1);
  if (config->codec != FVV_CODEC_VP09) {
    context->extradata = av_mallocz(config->record_size + AV_INPUT_BUFFER_PADDING_SIZE);
    if (!context->extradata) exit(1);
    memcpy(context->extradata, config->record, config->record_size);
    context->extradata_size = (int)config->record_size;
  }
  context->thread_count = 1;
  context->flags |= AV_CODEC_FLAG_LOW_DELAY;
  if (avcodec_open2(context, codec, NULL) < 0) exit(1);
  return context;
}

static void put_planes(const AVFrame *frame, unsigned track) {
  const AVPixFmtDescriptor *format = av_pix_fmt_desc_get(frame->format);
  const int bytes = format->comp[0].depth > 8 ? 2 : 1;
  const int widths[3] = {frame->width, (frame->width + 1) / 2, (frame->width + 1) / 2};
  const int heights[3] = {frame->height, (frame->height + 1) / 2, (frame->height + 1) / 2};
  int size = 0;
  for (int i = 0; i < 3; i++) size += widths[i] * heights[i] * bytes;
  printf("planes %u %d\n", track, size);
  for (int i = 0; i < 3; i++)
    for (int y = 0; y < heights[i]; y++)
      fwrite(frame->data[i] + y * frame->linesize[i], 1, (size_t)(widths[i] * bytes), stdout);
}

static void put_sample(AVCodecContext *context, unsigned track, const uint8_t *sample, size_t size) {
  AVPacket *packet = av_packet_alloc();
  AVFrame *frame = av_frame_alloc();
  if (!packet || !frame || av_new_packet(packet, (int)size) < 0) exit(1);
  memcpy(packet->data, sample, size);
  if (avcodec_send_packet(context, packet) < 0 || avcodec_receive_frame(context, frame) < 0) exit(1);
  put_planes(frame, track);
  av_packet_free(&packet);
  av_frame_free(&frame);
}

int main(int count, char **arguments) {
  FILE *file = count == 2 ? fopen(arguments[1], "rb") : NULL;
  if (!file || fseek(file, 0, SEEK_END)) return 2;
  const fvv_input input = {read_at, file, (uint64_t)ftell(file)};
  fvv_stream *stream;
  if (fvv_stream_open(&input, NULL, NULL, &stream, NULL) != FVV_OK) return 1;
  AVCodecContext *decoders[16] = {NULL};
  for (size_t f = 0; f < fvv_stream_frame_count(stream); f++) {
    fvv_frame frame;
    const fvv_configuration *configuration;
    if (fvv_stream_frame(stream, f, &frame, NULL) != FVV_OK ||
        fvv_stream_configuration(stream, frame.group, &configuration, NULL) != FVV_OK ||
        configuration->video_count > sizeof decoders / sizeof *decoders)
      return 1;
    for (size_t i = 0; i < configuration->video_count; i++) {
      const fvv_video_layout *video = &configuration->videos[i];
      const uint8_t *sample;
      size_t size;
      int key;
      if (fvv_stream_sample(stream, f, video->track, &sample, &size, &key, NULL) != FVV_OK) return 1;
      if (!decoders[i]) decoders[i] = open_decoder(&video->config);
      put_sample(decoders[i], video->track, sample, size);
    }
  }
  for (size_t i = 0; i < sizeof decoders / sizeof *decoders; i++) avcodec_free_context(&decoders[i]);
  fvv_stream_close(stream);
  fclose(file);
  return 0;
}
