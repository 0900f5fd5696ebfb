/* NAL units of H.264 and HEVC between Annex B of either standard and the MP4 sample format of ISO/IEC
 * 14496-15. Knows start codes and lengths; what a unit's type is, avc.cpp and hevc.cpp say. Internal to
 * fvv_media. */
#ifndef FVV_MEDIA_NAL_H
#define FVV_MEDIA_NAL_H

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace fvv::media {

using Bytes = std::vector<uint8_t>;

/* The units of an Annex B stream for which keep(first header byte) holds. */
std::vector<Bytes> annex_b_units(const uint8_t *bytes, size_t size, const std::function<bool(uint8_t)> &keep);

/* Units one after the other, each behind its length in length_bytes bytes, big-endian. */
void append_units(Bytes &out, const std::vector<Bytes> &units, unsigned length_bytes);

/* The one parameter set of a kind. Error, by the name "HEVC encoder ... VPS", when there is not exactly one
 * of least to 65535 bytes. */
const Bytes &only_set(const std::vector<Bytes> &sets, size_t least, const std::string &name);

} // namespace fvv::media

#endif
