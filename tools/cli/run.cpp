#include "cli/cli.h"

#include "cli/temporary.h"

#include <csignal>
#include <cstdio>
#include <new>

namespace fvv::cli {

namespace {

std::string tool_name = "fvv";

extern "C" void interrupted(int signal) {
  remove_temporaries_in_handler();
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

} // namespace

Exit worse(Exit a, Exit b) {
  const auto rank = [](Exit e) { return e == failed ? 3 : e == usage ? 2 : e == loss ? 1 : 0; };
  return rank(a) >= rank(b) ? a : b;
}

void warn(const std::string &text) {
  std::fprintf(stderr, "%s: warning: %s\n", tool_name.c_str(), text.c_str());
}

int run(const char *tool, const std::function<Exit()> &body) {
  tool_name = tool;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, interrupted);
  // A full disk and a closed pipe are errors of write(2), told in one line, not deaths by signal.
  for (const int signal : {SIGPIPE, SIGXFSZ}) std::signal(signal, SIG_IGN);
  try {
    const Exit exit = body();
    if (std::fflush(stdout) != 0) throw Error("standard output: cannot write");
    return exit;
  } catch (const Error &error) {
    std::fprintf(stderr, "%s: %s\n", tool, error.what());
    return error.kind == Error::usage ? usage : failed;
  } catch (const std::bad_alloc &) {
    std::fprintf(stderr, "%s: out of memory\n", tool);
  } catch (const std::exception &exception) {
    std::fprintf(stderr, "%s: %s\n", tool, exception.what());
  }
  return failed;
}

} // namespace fvv::cli
