/* One decoder of libavcodec in an instance of wasm: a sample in, the planes of its picture out. Who calls is
 * software_video.js of @fvv/decoder; every sample has one picture of its own (clauses 10.5 to 10.8 of the
 * format). What is not as it should be is an error, never a picture that was patched up.
 * SPDX-License-Identifier: LGPL-2.1-or-later */
#include <limits.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <libavcodec/avcodec.h>
#include <libavutil/log.h>
#include <libavutil/mem.h>
#include <libavutil/pixdesc.h>

#define EXPORT __attribute__((visibility("default"), used))
#define FOURCC(a, b, c, d) ((uint32_t)(a) | (uint32_t)(b) << 8 | (uint32_t)(c) << 16 | (uint32_t)(d) << 24)

/* Of these functions and their meaning: software_video.js asks for it. */
enum { ABI = 1 };

/* Whether this call has had its time. Hostile samples can have millions of slices that each cover a picture.
 */
__attribute__((import_module("fvv"), import_name("expired"))) int expired(void);

static AVCodecContext *context;
static AVPacket *packet;
static AVFrame *frame;
static struct {
  uint32_t width, height;
  enum AVPixelFormat format;
} wanted;
static char message[200];

/* libavcodec replaces a missing reference picture with nothing but a message: any error counts. */
static void keep_message(void *speaker, int level, const char *format, va_list arguments) {
  (void)speaker;
  if (level > AV_LOG_ERROR || message[0]) return;
  vsnprintf(message, sizeof message, format, arguments);
  message[strcspn(message, "\r\n")] = 0;
}

static int refuse(const char *why) {
  if (!message[0]) snprintf(message, sizeof message, "%s", why);
  return 0;
}

/* The caller drops an instance that traps: there is no other way out of the middle of libavcodec. */
static void check_time(void) {
  if (expired()) __builtin_trap();
}

static void watch_rows(AVCodecContext *c, const AVFrame *f, int offset[AV_NUM_DATA_POINTERS], int y, int type,
                       int height) {
  (void)c, (void)f, (void)offset, (void)y, (void)type, (void)height;
  check_time();
}
static int watch_slices(AVCodecContext *c, int (*run)(AVCodecContext *, void *), void *arguments,
                        int *results, int count, int size) {
  check_time();
  return avcodec_default_execute(c, run, arguments, results, count, size);
}
static int watch_pictures(AVCodecContext *c, AVFrame *f, int flags) {
  check_time();
  return avcodec_default_get_buffer2(c, f, flags);
}

EXPORT uint32_t fvvvideo_abi(void) {
  return ABI;
}
EXPORT const char *fvvvideo_message(void) {
  return message;
}

EXPORT void fvvvideo_close(void) {
  avcodec_free_context(&context);
  av_packet_free(&packet);
  av_frame_free(&frame);
}

/* Room for a sample or a record, zeros behind it as libavcodec wants them. NULL: no memory. */
EXPORT uint8_t *fvvvideo_input(uint32_t size) {
  if (!packet) packet = av_packet_alloc();
  if (!packet || size > INT_MAX / 2) return NULL;
  av_packet_unref(packet);
  return av_new_packet(packet, (int)size) < 0 ? NULL : packet->data;
}

static const AVCodec *find(uint32_t codec) {
  switch (codec) {
  case FOURCC('a', 'v', 'c', '1'):
    return avcodec_find_decoder(AV_CODEC_ID_H264);
  case FOURCC('h', 'v', 'c', '1'):
    return avcodec_find_decoder(AV_CODEC_ID_HEVC);
  case FOURCC('v', 'p', '0', '9'):
    return avcodec_find_decoder(AV_CODEC_ID_VP9);
  default:
    return NULL;
  }
}

static int take_record(void) {
  context->extradata = av_mallocz((size_t)packet->size + AV_INPUT_BUFFER_PADDING_SIZE);
  if (!context->extradata) return 0;
  memcpy(context->extradata, packet->data, (size_t)packet->size);
  context->extradata_size = packet->size;
  return 1;
}

/* Opens a decoder, with the record that was put into fvvvideo_input. 0: the message tells why not. Width,
 * height and bits are those of the configuration: pictures of others are refused before they are allocated.
 */
EXPORT int fvvvideo_open(uint32_t codec, uint32_t width, uint32_t height, uint32_t bits) {
  AVPacket *record = packet;
  packet = NULL;
  fvvvideo_close();
  packet = record;
  message[0] = 0;
  av_log_set_callback(keep_message);
  const AVCodec *found = find(codec);
  if (!found) return refuse("this codec is not in it");
  if (bits != 8 && bits != 10) return refuse("pictures of 8 or 10 bits a sample only");
  wanted.width = width;
  wanted.height = height;
  wanted.format = bits == 8 ? AV_PIX_FMT_YUV420P : AV_PIX_FMT_YUV420P10LE;
  context = avcodec_alloc_context3(found);
  frame = av_frame_alloc();
  if (!context || !frame) return refuse("no memory");
  /* VP9's record says nothing that its decoder needs. */
  if (found->id != AV_CODEC_ID_VP9 && packet && !take_record()) return refuse("no memory");
  context->flags |= AV_CODEC_FLAG_LOW_DELAY;
  context->err_recognition = AV_EF_EXPLODE | AV_EF_CRCCHECK | AV_EF_BITSTREAM | AV_EF_BUFFER;
  /* Without any concealment the H.264 decoder does not tell that blocks are missing. This one costs least. */
  context->error_concealment = FF_EC_FAVOR_INTER;
  /* Coded sizes are whole blocks, of up to 64 pixels. */
  context->max_pixels = ((int64_t)width + 64) * ((int64_t)height + 64);
  context->draw_horiz_band = watch_rows;
  context->execute = watch_slices;
  context->get_buffer2 = watch_pictures;
  if (avcodec_open2(context, found, NULL) < 0) return refuse("its configuration record cannot be used");
  return 1;
}

static int is_wanted(void) {
  const int format = frame->format == AV_PIX_FMT_YUVJ420P ? AV_PIX_FMT_YUV420P : frame->format;
  if (format != (int)wanted.format)
    return refuse("it is not 4:2:0 with the bits that its configuration says");
  if (frame->width != (int)wanted.width || frame->height != (int)wanted.height)
    return refuse("its picture has another size than its configuration says");
  return 1;
}

/* Decodes the sample in fvvvideo_input: 1 when its picture is there, 0: the message tells why not, and only a
 * key can follow. The picture is good until the next call. */
EXPORT int fvvvideo_decode(int restart) {
  message[0] = 0;
  if (!context || !packet) return refuse("there is no decoder");
  if (restart) avcodec_flush_buffers(context);
  av_frame_unref(frame);
  if (avcodec_send_packet(context, packet) < 0) return refuse("it is damaged");
  const int code = avcodec_receive_frame(context, frame);
  if (code == AVERROR(EAGAIN)) return refuse("it gives no picture of its own");
  if (code < 0 || message[0]) return refuse("it is damaged");
  if (frame->decode_error_flags || (frame->flags & AV_FRAME_FLAG_CORRUPT))
    return refuse("its picture is not whole");
  return is_wanted();
}

/* Y, U, V: 8 bits in a byte, 10 in two, the lower one first. */
EXPORT const uint8_t *fvvvideo_plane(uint32_t plane) {
  return frame->data[plane];
}
EXPORT int32_t fvvvideo_stride(uint32_t plane) {
  return frame->linesize[plane];
}
