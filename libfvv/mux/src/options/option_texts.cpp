#include "fvv_mux/option_texts.h"

#include "fvv/colours.h"
#include "fvv/mesh.h"
#include "fvv_cxx/format.h"
#include "fvv_media/sound.h"
#include "fvv_media/video.h"
#include "fvv_scene/file_io.h"

#include <algorithm>
#include <cmath>
#include <type_traits>

namespace fvv::mux {

namespace {

[[noreturn]] void refuse(const char *option, const char *expected, const std::string &found) {
  throw Error(std::string(option) + ": expected " + expected + ", found " + scene::quote(found),
              Error::usage);
}

bool ends_with(const std::string &text, const std::string &end) {
  return text.size() > end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

bool whole_number(const std::string &text, int64_t least, int64_t most, int64_t &value) {
  return text.find_first_not_of("0123456789") == text.npos && scene::parse_integer(text, value) &&
         value >= least && value <= most;
}

} // namespace

uint32_t parse_codec(const std::string &text) {
  for (const media::VideoCodec &codec : media::video_codecs())
    if (text == codec.option) return codec.code;
  refuse("--codec", "jpeg, h264, hevc, vp9, av1 or exr", text);
}

int parse_bit_depth(const std::string &text, uint32_t codec) {
  const media::VideoCodec &known = *media::find_video_codec(codec);
  int64_t bits = 0;
  if (!whole_number(text, 8, 16, bits)) refuse("--bit-depth", "8, 10 or 16", text);
  try {
    media::check_bit_depth(known, int(bits));
  } catch (const Error &error) {
    throw Error(std::string("--bit-depth: ") + error.what(), Error::usage);
  }
  return int(bits);
}

Quality parse_quality(const std::string &text, uint32_t codec) {
  const media::VideoCodec &known = *media::find_video_codec(codec);
  const auto [least, most] = std::minmax(known.finest, known.coarsest);
  if (codec == FVV_CODEC_OEXR) {
    if (text != "lossless") refuse("--quality", "lossless, the only quality of OpenEXR", text);
    return default_quality(codec);
  }
  Quality quality;
  if (ends_with(text, "dB") || ends_with(text, "db")) {
    if (scene::parse_double(text.substr(0, text.size() - 2), quality.value) && quality.value > 0 &&
        quality.value <= 100)
      return quality;
  } else if (int64_t number; whole_number(text, least, most, number)) {
    return {false, double(number)};
  }
  const std::string expected = std::string("a PSNR such as 42dB, or ") +
                               (codec == FVV_CODEC_JPEG ? "libjpeg's quality" : "a CRF") + " from " +
                               std::to_string(least) + " to " + std::to_string(most);
  refuse("--quality", expected.c_str(), text);
}

namespace {

uint64_t parse_amount(const char *option, const char *expected, const std::string &text, double least,
                      double most) {
  const char last = text.empty() ? 0 : text.back();
  const double unit = last == 'k' ? 1e3 : last == 'M' ? 1e6 : last == 'G' ? 1e9 : 1;
  double value;
  if (!scene::parse_double(text.substr(0, text.size() - (unit > 1)), value) || !(value * unit >= least) ||
      value * unit > most)
    refuse(option, expected, text);
  return uint64_t(std::llround(value * unit));
}

} // namespace

uint64_t parse_bit_rate(const std::string &text) {
  return parse_amount("--bitrate", "bits a second such as 4M, 800k or 64000, from 1k to 10G", text, 1e3,
                      1e10);
}

uint32_t parse_audio_bit_rate(const std::string &text) {
  constexpr double most = double(media::most_sound_bit_rate) * media::max_sound_channels;
  return uint32_t(parse_amount("--audio-bitrate", "bits a second such as 96k or 64000, from 6k to 2048k",
                               text, media::least_sound_bit_rate, most));
}

uint64_t parse_pixels(const std::string &text) {
  return parse_amount("--video-pixels", "pixels such as 300k, 2M or 100000, from 4k to 200M", text, 4e3, 2e8);
}

std::vector<Rung> parse_ladder(const std::string &text) {
  const char *expected =
      "2 to 8 falling scales above 0 and at most 1 (1,0.5,0.25), or falling bits a second from "
      "1k to 10G (8M,2M,500k)";
  std::vector<Rung> scales;
  std::vector<uint64_t> rates;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(',', begin), text.size());
    const std::string part = text.substr(begin, end - begin);
    double scale;
    if (scene::parse_double(part, scale) && scale <= 1)
      scales.push_back({scale});
    else
      rates.push_back(parse_amount("--ladder", expected, part, 1e3, 1e10));
    begin = end + 1;
  }
  if (!scales.empty() && !rates.empty()) refuse("--ladder", expected, text);
  const std::vector<Rung> ladder = rates.empty() ? scales : ladder_of_rates(rates);
  const auto falls = [](const Rung &a, const Rung &b) { return b.scale < a.scale && b.scale > 0; };
  if (ladder.size() < 2 || ladder.size() > most_rungs || !(ladder[0].scale > 0))
    refuse("--ladder", expected, text);
  for (size_t i = 1; i < ladder.size(); i++)
    if (!falls(ladder[i - 1], ladder[i])) refuse("--ladder", expected, text);
  return ladder;
}

