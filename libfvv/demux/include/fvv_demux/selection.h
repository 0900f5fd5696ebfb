// Lists of numbers as users write them: "25", "0-9,25".
#pragma once

#include "fvv_cxx/range.h"

#include <cstdint>
#include <string>
#include <vector>

namespace fvv::demux {

// Numbers from 0 to 2147483647. A selection that was never parsed selects everything.
class Selection {
public:
  // The value of the option with that identifier. Throws Error (usage) if text is not a list.
  static Selection parse(const std::string &option, const std::string &text);

  bool everything() const { return ranges.empty(); }
  bool has(int64_t number) const;
  // The selected numbers within first ... last (both included), in rising order.
  std::vector<fvv::Range> within(int64_t first, int64_t last) const;
  int64_t largest() const { return ranges.back().last; } // not for everything()

private:
  std::vector<fvv::Range> ranges; // rising, disjoint
};

} // namespace fvv::demux
