/* Orientation in a JPEG file's Exif segment. Internal to fvv_media. */
#ifndef FVV_MEDIA_EXIF_H
#define FVV_MEDIA_EXIF_H

#include <cstddef>
#include <cstdint>

namespace fvv::media {

/* Tag 0x0112 of the first directory (CIPA DC-008 4.6.4 A), 1 to 8; 1, upright, when there is none or it
 * cannot be read. bytes: the beginning of a JPEG file, whatever it holds; never read behind size. */
uint8_t exif_orientation(const uint8_t *bytes, size_t size);

} // namespace fvv::media

#endif
