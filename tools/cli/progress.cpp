#include "cli/progress.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

namespace fvv::cli {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double redraw_seconds = 0.1, settled_seconds = 1; // before, a rate says little
constexpr char clear_line[] = "\r\x1b[K";

std::atomic<bool> is_shown = false;

bool can_clear_lines() {
  const char *terminal = std::getenv("TERM");
  return isatty(STDERR_FILENO) && terminal && std::strcmp(terminal, "dumb") != 0;
}

size_t columns() {
  winsize size;
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col ? size.ws_col : 80;
}

std::string short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, value < 10 ? "%.1f" : "%.0f", value);
  return text;
}

std::string duration(double seconds) {
  const auto whole = static_cast<long long>(std::ceil(std::min(seconds, 359999.0)));
  char text[32];
  if (whole < 60)
    std::snprintf(text, sizeof text, "%lld s", whole);
  else if (whole < 3600)
    std::snprintf(text, sizeof text, "%lld:%02lld min", whole / 60, whole % 60);
  else
    std::snprintf(text, sizeof text, "%lld:%02lld h", whole / 3600, whole / 60 % 60);
  return text;
}

// The parts that fit, by what is dropped first: the count, the rate, the label, the time.
std::string fitted(std::string label, std::string count, const std::string &percent, std::string rate,
                   std::string left, size_t width) {
  std::string line;
  for (std::string *dropped : {static_cast<std::string *>(nullptr), &count, &rate, &label, &left}) {
    if (dropped) dropped->clear();
    line.clear();
    for (const std::string &part : {label, count, percent, rate, left})
      if (!part.empty()) line += (line.empty() ? "" : "  ") + part;
    if (line.size() < width) return line; // the last column would wrap
  }
  return "";
}

} // namespace

struct Progress::Line {
  std::string label, unit;
  uint64_t steps, done = 0;
  Clock::time_point began = Clock::now(), drawn = began;

  void draw(Clock::time_point now) {
    drawn = now;
    const double seconds = std::chrono::duration<double>(now - began).count();
    std::string rate, left;
    if (seconds >= settled_seconds && done) {
      rate = short_number(double(done) / seconds) + " " + unit + "/s";
      left = duration(seconds / double(done) * double(steps - done)) + " left";
    }
    const std::string text = fitted(label, std::to_string(done) + " of " + std::to_string(steps) + " " + unit,
                                    std::to_string(done * 100 / steps) + " %", rate, left, columns());
    is_shown = true;
    std::fprintf(stderr, "%s%s", clear_line, text.c_str());
    std::fflush(stderr);
  }
};

Progress::Progress(const std::string &label, uint64_t steps, const std::string &unit) {
  if (!steps || !can_clear_lines()) return;
  line = std::make_unique<Line>();
  line->label = label;
  // A name of a file may hold anything.
  std::replace_if(
      line->label.begin(), line->label.end(), [](unsigned char c) { return c < 32 || c == 127; }, '?');
  line->unit = unit;
  line->steps = steps;
}

Progress::~Progress() {
  if (line) hide_progress();
}

void Progress::step(uint64_t n) {
  if (!line) return;
  line->done = std::min(line->done + n, line->steps);
  const Clock::time_point now = Clock::now();
  if (std::chrono::duration<double>(now - line->drawn).count() >= redraw_seconds) line->draw(now);
}

void hide_progress() {
  if (is_shown.exchange(false) && write(STDERR_FILENO, clear_line, sizeof clear_line - 1) < 0) return;
}

} // namespace fvv::cli
