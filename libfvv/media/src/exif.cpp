/* See exif.h. */
#include "exif.h"

#include <cstring>

namespace fvv::media {
namespace {

/* A TIFF structure, which says itself in which order its bytes are. */
struct Tiff {
  const uint8_t *bytes;
  size_t size;

  bool little() const { return bytes[0] == 'I'; }
  /* 0 behind the end. */
  uint32_t number(size_t offset, size_t length) const {
    if (offset > size || size - offset < length) return 0;
    uint32_t value = 0;
    for (size_t i = 0; i < length; i++) value = value << 8 | bytes[offset + (little() ? length - 1 - i : i)];
    return value;
  }
};

uint8_t orientation_in(const Tiff &tiff) {
  if (tiff.size < 8 || (memcmp(tiff.bytes, "II*\0", 4) && memcmp(tiff.bytes, "MM\0*", 4))) return 1;
  const size_t directory = tiff.number(4, 4);
  const uint32_t entries = tiff.number(directory, 2);
  for (uint32_t i = 0; i < entries; i++) {
    const size_t entry = directory + 2 + size_t(12) * i;
    constexpr uint32_t orientation = 0x0112, short_type = 3;
    if (tiff.number(entry, 2) != orientation || tiff.number(entry + 2, 2) != short_type) continue;
    const uint32_t value = tiff.number(entry + 8, 2);
    return value >= 1 && value <= 8 ? uint8_t(value) : 1;
  }
  return 1;
}

} // namespace

uint8_t exif_orientation(const uint8_t *bytes, size_t size) {
  constexpr uint8_t app1 = 0xe1, first_app = 0xe0, last_app = 0xef, comment = 0xfe;
  // Segments stand in front of the picture: marker, length with its own two bytes.
  for (size_t at = 2; at + 4 <= size && bytes[at] == 0xff;) {
    const uint8_t marker = bytes[at + 1];
    const size_t length = size_t(bytes[at + 2]) << 8 | bytes[at + 3];
    const size_t body = at + 4, end = at + 2 + length;
    if (length < 2 || end > size) break;
    if (marker == app1 && end - body > 6 && !memcmp(bytes + body, "Exif\0", 6))
      return orientation_in({bytes + body + 6, end - body - 6});
    if ((marker < first_app || marker > last_app) && marker != comment && (marker < 0xc0 || marker > 0xdf))
      break;
    at = end;
  }
  return 1;
}

} // namespace fvv::media
