// A new stream from what is whole in a damaged or unfinished one. docs/tools/fvvrecover.md has the rules that
// users read.
#pragma once

#include "fvv/types.h"
#include "fvv_cxx/input_file.h"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace fvv::recover {

enum class State {
  whole,      // nothing is wrong: the output has the same bytes
  unfinished, // nothing is wrong but that the end is missing: live, or cut
  damaged
};

// A group of which not everything was kept.
struct Loss {
  uint64_t offset = 0;              // where it begins in the input, or where the damage was found
  std::optional<uint32_t> sequence; // unknown where its head is lost
  int64_t start = 0, end = 0;       // ticks; of groups whose head is known
  uint64_t groups = 1;              // more where a range of sequence numbers is missing
  uint64_t frames_kept = 0;
  std::optional<uint64_t> frames_lost; // unknown where chunks are missing that nothing lists
  uint64_t chunks_lost = 0;            // that are known: damaged, or intact but of no use without others
  fvv_diagnostic why = {};
};

struct Result {
  State state = State::damaged;
  uint64_t bytes_read = 0, bytes_written = 0;
  std::vector<fvv_diagnostic> problems; // of the input: the first ones, as fvvinfo --check reports them
  uint64_t problem_count = 0;
  uint64_t groups_copied = 0;     // with the bytes that they had
  uint64_t groups_renumbered = 0; // whole, with another sequence number because groups before them are lost
  uint64_t groups_reduced = 0;    // without the frames or chunks that are lost
  uint64_t groups_lost = 0;       // at least: where the end is missing, nothing says how many followed
  uint64_t frames_kept = 0;
  uint64_t frames_lost = 0;         // at least
  bool frames_lost_is_exact = true; // not only at least
  std::vector<Loss> losses;         // the first ones, in order
  bool has_kept() const { return groups_copied + groups_renumbered + groups_reduced != 0; }
  bool has_lost() const { return state != State::whole; }
};

struct Options {
  std::function<void(uint64_t bytes)> progress; // bytes that were read since the last call; may be empty
};

// The file is read this many times at most, for the steps of progress.
constexpr uint64_t passes = 3;

using Write = std::function<void(const void *bytes, size_t size)>;

// Passes the new stream to write, in order. When Result::has_kept() is false, what was written is no use.
// What is written passes fvvinfo --check without a problem. Memory is bounded by the largest group, not by
// the file. Throws Error when the file cannot be read or changes while it is read, and what write throws.
Result recover(const InputFile &file, const Write &write, const Options &options = {});

} // namespace fvv::recover
