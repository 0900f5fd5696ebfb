// Options as texts, with the names and words of fvvmux: one parser for the command line and for bindings.
#pragma once

#include "fvv/format.h"
#include "fvv_media/sound.h"
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
uint32_t parse_blend(const std::string &text);                                    // "viewer", "paper"

// The values of options that are no plain number; empty or without value: as by default.
struct OptionTexts {
  std::optional<std::string> bit_depth, quality, ladder;
  std::string codec = "h264", bit_rate, tile, scale, atlas_scale, background = "auto", crop = "auto",
              video_pixels, video_size, video_tracks = "1", mesh_ladder = "auto", step, max_error,
              mesh_profile = "draco", normals = "auto", winding, frames, visibility = "auto",
              colours = "auto", match_colours = "auto", texture_blend, texture_unseen, texture_inset = "auto",
              audio_bit_rate, meshes, atlas, pictures, masks, fps, units, up;
};

// Of options that are numbers.
template <class T> struct Bounds { T least, most; };
constexpr Bounds<int> texture_bits_bounds = {1, FVV_TEXTURE_BITS_MAX}, triangles_bounds = {1, 1000000000},
                      group_bounds = {1, 100000}, mesh_level_bounds = {0, 10}, texture_best_bounds = {1, 255},
                      min_component_bounds = {0, 1000000000}, threads_bounds = {1, 256},
                      audio_channels_bounds = {1, media::max_sound_channels};
constexpr Bounds<double> undistort_alpha_bounds = {0, 1}, texture_threshold_bounds = {0, 1},
                         texture_depth_bounds = {0, 1e6};

// Sets the option that fvvmux calls --name: a number or flag ("on", "off") in options, any other in texts,
// for take_texts. Returns false for another name. Throws Error (usage) for a number out of bounds.
bool set_option(const std::string &name, const std::string &text, Options &options, OptionTexts &texts);

// Throws Error (usage) for texts that are wrong and options that exclude each other.
void take_texts(Options &options, const OptionTexts &texts);

} // namespace fvv::mux
