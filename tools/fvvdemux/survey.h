// What is certain in a damaged file: reads all of it once, with the push reader, and tells for each group how
// many of its first frames are whole beyond doubt. Behind the first damage of a group chunks may be missing
// without a trace (a table that was lost can't tell), and pictures may depend on them.
#pragma once

#include "cli/cli.h"
#include "fvv/types.h"

#include <map>

namespace fvv::demux {

class Survey {
public:
  // cli::Failure when the file cannot be read.
  explicit Survey(const cli::InputFile &file);

  struct Group {
    uint64_t whole = 0;         // frames from the first on
    fvv_diagnostic reason = {}; // why no more; status 0: nothing is wrong within
    fvv_diagnostic behind = {}; // the first damage between this group and the next
  };
  // By the offset of GRUP. A group whose GRUP was lost has none of its frames whole.
  Group group(uint64_t offset) const;

private:
  std::map<uint64_t, Group> groups; // key 0: what stands in front of the first group
};

} // namespace fvv::demux
