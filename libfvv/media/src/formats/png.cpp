// PNG by libpng. libpng reports errors by longjmp, so no object with a destructor lives in a function that
// calls setjmp.
#include "media/src/codecs.h"

#include <png.h>
#include <zlib.h>

#include <csetjmp>
#include <cstdio>
#include <cstring>
#include <new>
#include <utility>

namespace fvv::media {
namespace {

// Samples of 16 bits are big-endian in the file.
void swap_if_needed(png_structp png) {
  const uint16_t one = 1;
  if (*reinterpret_cast<const uint8_t *>(&one)) png_set_swap(png);
}

class PngReader {
public:
  PngReader(const uint8_t *bytes, size_t size, const std::string &name)
      : bytes_(bytes), size_(size), name_(name) {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, on_error, on_warning);
    if (png_) info_ = png_create_info_struct(png_);
    if (!info_) {
      png_destroy_read_struct(&png_, nullptr, nullptr);
      throw std::bad_alloc();
    }
    png_set_read_fn(png_, this, on_read);
    // Sizes are checked by check_dimensions, with a better message; compressed text and profiles are limited
    // here.
    png_set_user_limits(png_, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
    png_set_chunk_malloc_max(png_, 8000000);
  }
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngReader(const PngReader &) = delete;
  PngReader &operator=(const PngReader &) = delete;

  ImageInfo header() {
    if (!read_header()) fail();
    const uint32_t width = png_get_image_width(png_, info_), height = png_get_image_height(png_, info_);
    check_dimensions(width, height, name_);
    return {width, height, png_get_color_type(png_, info_) & PNG_COLOR_MASK_COLOR ? 3 : 1, ImageFormat::png};
  }

  template <class Sample> BasicImage<Sample> picture() {
    const ImageInfo info = header();
    // Deflate makes at most 1032 bytes of one.
    const uint64_t packed = uint64_t(png_get_rowbytes(png_, info_)) * info.height;
    check_justified(packed, 1032, size_, name_);
    BasicImage<Sample> image = make_image<Sample>(info.width, info.height, info.channels, 0);
    const size_t stride = size_t(info.width) * size_t(info.channels) * sizeof(Sample);
    if (!read_rows(reinterpret_cast<uint8_t *>(image.pixels.data()), stride, info.height, sizeof(Sample) > 1))
      fail();
    return image;
  }

  RgbaImage rgba() {
    const ImageInfo info = header();
    check_justified(uint64_t(png_get_rowbytes(png_, info_)) * info.height, 1032, size_, name_);
    RgbaImage out = {info.width,
                     info.height,
                     (png_get_color_type(png_, info_) & PNG_COLOR_MASK_ALPHA) != 0 ||
                         png_get_valid(png_, info_, PNG_INFO_tRNS) != 0,
                     {}};
    out.pixels.resize(size_t(4) * info.width * info.height);
    if (!read_rows(reinterpret_cast<uint8_t *>(out.pixels.data()), size_t(8) * info.width, info.height, true,
                   true))
      fail();
    return out;
  }

private:
  static void on_error(png_structp png, png_const_charp message) {
    auto *self = static_cast<PngReader *>(png_get_error_ptr(png));
    snprintf(self->message_, sizeof self->message_, "%s", message);
    png_longjmp(png, 1);
  }
  // Warnings are about ancillary chunks; damage to the picture itself is an error.
  static void on_warning(png_structp, png_const_charp) {}
  static void on_read(png_structp png, png_bytep out, size_t wanted) {
    auto *self = static_cast<PngReader *>(png_get_io_ptr(png));
    if (wanted > self->size_ - self->position_) {
      self->position_ = self->size_;
      self->cut_ = true;
      png_error(png, "the file ends early");
    }
    memcpy(out, self->bytes_ + self->position_, wanted);
    self->position_ += wanted;
  }

  [[noreturn]] void fail() const {
    const std::string at = " byte " + std::to_string(position_);
    if (cut_) throw Error(name_, "the PNG file is cut at" + at);
    throw Error(name_, "the PNG file is damaged before" + at + ": " + message_);
  }

  bool read_header() {
    if (setjmp(png_jmpbuf(png_))) return false;
    png_read_info(png_, info_);
    return true;
  }

  bool read_rows(uint8_t *pixels, size_t stride, uint32_t height, bool deep, bool with_alpha = false) {
    if (setjmp(png_jmpbuf(png_))) return false;
    const int type = png_get_color_type(png_, info_);
    if (type == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png_);
    if (type == PNG_COLOR_TYPE_GRAY) png_set_expand_gray_1_2_4_to_8(png_);
    if (deep) {
      png_set_expand_16(png_);
      swap_if_needed(png_);
    } else {
      png_set_scale_16(png_);
    }
    if (with_alpha) {
      png_set_tRNS_to_alpha(png_);
      png_set_gray_to_rgb(png_);
      png_set_add_alpha(png_, 0xffff, PNG_FILLER_AFTER);
    } else {
      png_set_strip_alpha(png_);
    }
    const int passes = png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    if (png_get_rowbytes(png_, info_) != stride) png_error(png_, "unexpected length of a row");
    for (int pass = 0; pass < passes; pass++)
      for (uint32_t row = 0; row < height; row++) png_read_row(png_, pixels + row * stride, nullptr);
    // To IEND, whose absence is the only sign of a file that was cut after its last row.
    png_read_end(png_, nullptr);
    return true;
  }

