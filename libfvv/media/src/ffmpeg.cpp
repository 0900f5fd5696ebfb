#include "ffmpeg.h"

extern "C" {
#include <libavutil/error.h>
#include <libavutil/log.h>
}

#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <new>

namespace fvv::media {
namespace {

thread_local char last_message[200];
thread_local bool demuxer_spoke;

void keep_message(void *speaker, int level, const char *format, va_list arguments) {
  if (level > AV_LOG_ERROR) return;
  const AVClass *kind = speaker ? *static_cast<AVClass **>(speaker) : nullptr;
  if (kind && kind->category == AV_CLASS_CATEGORY_DEMUXER) demuxer_spoke = true;
  char message[sizeof last_message];
  vsnprintf(message, sizeof message, format, arguments);
  message[strcspn(message, "\r\n")] = 0;
  if (message[0]) memcpy(last_message, message, sizeof message);
}

template <typename T> T *checked(T *pointer) {
  if (!pointer) throw std::bad_alloc();
  return pointer;
}

} // namespace

Context make_context(const AVCodec *codec) {
  return Context(checked(avcodec_alloc_context3(codec)));
}
AvFrame make_frame() {
  return AvFrame(checked(av_frame_alloc()));
}
Packet make_packet() {
  return Packet(checked(av_packet_alloc()));
}

Context make_decoder_context(const AVCodec *codec) {
  Context context = make_context(codec);
  context->thread_count = 1;
  context->err_recognition = AV_EF_EXPLODE | AV_EF_CRCCHECK | AV_EF_BITSTREAM | AV_EF_BUFFER;
  // Concealment stays on: without it the H.264 decoder does not report missing blocks.
  return context;
}

bool is_broken(const AVFrame &frame) {
  return frame.decode_error_flags || (frame.flags & AV_FRAME_FLAG_CORRUPT);
}

void quiet_log() {
  static std::once_flag once;
  std::call_once(once, [] { av_log_set_callback(keep_message); });
}

void clear_log() {
  last_message[0] = 0;
  demuxer_spoke = false;
}
bool log_has_error() {
  return last_message[0] != 0;
}
bool log_has_demuxer_error() {
  return demuxer_spoke;
}

void fail(const std::string &what, int code) {
  // The HEVC decoder returns ENOMEM, with a message, for a picture above its limit.
  if (code == AVERROR(ENOMEM) && !last_message[0]) throw std::bad_alloc();
  if (last_message[0]) throw Error(what + ": " + last_message);
  char text[AV_ERROR_MAX_STRING_SIZE];
  av_strerror(code, text, sizeof text);
  throw Error(what + ": " + text);
}

} // namespace fvv::media
