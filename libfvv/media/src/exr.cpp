// OpenEXR. OpenEXRCore, the C library below OpenEXR, reads headers: it checks the sizes of attributes against
// the file's before it allocates, which the C++ library does not. The C++ library reads samples: OpenEXRCore
// 3.1.5 mixes up the channels of RGBA in half precision, and gives wrong samples for B44 with several float
// channels.
#include "fvv_media/exr.h"

#include "codecs.h"
#include "fvv_cxx/error.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <half.h>
#include <openexr.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace fvv::media {

namespace {

namespace exr = OPENEXR_IMF_NAMESPACE;

// Bytes in memory as OpenEXR reads them.
class Source : public exr::IStream {
public:
  Source(const uint8_t *bytes, size_t size) : IStream("memory"), bytes_(bytes), size_(size) {}
  bool read(char out[], int wanted) override {
    if (wanted < 0 || position_ > size_ || uint64_t(wanted) > size_ - position_)
      throw std::runtime_error("the file ends early");
    memcpy(out, bytes_ + position_, size_t(wanted));
    position_ += uint64_t(wanted);
    return position_ < size_;
  }
  uint64_t tellg() override { return position_; }
  void seekg(uint64_t position) override { position_ = position; }

private:
  const uint8_t *bytes_;
  uint64_t size_, position_ = 0;
};

// Bytes in memory as OpenEXR writes them: blocks one after the other, then the table before them.
class Sink : public exr::OStream {
public:
  Sink() : OStream("memory") {}
  void write(const char in[], int size) override {
    const size_t end = position_ + size_t(size);
    if (end > bytes.size()) bytes.resize(end);
    memcpy(bytes.data() + position_, in, size_t(size));
    position_ = end;
  }
  uint64_t tellp() override { return position_; }
  void seekp(uint64_t position) override { position_ = size_t(position); }

  std::vector<uint8_t> bytes;

private:
  size_t position_ = 0;
};

// The channels of samples, half or float, that are interleaved, the first of which is that of pixel (left,
// top).
template <class Sample>
exr::FrameBuffer slices(const std::vector<std::string> &channels, Sample *samples, uint32_t width,
                        int32_t left, int32_t top) {
  constexpr exr::PixelType type = sizeof(Sample) == 2 ? exr::HALF : exr::FLOAT;
  const size_t pixel = channels.size() * sizeof(Sample), line = pixel * width;
  // OpenEXR counts from pixel (0, 0), which need not be in the image: an address, not a pointer.
  uintptr_t origin = reinterpret_cast<uintptr_t>(samples);
  origin -= uintptr_t(intptr_t(left) * intptr_t(pixel) + intptr_t(top) * intptr_t(line));
  exr::FrameBuffer buffer;
  for (size_t i = 0; i < channels.size(); i++)
    buffer.insert(channels[i],
                  exr::Slice(type, reinterpret_cast<char *>(origin + i * sizeof(Sample)), pixel, line));
  return buffer;
}

// A whole file of interleaved samples, half or float.
template <class Sample>
std::vector<uint8_t> write_exr(const std::vector<std::string> &channels, const Sample *samples,
                               uint32_t width, uint32_t height, exr::Compression compression) {
  try {
    exr::Header header{int(width), int(height)};
    header.compression() = compression;
    const exr::Channel channel(sizeof(Sample) == 2 ? exr::HALF : exr::FLOAT);
    for (const std::string &name : channels) header.channels().insert(name, channel);
    Sink sink;
    {
      exr::OutputFile file(sink, header, 0);
      // OpenEXR uses its buffers for reading and writing, so they are not const; writing does not change
      // them.
      file.setFrameBuffer(slices<Sample>(channels, const_cast<Sample *>(samples), width, 0, 0));
      file.writePixels(int(height));
    } // writes the table of blocks
    return std::move(sink.bytes);
  } catch (const std::bad_alloc &) {
    throw;
  } catch (const std::exception &error) {
    throw Error(std::string("a picture cannot be written as OpenEXR: ") + error.what());
  }
}

struct ExrHeader {
  uint32_t width = 0, height = 0;
  int32_t left = 0, top = 0;       // of the data window
  std::vector<std::string> chosen; // R G B [A], Y [A] or Z
  std::string chromaticities;      // as text, when they are not those of Rec.709; else empty
  uint64_t blocks = 0;             // lines or tiles that are compressed together
  uint64_t block_size = 0;         // bytes of the largest, all channels, uncompressed
  uint64_t image_size = 0;         // bytes of the finest level, likewise
};

// bytes may end anywhere after the header. Errors are those of decode_exr that the header shows.
ExrHeader read_exr_header(const uint8_t *bytes, size_t size, const std::string &name);

// Of one attribute: more than any real one needs.
constexpr size_t max_allocation = size_t(64) << 20;

void *allocate(size_t size) {
  return size <= max_allocation ? malloc(size) : nullptr;
}

// Text of a file for a message.
std::string printable(const char *text) {
  std::string out;
  for (; *text && out.size() < 200; text++) out += *text >= ' ' && *text < 127 ? *text : '?';
  return out;
}

// A context of OpenEXRCore over bytes in memory.
class Context {
public:
  Context(const uint8_t *bytes, size_t size, const std::string &name)
      : bytes_(bytes), size_(size), name_(name) {
    exr_context_initializer_t wanted = EXR_DEFAULT_CONTEXT_INITIALIZER;
    wanted.error_handler_fn = on_error;
    wanted.alloc_fn = allocate;
    wanted.free_fn = free;
    wanted.user_data = this;
    wanted.size_fn = on_size;
    wanted.read_fn = on_read;
    wanted.max_tile_width = wanted.max_tile_height = int(max_dimension);
    wanted.flags = EXR_CONTEXT_FLAG_STRICT_HEADER;
    check(exr_start_read(&context_, "picture", &wanted));
  }
  ~Context() { exr_finish(&context_); }
  Context(const Context &) = delete;
  Context &operator=(const Context &) = delete;

