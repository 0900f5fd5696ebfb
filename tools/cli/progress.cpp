#include "cli/cli.h"

#include <boost/timer/progress_display.hpp>
#include <iostream>
#include <unistd.h>

namespace fvv::cli {

struct Progress::Bar {
  Bar(const std::string &label, uint64_t steps) : display(steps, std::cerr, label + "\n") {}
  boost::timer::progress_display display;
};

Progress::Progress(const std::string &label, uint64_t steps) {
  if (steps && isatty(STDERR_FILENO)) bar = std::make_unique<Bar>(label, steps);
}

Progress::~Progress() = default;

void Progress::step(uint64_t n) {
  if (bar) bar->display += n;
}

} // namespace fvv::cli
