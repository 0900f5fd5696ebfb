// What all tools do alike: exit codes, one line per problem.
#pragma once

#include "cli/progress.h"
#include "fvv_cxx/error.h"

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

namespace fvv::cli {

// Exit codes of the whole family; over several inputs the worst one counts (failed > usage > loss > done).
enum Exit { done = 0, failed = 1, usage = 2, loss = 3 };
Exit worse(Exit a, Exit b);

// One line to stderr: "TOOL: warning: TEXT". Never called for success.
void warn(const std::string &text);

// Runs body, prints "TOOL: LINE" for an Error (and for bad_alloc and the like), returns the exit code.
// Installs the handlers that remove temporary files when the run is interrupted (SIGINT, SIGTERM, SIGHUP).
int run(const char *tool, const std::function<Exit()> &body);

// For tools that write until they are stopped: from now on the first SIGINT or SIGTERM makes is_stopped()
// true, and only the next one ends the run. Inside of run().
void stop_gently();
bool is_stopped();

// "480x270", the argument of that option. Error (usage) for other text; ranges are the caller's to check.
void parse_size(const std::string &option, const std::string &text, uint32_t &width, uint32_t &height);

// The name that run() was given.
const std::string &tool();

// For tools that ask for much memory and give it back, again and again: freed memory stays with the process,
// up to some tens of megabytes a thread, where the system would take it away and clear it for the next
// request. Once, before threads start. Does nothing where the C library has no such setting.
void keep_freed_memory();

} // namespace fvv::cli
