/* See avc.h. */
#include "avc.h"

#include "fvv_media/error.h"

#include <algorithm>
#include <cstdio>
#include <functional>

namespace fvv::media {
namespace {

Nal type_of(uint8_t header) {
  return Nal(header & 31);
}

using OnUnit = std::function<void(const uint8_t *unit, size_t size)>;

/* ITU-T H.264 clause B.1: units stand between start codes 00 00 01; zeros in front of one belong to no unit.
 */
void for_each_unit(const uint8_t *bytes, size_t size, const OnUnit &on_unit) {
  const uint8_t start[] = {0, 0, 1};
  const uint8_t *const end = bytes + size;
  const uint8_t *code = std::search(bytes, end, start, start + 3);
  while (code != end) {
    const uint8_t *unit = code + 3;
    code = std::search(unit, end, start, start + 3);
    const uint8_t *last = code;
    while (last > unit && last[-1] == 0) last--;
    if (last > unit) on_unit(unit, size_t(last - unit));
  }
}

void append(std::vector<uint8_t> &out, const uint8_t *unit, size_t size) {
  out.insert(out.end(), unit, unit + size);
}

void append_parameter_set(std::vector<uint8_t> &out, const std::vector<uint8_t> &set) {
  out.push_back(uint8_t(set.size() >> 8));
  out.push_back(uint8_t(set.size()));
  append(out, set.data(), set.size());
}

} // namespace

std::vector<uint8_t> avc_sample(const uint8_t *annex_b, size_t size) {
  std::vector<uint8_t> out;
  for_each_unit(annex_b, size, [&](const uint8_t *unit, size_t length) {
    const Nal type = type_of(unit[0]);
    if (type != Nal::slice && type != Nal::idr_slice) return;
    for (int shift = 24; shift >= 0; shift -= 8) out.push_back(uint8_t(uint64_t(length) >> shift));
    append(out, unit, length);
  });
  return out;
}

std::vector<uint8_t> avc_record(const uint8_t *annex_b, size_t size) {
  std::vector<std::vector<uint8_t>> sequence, picture;
  for_each_unit(annex_b, size, [&](const uint8_t *unit, size_t length) {
    if (type_of(unit[0]) == Nal::sps) sequence.emplace_back(unit, unit + length);
    if (type_of(unit[0]) == Nal::pps) picture.emplace_back(unit, unit + length);
  });
  if (sequence.size() != 1 || picture.size() != 1 || sequence[0].size() < 4 || sequence[0].size() > 0xffff ||
      picture[0].size() > 0xffff)
    throw Error("the H.264 encoder gave " + std::to_string(sequence.size()) + " sequence and " +
                std::to_string(picture.size()) + " picture parameter sets, expected one of each");
  const std::vector<uint8_t> &sps = sequence[0];
  // Version; profile, compatibility, level; 4-byte lengths; how many sets. Reserved bits are ones.
  std::vector<uint8_t> record = {1, sps[1], sps[2], sps[3], 0xff, 0xe1};
  append_parameter_set(record, sps);
  record.push_back(1);
  append_parameter_set(record, picture[0]);
  // From High profile on: 4:2:0, 8 bits, 8 bits, no extensions.
  if (sps[1] >= 100) record.insert(record.end(), {0xfd, 0xf8, 0xf8, 0});
  return record;
}

std::string avc_codec_string(const std::vector<uint8_t> &record) {
  char text[16];
  snprintf(text, sizeof text, "avc1.%02x%02x%02x", record.at(1), record.at(2), record.at(3));
  return text;
}

void avc_check_record(const uint8_t *record, size_t size) {
  if (size < 7) throw Error("the avc1 record has " + std::to_string(size) + " bytes, expected at least 7");
  if (record[0] != 1)
    throw Error("the avc1 record has version " + std::to_string(record[0]) + ", expected 1");
  if ((record[4] & 3) != 3)
    throw Error("the avc1 record announces lengths of " + std::to_string((record[4] & 3) + 1) +
                " bytes, expected 4");
}

bool avc_check_sample(const uint8_t *sample, size_t size) {
  if (size == 0) throw Error("the avc1 sample is empty");
  bool idr = false;
  for (size_t at = 0; at < size;) {
    const size_t left = size - at;
    uint32_t length = 0;
    for (size_t i = 0; i < 4 && i < left; i++) length = length << 8 | sample[at + i];
    if (left < 5 || length == 0 || length > left - 4)
      throw Error("the NAL unit lengths of an avc1 sample do not fill it: at byte " + std::to_string(at) +
                  " of " + std::to_string(size));
    idr = idr || type_of(sample[at + 4]) == Nal::idr_slice;
    at += 4 + size_t(length);
  }
  return idr;
}

} // namespace fvv::media