namespace {

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

} // namespace

Length parse_length(const std::string &text) {
  Length length = {};
  if (!read_length(text, length))
    refuse("--step", "a length above 0 such as 1.5mm, 0.2cm, 0.002m or 0.002", text);
  return length;
}

MaxError parse_max_error(const std::string &text) {
  Length length = {};
  const bool pixels = ends_with(text, "px");
  if (!read_length(pixels ? text.substr(0, text.size() - 2) : text, length) || (pixels && length.metric) ||
      length.value > 1000)
    refuse("--max-error",
           "pixels such as 0.15, or a length such as 1mm, 0.1cm or 0.001m, above 0 and at most 1000", text);
  return {length.value, pixels ? MaxError::pixels : length.metric ? MaxError::metres : MaxError::plain};
}

namespace {

TileSize parse_sides(const char *option, const char *expected, const std::string &text, int64_t least,
                     int64_t most) {
  const size_t by = text.find('x');
  int64_t width, height;
  if (by == text.npos || !whole_number(text.substr(0, by), least, most, width) ||
      !whole_number(text.substr(by + 1), least, most, height))
    refuse(option, expected, text);
  return {uint16_t(width), uint16_t(height)};
}

} // namespace

TileSize parse_tile(const std::string &text) {
  return parse_sides("--tile", "WIDTHxHEIGHT such as 480x270, each from 1 to 16384", text, 1, 16384);
}

TileSize parse_video_size(const std::string &text) {
  return parse_sides("--video-size", "WIDTHxHEIGHT such as 1920x1088, each from 64 to 8192", text, 64, 8192);
}

double parse_scale(const char *option, const std::string &text) {
  double value;
  if (!scene::parse_double(text, value) || !(value > 0) || value > 1)
    refuse(option, "a number above 0 and at most 1", text);
  return value;
}

uint8_t parse_profile(const std::string &text) {
  if (text == "draco") return FVV_MESH_DRACO;
  if (text == "raw") return FVV_MESH_RAW;
  if (text == "fast") return FVV_MESH_FAST;
  refuse("--mesh-profile", "draco, raw or fast", text);
}

Normals parse_normals(const std::string &text) {
  if (text == "auto") return Normals::automatic;
  if (text == "always") return Normals::always;
  if (text == "never") return Normals::never;
  refuse("--normals", "auto, always or never", text);
}

Winding parse_winding(const std::string &text) {
  if (text == "auto") return Winding::automatic;
  if (text == "keep") return Winding::keep;
  if (text == "flip") return Winding::flip;
  refuse("--winding", "auto, keep or flip", text);
}

Background parse_background(const std::string &text) {
  if (text == "auto") return Background::automatic;
  if (text == "keep") return Background::keep;
  if (text == "flat") return Background::flat;
  if (text == "smooth") return Background::smooth;
  refuse("--background", "auto, keep, flat or smooth", text);
}

uint32_t parse_video_tracks(const std::string &text) {
  int64_t count;
  if (text == "camera") return UINT32_MAX;
  if (!whole_number(text, 1, 1000, count))
    refuse("--video-tracks", "camera, or a number from 1 to 1000", text);
  return uint32_t(count);
}

