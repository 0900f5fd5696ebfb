#include "mux/src/options/option_values.h"
#include "mux/src/options/presets.h"

#include "fvv/colours.h"
#include "fvv_cxx/format.h"
#include "fvv_media/memory_limit.h"
#include "fvv_media/sound.h"
#include "fvv_media/video.h"
#include "fvv_scene/file_io.h"

#include <algorithm>
#include <cctype>
#include <cmath>

namespace fvv::mux {

void refuse_value(const std::string &option, const std::string &expected, const std::string &found) {
  refuse_option(option, "expected " + expected + ", found " + scene::quote(found));
}

namespace {

bool ends_with(const std::string &text, const std::string &end) {
  return text.size() > end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

bool whole_number(const std::string &text, int64_t least, int64_t most, int64_t &value) {
  return text.find_first_not_of("0123456789") == text.npos && scene::parse_integer(text, value) &&
         value >= least && value <= most;
}

uint64_t parse_amount(const std::string &option, const char *expected, const std::string &text, double least,
                      double most) {
  const char last = text.empty() ? 0 : text.back();
  const double unit = last == 'k' ? 1e3 : last == 'M' ? 1e6 : last == 'G' ? 1e9 : 1;
  double value;
  if (!scene::parse_double(text.substr(0, text.size() - (unit > 1)), value) || !(value * unit >= least) ||
      value * unit > most)
    refuse_value(option, expected, text);
  return uint64_t(std::llround(value * unit));
}

// A length above 0 with its unit, or a plain number; false when it is neither.
bool read_length(const std::string &text, Length &length) {
  struct Unit {
    const char *name;
    double per_metre;
  };
  for (const Unit unit : {Unit{"mm", 1000}, Unit{"cm", 100}, Unit{"m", 1}, Unit{"", 1}}) {
    const std::string name = unit.name;
    if (!ends_with(text, name)) continue;
    double value;
    // Division by a power of ten gives the double that the decimal in metres would give.
    if (!scene::parse_double(text.substr(0, text.size() - name.size()), value) || !(value > 0)) return false;
    length = {value / unit.per_metre, !name.empty()};
    return true;
  }
  return false;
}

TileSize parse_sides(const std::string &option, const char *expected, const std::string &text, int64_t least,
                     int64_t most) {
  const size_t by = text.find('x');
  int64_t width, height;
  if (by == text.npos || !whole_number(text.substr(0, by), least, most, width) ||
      !whole_number(text.substr(by + 1), least, most, height))
    refuse_value(option, expected, text);
  return {uint16_t(width), uint16_t(height)};
}

} // namespace

uint32_t parse_codec(const std::string &option, const std::string &text) {
  for (const media::VideoCodec &codec : media::video_codecs())
    if (text == codec.option) return codec.code;
  refuse_value(option, "jpeg, h264, hevc, vp9, av1 or exr", text);
}

std::string codec_text(uint32_t codec) {
  return media::find_video_codec(codec)->option;
}

int parse_bit_depth(const std::string &option, const std::string &text) {
  int64_t bits = 0;
  if (!whole_number(text, 8, 16, bits)) refuse_value(option, "8, 10 or 16", text);
  return int(bits); // which of them a codec has is for fill_in()
}

Quality parse_quality(const std::string &option, const std::string &text) {
  Quality quality;
  if (text == "lossless") return default_quality(FVV_CODEC_OEXR);
  if (ends_with(text, "dB") || ends_with(text, "db")) {
    if (scene::parse_double(text.substr(0, text.size() - 2), quality.value) && quality.value > 0 &&
        quality.value <= 100)
      return quality;
  } else if (double number; !text.empty() && std::isdigit(uint8_t(text[0])) &&
                            scene::parse_double(text, number) && number >= 1 && number <= 100) {
    return {false, number}; // which parts a codec has is for fill_in()
  }
  refuse_value(option,
               "a PSNR such as 42dB, libjpeg's quality from 1 to 100, a CRF from 1 to 51 or 63, or lossless",
               text);
}

std::string quality_text(const Quality &quality) {
  if (quality.is_psnr) return number_text(quality.value) + "dB";
  return quality.value == 0 ? "lossless" : number_text(quality.value);
}

double parse_view_loss(const std::string &option, const std::string &text) {
  double loss;
  if (text == "none") return 0;
  const bool named = ends_with(text, "dB") || ends_with(text, "db");
  if (!scene::parse_double(text.substr(0, text.size() - (named ? 2 : 0)), loss) || !(loss >= 0.01) ||
      loss > 10)
    refuse_value(option, "decibels such as 0.1dB, from 0.01 to 10, or none", text);
  return loss;
}

std::string view_loss_text(double loss) {
  return loss > 0 ? number_text(loss) + "dB" : "none";
}

uint64_t parse_bit_rate(const std::string &option, const std::string &text) {
  return parse_amount(option, "bits a second such as 4M, 800k or 64000, from 1k to 10G", text, 1e3, 1e10);
}

uint32_t parse_audio_bit_rate(const std::string &option, const std::string &text) {
  constexpr double most = double(media::most_sound_bit_rate) * media::max_sound_channels;
  return uint32_t(parse_amount(option, "bits a second such as 96k or 64000, from 6k to 2048k", text,
                               media::least_sound_bit_rate, most));
}

uint64_t parse_pixels(const std::string &option, const std::string &text) {
  return parse_amount(option, "pixels such as 300k, 2M or 100000, from 4k to 200M", text, 4e3, 2e8);
}

uint64_t parse_bytes(const std::string &option, const std::string &text) {
  const std::optional<uint64_t> bytes = media::parse_memory(text);
  if (!bytes) refuse_value(option, media::memory_words, text);
  return *bytes;
}

Length parse_length(const std::string &option, const std::string &text) {
  Length length = {};
  if (!read_length(text, length))
    refuse_value(option, "a length above 0 such as 1.5mm, 0.2cm, 0.002m or 0.002", text);
  return length;
}

std::string length_text(const Length &length) {
  return number_text(length.value) + (length.metric ? "m" : "");
}

MaxError parse_max_error(const std::string &option, const std::string &text) {
  Length length = {};
  const bool pixels = ends_with(text, "px");
  if (!read_length(pixels ? text.substr(0, text.size() - 2) : text, length) || (pixels && length.metric) ||
      length.value > 1000)
    refuse_value(option,
                 "pixels such as 0.15, or a length such as 1mm, 0.1cm or 0.001m, above 0 and at most 1000",
                 text);
  return {length.value, pixels ? MaxError::pixels : length.metric ? MaxError::metres : MaxError::plain};
}

std::string max_error_text(const MaxError &error) {
  const char *unit = error.unit == MaxError::pixels ? "px" : error.unit == MaxError::metres ? "m" : "";
  return number_text(error.value) + unit;
}

TileSize parse_tile(const std::string &option, const std::string &text) {
  return parse_sides(option, "WIDTHxHEIGHT such as 480x270, each from 1 to 16384", text, 1, 16384);
}

TileSize parse_video_size(const std::string &option, const std::string &text) {
  return parse_sides(option, "WIDTHxHEIGHT such as 1920x1088, each from 64 to 8192", text, 64, 8192);
}

std::string size_text(const TileSize &size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

double parse_scale(const std::string &option, const std::string &text) {
  double value;
  if (!scene::parse_double(text, value) || !(value > 0) || value > 1)
    refuse_value(option, "a number above 0 and at most 1", text);
  return value;
}

std::string number_text(double value) {
  std::string out;
  scene::append_double(out, value);
  return out;
}

uint32_t parse_video_tracks(const std::string &option, const std::string &text) {
  int64_t count;
  if (text == "camera") return UINT32_MAX;
  if (!whole_number(text, 1, 1000, count)) refuse_value(option, "camera, or a number from 1 to 1000", text);
  return uint32_t(count);
}

std::string video_tracks_text(uint32_t count) {
  return count == UINT32_MAX ? "camera" : std::to_string(count);
}

std::vector<Rung> parse_ladder(const std::string &option, const std::string &text) {
  const char *expected =
      "2 to 8 falling scales above 0 and at most 1 (1,0.5,0.25), or falling bits a second from "
      "1k to 10G (8M,2M,500k), or falling qualities (42dB,36dB,30dB), or auto";
  std::vector<Rung> scales, qualities;
  std::vector<uint64_t> rates;
  for (const std::string &part : parse_list(text)) {
    double scale;
    if (part.size() > 2 && part.substr(part.size() - 2) == "dB")
      qualities.push_back({1, 0, parse_quality(option, part).value});
    else if (scene::parse_double(part, scale) && scale <= 1)
      scales.push_back({scale});
    else
      rates.push_back(parse_amount(option, expected, part, 1e3, 1e10));
  }
  if (int(!scales.empty()) + int(!rates.empty()) + int(!qualities.empty()) > 1)
    refuse_value(option, expected, text);
  const std::vector<Rung> ladder = !qualities.empty() ? qualities
                                   : rates.empty()    ? scales
                                                      : ladder_of_rates(rates);
  const auto falls = [](const Rung &a, const Rung &b) {
    return a.psnr ? b.psnr < a.psnr : b.scale < a.scale && b.scale > 0;
  };
  if (ladder.size() < 2 || ladder.size() > most_rungs || !(ladder[0].scale > 0))
    refuse_value(option, expected, text);
  for (size_t i = 1; i < ladder.size(); i++)
    if (!falls(ladder[i - 1], ladder[i])) refuse_value(option, expected, text);
  return ladder;
}

std::string ladder_text(const std::vector<Rung> &ladder) {
  std::vector<std::string> parts;
  for (const Rung &rung : ladder)
    parts.push_back(rung.psnr       ? number_text(rung.psnr) + "dB"
                    : rung.bit_rate ? std::to_string(rung.bit_rate)
                                    : number_text(rung.scale));
  return list_text(parts);
}

std::array<uint8_t, 3> parse_colour(const std::string &option, const std::string &text) {
  std::array<uint8_t, 3> out = {};
  const std::vector<std::string> parts = parse_list(text);
  for (size_t i = 0; i < 3; i++) {
    int64_t value = 0;
    if (parts.size() != 3 || !whole_number(parts[i], 0, 255, value))
      refuse_value(option, "R,G,B, each from 0 to 255", text);
    out[i] = uint8_t(value);
  }
  return out;
}

std::string colour_text(const std::array<uint8_t, 3> &colour) {
  return fvv::format("%d,%d,%d", colour[0], colour[1], colour[2]);
}

namespace {

void check_quality(const Quality &quality, const media::VideoCodec &codec) {
  const auto [least, most] = std::minmax(codec.finest, codec.coarsest);
  if (codec.code == FVV_CODEC_OEXR) {
    if (quality.is_psnr || quality.value != 0)
      refuse_value("quality", "lossless, the only quality of OpenEXR", quality_text(quality));
    return;
  }
  const int parts = media::parts_of_quality(codec.code);
  const bool fits = std::fmod(quality.value * parts, 1) == 0;
  if (quality.is_psnr || (fits && quality.value >= least && quality.value <= most)) return;
  refuse_value("quality",
               std::string("a PSNR such as 42dB, or ") +
                   (codec.code == FVV_CODEC_JPEG ? "libjpeg's quality" : "a CRF") + " from " +
                   std::to_string(least) + " to " + std::to_string(most) +
                   (fits        ? ""
                    : parts > 1 ? ", in parts of 1/" + std::to_string(parts)
                                : ", a whole number"),
               quality_text(quality));
}

} // namespace

void fill_in(Options &options) {
  fill_in_preset(options);
  const media::VideoCodec *const codec = media::find_video_codec(options.codec);
  if (!codec)
    refuse_option("codec", "expected one of this library, found number " + std::to_string(options.codec));
  if (options.quality.by_default && options.codec == FVV_CODEC_OEXR) {
    options.quality = default_quality(options.codec);
    options.quality.by_default = true;
  }
  check_quality(options.quality, *codec);
  if (!options.bit_depth) options.bit_depth = codec->shallowest;
  try {
    media::check_bit_depth(*codec, options.bit_depth);
  } catch (const Error &error) {
    refuse_option("bit-depth", error.what());
  }
}

void parse_colours(const std::string &option, const std::string &text, Options &options) {
  int64_t cells = 0;
  if (text == "auto")
    options.colours = Colours::automatic;
  else if (text == "on")
    options.colours = Colours::on;
  else if (text == "off")
    options.colours = Colours::off;
  else if (whole_number(text, 10, FVV_COLOURS_MAX_CELLS, cells))
    options.colours = Colours::on;
  else
    refuse_value(option, "auto, on, off or a number of cells from 10 to 65536", text);
  options.colour_cells = uint32_t(cells);
}

std::string colours_text(const Options &options) {
  if (options.colour_cells) return std::to_string(options.colour_cells);
  return options.colours == Colours::automatic ? "auto" : options.colours == Colours::on ? "on" : "off";
}

std::optional<double> parse_inset(const std::string &option, const std::string &text) {
  if (text == "auto") return {};
  if (text == "off") return 0;
  Length length = {};
  if (!read_length(text, length)) refuse_value(option, "auto, off or a length above 0 such as 3mm", text);
  return length.value;
}

std::string inset_text(const std::optional<double> &inset) {
  return !inset ? "auto" : *inset == 0 ? "off" : number_text(*inset);
}

double parse_number(const std::string &option, const std::string &text, double least, double most,
                    bool whole) {
  double value = 0;
  if (!scene::parse_double(text, value) || !(value >= least && value <= most) ||
      (whole && value != std::floor(value)))
    refuse_value(option, fvv::format("a%s number from %.10g to %.10g", whole ? " whole" : "", least, most),
                 text);
  return value;
}

std::vector<std::string> parse_list(const std::string &text) {
  std::vector<std::string> out;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(',', begin), text.size());
    out.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return out;
}

std::string list_text(const std::vector<std::string> &list) {
  std::string out;
  for (const std::string &one : list) out += (out.empty() ? "" : ",") + one;
  return out;
}

} // namespace fvv::mux
