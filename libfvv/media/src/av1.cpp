/* AV1. See bitstream.h. */
#include "bitstream.h"

#include "fvv_cxx/error.h"

namespace fvv::media {
namespace {

/* obu_type, AV1 bitstream specification, clause 6.2.2. */
constexpr unsigned sequence_header = 1, temporal_delimiter = 2;

struct Obu {
  unsigned type;
  const uint8_t *begin, *payload, *end;
};

/* Clause 5.3. The encoder gives every OBU a size field. */
std::vector<Obu> obus_of(const uint8_t *bytes, size_t size) {
  std::vector<Obu> out;
  const uint8_t *const end = bytes + size;
  for (const uint8_t *at = bytes; at < end;) {
    Obu obu = {at[0] >> 3 & 15u, at, at + (at[0] & 4 ? 2 : 1), nullptr};
    uint64_t length = 0;
    bool more = true;
    for (unsigned shift = 0; more && shift < 56 && obu.payload < end; shift += 7) {
      length |= uint64_t(*obu.payload & 127) << shift;
      more = *obu.payload++ & 128;
    }
    if (!(at[0] & 2) || more || length > uint64_t(end - obu.payload))
      throw Error("the encoder gave AV1 whose OBUs do not fill its packet");
    at = obu.end = obu.payload + length;
    out.push_back(obu);
  }
  return out;
}

Bytes sample(const uint8_t *packet, size_t size) {
  Bytes out;
  for (const Obu &obu : obus_of(packet, size))
    if (obu.type != temporal_delimiter) out.insert(out.end(), obu.begin, obu.end);
  return out;
}

/* The first fields of a sequence header, clause 5.5.1, from its most significant bit on. */
unsigned bits(const Obu &obu, size_t first, size_t count) {
  unsigned value = 0;
  for (size_t i = first; i < first + count; i++) {
    if (i / 8 >= size_t(obu.end - obu.payload))
      throw Error("the encoder gave an AV1 sequence header that ends early");
    value = value << 1 | (obu.payload[i / 8] >> (7 - i % 8) & 1u);
  }
  return value;
}

/* AV1CodecConfigurationRecord. seq_profile is bits 0 to 2; then still_picture,
 * reduced_still_picture_header, timing_info_present_flag and initial_display_delay_present_flag, and
 * operating_points_cnt_minus_1 (5 bits), all 0 as the encoder is not asked for any; operating_point_idc
 * (12 bits), seq_level_idx (5 bits), and seq_tier for levels above 7. */
Bytes record(const VideoSettings &settings, const Bytes &, const Bytes &first) {
  for (const Obu &obu : obus_of(first.data(), first.size())) {
    if (obu.type != sequence_header) continue;
    if (bits(obu, 0, 12) != 0)
      throw Error(
          "the encoder gave an AV1 sequence header that is not of Main profile with one operating point");
    const unsigned level = bits(obu, 24, 5), tier = level > 7 ? bits(obu, 29, 1) : 0;
    const unsigned high_bitdepth = settings.bit_depth > 8;
    // Marker and version; profile and level; tier, depth, not monochrome, 4:2:0, chroma position unknown.
    Bytes out = {0x81, uint8_t(level), uint8_t(tier << 7 | high_bitdepth << 6 | 0x0c), 0};
    out.insert(out.end(), obu.begin, obu.end);
    return out;
  }
  throw Error("the encoder gave AV1 without a sequence header");
}

} // namespace

const Bitstream av1_bitstream = {sample, record};

} // namespace fvv::media
