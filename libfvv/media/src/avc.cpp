/* H.264. See bitstream.h. */
#include "bitstream.h"

namespace fvv::media {
namespace {

/* nal_unit_type, ITU-T H.264 table 7-1. */
enum class Nal : uint8_t { slice = 1, idr_slice = 5, sps = 7, pps = 8 };

Nal type_of(uint8_t header) {
  return Nal(header & 31);
}

std::vector<Bytes> units_of(const Bytes &annex_b, Nal type) {
  return annex_b_units(annex_b.data(), annex_b.size(),
                       [&](uint8_t header) { return type_of(header) == type; });
}

Bytes sample(const uint8_t *packet, size_t size) {
  Bytes out;
  append_units(out,
               annex_b_units(packet, size,
                             [](uint8_t header) {
                               return type_of(header) == Nal::slice || type_of(header) == Nal::idr_slice;
                             }),
               4);
  return out;
}

Bytes record(const VideoSettings &, const Bytes &header, const Bytes &) {
  const std::vector<Bytes> sequence = units_of(header, Nal::sps), picture = units_of(header, Nal::pps);
  const Bytes &sps = only_set(sequence, 4, "sequence parameter sets of H.264");
  only_set(picture, 2, "picture parameter sets of H.264");
  // Version; profile, compatibility, level; 4-byte lengths; how many sets. Reserved bits are ones.
  Bytes out = {1, sps[1], sps[2], sps[3], 0xff, 0xe1};
  append_units(out, sequence, 2);
  out.push_back(1);
  append_units(out, picture, 2);
  // From High profile on: 4:2:0, 8 bits, 8 bits, no extensions.
  if (sps[1] >= 100) out.insert(out.end(), {0xfd, 0xf8, 0xf8, 0});
  return out;
}

} // namespace

const Bitstream avc_bitstream = {sample, record};

} // namespace fvv::media
