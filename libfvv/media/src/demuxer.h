/* Packets of one video stream of a file, by libavformat, and the index of its pictures. Internal to
 * fvv_media. */
#ifndef FVV_MEDIA_DEMUXER_H
#define FVV_MEDIA_DEMUXER_H

#include "fvv_media/video_file.h"

#include "ffmpeg.h"

extern "C" {
#include <libavformat/avformat.h>
}

namespace fvv::media {

class Demuxer {
public:
  Demuxer(const std::string &path, std::optional<uint32_t> stream);
  ~Demuxer();
  Demuxer(const Demuxer &) = delete;

  const AVStream &stream() const { return *stream_; }
  /* The next packet of the stream that holds anything; false at the end of the file. Error for what is cut or
   * damaged as far as the container can tell. */
  bool read(AVPacket *packet);
  /* To a key at or before a decoding time, as far as the container knows; false when it cannot. */
  bool seek(int64_t dts);

private:
  struct Source;
  void open();
  void choose(std::optional<uint32_t> wanted);

  const std::string path_;
  std::unique_ptr<Source> source_;
  AVFormatContext *context_ = nullptr;
  AVStream *stream_ = nullptr;
};

struct VideoIndex {
  struct Entry {
    int64_t pts, dts; /* dts may be AV_NOPTS_VALUE */
    bool key;
  };
  VideoInfo info;
  std::vector<Entry> packets;    /* as they are stored, those too that are decoded but not shown */
  std::vector<size_t> packet_of; /* by picture, as they are shown */

  int64_t pts(size_t picture) const { return packets[packet_of[picture]].pts; }
};

/* Reads demuxer, which was just opened, to its end. */
VideoIndex make_index(Demuxer &demuxer, const std::string &path);

/* Why pictures with this transfer cannot be taken; NULL when they can. */
const char *refused_transfer(AVColorTransferCharacteristic transfer);

} // namespace fvv::media

#endif
