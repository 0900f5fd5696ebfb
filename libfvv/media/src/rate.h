/* Encodes a group within a bit rate by trying qualities. Internal to fvv_media. */
#ifndef FVV_MEDIA_RATE_H
#define FVV_MEDIA_RATE_H

#include "fvv_media/video.h"

#include <functional>

namespace fvv::media {

/* Implements settings.bit_rate of encode_group. encode_at returns the group at a quality of the codec. */
EncodedGroup encode_to_rate(const VideoSettings &settings, size_t frames,
                            const std::function<EncodedGroup(double quality)> &encode_at);

} // namespace fvv::media

#endif
