/* See muxer.h. */
#include "media/src/container/muxer.h"

#include "fvv_cxx/error.h"
#include "media/src/ffmpeg.h"

extern "C" {
#include <libavutil/mem.h>
}

#include <algorithm>
#include <cstring>
#include <new>
#include <utility>

namespace fvv::media {

Muxer::Muxer(const char *format, std::string what) : what_(std::move(what)) {
  quiet_log();
  clear_log();
  if (avformat_alloc_output_context2(&context_, nullptr, format, nullptr) < 0 || !context_)
    throw Error(std::string("this build of FFmpeg does not write ") + format);
  constexpr int buffer_size = 65536;
  auto *buffer = static_cast<uint8_t *>(av_malloc(buffer_size));
  if (buffer) context_->pb = avio_alloc_context(buffer, buffer_size, 1, this, nullptr, put, seek);
  if (!context_->pb) {
    av_free(buffer);
    avformat_free_context(context_);
    throw std::bad_alloc();
  }
  context_->flags |= AVFMT_FLAG_BITEXACT | AVFMT_FLAG_CUSTOM_IO; // the same bytes everywhere
}

Muxer::~Muxer() {
  av_free(context_->pb->buffer);
  avio_context_free(&context_->pb);
  avformat_free_context(context_);
}

AVStream *Muxer::add_stream(AVRational time_base) {
  AVStream *stream = avformat_new_stream(context_, nullptr);
  if (!stream) throw std::bad_alloc();
  stream->time_base = time_base;
  time_bases_.push_back(time_base);
  return stream;
}

void Muxer::check(int code) const {
  if (code < 0) fail(what_ + " cannot be written", code);
}

void Muxer::write(const AVStream &stream, const std::vector<uint8_t> &bytes, int64_t time, int64_t duration,
                  bool key) {
  const Packet packet = make_packet();
  if (av_new_packet(packet.get(), int(bytes.size())) < 0) throw std::bad_alloc();
  std::copy(bytes.begin(), bytes.end(), packet->data);
  const AVRational time_base = time_bases_[size_t(stream.index)];
  packet->stream_index = stream.index;
  packet->pts = packet->dts = av_rescale_q(time, time_base, stream.time_base);
  packet->duration = av_rescale_q(duration, time_base, stream.time_base);
  if (key) packet->flags |= AV_PKT_FLAG_KEY;
  check(av_interleaved_write_frame(context_, packet.get()));
}

std::string Muxer::finish() {
  check(av_write_trailer(context_));
  avio_flush(context_->pb);
  return std::move(bytes_);
}

int Muxer::put(void *self, uint8_t *from, int size) {
  auto *to = static_cast<Muxer *>(self);
  const size_t end = to->at_ + size_t(size);
  if (to->bytes_.size() < end) to->bytes_.resize(end);
  std::memcpy(to->bytes_.data() + to->at_, from, size_t(size));
  to->at_ = end;
  return size;
}

int64_t Muxer::seek(void *self, int64_t offset, int whence) {
  auto *in = static_cast<Muxer *>(self);
  whence &= ~AVSEEK_FORCE;
  if (whence == AVSEEK_SIZE) return int64_t(in->bytes_.size());
  const int64_t from = whence == SEEK_CUR   ? int64_t(in->at_)
                       : whence == SEEK_END ? int64_t(in->bytes_.size())
                                            : 0;
  if (from + offset < 0) return AVERROR(EINVAL);
  in->at_ = size_t(from + offset);
  return from + offset;
}

void copy_record(const std::vector<uint8_t> &record, uint8_t *&extradata, int &size) {
  extradata = static_cast<uint8_t *>(av_mallocz(record.size() + AV_INPUT_BUFFER_PADDING_SIZE));
  if (!extradata) throw std::bad_alloc();
  std::copy(record.begin(), record.end(), extradata);
  size = int(record.size());
}

} // namespace fvv::media
