// The pictures of one video track, from its samples in order: which samples a picture needs, which one was
// decoded last, and what damage costs.
#pragma once

#include "fvv/stream.h"
#include "fvv_media/image.h"
#include "fvv_media/video.h"

#include <memory>
#include <optional>
#include <string>
#include <variant>

namespace fvv::demux {

// A frame of video, with the pictures of all its cameras.
using VideoFrame = std::variant<media::Image, media::DeepImage, media::LinearImage>;

// The type of decoded samples.
enum class Samples {
  coded,        // as the track has them: media::with_sample_type
  eight_bits,   // Image
  sixteen_bits, // DeepImage
  linear,       // LinearImage
};

// Decodes frames of a stream by number, or samples as they arrive; use one decoder for one of the two. Frames
// in order cost one sample each. A frame out of order costs those since its group began, of a codec of stills
// one. After a sample that is damaged, or that does not decode, every picture is lost until the next key;
// before the first key of a group too. One thread at a time; separate decoders are independent.
class PictureDecoder {
public:
  // Copies what it needs of video. A codec or record that cannot be decoded is not reported here but by every
  // sample. Takes up to media::decoding_memory; a reader of untrusted files checks that first.
  explicit PictureDecoder(const fvv_video_layout &video, Samples samples = Samples::coded);

  // The picture of a frame of a stream whose configuration has this video track; first: the first frame of
  // its group. FVV_OK: the picture is in frame(). FVV_END: the frame has no sample on the track.
  // FVV_ERROR_DAMAGED and what is below it: the picture is lost. Other errors (memory, input) say nothing
  // about the picture: the next call starts again with the group.
  fvv_status decode(fvv_stream *stream, size_t first, size_t frame);

  // The samples that follow are those of another group.
  void begin_group();
  // The picture of the next sample of the group. FVV_OK or FVV_ERROR_DAMAGED, as above.
  fvv_status decode(const uint8_t *sample, size_t size, bool key);

  // After FVV_OK; else NULL. A caller may keep it; this object holds the last one.
  const std::shared_ptr<const VideoFrame> &frame() const { return frame_; }
  // After an error: that of the stream. Status 0: the codec refused a sample, or waits for a key.
  const fvv_diagnostic &diagnostic() const { return diagnostic_; }
  // After an error: the line without the name of the file.
  const std::string &why() const { return why_; }
  uint16_t track() const { return track_; }

private:
  fvv_status take(fvv_stream *stream, size_t frame);
  fvv_status lose(fvv_status status, const fvv_diagnostic &diagnostic, const std::string &why);
  VideoFrame decoded(const uint8_t *sample, size_t size);

  const uint16_t track_;
  const uint32_t codec_;
  const int bit_depth_;
  const Samples samples_;
  std::optional<media::Decoder> decoder_;
  std::string unusable_; // why there is no decoder

  size_t group_ = SIZE_MAX;               // its first frame; SIZE_MAX: none was begun
  size_t next_ = 0;                       // frame after the last one that was taken
  fvv_status status_ = FVV_END;           // of the last one
  fvv_status broken_ = FVV_ERROR_DAMAGED; // what non-key samples return; FVV_OK: they decode
  std::shared_ptr<const VideoFrame> frame_;
  fvv_diagnostic diagnostic_ = {};
  std::string why_;
};

} // namespace fvv::demux
