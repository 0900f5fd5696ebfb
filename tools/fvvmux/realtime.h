// The command --realtime: a capture whose frames arrive while it is packed (docs/guide/live.md).
#pragma once

#include "cli/cli.h"
#include "fvv_mux/options.h"

#include <CLI/CLI.hpp>
#include <string>

namespace fvv {

struct RealtimeCommand {
  bool on = false;
  bool in_place = false;
  double max_delay, idle; // seconds
};

void add_realtime_options(CLI::App &app, RealtimeCommand &command);

// options have been parsed; those of the stream without a preset get that for live.
cli::Exit run_realtime(const RealtimeCommand &command, const mux::Options &options, const std::string &output,
                       bool force, bool as_json);

} // namespace fvv