  exr_context_t get() const { return context_; }
  // Error unless result is success, with OpenEXR's own first message if it gave one.
  void check(exr_result_t result) const {
    if (result == EXR_ERR_SUCCESS) return;
    throw Error(name_, "the OpenEXR file is cut or damaged: " +
                           (message_.empty() ? exr_get_default_error_message(result) : message_));
  }

private:
  static void on_error(exr_const_context_t context, exr_result_t, const char *message) {
    void *user = nullptr;
    if (exr_get_user_data(context, &user) != EXR_ERR_SUCCESS || !user) return;
    std::string &first = static_cast<Context *>(user)->message_;
    if (first.empty()) first = printable(message);
  }
  static int64_t on_size(exr_const_context_t, void *user) {
    return int64_t(static_cast<const Context *>(user)->size_);
  }
  static int64_t on_read(exr_const_context_t, void *user, void *out, uint64_t wanted, uint64_t offset,
                         exr_stream_error_func_ptr_t) {
    const auto *self = static_cast<const Context *>(user);
    if (offset >= self->size_) return 0;
    const size_t got = size_t(std::min<uint64_t>(wanted, self->size_ - offset));
    memcpy(out, self->bytes_ + offset, got);
    return int64_t(got);
  }

  const uint8_t *bytes_;
  size_t size_;
  const std::string &name_;
  exr_context_t context_ = nullptr;
  std::string message_;
};

const exr_attr_chlist_entry_t *find(const exr_attr_chlist_t &channels, const char *name) {
  for (int i = 0; i < channels.num_channels; i++)
    if (std::string(channels.entries[i].name.str) == name) return &channels.entries[i];
  return nullptr;
}

// "A, B, G, R", as far as a message has room.
std::string list(const exr_attr_chlist_t &channels) {
  std::string text;
  for (int i = 0; i < channels.num_channels; i++) {
    if (i == 8) return text + ", ...";
    text += i ? ", " : "";
    text += printable(channels.entries[i].name.str);
  }
  return text.empty() ? "none" : text;
}

std::vector<std::string> choose(const exr_attr_chlist_t &channels, const std::string &name) {
  std::vector<std::string> chosen;
  if (find(channels, "R") && find(channels, "G") && find(channels, "B"))
    chosen = {"R", "G", "B"};
  else if (find(channels, "Y") && !find(channels, "RY") && !find(channels, "BY"))
    chosen = {"Y"};
  else if (find(channels, "Z"))
    return {"Z"};
  else
    throw Error(name, "has the channels " + list(channels) + ", expected R, G and B, or Y, or Z");
  if (find(channels, "A")) chosen.push_back("A");
  return chosen;
}

void check_channel(const exr_attr_chlist_entry_t &channel, const std::string &name) {
  const std::string subject = std::string("channel ") + channel.name.str + " of the OpenEXR file ";
  if (channel.pixel_type != EXR_PIXEL_HALF && channel.pixel_type != EXR_PIXEL_FLOAT)
    throw Error(name, subject + "has integers, expected half or float");
  if (channel.x_sampling != 1 || channel.y_sampling != 1)
    throw Error(name, subject + "is subsampled " + std::to_string(channel.x_sampling) + " x " +
                          std::to_string(channel.y_sampling) + ", expected a sample for every pixel");
}

std::string text(const exr_attr_box2i_t &box) {
  return "(" + std::to_string(box.min.x) + ", " + std::to_string(box.min.y) + ") to (" +
         std::to_string(box.max.x) + ", " + std::to_string(box.max.y) + ")";
}

// The chromaticities as text when they are not those of Rec.709 with D65.
std::string other_chromaticities(const Context &file) {
  const exr_attribute_t *attribute = nullptr;
  // Absent: OpenEXR's default, Rec.709.
  if (exr_get_attribute_by_name(file.get(), 0, "chromaticities", &attribute) != EXR_ERR_SUCCESS) return "";
  exr_attr_chromaticities_t found;
  file.check(exr_attr_get_chromaticities(file.get(), 0, "chromaticities", &found));
  const float values[8] = {found.red_x,  found.red_y,  found.green_x, found.green_y,
                           found.blue_x, found.blue_y, found.white_x, found.white_y};
  constexpr double rec709[8] = {0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290};
  // Writers round the white point to three or four digits.
  const auto near = [](float a, double b) { return std::abs(a - b) < 1e-3; };
  if (std::equal(values, values + 8, rec709, near)) return "";
  char text[160];
  snprintf(text, sizeof text, "(%.4g, %.4g) (%.4g, %.4g) (%.4g, %.4g) white (%.4g, %.4g)", values[0],
           values[1], values[2], values[3], values[4], values[5], values[6], values[7]);
  return text;
}

// Width, height and place of the picture; the data window must be the display window.
void read_windows(const Context &file, const std::string &name, ExrHeader &header) {
  exr_attr_box2i_t data, display;
  file.check(exr_get_data_window(file.get(), 0, &data));
  file.check(exr_get_display_window(file.get(), 0, &display));
  const int64_t width = int64_t(data.max.x) - data.min.x + 1, height = int64_t(data.max.y) - data.min.y + 1;
  constexpr int64_t beyond = int64_t(max_dimension) + 1;
  check_dimensions(uint32_t(std::clamp<int64_t>(width, 0, beyond)),
                   uint32_t(std::clamp<int64_t>(height, 0, beyond)), name);
  if (data.min.x != display.min.x || data.min.y != display.min.y || data.max.x != display.max.x ||
      data.max.y != display.max.y)
    throw Error(name, "the OpenEXR file has the data window " + text(data) +
                          ", expected the display window " + text(display));
  header.width = uint32_t(width);
  header.height = uint32_t(height);
  header.left = data.min.x;
  header.top = data.min.y;
}

void read_channels(const Context &file, const std::string &name, ExrHeader &header) {
  const exr_attr_chlist_t *channels = nullptr;
  file.check(exr_get_channels(file.get(), 0, &channels));
  header.chosen = choose(*channels, name);
  for (const std::string &chosen : header.chosen) check_channel(*find(*channels, chosen.c_str()), name);
  uint64_t pixel_size = 0; // were no channel subsampled
  for (int i = 0; i < channels->num_channels; i++)
    pixel_size += channels->entries[i].pixel_type == EXR_PIXEL_HALF ? 2 : 4;
  header.image_size = pixel_size * header.width * header.height;
}

void read_blocks(const Context &file, exr_storage_t storage, ExrHeader &header) {
  int32_t count = 0, width = int32_t(header.width), height = 0;
  file.check(exr_get_chunk_count(file.get(), 0, &count));
  if (storage == EXR_STORAGE_TILED)
    file.check(exr_get_tile_sizes(file.get(), 0, 0, 0, &width, &height));
  else
    file.check(exr_get_scanlines_per_chunk(file.get(), 0, &height));
  header.blocks = uint64_t(std::max(count, 0));
  const uint64_t pixels = uint64_t(header.width) * header.height;
  header.block_size =
      header.image_size / pixels * uint64_t(std::max(width, 0)) * uint64_t(std::max(height, 0));
}

ExrHeader read_exr_header(const uint8_t *bytes, size_t size, const std::string &name) {
  const Context file(bytes, size, name);
  int parts = 0;
  file.check(exr_get_count(file.get(), &parts));
  if (parts != 1) throw Error(name, "the OpenEXR file has " + std::to_string(parts) + " parts, expected 1");
  exr_storage_t storage;
  file.check(exr_get_storage(file.get(), 0, &storage));
  if (storage != EXR_STORAGE_SCANLINE && storage != EXR_STORAGE_TILED)
    throw Error(name, "the OpenEXR file has deep data, expected scan lines or tiles");
  exr_compression_t compression;
  file.check(exr_get_compression(file.get(), 0, &compression));
  if (compression == EXR_COMPRESSION_DWAA || compression == EXR_COMPRESSION_DWAB)
    throw Error(name, std::string("the OpenEXR file is compressed with DWA") +
                          (compression == EXR_COMPRESSION_DWAA ? "A" : "B") +
                          ", which does not decode to the same samples on every machine; expected another "
                          "compression");
  ExrHeader header;
  read_windows(file, name, header);
  read_channels(file, name, header);
  read_blocks(file, storage, header);
  header.chromaticities = other_chromaticities(file);
  return header;
}

// Deflate makes at most 1032 bytes of one, and PXR24 widens 3 of those to 4. PIZ, B44 and RLE stay below.
constexpr uint64_t most_per_byte = 1376;
// Place of a block in the table, its coordinate and its length.
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

bool is_exr(const uint8_t *bytes, size_t size) {
  return size >= 4 && bytes[0] == 0x76 && bytes[1] == 0x2f && bytes[2] == 0x31 && bytes[3] == 0x01;
}

FloatImage decode_exr(const uint8_t *bytes, size_t size, const std::string &name) {
  if (!is_exr(bytes, size)) throw Error(name, size == 0 ? "is empty" : "is no OpenEXR file");
  const ExrHeader header = read_exr_header(bytes, size, name);
  check_justified(std::max(header.image_size, header.block_size), most_per_byte, size, name);
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

FloatImage read_exr(const std::string &path) {
  const std::vector<uint8_t> bytes = read_file(path);
  return decode_exr(bytes.data(), bytes.size(), path);
}

std::vector<uint8_t> encode_exr(const FloatImage &image) {
  check_channels(image);
  return write_exr(image.channels, image.samples.data(), image.width, image.height, exr::ZIP_COMPRESSION);
}

namespace {

const std::vector<std::string> rgb = {"R", "G", "B"};

int picture_channels(const std::vector<std::string> &channels, const std::string &name) {
  if (channels[0] == "Z") throw Error(name, "has the depth channel Z alone, expected R, G and B, or Y");
  return channels[0] == "R" ? 3 : 1;
}

// The first channels, without A.
LinearImage picture_of(FloatImage &&file, int channels) {
  LinearImage image;
  image.width = file.width;
  image.height = file.height;
  image.channels = channels;
  const size_t count = file.channels.size(), pixels = size_t(file.width) * file.height;
  if (count == size_t(channels)) {
    image.pixels = std::move(file.samples);
    return image;
  }
  image.pixels.reserve(pixels * size_t(channels));
  for (size_t i = 0; i < pixels; i++)
    for (size_t c = 0; c < size_t(channels); c++) image.pixels.push_back(file.samples[i * count + c]);
  return image;
}

} // namespace

ImageInfo probe_exr(const uint8_t *bytes, size_t size, const std::string &name) {
  const ExrHeader header = read_exr_header(bytes, size, name);
  if (!header.chromaticities.empty())
    throw Error(name, "the OpenEXR file has the chromaticities " + header.chromaticities +
                          ", expected Rec.709: (0.64, 0.33) (0.3, 0.6) (0.15, 0.06) white (0.3127, 0.329)");
  return {header.width, header.height, picture_channels(header.chosen, name), ImageFormat::exr};
}

template <class Sample>
BasicImage<Sample> decode_exr_picture(const uint8_t *bytes, size_t size, const std::string &name) {
  const int channels = probe_exr(bytes, size, name).channels;
  LinearImage image = picture_of(decode_exr(bytes, size, name), channels);
  check_finite(image, name);
  if constexpr (std::is_same_v<Sample, float>)
    return image;
  else
    return display_of<Sample>(image);
}

template Image decode_exr_picture(const uint8_t *bytes, size_t size, const std::string &name);
template DeepImage decode_exr_picture(const uint8_t *bytes, size_t size, const std::string &name);
template LinearImage decode_exr_picture(const uint8_t *bytes, size_t size, const std::string &name);

void check_halves(const LinearImage &image, const std::string &name) {
  check_image(image);
  check_finite(image, name);
  const auto found = std::find_if(image.pixels.begin(), image.pixels.end(),
                                  [](float value) { return !Imath::half(value).isFinite(); });
  if (found == image.pixels.end()) return;
  const size_t index = size_t(found - image.pixels.begin()), channels = size_t(image.channels);
  const size_t pixel = index / channels;
  char value[40];
  snprintf(value, sizeof value, "%g", double(*found));
  throw Error(name, "channel " + (channels == 1 ? "Y" : rgb[index % channels]) + " of pixel (" +
                        std::to_string(pixel % image.width) + ", " + std::to_string(pixel / image.width) +
                        ") is " + value + ", expected -65504 to 65504, which half floats hold");
}

std::vector<uint8_t> encode_half_exr(const LinearImage &image) {
  check_halves(image, "a picture");
  if (image.channels != 3) throw Error("a grey picture came where an RGB picture was expected");
  std::vector<Imath::half> samples(image.pixels.begin(), image.pixels.end());
  return write_exr(rgb, samples.data(), image.width, image.height, exr::PIZ_COMPRESSION);
}

} // namespace fvv::media