Crop parse_crop(const std::string &text) {
  if (text == "auto") return Crop::automatic;
  if (text == "none") return Crop::none;
  refuse("--crop", "auto or none", text);
}

std::array<uint8_t, 3> parse_colour(const char *option, const std::string &text) {
  std::array<uint8_t, 3> out = {};
  size_t begin = 0;
  for (size_t i = 0; i < 3; i++) {
    const size_t end = i < 2 ? text.find(',', begin) : text.size();
    int64_t value = 0;
    if (end == text.npos || !whole_number(text.substr(begin, end - begin), 0, 255, value))
      refuse(option, "R,G,B, each from 0 to 255", text);
    out[i] = uint8_t(value);
    begin = end + 1;
  }
  return out;
}

void parse_colours(const std::string &text, Options &options) {
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
    refuse("--colours", "auto, on, off or a number of cells from 10 to 65536", text);
  options.colour_cells = uint32_t(cells);
}

std::optional<double> parse_inset(const std::string &text) {
  if (text == "auto") return {};
  if (text == "off") return 0;
  Length length = {};
  if (!read_length(text, length))
    refuse("--texture-inset", "auto, off or a length above 0 such as 3mm", text);
  return length.value;
}

MeshLadder parse_mesh_ladder(const std::string &text) {
  if (text == "auto") return MeshLadder::automatic;
  if (text == "on") return MeshLadder::on;
  if (text == "off") return MeshLadder::off;
  refuse("--mesh-ladder", "auto, on or off", text);
}

MatchColours parse_match_colours(const std::string &text) {
  if (text == "auto") return MatchColours::automatic;
  if (text == "on") return MatchColours::on;
  if (text == "off") return MatchColours::off;
  refuse("--match-colours", "auto, on or off", text);
}

Visibility parse_visibility(const std::string &text) {
  if (text == "auto") return Visibility::automatic;
  if (text == "weight") return Visibility::weights;
  if (text == "none") return Visibility::none;
  refuse("--visibility", "auto, weight or none", text);
}

uint32_t parse_blend(const std::string &text) {
  if (text == "viewer") return FVV_BLEND_VIEWER;
  if (text == "paper") return FVV_BLEND_PAPER;
  refuse("--texture-blend", "viewer or paper", text);
}

