/* A group that keeps a bit rate, by trying qualities. Knows codecs' scales; encodes nothing itself. Internal
 * to fvv_media. */
#ifndef FVV_MEDIA_RATE_H
#define FVV_MEDIA_RATE_H

#include "fvv_media/video.h"

#include <functional>

namespace fvv::media {

/* What encode_group promises for settings.bit_rate. encode_at answers the group at a quality of the codec. */
EncodedGroup encode_to_rate(const VideoSettings &settings, size_t frames,
                            const std::function<EncodedGroup(double quality)> &encode_at);

} // namespace fvv::media

#endif
