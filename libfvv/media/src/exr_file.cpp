/* The header is read by OpenEXRCore, the C library below OpenEXR: it holds the sizes of attributes against
 * the file's before it allocates, which the C++ library does not. Samples are left to the C++ library
 * (exr.cpp): OpenEXRCore 3.1.5 mixes up the channels of RGBA in half precision, and gives wrong samples for
 * B44 with several float channels. */
#include "exr_file.h"

#include "codecs.h"

#include <openexr.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace fvv::media {
namespace {

/* Of one attribute: more than any that makes sense. */
constexpr size_t max_allocation = size_t(64) << 20;

void *allocate(size_t size) {
  return size <= max_allocation ? malloc(size) : nullptr;
}

/* What comes out of a file and goes into a message. */
std::string printable(const char *text) {
  std::string out;
  for (; *text && out.size() < 200; text++) out += *text >= ' ' && *text < 127 ? *text : '?';
  return out;
}

/* A context of OpenEXRCore over bytes in memory. */
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
  /* Error unless result is success, with OpenEXR's own first message if it gave one. */
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

/* "A, B, G, R" of what a message has room for. */
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

/* The chromaticities as text when they are not those of Rec.709 with D65. */
std::string other_chromaticities(const Context &file) {
  const exr_attribute_t *attribute = nullptr;
  // Absent: Rec.709, says OpenEXR.
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

/* Width, height and place of the picture; the data window must be the display window. */
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

} // namespace

bool is_exr(const uint8_t *bytes, size_t size) {
  return size >= 4 && bytes[0] == 0x76 && bytes[1] == 0x2f && bytes[2] == 0x31 && bytes[3] == 0x01;
}

ExrHeader read_exr_header(const uint8_t *bytes, size_t size, const std::string &name, Dwa dwa) {
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
  const bool is_dwa = compression == EXR_COMPRESSION_DWAA || compression == EXR_COMPRESSION_DWAB;
  if (is_dwa && dwa == Dwa::refused)
    throw Error(name, std::string("the OpenEXR file is compressed with DWA") +
                          (compression == EXR_COMPRESSION_DWAA ? "A" : "B") +
                          ", which does not decode to the same samples on every machine; expected another "
                          "compression");
  ExrHeader header;
  header.is_dwa = is_dwa;
  read_windows(file, name, header);
  read_channels(file, name, header);
  read_blocks(file, storage, header);
  header.chromaticities = other_chromaticities(file);
  return header;
}

} // namespace fvv::media
