/* See nal.h. */
#include "nal.h"

#include "fvv_cxx/error.h"

#include <algorithm>

namespace fvv::media {

/* ITU-T H.264 clause B.1, H.265 clause B.2: units stand between start codes 00 00 01; zeros in front of one
 * belong to no unit. */
std::vector<Bytes> annex_b_units(const uint8_t *bytes, size_t size,
                                 const std::function<bool(uint8_t)> &keep) {
  std::vector<Bytes> units;
  const uint8_t start[] = {0, 0, 1};
  const uint8_t *const end = bytes + size;
  const uint8_t *code = std::search(bytes, end, start, start + 3);
  while (code != end) {
    const uint8_t *unit = code + 3;
    code = std::search(unit, end, start, start + 3);
    const uint8_t *last = code;
    while (last > unit && last[-1] == 0) last--;
    if (last > unit && keep(unit[0])) units.emplace_back(unit, last);
  }
  return units;
}

void append_units(Bytes &out, const std::vector<Bytes> &units, unsigned length_bytes) {
  for (const Bytes &unit : units) {
    for (unsigned i = length_bytes; i-- > 0;) out.push_back(uint8_t(uint64_t(unit.size()) >> 8 * i));
    out.insert(out.end(), unit.begin(), unit.end());
  }
}

const Bytes &only_set(const std::vector<Bytes> &sets, size_t least, const std::string &name) {
  if (sets.size() != 1 || sets[0].size() < least || sets[0].size() > 0xffff)
    throw Error("the encoder gave " + std::to_string(sets.size()) + " " + name +
                ", expected one, of at least " + std::to_string(least) + " bytes");
  return sets[0];
}

} // namespace fvv::media
