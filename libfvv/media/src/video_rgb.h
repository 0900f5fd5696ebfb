// Pictures of any pixel format to RGB, by libswscale. Internal to fvv_media.
#pragma once

#include "ffmpeg.h"

struct SwsContext;

namespace fvv::media {

class RgbConverter {
public:
  RgbConverter() = default;
  ~RgbConverter();
  RgbConverter(const RgbConverter &) = delete;

  // As VideoFile::picture says. Keeps what it has set up while pictures and sample type are alike. Error
  // without a name.
  template <class SampleType> BasicImage<SampleType> convert(const AVFrame &frame);

private:
  SwsContext *context_ = nullptr;
  std::string made_for_;
};

} // namespace fvv::media
