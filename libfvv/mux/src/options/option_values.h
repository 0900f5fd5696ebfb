// Values of options as texts, and back. Each parser throws Error (usage) that names the option, what was
// expected and what was found; each text reads back as the same value.
#pragma once

#include "fvv_mux/options.h"

#include <array>
#include <string>
#include <vector>

namespace fvv::mux {

[[noreturn]] void refuse_value(const std::string &option, const std::string &expected,
                               const std::string &found);

uint32_t parse_codec(const std::string &option, const std::string &text); // "jpeg", "h264", "hevc", ...
std::string codec_text(uint32_t codec);

int parse_bit_depth(const std::string &option, const std::string &text); // "8", "10", "16"

// "42dB", "23", "lossless"; whether it fits a codec is for fill_in().
Quality parse_quality(const std::string &option, const std::string &text);
std::string quality_text(const Quality &quality);

double parse_view_loss(const std::string &option, const std::string &text); // "0.1dB", "0.1"; "none": 0
std::string view_loss_text(double loss);

uint64_t parse_bit_rate(const std::string &option, const std::string &text);       // "4M", "800k", "64000"
uint32_t parse_audio_bit_rate(const std::string &option, const std::string &text); // "96k", "64000"
uint64_t parse_pixels(const std::string &option, const std::string &text);         // "300k", "2M", "100000"

Length parse_length(const std::string &option,
                    const std::string &text); // "1.5mm", "0.2cm", "0.002m", "0.002"
std::string length_text(const Length &length);

MaxError parse_max_error(const std::string &option, const std::string &text); // "0.15", "0.3px", "1mm"
std::string max_error_text(const MaxError &error);

TileSize parse_tile(const std::string &option, const std::string &text);       // "480x270"
TileSize parse_video_size(const std::string &option, const std::string &text); // "1920x1088"
std::string size_text(const TileSize &size);

double parse_scale(const std::string &option, const std::string &text);   // "0.5"
uint64_t parse_bytes(const std::string &option, const std::string &text); // "512M", "4G", "100000"
std::string number_text(double value);

uint32_t parse_video_tracks(const std::string &option, const std::string &text); // "4", "camera"
std::string video_tracks_text(uint32_t count);

std::vector<Rung> parse_ladder(const std::string &option, const std::string &text); // "1,0.5", "8M,2M,500k"
std::string ladder_text(const std::vector<Rung> &ladder);

// What the preset has, and quality and bit depth as the codec has them. Throws Error (usage) for what it does
// not have.
void fill_in(Options &options);

// "auto", "on", "off", or a number of cells.
void parse_colours(const std::string &option, const std::string &text, Options &options);
std::string colours_text(const Options &options);

std::optional<double> parse_inset(const std::string &option, const std::string &text); // "auto", "off", "3mm"
std::string inset_text(const std::optional<double> &inset);

std::array<uint8_t, 3> parse_colour(const std::string &option, const std::string &text); // "128,128,128"
std::string colour_text(const std::array<uint8_t, 3> &colour);

// A number within bounds.
double parse_number(const std::string &option, const std::string &text, double least, double most,
                    bool whole);

std::vector<std::string> parse_list(const std::string &text);
std::string list_text(const std::vector<std::string> &list);

} // namespace fvv::mux
