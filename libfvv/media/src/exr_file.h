/* What the header of an OpenEXR file says, checked against what exr.h allows before a sample is asked for.
 * Internal to fvv_media. */
#ifndef FVV_MEDIA_EXR_FILE_H
#define FVV_MEDIA_EXR_FILE_H

#include "fvv_media/exr.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace fvv::media {

struct ExrHeader {
  uint32_t width = 0, height = 0;
  int32_t left = 0, top = 0;       /* of the data window */
  std::vector<std::string> chosen; /* R G B [A], Y [A] or Z */
  std::string chromaticities;      /* as text, when they are not those of Rec.709; else empty */
  uint64_t blocks = 0;             /* lines or tiles that are compressed together */
  uint64_t block_size = 0;         /* bytes of the largest, all channels, uncompressed */
  uint64_t image_size = 0;         /* bytes of the finest level, likewise */
  bool is_dwa = false;
};

/* Whether DWAA and DWAB may come: where decoders need not agree to the last bit. */
enum class Dwa { refused, allowed };

/* bytes may end anywhere behind the header. Error as decode_exr says, as far as the header tells. */
ExrHeader read_exr_header(const uint8_t *bytes, size_t size, const std::string &name, Dwa dwa = Dwa::refused);
/* decode_exr, with a word on DWA. */
FloatImage decode_exr(const uint8_t *bytes, size_t size, const std::string &name, Dwa dwa);

} // namespace fvv::media

#endif
