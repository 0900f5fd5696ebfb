// Parses values of options.
#pragma once

#include "fvv_mux/options.h"

namespace fvv::mux {

// Each throws Error (usage) that names the option, what was expected and what was found.
uint32_t parse_codec(const std::string &text); // "jpeg", "h264", "hevc", "vp9", "av1", "exr"
int parse_bit_depth(const std::string &text,
                    uint32_t codec);                             // "8"; "10", "16" where the codec has it
Quality parse_quality(const std::string &text, uint32_t codec);  // "42dB", "23", "lossless"
uint64_t parse_bit_rate(const std::string &text);                // "4M", "800k", "64000"
uint32_t parse_audio_bit_rate(const std::string &text);          // "96k", "64000"
Length parse_length(const std::string &text);                    // "1.5mm", "0.2cm", "0.002m", "0.002"
MaxError parse_max_error(const std::string &text);               // "0.15", "1mm"
TileSize parse_tile(const std::string &text);                    // "480x270"
double parse_scale(const char *option, const std::string &text); // "0.5"
uint8_t parse_profile(const std::string &text);                  // "draco", "raw", "fast"
Normals parse_normals(const std::string &text);                  // "auto", "always", "never"
Winding parse_winding(const std::string &text);                  // "auto", "keep", "flip"
Background parse_background(const std::string &text);            // "auto", "keep", "flat", "smooth"
uint64_t parse_pixels(const std::string &text);                  // "300k", "2M", "100000"
TileSize parse_video_size(const std::string &text);              // "1920x1088"
uint32_t parse_video_tracks(const std::string &text);            // "4", "camera"
std::vector<Rung> parse_ladder(const std::string &text);         // "1,0.5,0.25", "8M,2M,500k"
MeshLadder parse_mesh_ladder(const std::string &text);           // "auto", "on", "off"
Crop parse_crop(const std::string &text);                        // "auto", "none"
// "auto", "on", "off", or a number of cells.
void parse_colours(const std::string &text, Options &options);
MatchColours parse_match_colours(const std::string &text);                        // "auto", "on", "off"
std::optional<double> parse_inset(const std::string &text);                       // "auto", "off", "3mm"
Visibility parse_visibility(const std::string &text);                             // "auto", "weight", "none"
std::array<uint8_t, 3> parse_colour(const char *option, const std::string &text); // "128,128,128"

} // namespace fvv::mux
