#include "fvvrecover/command.h"

#include "cli/cli.h"
#include "cli/output.h"
#include "cli/progress.h"
#include "fvv_cxx/format.h"

#include <memory>

namespace fvv::recover {

namespace {

constexpr uint64_t progress_step = uint64_t(1) << 20;

// A step for each MiB of all passes.
class Steps {
public:
  Steps(const std::string &name, uint64_t size)
      : bar("reading " + name, passes * size / progress_step, "MiB"), left(progress_step) {}
  void add(uint64_t bytes) {
    for (; bytes >= left; left = progress_step) {
      bytes -= left;
      bar.step();
    }
    left -= bytes;
  }

private:
  cli::Progress bar;
  uint64_t left;
};

} // namespace

bool is_empty(const Result &result) {
  return !result.has_kept() && result.state != State::whole;
}

Result run(const Command &command) {
  const InputFile file(command.input);
  std::unique_ptr<cli::OutputFile> output;
  if (!command.output.empty())
    output = std::make_unique<cli::OutputFile>(command.output, command.force, cli::inputs({command.input}));
  Result result;
  {
    Steps steps(command.input, file.size());
    Options options;
    options.progress = [&](uint64_t bytes) { steps.add(bytes); };
    result = recover(
        file,
        [&](const void *bytes, size_t size) {
          if (output) output->write(bytes, size);
        },
        options);
  }
  if (is_empty(result))
    result.bytes_written = 0;
  else if (output)
    output->commit();
  return result;
}

std::vector<std::string> messages(const Command &command, const Result &result) {
  std::vector<std::string> lines;
  for (const Loss &loss : result.losses) lines.push_back(text(command.input, loss));
  if (result.state == State::unfinished)
    lines.push_back(command.input + fvv::format(": 0x%llx: no footer: whether more followed is not known",
                                                static_cast<unsigned long long>(result.bytes_read)));
  if (result.state == State::damaged && result.losses.empty() && !result.problems.empty()) {
    char line[1024];
    fvv_diagnostic_format(&result.problems.front(), command.input.c_str(), line, sizeof line);
    lines.push_back(std::string(line) + "; nothing is lost");
  }
  if (is_empty(result)) lines.push_back(command.input + ": nothing can be kept: no group has a whole frame");
  return lines;
}

} // namespace fvv::recover