namespace {

struct NamedText {
  const char *name;
  std::string OptionTexts::*text;
};
constexpr NamedText named_texts[] = {
    {"codec", &OptionTexts::codec},
    {"bitrate", &OptionTexts::bit_rate},
    {"tile", &OptionTexts::tile},
    {"scale", &OptionTexts::scale},
    {"atlas-scale", &OptionTexts::atlas_scale},
    {"background", &OptionTexts::background},
    {"crop", &OptionTexts::crop},
    {"video-pixels", &OptionTexts::video_pixels},
    {"video-size", &OptionTexts::video_size},
    {"video-tracks", &OptionTexts::video_tracks},
    {"mesh-ladder", &OptionTexts::mesh_ladder},
    {"step", &OptionTexts::step},
    {"max-error", &OptionTexts::max_error},
    {"mesh-profile", &OptionTexts::mesh_profile},
    {"normals", &OptionTexts::normals},
    {"winding", &OptionTexts::winding},
    {"frames", &OptionTexts::frames},
    {"visibility", &OptionTexts::visibility},
    {"colours", &OptionTexts::colours},
    {"match-colours", &OptionTexts::match_colours},
    {"texture-blend", &OptionTexts::texture_blend},
    {"texture-unseen", &OptionTexts::texture_unseen},
    {"texture-inset", &OptionTexts::texture_inset},
    {"audio-bitrate", &OptionTexts::audio_bit_rate},
    {"meshes", &OptionTexts::meshes},
    {"atlas", &OptionTexts::atlas},
    {"pictures", &OptionTexts::pictures},
    {"masks", &OptionTexts::masks},
    {"fps", &OptionTexts::fps},
    {"units", &OptionTexts::units},
    {"up", &OptionTexts::up},
};

struct NamedOptionalText {
  const char *name;
  std::optional<std::string> OptionTexts::*text;
};
constexpr NamedOptionalText named_optional_texts[] = {
    {"bit-depth", &OptionTexts::bit_depth},
    {"quality", &OptionTexts::quality},
    {"ladder", &OptionTexts::ladder},
};

template <class Target> void set_number(Target &target, double value) {
  target = Target(value);
}
template <class Value> void set_number(std::optional<Value> &target, double value) {
  target = Value(value);
}

struct NamedNumber {
  const char *name;
  double least, most;
  bool whole;
  void (*set)(Options &, double);
};
template <auto Member, class T>
constexpr NamedNumber named_number(const char *name, const Bounds<T> &bounds) {
  return {name, double(bounds.least), double(bounds.most), std::is_integral_v<T>,
          [](Options &options, double value) { set_number(options.*Member, value); }};
}
constexpr NamedNumber named_numbers[] = {
    named_number<&Options::texture_bits>("texture-bits", texture_bits_bounds),
    named_number<&Options::undistort_alpha>("undistort-alpha", undistort_alpha_bounds),
    named_number<&Options::triangles>("triangles", triangles_bounds),
    named_number<&Options::group>("group", group_bounds),
    named_number<&Options::mesh_level>("mesh-level", mesh_level_bounds),
    named_number<&Options::texture_threshold>("texture-threshold", texture_threshold_bounds),
    named_number<&Options::texture_best>("texture-best", texture_best_bounds),
    named_number<&Options::texture_depth_bias>("texture-depth-bias", texture_depth_bounds),
    named_number<&Options::texture_depth_slope>("texture-depth-slope", texture_depth_bounds),
    named_number<&Options::min_component>("min-component", min_component_bounds),
    named_number<&Options::threads>("threads", threads_bounds),
    named_number<&Options::sound_channels>("audio-channels", audio_channels_bounds),
};

struct NamedFlag {
  const char *name;
  bool Options::*flag;
  bool value; // when the flag is given
};
constexpr NamedFlag named_flags[] = {
    {"undistort", &Options::undistort, true},
    {"keep-geometry", &Options::keep_geometry, true},
    {"no-delta", &Options::delta, false},
    {"skip-bad-frames", &Options::skip_bad_frames, true},
    {"no-pictures", &Options::pictures, false},
    {"no-meshes", &Options::meshes, false},
    {"no-background", &Options::environment, false},
    {"no-audio", &Options::sound, false},
    {"repeat-configuration", &Options::repeat_configuration, true},
    {"live", &Options::live, true},
    {"verify", &Options::verify, true},
};

void set_number(const NamedNumber &number, const std::string &text, Options &options) {
  double value = 0;
  if (scene::parse_double(text, value) && value >= number.least && value <= number.most &&
      (!number.whole || value == std::floor(value))) {
    number.set(options, value);
    return;
  }
  const std::string expected =
      fvv::format("a%s number from %.10g to %.10g", number.whole ? " whole" : "", number.least, number.most);
  refuse(("--" + std::string(number.name)).c_str(), expected.c_str(), text);
}

void check_exclusion(bool first, const char *first_name, bool second, const char *second_name) {
  if (first && second)
    throw Error(std::string(first_name) + ": expected without " + second_name + ", found both", Error::usage);
}

void check_need(bool given, const char *name, bool needed, const char *needed_name) {
  if (given && !needed)
    throw Error(std::string(name) + ": expected with " + needed_name + ", found alone", Error::usage);
}

} // namespace

bool set_option(const std::string &name, const std::string &text, Options &options, OptionTexts &texts) {
  for (const NamedText &one : named_texts)
    if (name == one.name) {
      if (text.empty()) refuse(("--" + name).c_str(), "a value", text);
      texts.*one.text = text;
      return true;
    }
  for (const NamedOptionalText &one : named_optional_texts)
    if (name == one.name) {
      texts.*one.text = text;
      return true;
    }
  for (const NamedNumber &one : named_numbers)
    if (name == one.name) {
      set_number(one, text, options);
      return true;
    }
  for (const NamedFlag &one : named_flags)
    if (name == one.name) {
      if (text != "on" && text != "off") refuse(("--" + name).c_str(), "on or off", text);
      options.*one.flag = (text == "on") == one.value;
      return true;
    }
  return false;
}

