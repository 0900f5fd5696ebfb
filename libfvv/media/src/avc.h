/* H.264 bytes between Annex B of ITU-T H.264 and the MP4 sample format of ISO/IEC 14496-15. Looks at NAL unit
 * headers and the first bytes of a sequence parameter set, never at slices. Internal to fvv_media. */
#ifndef FVV_MEDIA_AVC_H
#define FVV_MEDIA_AVC_H

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace fvv::media {

/* nal_unit_type, ITU-T H.264 table 7-1. */
enum class Nal : uint8_t { slice = 1, idr_slice = 5, sei = 6, sps = 7, pps = 8, delimiter = 9 };

/* The slices of an Annex B access unit behind 4-byte lengths; parameter sets, SEI and delimiters are left
 * out. */
std::vector<uint8_t> avc_sample(const uint8_t *annex_b, size_t size);

/* AVCDecoderConfigurationRecord of 4:2:0, 8-bit video with the parameter sets of an Annex B stream. Error
 * when there is not exactly one sequence and one picture parameter set. */
std::vector<uint8_t> avc_record(const uint8_t *annex_b, size_t size);

/* "avc1.PPCCLL" (RFC 6381) of a record. */
std::string avc_codec_string(const std::vector<uint8_t> &record);

/* Error unless the record opens like an AVCDecoderConfigurationRecord with 4-byte lengths. */
void avc_check_record(const uint8_t *record, size_t size);

/* Error unless the lengths fill the sample exactly with NAL units that are not empty. Answers whether the
 * sample has an IDR picture. */
bool avc_check_sample(const uint8_t *sample, size_t size);

} // namespace fvv::media

#endif
