#include "cli/cli.h"

#include <cstdio>

namespace fvv::cli {

void parse_size(const std::string &option, const std::string &text, uint32_t &width, uint32_t &height) {
  int used = 0;
  if (text.size() > 11 || text.find_first_not_of("0123456789x") != std::string::npos ||
      std::sscanf(text.c_str(), "%5ux%5u%n", &width, &height, &used) != 2 || size_t(used) != text.size())
    throw Error(option + ": expected WIDTHxHEIGHT like 480x270, found \"" + text + "\"", Error::usage);
}

} // namespace fvv::cli