void take_texts(Options &options, const OptionTexts &texts) {
  options.codec = parse_codec(texts.codec);
  options.bit_depth = texts.bit_depth ? parse_bit_depth(*texts.bit_depth, options.codec)
                                      : media::find_video_codec(options.codec)->shallowest;
  options.quality =
      texts.quality ? parse_quality(*texts.quality, options.codec) : default_quality(options.codec);
  if (!texts.bit_rate.empty()) options.bit_rate = parse_bit_rate(texts.bit_rate);
  if (options.bit_rate && options.codec == FVV_CODEC_OEXR)
    throw Error("--bitrate: video in OpenEXR is lossless and keeps no bit rate", Error::usage);
  if (!texts.tile.empty()) options.tile = parse_tile(texts.tile);
  if (!texts.scale.empty()) options.scale = parse_scale("--scale", texts.scale);
  if (!texts.atlas_scale.empty()) options.atlas_scale = parse_scale("--atlas-scale", texts.atlas_scale);
  if (!texts.audio_bit_rate.empty()) options.sound_bit_rate = parse_audio_bit_rate(texts.audio_bit_rate);
  options.background = parse_background(texts.background);
  options.crop = parse_crop(texts.crop);
  if (!texts.video_pixels.empty()) options.video_pixels = parse_pixels(texts.video_pixels);
  if (!texts.video_size.empty()) options.video_size = parse_video_size(texts.video_size);
  if (!texts.step.empty()) options.step = parse_length(texts.step);
  if (!texts.max_error.empty()) options.max_error = parse_max_error(texts.max_error);
  options.video_tracks = parse_video_tracks(texts.video_tracks);
  if (texts.ladder) options.ladder = parse_ladder(*texts.ladder);
  if (!options.ladder.empty() && options.ladder[0].bit_rate && (texts.quality || !texts.bit_rate.empty()))
    throw Error("--ladder: with bits a second of each rung there is no --quality and no --bitrate",
                Error::usage);
  options.mesh_ladder = parse_mesh_ladder(texts.mesh_ladder);
  options.mesh_profile = parse_profile(texts.mesh_profile);
  options.visibility = parse_visibility(texts.visibility);
  parse_colours(texts.colours, options);
  options.match_colours = parse_match_colours(texts.match_colours);
  options.texture_inset = parse_inset(texts.texture_inset);
  if (!texts.texture_blend.empty()) options.texture_blend = parse_blend(texts.texture_blend);
  if (!texts.texture_unseen.empty())
    options.texture_unseen = parse_colour("--texture-unseen", texts.texture_unseen);
  options.normals = parse_normals(texts.normals);
  if (!texts.winding.empty()) options.winding = parse_winding(texts.winding);
  if (!texts.frames.empty()) options.frames = fvv::parse_range("--frames", texts.frames);
  options.inputs = {texts.meshes, texts.atlas, texts.pictures, texts.masks, {}, texts.units, texts.up};
  if (!texts.fps.empty()) options.inputs.frame_duration = scene::parse_frame_rate("--fps", texts.fps);
  scene::check_inputs(options.inputs);
  const bool has_pixels = !texts.video_pixels.empty(), has_size = !texts.video_size.empty();
  const bool has_tracks = options.video_tracks != 1;
  check_exclusion(texts.quality.has_value(), "--quality", options.bit_rate, "--bitrate");
  check_exclusion(!texts.tile.empty(), "--tile", !texts.scale.empty(), "--scale");
  check_exclusion(has_pixels, "--video-pixels", has_size, "--video-size");
  check_exclusion(has_tracks, "--video-tracks", has_pixels, "--video-pixels");
  check_exclusion(has_tracks, "--video-tracks", has_size, "--video-size");
  check_exclusion(options.triangles, "--triangles", options.keep_geometry, "--keep-geometry");
  check_exclusion(options.sound_bit_rate, "--audio-bitrate", !options.sound, "--no-audio");
  check_need(options.mesh_ladder != MeshLadder::automatic, "--mesh-ladder", !options.ladder.empty(),
             "--ladder");
  check_need(options.undistort_alpha != 0, "--undistort-alpha", options.undistort, "--undistort");
}

} // namespace fvv::mux
