#include "fvv_demux/picture_decoder.h"

#include "fvv_cxx/error.h"
#include "fvv_demux/frame_plan.h"

namespace fvv::demux {

PictureDecoder::PictureDecoder(const fvv_video_layout &video, Samples samples)
    : track_(video.track), codec_(video.config.codec), bit_depth_(video.config.bit_depth), samples_(samples) {
  try {
    decoder_.emplace(video.config);
  } catch (const Error &error) {
    unusable_ = error.what();
  }
  begin_group();
}

void PictureDecoder::begin_group() {
  group_ = SIZE_MAX;
  frame_.reset();
  broken_ = lose(FVV_ERROR_DAMAGED, {}, "a picture comes before its key picture");
}

fvv_status PictureDecoder::lose(fvv_status status, const fvv_diagnostic &diagnostic, const std::string &why) {
  diagnostic_ = diagnostic;
  why_ = diagnostic.status ? text_of(diagnostic) : "track " + std::to_string(track_) + ": " + why;
  return status;
}

VideoFrame PictureDecoder::decoded(const uint8_t *sample, size_t size) {
  switch (samples_) {
  case Samples::eight_bits:
    return decoder_->decode<uint8_t>(sample, size);
  case Samples::sixteen_bits:
    return decoder_->decode<uint16_t>(sample, size);
  case Samples::linear:
    return decoder_->decode<float>(sample, size);
  case Samples::coded:
    break;
  }
  return media::with_sample_type(codec_, bit_depth_, [&](auto type) -> VideoFrame {
    return decoder_->decode<decltype(type)>(sample, size);
  });
}

fvv_status PictureDecoder::decode(const uint8_t *sample, size_t size, bool key) {
  frame_.reset();
  if (!decoder_) return broken_ = lose(FVV_ERROR_DAMAGED, {}, unusable_);
  if (!key && broken_ != FVV_OK) return broken_;
  broken_ = FVV_ERROR_DAMAGED; // until the sample has decoded
  try {
    frame_ = std::make_shared<const VideoFrame>(decoded(sample, size));
  } catch (const Error &error) {
    return lose(FVV_ERROR_DAMAGED, {}, error.what());
  }
  return broken_ = FVV_OK;
}

fvv_status PictureDecoder::take(fvv_stream *stream, size_t frame) {
  const uint8_t *sample = nullptr;
  size_t size = 0;
  int key = 0;
  fvv_diagnostic diagnostic = {};
  frame_.reset();
  const fvv_status status = fvv_stream_sample(stream, frame, track_, &sample, &size, &key, &diagnostic);
  if (status == FVV_END) return status;
  if (status < 0) return broken_ = lose(status, diagnostic, fvv_status_text(status));
  return decode(sample, size, key != 0);
}

fvv_status PictureDecoder::decode(fvv_stream *stream, size_t first, size_t frame) {
  if (group_ == first && next_ == frame + 1) return status_;
  if (group_ != first || next_ > frame) {
    begin_group();
    next_ = first;
  }
  const media::VideoCodec *codec = media::find_video_codec(codec_);
  if (codec && codec->is_stills()) next_ = frame;
  group_ = SIZE_MAX; // until the frame is reached
  for (; next_ <= frame; next_++) {
    status_ = take(stream, next_);
    if (status_ < 0 && status_ > FVV_ERROR_DAMAGED) return status_;
  }
  group_ = first;
  return status_;
}

} // namespace fvv::demux
