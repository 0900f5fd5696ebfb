// Pictures that are used as masks: which of their pixels are foreground. Segmentation programs write masks in
// many ways: 0 and 255, 0 and 1, numbers of classes, palettes of colours, 16 bits, cut-outs with alpha.
#pragma once

#include "fvv_media/image.h"

#include <optional>
#include <set>

namespace fvv::media {

enum class MaskRule : uint8_t {
  luma,  // BT.709 luma above 127 of 255
  any,   // any channel above 0
  alpha, // alpha of at least one half
};

// What decides the rule for the masks of a camera. Sums of several files are sums over the whole take.
class MaskFacts {
public:
  // Of a PNG file; of a file in another format, which keeps the threshold, nothing.
  static std::optional<MaskFacts> of(const std::string &path);
  void add(const MaskFacts &other);
  MaskRule rule() const;
  // Whether no further file is likely to change the rule: three that are black and white, of 8-bit numbers of
  // objects some of which are bright, do not.
  bool is_decided() const;

private:
  bool has_alpha = false;           // a channel, or a colour that is transparent
  bool is_transparent = false;      // some pixel is, at least in part
  bool is_bright = false;           // some luma is above the threshold
  bool is_coloured = false;         // some pixel has channels that differ
  uint64_t pixels = 0, changes = 0; // from a pixel to the next one of its row, about
  uint64_t dark = 0, dark_runs = 0; // pixels up to the threshold that are not black; their areas, by rows
  size_t files = 0;
  std::set<uint64_t> colours; // 16 bits each of R, G, B; at most one more than most_labels
};

// Grey, 255 where rule luma or alpha has more, and for any 255 or 0: values above 127 are foreground. Files
// that are no PNG are read with luma.
Image read_mask(const std::string &path, MaskRule rule);

} // namespace fvv::media
