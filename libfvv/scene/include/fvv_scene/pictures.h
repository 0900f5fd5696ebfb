// Pictures of a capture's files, stills and videos, for several threads: keeps videos open, a bounded number
// of times each, and caches what is read twice.
#pragma once

#include "fvv_media/image.h"
#include "fvv_media/mask.h"
#include "fvv_scene/capture.h"

#include <memory>

namespace fvv::scene {

// How many pictures and grey pictures (masks) were decoded from files, but for stills that frames share.
struct PictureReads {
  uint64_t pictures, masks;
};

class Videos {
public:
  // threads: that may call at once. limit: of what decoding one file may take; MemoryError for one that takes
  // more.
  explicit Videos(unsigned threads, const media::MemoryLimit &limit = {});
  ~Videos();

  // For check_files. Error.
  VideoFacts facts(const std::string &path, std::optional<uint32_t> stream);

  // The picture of a frame number, turned as capture.json or the video says. A still that several frames
  // share is read once, and again only for other samples or channels; a grey picture of 8 bits is read once,
  // too, as long as all of them take little memory. Waits while all readers of a video are in use; threads
  // that go through frames in order each get the reader that is where they left off.
  template <class Sample = uint8_t>
  media::BasicImage<Sample> read(const Capture &capture, const PictureSource &source, int64_t frame,
                                 int channels);

  // By which the masks of a camera are read: of stills, by the files of all frames.
  media::MaskRule mask_rule(const Capture &capture, const PictureSource &source);

  PictureReads reads() const;

private:
  struct Shared;
  std::unique_ptr<Shared> shared;
};

} // namespace fvv::scene
