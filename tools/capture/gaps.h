// capture/gaps.h: numbers of frames as ranges, for people.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace fvv::capture {

struct FrameRange {
  int64_t first, last;
};

class Gaps {
public:
  explicit Gaps(int64_t frame_step) : step(frame_step) {}

  // Numbers come in ascending order.
  void add(int64_t frame) {
    if (found.empty() || found.back().last + step != frame)
      found.push_back({frame, frame});
    else
      found.back().last = frame;
  }
  const std::vector<FrameRange> &ranges() const { return found; }
  // "3, 17 to 27"
  std::string text() const {
    constexpr size_t most = 8; // more would hide the other problems
    std::string out;
    for (size_t i = 0; i < found.size() && i < most; i++) {
      out += (i ? ", " : "") + std::to_string(found[i].first);
      if (found[i].first != found[i].last) out += " to " + std::to_string(found[i].last);
    }
    return out + (found.size() > most ? ", ..." : "");
  }

private:
  int64_t step;
  std::vector<FrameRange> found;
};

} // namespace fvv::capture
