// Whether a stream gets visibility: it saves a player one depth pass for each camera and frame, and costs
// bytes.
#include "fvvmux/visibility.h"

#include "cli/cli.h"

#include <algorithm>
#include <cstdio>

namespace fvv::mux {

namespace {

// Of the pictures' bytes. A player without bits loses no picture, only time for depth maps.
constexpr double most_share = 0.1;

} // namespace

std::optional<fvv_texturing> texturing_of(const Options &options) {
  if (!options.texture_threshold && !options.texture_best && !options.texture_unseen &&
      !options.texture_depth_bias && !options.texture_depth_slope)
    return {};
  fvv_texturing out;
  fvv_texturing_default(&out);
  if (options.texture_threshold) out.threshold = *options.texture_threshold;
  if (options.texture_best) out.best = uint8_t(*options.texture_best);
  if (options.texture_depth_bias) out.depth_bias = *options.texture_depth_bias;
  if (options.texture_depth_slope) out.depth_slope = *options.texture_depth_slope;
  if (options.texture_unseen) std::copy_n(options.texture_unseen->begin(), 3, out.unseen);
  return out;
}

VisibilityChoice choose_visibility(const Options &options, const capture::Capture &capture,
                                   const Tiling &tiling) {
  VisibilityChoice choice;
  choice.cameras = tiling.cameras;
  choice.smooth = options.visibility_smooth;
  if (options.texture_threshold) {
    choice.cosine = *options.texture_threshold;
    choice.threshold =
        uint8_t(std::min(255.0, 256 * choice.cosine)); // rounded down: what may be used has bits
  }
  const bool automatic = options.visibility == Visibility::automatic;
  // Whoever asks for bits may have pictures elsewhere.
  if (!automatic && choice.cameras.empty())
    for (size_t i = 0; i < capture.cameras.size(); i++) choice.cameras.push_back(i);
  std::sort(choice.cameras.begin(), choice.cameras.end());
  if (options.visibility == Visibility::faces) choice.domain = FVV_VISIBILITY_FACES;
  if (options.visibility == Visibility::vertices) choice.domain = FVV_VISIBILITY_VERTICES;
  const char *missing = !capture.meshes ? "there are no meshes"
                        : choice.cameras.empty()
                            ? (automatic ? "there are no pictures of cameras" : "there are no cameras")
                            : nullptr;
  if (options.visibility == Visibility::none)
    choice.reason = "--visibility none";
  else if (missing && !automatic)
    throw cli::Failure(std::string("--visibility: ") + missing, cli::usage);
  else if (missing)
    choice.reason = missing;
  else if (automatic && choice.cameras.size() == 1)
    choice.reason = "one camera alone costs a player one depth map";
  else {
    choice.on = true;
    choice.open = automatic;
    choice.reason = automatic ? "" : "--visibility";
  }
  return choice;
}

void settle_visibility(VisibilityChoice &choice, uint64_t bytes, uint64_t pictures) {
  if (!choice.open) return;
  choice.open = false;
  choice.on = double(bytes) <= most_share * double(pictures);
  char text[160];
  std::snprintf(
      text, sizeof text,
      "shares of vertices, which err least: %.2g %% of the pictures' bytes in the first group, %s %g %%",
      pictures ? 100 * double(bytes) / double(pictures) : 100.0, choice.on ? "at most" : "more than",
      100 * most_share);
  choice.reason = text;
}

void VisibilitySums::add(const VisibilityFrame &frame) {
  if (frame.payload.empty()) return;
  const uint64_t size = frame.payload.size();
  frames++;
  keys += frame.key;
  bytes += size;
  smallest = std::min(smallest, size);
  largest = std::max(largest, size);
  pairs += uint64_t(frame.elements) * frame.cameras.size();
  cameras.insert(frame.cameras.begin(), frame.cameras.end());
}

} // namespace fvv::mux
