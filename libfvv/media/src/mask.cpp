#include "fvv_media/mask.h"

#include "codecs.h"

#include <algorithm>

namespace fvv::media {

namespace {

// More classes or objects than these are noise or a photograph.
constexpr size_t most_labels = 256;
// Labels have areas. Noise changes from pixel to pixel.
constexpr uint64_t least_run = 8;
// One of these many pixels of the take.
constexpr uint64_t least_area = 500;
// Of numbers of objects beside bright ones; a soft edge has more.
constexpr int64_t most_greys = 32;
constexpr size_t enough_files = 3;
constexpr uint16_t opaque = 0xffff;
// The least that becomes 128 of 255.
constexpr uint32_t bright = 32768;

// None: the format has no alpha.
std::optional<RgbaImage> rgba_of(const std::vector<uint8_t> &bytes, const std::string &path) {
  if (is_png(bytes.data(), bytes.size())) return decode_png_rgba(bytes.data(), bytes.size(), path);
  if (is_webp(bytes.data(), bytes.size())) return decode_webp_rgba(bytes.data(), bytes.size(), path);
  return std::nullopt;
}

uint32_t luma(const uint16_t *rgb) {
  return uint32_t((13933ull * rgb[0] + 46871ull * rgb[1] + 4732ull * rgb[2] + 32768) >> 16);
}

} // namespace

std::optional<MaskFacts> MaskFacts::of(const std::string &path) {
  const std::vector<uint8_t> bytes = read_file(path);
  const std::optional<RgbaImage> found = rgba_of(bytes, path);
  if (!found) return std::nullopt;
  const RgbaImage &image = *found;
  MaskFacts out;
  out.has_alpha = image.has_alpha;
  out.pixels = image.pixels.size() / 4;
  out.files = 1;
  uint64_t last = UINT64_MAX; // neighbours are mostly equal
  bool is_dark = false;
  for (size_t i = 0; i + 3 < image.pixels.size(); i += 4) {
    const uint16_t *p = &image.pixels[i];
    out.is_transparent = out.is_transparent || p[3] != opaque;
    const uint64_t colour = uint64_t(p[0]) << 32 | uint64_t(p[1]) << 16 | p[2];
    out.dark += colour == last && is_dark;
    if (colour == last) continue;
    last = colour;
    out.changes++;
    out.is_bright = out.is_bright || luma(p) >= bright;
    is_dark = colour && luma(p) < bright;
    out.dark += is_dark;
    out.dark_runs += is_dark;
    out.is_coloured = out.is_coloured || p[0] != p[1] || p[1] != p[2];
    if (out.colours.size() <= most_labels) out.colours.insert(colour);
  }
  return out;
}

void MaskFacts::add(const MaskFacts &other) {
  has_alpha = has_alpha || other.has_alpha;
  is_transparent = is_transparent || other.is_transparent;
  is_bright = is_bright || other.is_bright;
  is_coloured = is_coloured || other.is_coloured;
  pixels += other.pixels;
  changes += other.changes;
  dark += other.dark;
  dark_runs += other.dark_runs;
  files += other.files;
  for (const uint64_t colour : other.colours)
    if (colours.size() <= most_labels) colours.insert(colour);
}

MaskRule MaskFacts::rule() const {
  if (is_transparent) return MaskRule::alpha;
  const bool are_labels = colours.size() <= most_labels && changes * least_run < pixels;
  // A soft edge has greys between, which are lines and no areas; colours of a palette are numbers of objects,
  // however dark they are.
  const auto greys = std::count_if(colours.begin(), colours.end(),
                                   [](uint64_t colour) { return colour && colour >> 32 < bright; });
  const bool has_dark_areas = dark && 2 * dark >= 5 * dark_runs && dark * least_area >= pixels;
  if (are_labels && (is_coloured || !is_bright || (has_dark_areas && greys <= most_greys)))
    return MaskRule::any;
  return MaskRule::luma;
}

bool MaskFacts::is_decided() const {
  return is_transparent || (!has_alpha && is_bright && !is_coloured && files >= enough_files);
}

Image read_mask(const std::string &path, MaskRule rule) {
  if (rule == MaskRule::luma) return read_image(path, 1);
  const std::vector<uint8_t> bytes = read_file(path);
  const std::optional<RgbaImage> found = rgba_of(bytes, path);
  if (!found) return decode_image(bytes.data(), bytes.size(), 1, path);
  const RgbaImage &image = *found;
  Image out = make_image(image.width, image.height, 1, 0);
  for (size_t i = 0; i < out.pixels.size(); i++) {
    const uint16_t *p = &image.pixels[4 * i];
    out.pixels[i] = rule == MaskRule::alpha ? uint8_t(p[3] >> 8) : p[0] || p[1] || p[2] ? 255 : 0;
  }
  return out;
}

} // namespace fvv::media
