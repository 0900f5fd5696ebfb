// A container that libavformat writes into memory. Internal to fvv_media.
#pragma once

extern "C" {
#include <libavformat/avformat.h>
}

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace fvv::media {

class Muxer {
public:
  // format: libavformat's name, "mp4". what: what messages call that which is written, "sound". Error when
  // this build of FFmpeg does not write the format.
  Muxer(const char *format, std::string what);
  ~Muxer();
  Muxer(const Muxer &) = delete;

  AVFormatContext *context() { return context_; }
  // Time stamps of write() count in units of time_base.
  AVStream *add_stream(AVRational time_base);
  // Throws Error "WHAT cannot be written: reason" for a code below 0.
  void check(int code) const;
  void write_header() { check(avformat_write_header(context_, nullptr)); }
  // A packet of a stream, shown at time. Packets of several streams may come in any order.
  void write(const AVStream &stream, const std::vector<uint8_t> &bytes, int64_t time, int64_t duration,
             bool key);
  // The whole file; nothing can be written any more.
  std::string finish();

private:
  static int put(void *self, uint8_t *from, int size);
  static int64_t seek(void *self, int64_t offset, int whence);

  const std::string what_;
  std::vector<AVRational> time_bases_; // that write() counts in; the container chooses others
  AVFormatContext *context_ = nullptr;
  std::string bytes_;
  size_t at_ = 0;
};

// Gives a codec a copy of a decoder's record.
void copy_record(const std::vector<uint8_t> &record, uint8_t *&extradata, int &size);

} // namespace fvv::media
