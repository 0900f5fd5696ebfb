#include "cli/cli.h"

#include "cli/temporary.h"

#include <fcntl.h>
#include <pthread.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <string_view>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace fvv::cli {

namespace {

std::string tool_name = "fvv";
pthread_t main_thread;

volatile std::sig_atomic_t stopped = 0;

// The system gives a signal to any thread. Only the main thread knows when outputs must not be touched (it
// blocks signals then), and is neither starting nor ending.
extern "C" void interrupted(int signal) {
  if (!pthread_equal(pthread_self(), main_thread)) {
    pthread_kill(main_thread, signal);
    return;
  }
  hide_progress();
  remove_temporaries_in_handler();
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

extern "C" void asked_to_stop(int signal) {
  stopped = 1;
  std::signal(signal, interrupted);
}

// The first file that a run opens would get the number of a standard stream that is closed, and what is
// printed would be written into it. Reading from 0 and writing to 1 still fail, so that nothing is lost in
// silence.
void open_standard_descriptors() {
  const int modes[] = {O_WRONLY, O_RDONLY, O_WRONLY};
  for (int number = 0; number < 3; number++)
    if (fcntl(number, F_GETFD) < 0 && errno == EBADF && open("/dev/null", modes[number]) != number)
      std::_Exit(failed); // there is no place for a message
}

// What was ignored when the tool started (nohup, jobs of a script in the background) stays ignored.
void handle(int signal, void (*handler)(int) = interrupted) {
  struct sigaction former, action = {};
  if (sigaction(signal, nullptr, &former) == 0 && former.sa_handler == SIG_IGN) return;
  action.sa_handler = handler;
  if (handler != interrupted) action.sa_flags = SA_RESTART; // the run goes on
  sigaction(signal, &action, nullptr);
}

// A message has a line for each problem.
void print_lines(const char *tool, std::string_view text) {
  for (size_t end; !text.empty(); text.remove_prefix(std::min(text.size(), end + 1))) {
    end = std::min(text.find('\n'), text.size());
    std::fprintf(stderr, "%s: %.*s\n", tool, int(end), text.data());
  }
}

} // namespace

Exit worse(Exit a, Exit b) {
  const auto rank = [](Exit e) { return e == failed ? 3 : e == usage ? 2 : e == loss ? 1 : 0; };
  return rank(a) >= rank(b) ? a : b;
}

const std::string &tool() {
  return tool_name;
}

void warn(const std::string &text) {
  hide_progress();
  std::fprintf(stderr, "%s: warning: %s\n", tool_name.c_str(), spell(text, Spelling::command_line).c_str());
}

int run(const char *tool, const std::function<Exit()> &body) {
  open_standard_descriptors();
  tool_name = tool;
  main_thread = pthread_self();
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) handle(signal);
  // A full disk and a closed pipe are errors of write(2), reported in one line, not deaths by signal.
  for (const int signal : {SIGPIPE, SIGXFSZ}) std::signal(signal, SIG_IGN);
  try {
    const Exit exit = body();
    if (std::fflush(stdout) != 0) throw Error("standard output: cannot write");
    return exit;
  } catch (const Error &error) {
    print_lines(tool, error.in(Spelling::command_line));
    return error.kind == Error::usage ? usage : failed;
  } catch (const std::bad_alloc &) {
    std::fprintf(stderr, "%s: out of memory\n", tool);
  } catch (const std::exception &exception) {
    print_lines(tool, exception.what());
  }
  return failed;
}

void stop_gently() {
  for (const int signal : {SIGINT, SIGTERM}) handle(signal, asked_to_stop);
}

bool is_stopped() {
  return stopped != 0;
}

void parse_size(const std::string &option, const std::string &text, uint32_t &width, uint32_t &height) {
  int used = 0;
  if (text.size() > 11 || text.find_first_not_of("0123456789x") != std::string::npos ||
      std::sscanf(text.c_str(), "%5ux%5u%n", &width, &height, &used) != 2 || size_t(used) != text.size())
    throw Error(option + ": expected WIDTHxHEIGHT like 480x270, found \"" + text + "\"", Error::usage);
}

void keep_freed_memory() {
#ifdef __GLIBC__
  constexpr int megabyte = 1 << 20;
  mallopt(M_MMAP_THRESHOLD, 32 * megabyte); // the most that glibc takes
  mallopt(M_TRIM_THRESHOLD, 64 * megabyte);
#endif
}

} // namespace fvv::cli
