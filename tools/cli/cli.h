// tools/cli: what every tool of the family does alike: exit codes, one line per problem, progress, files that
// are whole or absent. Knows libfvv's I/O callbacks; knows no chunk and no option of a single tool.
#pragma once

#include "fvv/types.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace fvv::cli {

// Exit codes of the whole family; over several inputs the worst one counts (failed > usage > loss > done).
enum Exit { done = 0, failed = 1, usage = 2, loss = 3 };
Exit worse(Exit a, Exit b);

// A problem that ends the run: what() is the whole line that the user reads, "file: position: what is wrong".
class Failure : public std::runtime_error {
public:
  explicit Failure(const std::string &line, Exit code = failed) : std::runtime_error(line), exit(code) {}
  const Exit exit;
};

// A Failure with the line of a diagnostic; name is the file as the user wrote it.
[[noreturn]] void fail(const std::string &name, const fvv_diagnostic &diagnostic);
// The same when status is an error; otherwise does nothing.
void check(fvv_status status, const std::string &name, const fvv_diagnostic &diagnostic);

// One line to stderr: "TOOL: warning: TEXT". Never called for success.
void warn(const std::string &text);

// Runs body, prints "TOOL: LINE" for a Failure (and for bad_alloc and the like), answers the exit code.
// Installs the handlers that remove temporary files when the run is interrupted (SIGINT, SIGTERM, SIGHUP).
int run(const char *tool, const std::function<Exit()> &body);

// "480x270", the argument of that option. Failure (usage) for other text; ranges are the caller's to check.
void parse_size(const std::string &option, const std::string &text, uint32_t &width, uint32_t &height);

// A bar on stderr while it is a terminal, nothing in a pipe. Steps may come from one thread only.
class Progress {
public:
  Progress(const std::string &label, uint64_t steps);
  ~Progress();
  void step(uint64_t n = 1);

private:
  struct Bar;
  std::unique_ptr<Bar> bar;
};

// A file opened for reading; the callbacks of libfvv read through it with pread. Failures name path and
// reason.
class InputFile {
public:
  explicit InputFile(const std::string &path);
  ~InputFile();
  InputFile(const InputFile &) = delete;
  InputFile &operator=(const InputFile &) = delete;
  fvv_input input() const; // valid as long as this object
  uint64_t size() const { return length; }
  const std::string &path() const { return name; }

private:
  std::string name;
  int descriptor;
  uint64_t length;
};

// A file that appears under its name only when commit() is reached: written beside it under a temporary name,
// flushed to disk, renamed. Refuses an existing path unless force. Path "-" is standard output, refused when
// that is a terminal.
class OutputFile {
public:
  OutputFile(const std::string &path, bool force);
  ~OutputFile(); // without commit: removes the temporary file
  OutputFile(const OutputFile &) = delete;
  OutputFile &operator=(const OutputFile &) = delete;
  void write(const void *bytes, size_t size); // Failure names path and reason (disk full, ...)
  fvv_output output(); // for fvv_writer; after FVV_ERROR_IO, rethrow() throws the reason
  void rethrow() const;
  void commit();

private:
  static fvv_status write_callback(void *user, const void *bytes, size_t size);
  std::string name, temporary, reason;
  int descriptor;
};

// A folder that appears under its name only when commit() is reached. Refuses an existing path unless it is
// an empty folder or force; with force the former folder is replaced as a whole.
class OutputFolder {
public:
  OutputFolder(const std::string &path, bool force);
  ~OutputFolder();
  OutputFolder(const OutputFolder &) = delete;
  OutputFolder &operator=(const OutputFolder &) = delete;
  // Where to write "a/b.png" now; makes its folders. Refuses absolute names and "..": nothing leaves the
  // folder.
  std::string file(const std::string &relative) const;
  void commit();

private:
  std::string name, temporary;
  bool replace;
};

// For tools that ask for much memory and give it back, again and again: freed memory stays with the process,
// up to some tens of megabytes a thread, where the system would take it away and clear it for the next
// request. Once, before threads start. Does nothing where the C library has no such setting.
void keep_freed_memory();

} // namespace fvv::cli
