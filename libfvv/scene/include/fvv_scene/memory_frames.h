// Meshes and pictures of a capture that are in memory in place of files.
#pragma once

#include "fvv_geometry/mesh.h"
#include "fvv_media/image.h"
#include "fvv_media/video.h"

#include <map>
#include <memory>
#include <mutex>
#include <vector>

namespace fvv::scene {

// Frames by number, for several threads.
class MemoryFrames {
public:
  struct Frame {
    geometry::Mesh mesh;
    std::vector<media::AnyImage> pictures;   // RGB of each camera
    std::vector<media::Image> masks;         // of each camera, one channel
    std::vector<media::Sample> samples = {}; // of each video track that was encoded before
    // Of each camera and vertex, how much of the surface around it is seen, 0 to 255; none: not known.
    std::vector<std::vector<uint8_t>> visibility = {};
  };

  void put(int64_t number, Frame frame);
  // Frees the frames below number.
  void drop_before(int64_t number);

  // With normals only if requested. All throw Error for a missing frame.
  geometry::Mesh mesh(int64_t number, bool normals) const;
  // Throws Error when the picture has other samples.
  template <class Sample> media::BasicImage<Sample> picture(int64_t number, size_t camera) const;
  media::Image mask(int64_t number, size_t camera) const;
  media::Sample sample(int64_t number, size_t track) const;
  std::vector<uint8_t> visibility(int64_t number, size_t camera) const;

private:
  std::shared_ptr<const Frame> at(int64_t number) const; // copies are made without the lock

  mutable std::mutex mutex;
  std::map<int64_t, std::shared_ptr<const Frame>> frames;
};

} // namespace fvv::scene
