#include "fvvmux/picture_file.h"

#include "fvv/background.h"
#include "fvv_media/error.h"
#include "fvv_media/image.h"

#include <algorithm>

namespace fvv::mux {

namespace {

constexpr char png_signature[] = "\x89PNG\r\n\x1a\n";
constexpr int quality = 92;

uint32_t big_endian(const std::string &file, size_t at, int bytes) {
  uint32_t value = 0;
  for (int i = 0; i < bytes; i++) value = value << 8 | uint8_t(file[at + size_t(i)]);
  return value;
}

std::string clean_png(const std::string &file) {
  std::string out = file.substr(0, 8);
  size_t at = 8;
  while (at + 12 <= file.size()) {
    const uint64_t size = uint64_t(big_endian(file, at, 4)) + 12;
    if (size > file.size() - at) return file;
    const bool critical = file[at + 4] >= 'A' && file[at + 4] <= 'Z';
    if (critical || file.compare(at + 4, 4, "tRNS") == 0) out += file.substr(at, size_t(size));
    at += size_t(size);
  }
  return at == file.size() ? out : file;
}

// Up to the first scan; behind it there is nothing that tells of anything.
std::string clean_jpeg(const std::string &file) {
  std::string out = file.substr(0, 2);
  size_t at = 2;
  while (at + 4 <= file.size() && uint8_t(file[at]) == 0xff) {
    const uint8_t marker = uint8_t(file[at + 1]);
    if (marker == 0xff) {
      at++;
      continue;
    }
    if (marker == 0xda) return out + file.substr(at);
    const size_t size = 2 + big_endian(file, at + 2, 2);
    if (size > file.size() - at) return file;
    const bool application = marker >= 0xe0 && marker <= 0xef && marker != 0xe0 && marker != 0xee;
    if (!application && marker != 0xfe) out += file.substr(at, size);
    at += size;
  }
  return file;
}

} // namespace

std::string without_metadata(const std::string &file) {
  if (file.compare(0, 8, png_signature, 8) == 0) return clean_png(file);
  return file.size() > 2 && file.compare(0, 2, "\xff\xd8") == 0 ? clean_jpeg(file) : file;
}

FittedPicture fit_picture(const std::string &file, const std::string &name) {
  FittedPicture out = {without_metadata(file)};
  fvv_background_picture entry = {};
  entry.data = reinterpret_cast<const uint8_t *>(out.file.data());
  entry.size = out.file.size();
  fvv_diagnostic diagnostic = {};
  if (fvv_background_picture_inspect(&entry, &diagnostic) != FVV_OK)
    throw media::Error(name + ": " + diagnostic.message);
  out.width = entry.width;
  out.height = entry.height;
  // Decoded in any case: a picture that does not decode would be noticed by whoever plays the stream.
  const media::Image image = media::decode_image(entry.data, entry.size, 3, name);
  const uint32_t side = std::max(out.width, out.height);
  if (side <= max_picture_side) return out;
  const auto shorter = [&](uint32_t length) {
    return std::max<uint32_t>(1, uint32_t(uint64_t(length) * max_picture_side / side));
  };
  out.width = shorter(out.width);
  out.height = shorter(out.height);
  const std::vector<uint8_t> bytes =
      media::encode_jpeg(media::scale(image, out.width, out.height), quality, media::Subsampling::yuv420);
  out.file.assign(bytes.begin(), bytes.end());
  out.scaled = true;
  return out;
}

} // namespace fvv::mux
