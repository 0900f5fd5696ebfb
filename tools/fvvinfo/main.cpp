// fvvinfo: what is in a fvv file, and whether it is whole.
#include "cli/cli.h"
#include "cli/help.h"
#include "cli/progress.h"
#include "fvv_cxx/error.h"
#include "fvv_info/report.h"

#include <CLI/CLI.hpp>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

using namespace fvv;
namespace {

// A pipe whose first configuration is damaged is read again when a repetition has come, up to that size.
constexpr uint64_t largest_copy = uint64_t(1) << 30;

// A descriptor that is closed when reading ends in any way.
class Source {
public:
  explicit Source(const std::string &path) : name(path == "-" ? "standard input" : path) {
    if (path == "-" && isatty(STDIN_FILENO))
      throw Error("standard input is a terminal: name a file or pipe a stream into it", Error::usage);
    if (path == "-") {
      descriptor = STDIN_FILENO;
      if (!size()) copy.reset(std::tmpfile());
      return;
    }
    descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) throw Error(name + ": cannot be opened: " + std::strerror(errno));
    struct stat status;
    if (fstat(descriptor, &status) != 0 || !S_ISDIR(status.st_mode)) return;
    close(descriptor);
    throw Error(name + ": is a folder, expected a file");
  }
  ~Source() {
    if (descriptor != STDIN_FILENO) close(descriptor);
  }
  Source(const Source &) = delete;
  Source &operator=(const Source &) = delete;

  uint64_t size() const { // 0 when it is not known
    struct stat status;
    return fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) ? uint64_t(status.st_size) : 0;
  }
  const std::string &shown() const { return name; }
  bool rewind() {
    if (!copy) return lseek(descriptor, 0, SEEK_SET) == 0;
    copy_is_read = std::fseek(copy.get(), 0, SEEK_SET) == 0;
    return copy_is_read;
  }
  // A pipe is not kept any longer.
  void settle() {
    if (!copy_is_read) copy.reset();
  }
  size_t read(uint8_t *out, size_t size) {
    if (copy_is_read) return std::fread(out, 1, size, copy.get());
    for (;;) {
      const ssize_t n = ::read(descriptor, out, size);
      if (n >= 0) return keep(out, size_t(n));
      if (errno != EINTR) throw Error(name + ": cannot read: " + std::strerror(errno));
    }
  }

private:
  // Where that fails the pipe is read once.
  size_t keep(const uint8_t *bytes, size_t size) {
    copied += size;
    if (copy && (copied > largest_copy || std::fwrite(bytes, 1, size, copy.get()) != size)) copy.reset();
    return size;
  }

  struct Close {
    void operator()(std::FILE *file) const { std::fclose(file); }
  };
  std::string name;
  int descriptor;
  std::unique_ptr<std::FILE, Close> copy; // of a pipe, without a name
  uint64_t copied = 0;
  bool copy_is_read = false;
};

info::Report inspect(const std::string &path, const info::Options &options) {
  Source source(path);
  std::unique_ptr<cli::Progress> progress;
  const auto begin = [&] {
    progress = std::make_unique<cli::Progress>("reading " + source.shown(), source.size() >> 20, "MiB");
  };
  begin();
  info::Input input;
  input.name = source.shown();
  input.seekable = true;
  input.size = source.size();
  input.read = [&](uint8_t *out, size_t most) {
    const size_t n = source.read(out, most);
    if (n == most) progress->step(most >> 20);
    return n;
  };
  input.rewind = [&] {
    begin();
    return source.rewind();
  };
  input.settle = [&] { source.settle(); };
  return info::inspect(input, options);
}

// done; loss: only an early end; failed: anything else.
cli::Exit exit_of(const info::Report &report) {
  const std::string state = report.integrity();
  return state == "complete" ? cli::done : state == "truncated" ? cli::loss : cli::failed;
}

// One line for each problem; a truncated stream also says what is left of it.
void tell_problems(const info::Report &report) {
  for (size_t i = 0; i < fvv_checker_problem_count(report.checker.get()); i++) {
    char line[1024];
    fvv_diagnostic_format(fvv_checker_problem(report.checker.get(), i), report.name.c_str(), line,
                          sizeof line);
    std::fprintf(stderr, "%s\n", line);
  }
  const auto &s = report.summary();
  const uint64_t kept = fvv_checker_problem_count(report.checker.get());
  if (s.problems > kept)
    std::fprintf(stderr, "%s: and %llu problems more\n", report.name.c_str(),
                 (unsigned long long)(s.problems - kept));
  if (exit_of(report) == cli::loss && !s.problems)
    std::fprintf(stderr, "%s: 0x%llx: no footer: the stream is live or truncated\n", report.name.c_str(),
                 (unsigned long long)s.bytes);
}

} // namespace

int main(int argc, char **argv) {
  CLI::App app{"Show what is in fvv files and whether they are whole."};
  std::vector<std::string> files;
  info::Options options;
  bool as_json = false;
  app.add_option("FILE", files, "fvv files; - is standard input")->required()->type_name("FILE.fvv");
  app.add_flag("--json", as_json, "print JSON (spec/fvvinfo.schema.json)");
  app.add_flag("--chunks", options.chunks, "list every chunk");
  app.add_flag("--check", options.check, "decode every mesh and check every video sample as well");
  app.footer("Exit code: 0 all whole, 1 damaged or unreadable, 2 usage, 3 truncated (or live: no footer).");
  cli::set_help(app, "fvvinfo",
                {
                    "fvvinfo players.fvv",
                    "fvvinfo --check --json players.fvv",
                });
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError &error) {
    return cli::end_of_parsing(app, error);
  }
  return cli::run("fvvinfo", [&] {
    cli::Exit worst = cli::done;
    std::vector<nlohmann::ordered_json> found;
    for (const auto &file : files) {
      try {
        const info::Report report = inspect(file, options);
        if (as_json)
          found.push_back(info::json(report));
        else
          std::fputs(spell(info::text(report), Spelling::command_line).c_str(), stdout);
        std::fflush(stdout);
        tell_problems(report);
        worst = cli::worse(worst, exit_of(report));
      } catch (const Error &failure) {
        // The other inputs are still read.
        std::fprintf(stderr, "fvvinfo: %s\n", failure.what());
        worst = cli::worse(worst, failure.kind == Error::usage ? cli::usage : cli::failed);
      }
    }
    if (as_json) std::printf("%s\n", info::document(found).c_str());
    return worst;
  });
}
