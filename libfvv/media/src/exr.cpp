#include "fvv_media/exr.h"

#include "codecs.h"
#include "exr_file.h"
#include "exr_memory.h"

#include <ImfChannelList.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>

#include <algorithm>
#include <new>

namespace fvv::media {
namespace {

/* Deflate makes at most 1032 bytes of one, and PXR24 widens 3 of those to 4. PIZ, B44 and RLE stay below. */
constexpr uint64_t most_per_byte = 1376;
/* DWA keeps a mean for 64 samples, half a byte a sample less, and deflates those; a block's tables bring that
 * down to some 10,000 for even pictures of the largest width. */
constexpr uint64_t most_per_byte_of_dwa = 16384;
/* Place of a block in the table, its coordinate and its length. */
constexpr uint64_t least_block = 16;

void check_channels(const FloatImage &image) {
  check_dimensions(image.width, image.height, "a picture");
  std::vector<std::string> names = image.channels;
  std::sort(names.begin(), names.end());
  const bool unlike = std::adjacent_find(names.begin(), names.end()) == names.end();
  const auto good = [](const std::string &name) {
    return !name.empty() && name.size() < 32 && name.find('\0') == std::string::npos;
  };
  if (names.empty() || !unlike || !std::all_of(names.begin(), names.end(), good))
    throw Error("a picture has channels that OpenEXR has no names for");
  const uint64_t size = uint64_t(image.width) * image.height * names.size();
  if (image.samples.size() != size)
    throw Error("a picture of " + std::to_string(image.width) + " x " + std::to_string(image.height) + " x " +
                std::to_string(names.size()) + " holds " + std::to_string(image.samples.size()) +
                " samples, expected " + std::to_string(size));
}

} // namespace

FloatImage decode_exr(const uint8_t *bytes, size_t size, const std::string &name, Dwa dwa) {
  if (!is_exr(bytes, size)) throw Error(name, size == 0 ? "is empty" : "is no OpenEXR file");
  const ExrHeader header = read_exr_header(bytes, size, name, dwa);
  check_justified(std::max(header.image_size, header.block_size),
                  header.is_dwa ? most_per_byte_of_dwa : most_per_byte, size, name);
  if (header.blocks > size / least_block)
    throw Error(name, "is cut or damaged: " + std::to_string(size) + " bytes cannot hold the " +
                          std::to_string(header.blocks) + " blocks that its header announces");
  FloatImage image;
  image.width = header.width;
  image.height = header.height;
  image.channels = header.chosen;
  image.samples.resize(size_t(header.width) * header.height * header.chosen.size());
  try {
    Source source(bytes, size);
    exr::InputFile file(source, 0);
    file.setFrameBuffer(
        slices<float>(image.channels, image.samples.data(), image.width, header.left, header.top));
    file.readPixels(header.top, header.top + int32_t(header.height - 1));
  } catch (const std::bad_alloc &) {
    throw;
  } catch (const std::exception &error) {
    throw Error(name, std::string("the OpenEXR file is cut or damaged: ") + error.what());
  }
  return image;
}

FloatImage decode_exr(const uint8_t *bytes, size_t size, const std::string &name) {
  return decode_exr(bytes, size, name, Dwa::refused);
}

FloatImage read_exr(const std::string &path) {
  const std::vector<uint8_t> bytes = read_file(path);
  return decode_exr(bytes.data(), bytes.size(), path);
}

std::vector<uint8_t> encode_exr(const FloatImage &image) {
  check_channels(image);
  return write_exr(image.channels, image.samples.data(), image.width, image.height, exr::ZIP_COMPRESSION);
}

} // namespace fvv::media
