// The commands of a stream in parts: --plan, --part and --merge (docs/encoding/parts.md).
#pragma once

#include "cli/cli.h"
#include "fvv_mux/options.h"
#include "fvv_mux/parts.h"

#include <CLI/CLI.hpp>
#include <string>

namespace fvv {

// One of plan, part and merge at most is set.
struct PartCommand {
  std::string plan;    // folder to write
  std::string part;    // numbers of groups
  bool merge = false;  // of the folder that is named in place of the capture
  std::string capture; // where it is now

  bool is_given() const { return !plan.empty() || !part.empty() || merge; }
};

void add_part_options(CLI::App &app, PartCommand &command);

// Throws CLI::ParseError for options that the command does not take.
void check_part_options(const CLI::App &app, const PartCommand &command);

// options.capture: the capture to plan, or the folder of a plan. output: of merge. options have been parsed.
cli::Exit run_part_command(const PartCommand &command, const mux::Options &options, const std::string &output,
                           bool force, bool as_json);

struct Joined {
  mux::Merged stream;
  size_t groups;
};

// --merge without what it prints: the stream of a plan's folder that has all its parts. Throws Error.
Joined merge_parts(const std::string &folder, const std::string &output, bool force);

} // namespace fvv
