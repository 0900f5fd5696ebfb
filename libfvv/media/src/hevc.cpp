/* HEVC. See bitstream.h. */
#include "bitstream.h"

#include "fvv_cxx/error.h"

namespace fvv::media {
namespace {

/* nal_unit_type, ITU-T H.265 table 7-1. */
constexpr unsigned vcl_last = 31, vps = 32, sps = 33, pps = 34;

unsigned type_of(uint8_t header) {
  return header >> 1 & 63u;
}

Bytes sample(const uint8_t *packet, size_t size) {
  Bytes out;
  append_units(out, annex_b_units(packet, size, [](uint8_t header) { return type_of(header) <= vcl_last; }),
               4);
  return out;
}

/* Without the emulation prevention bytes of clause 7.3.1.1. */
Bytes payload_of(const Bytes &unit) {
  Bytes out;
  for (size_t i = 0; i < unit.size(); i++)
    if (!(i >= 2 && unit[i] == 3 && unit[i - 1] == 0 && unit[i - 2] == 0)) out.push_back(unit[i]);
  return out;
}

/* ISO/IEC 14496-15 clause 8.3.3.1. An SPS opens with a 2-byte header, a byte that ends with
 * sps_max_sub_layers_minus1 (3 bits) and sps_temporal_id_nesting_flag, and the 12 bytes of
 * profile_tier_level that the record repeats. */
Bytes record(const VideoSettings &settings, const Bytes &header, const Bytes &) {
  std::vector<Bytes> sets[3];
  for (const unsigned type : {vps, sps, pps}) {
    sets[type - vps] =
        annex_b_units(header.data(), header.size(), [&](uint8_t first) { return type_of(first) == type; });
    only_set(sets[type - vps], 3, "parameter sets of HEVC of type " + std::to_string(type));
  }
  const Bytes sequence = payload_of(sets[sps - vps][0]);
  if (sequence.size() < 15)
    throw Error("the encoder gave an HEVC sequence parameter set of " + std::to_string(sequence.size()) +
                " bytes, expected at least 15");
  const unsigned layers = (sequence[2] >> 1 & 7u) + 1, nested = sequence[2] & 1u;
  Bytes out(sequence.begin() + 2, sequence.begin() + 15);
  out[0] = 1; // the version
  // No minimum of spatial segmentation; parallelism unknown; 4:2:0; depth of luma and chroma; frame rate not
  // said. Reserved bits are ones.
  const uint8_t depth = uint8_t(0xf8 | (settings.bit_depth - 8));
  out.insert(out.end(), {0xf0, 0, 0xfc, 0xfd, depth, depth, 0, 0});
  out.push_back(uint8_t(layers << 3 | nested << 2 | 3)); // 4-byte lengths
  out.push_back(3);
  for (const unsigned type : {vps, sps, pps}) {
    out.insert(out.end(), {uint8_t(0x80 | type), 0, 1}); // complete: none stands in samples
    append_units(out, sets[type - vps], 2);
  }
  return out;
}

} // namespace

const Bitstream hevc_bitstream = {sample, record};

} // namespace fvv::media
