// libavcodec's objects with owners, and its log. Internal to fvv_media.
#pragma once

#include "fvv_media/colour.h"

extern "C" {
#include <libavcodec/avcodec.h>
}

#include <memory>
#include <string>

namespace fvv::media {

struct FreeAv {
  void operator()(AVCodecContext *context) const { avcodec_free_context(&context); }
  void operator()(AVFrame *frame) const { av_frame_free(&frame); }
  void operator()(AVPacket *packet) const { av_packet_free(&packet); }
};
using Context = std::unique_ptr<AVCodecContext, FreeAv>;
using AvFrame = std::unique_ptr<AVFrame, FreeAv>;
using Packet = std::unique_ptr<AVPacket, FreeAv>;

// Throw std::bad_alloc where FFmpeg returns NULL.
Context make_context(const AVCodec *codec);
AvFrame make_frame();
Packet make_packet();

// A context for decoding, not opened yet: on one thread, as an error must belong to the packet that was sent
// last, and with an error for all damage that the decoder can detect.
Context make_decoder_context(const AVCodec *codec);
// Whether the decoder reports that a picture is not whole.
bool is_broken(const AVFrame &frame);

// 4:2:0 of 8 or 10 bits a sample, in the byte order of the machine: the planes of a BasicFrame.
constexpr AVPixelFormat pixel_format(int bit_depth) {
  return bit_depth == 8 ? AV_PIX_FMT_YUV420P : AV_PIX_FMT_YUV420P10;
}

// From now on FFmpeg prints nothing; its last error message on this thread is kept for fail. Process-wide:
// FFmpeg has one log.
void quiet_log();
// Forgets the message that an earlier call left.
void clear_log();
// Whether FFmpeg has logged an error on this thread since, even if it returned success.
bool log_has_error();
// The same of demuxers alone.
bool log_has_demuxer_error();
// Throws Error "what: message", by the log's last error or by the code's own text.
[[noreturn]] void fail(const std::string &what, int code);

} // namespace fvv::media
