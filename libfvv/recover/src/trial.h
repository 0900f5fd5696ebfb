// A group written as the only one of a stream and checked as fvvinfo --check does, before it is kept.
#pragma once

#include "recover/src/group.h"
#include "recover/src/scan.h"

#include <memory>
#include <utility>

namespace fvv::recover {

struct Verdict {
  uint64_t frames = 0;                                // that are whole, when nothing is wrong
  std::vector<std::pair<size_t, fvv_diagnostic>> bad; // parts that break a rule; offsets as in the file
  fvv_diagnostic group = {};                          // of all else that is wrong
  bool is_good() const { return bad.empty() && group.status == FVV_OK; }
};

Verdict try_group(const Block &block, const Head &head, const Slots &slots, const std::vector<Part> &parts,
                  Payloads &payloads);

using Writer = std::unique_ptr<fvv_writer, void (*)(fvv_writer *)>;
Writer make_writer(const fvv_output &output);
// Writes a block; an error is one of the block.
fvv_status write_block(fvv_writer *writer, const Block &block, Payloads &payloads,
                       fvv_diagnostic *diagnostic);

struct DestroyChecker {
  void operator()(fvv_checker *checker) const { fvv_checker_destroy(checker); }
};
using Checker = std::unique_ptr<fvv_checker, DestroyChecker>;
Checker make_checker(bool decode);

} // namespace fvv::recover
