// The pictures of a video file at random places, of every format that libavformat and libavcodec read, by
// their times. Pictures are returned as they are stored, not rotated.
#pragma once

#include "fvv/types.h"
#include "fvv_media/image.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fvv::media {

// 37 hours at 30 Hz. An index entry takes 40 bytes.
constexpr size_t max_video_pictures = 4'000'000;

struct VideoInfo {
  uint32_t width = 0, height = 0; // as stored
  fvv_rational tick = {1, 1};     // seconds, the unit of times
  std::vector<int64_t> times;     /* of the pictures, as they are shown: from 0, strictly rising, at most
                                   2^53 */
  // Degrees clockwise that the container's display matrix turns pictures by: 0, 90, 180, 270; nothing when it
  // does anything else, such as mirroring. Orientation inside the bitstream is ignored.
  std::optional<int> rotation = 0;
  // As the camera wrote it, "HH:MM:SS:FF", with ; before the last number where frames are dropped; empty:
  // none.
  std::string timecode;
  // The most bytes that a decoder takes: pictures that a codec keeps, in the stream's pixel format, and one
  // as RGB of 16 bits.
  uint64_t decoding_memory = 0;
  std::vector<std::string> warnings; // parts of sentences whose subject is the file
};

// One file, opened, for one thread at a time.
class VideoFile {
public:
  // Reads the whole file once, without decoding, for the times of its pictures. stream: index among all of
  // the file's streams; nothing: the first video stream. The name is a file's, never a URL's, and a file that
  // refers to others (a playlist) is not followed. Error for a file that cannot be read, is cut, has no
  // video, no decoder, pictures without or with equal presentation times, sides above max_dimension, more
  // than max_video_pictures, a PQ or HLG transfer (its colours would be wrong).
  // MemoryError for one that takes more than limit, before it is decoded.
  explicit VideoFile(const std::string &path, std::optional<uint32_t> stream = {},
                     const MemoryLimit &limit = {});
  ~VideoFile();
  VideoFile(VideoFile &&) noexcept;

  // The same file opened once more, with the same index; for another thread.
  VideoFile another() const;

  const VideoInfo &info() const;

  // Picture index < info().times.size(), counted as they are shown. channels: 1 or 3, as read_image.
  //
  // RGB by the matrix and range that the stream states. Unspecified: BT.709 from 720 lines on, else
  // BT.601, limited range unless the pixel format says otherwise; chroma of 4:2:0 as MPEG-2 has it (left).
  // Primaries and transfer are not converted. Samples deeper than SampleType are rounded, not
  // dithered; uint8_t, uint16_t and float (linear light, from 16 bits) are there.
  //
  // In rising order each picture is decoded once; otherwise decoding begins at the key before. Error for a
  // picture that is damaged, or that follows a damaged one up to the next key: libavcodec would conceal that.
  template <class SampleType = uint8_t> BasicImage<SampleType> picture(size_t index, int channels);
  // One more than the index of the last picture, 0 before: this picture is the cheapest to read.
  size_t position() const;

private:
  class Reader;
  explicit VideoFile(std::unique_ptr<Reader> reader);
  std::unique_ptr<Reader> reader_;
};

} // namespace fvv::media