  const uint8_t *bytes_;
  size_t size_, position_ = 0;
  const std::string &name_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  bool cut_ = false;
  char message_[160] = "";
};

class PngWriter {
public:
  explicit PngWriter(PngEffort effort) : effort_(effort) {
    png_ = png_create_write_struct(PNG_LIBPNG_VER_STRING, this, on_error, on_warning);
    if (png_) info_ = png_create_info_struct(png_);
    if (!info_) {
      png_destroy_write_struct(&png_, nullptr);
      throw std::bad_alloc();
    }
    png_set_write_fn(png_, this, on_write, on_flush);
  }
  ~PngWriter() { png_destroy_write_struct(&png_, &info_); }
  PngWriter(const PngWriter &) = delete;
  PngWriter &operator=(const PngWriter &) = delete;

  template <class Sample> std::vector<uint8_t> file(const BasicImage<Sample> &image) {
    const size_t stride = size_t(image.width) * size_t(image.channels) * sizeof(Sample);
    if (!write(reinterpret_cast<const uint8_t *>(image.pixels.data()), stride, image.width, image.height,
               8 * int(sizeof(Sample)), image.channels == 1 ? PNG_COLOR_TYPE_GRAY : PNG_COLOR_TYPE_RGB))
      throw Error(std::string("a picture cannot be written as PNG: ") + message_);
    return std::move(bytes_);
  }

private:
  static void on_error(png_structp png, png_const_charp message) {
    auto *self = static_cast<PngWriter *>(png_get_error_ptr(png));
    snprintf(self->message_, sizeof self->message_, "%s", message);
    png_longjmp(png, 1);
  }
  static void on_warning(png_structp, png_const_charp) {}
  // No exception may pass through libpng.
  static void on_write(png_structp png, png_bytep bytes, size_t size) {
    auto *self = static_cast<PngWriter *>(png_get_io_ptr(png));
    if (!self->append(bytes, size)) png_error(png, "there is not enough memory");
  }
  static void on_flush(png_structp) {}

  bool append(const uint8_t *bytes, size_t size) {
    try {
      bytes_.insert(bytes_.end(), bytes, bytes + size);
      return true;
    } catch (const std::bad_alloc &) {
      return false;
    }
  }

  bool write(const uint8_t *pixels, size_t stride, uint32_t width, uint32_t height, int bits, int type) {
    if (setjmp(png_jmpbuf(png_))) return false;
    png_set_IHDR(png_, info_, width, height, bits, type, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(png_, info_, PNG_sRGB_INTENT_PERCEPTUAL);
    if (effort_ == PngEffort::fast) {
      png_set_filter(png_, PNG_FILTER_TYPE_DEFAULT, PNG_FILTER_PAETH);
      png_set_compression_level(png_, Z_BEST_SPEED);
      png_set_compression_strategy(png_, Z_RLE);
    }
    png_write_info(png_, info_);
    if (bits == 16) swap_if_needed(png_);
    for (uint32_t row = 0; row < height; row++) png_write_row(png_, pixels + row * stride);
    png_write_end(png_, nullptr);
    return true;
  }

  const PngEffort effort_;
  std::vector<uint8_t> bytes_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  char message_[160] = "";
};

} // namespace

bool is_png(const uint8_t *bytes, size_t size) {
  return size >= 8 && png_sig_cmp(bytes, 0, 8) == 0;
}

ImageInfo probe_png(const uint8_t *bytes, size_t size, const std::string &name) {
  return PngReader(bytes, size, name).header();
}

template <class Sample>
BasicImage<Sample> decode_png(const uint8_t *bytes, size_t size, const std::string &name) {
  return PngReader(bytes, size, name).picture<Sample>();
}

RgbaImage decode_png_rgba(const uint8_t *bytes, size_t size, const std::string &name) {
  return PngReader(bytes, size, name).rgba();
}

template <class Sample> std::vector<uint8_t> encode_png(const BasicImage<Sample> &image, PngEffort effort) {
  check_image(image);
  PngWriter writer(effort);
  return writer.file(image);
}

template Image decode_png(const uint8_t *, size_t, const std::string &);
template DeepImage decode_png(const uint8_t *, size_t, const std::string &);
template std::vector<uint8_t> encode_png(const Image &, PngEffort);
template std::vector<uint8_t> encode_png(const DeepImage &, PngEffort);

} // namespace fvv::media
