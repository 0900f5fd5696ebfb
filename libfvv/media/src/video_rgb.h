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

  // As VideoFile::picture. Reuses its converter while pictures and sample type do not change. Errors have no
  // name.
  template <class SampleType> BasicImage<SampleType> convert(const AVFrame &frame);

private:
  SwsContext *context_ = nullptr;
  std::string made_for_;
};

} // namespace fvv::media
