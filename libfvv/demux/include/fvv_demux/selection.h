// Lists of numbers as users write them: "25", "0-9,25".
#pragma once

#include "fvv_cxx/range.h"

#include <cstdint>
#include <string>
#include <vector>

namespace fvv::demux {

// Numbers from 0 to 2147483647. An empty selection that was never parsed stands for everything.
class Selection {
public:
  // Error (usage) "--option: expected ..., found ..." for text that is no list.
  static Selection parse(const std::string &option, const std::string &text);

  bool everything() const { return ranges.empty(); }
  bool has(int64_t number) const;
  // The part of first ... last (both included) that is chosen, in rising order.
  std::vector<fvv::Range> within(int64_t first, int64_t last) const;
  int64_t largest() const { return ranges.back().last; } // not for everything()

private:
  std::vector<fvv::Range> ranges; // rising, apart from each other
};

} // namespace fvv::demux
