// Packets of one stream of a file, by libavformat. Internal to fvv_media.
#pragma once

#include "ffmpeg.h"

extern "C" {
#include <libavformat/avformat.h>
}

#include <memory>
#include <optional>
#include <string>

namespace fvv::media {

// libavformat is given bytes, not a name: a file called "http:..." or "a%d.png" is that file, and nothing
// that a file refers to is opened.
class Demuxer {
public:
  enum Kind { video, sound };

  // stream: index among all of the file's streams; nothing: the first of its kind. Error.
  Demuxer(const std::string &path, Kind kind, std::optional<uint32_t> stream);
  ~Demuxer();
  Demuxer(const Demuxer &) = delete;

  const AVStream &stream() const { return *stream_; }
  // Of the stream, or else of the file; empty: there is none.
  std::string tag(const char *name) const;
  // Time of the first picture of the file's first video, in the time base of stream().
  std::optional<int64_t> first_picture() const;
  // The next packet of the stream that is not empty; false at the end of the file. Error for a truncated or
  // damaged file, as far as the container shows it.
  bool read(AVPacket *packet);
  // Seeks to a key at or before a decoding time, as far as the container knows; false if it cannot.
  bool seek(int64_t dts);

private:
  struct Source;
  void open();
  void choose(std::optional<uint32_t> wanted);
  std::string no_such_file() const;

  const std::string path_;
  const Kind kind_;
  std::unique_ptr<Source> source_;
  bool is_endless_ = false;
  AVFormatContext *context_ = nullptr;
  AVStream *stream_ = nullptr;
};

} // namespace fvv::media
