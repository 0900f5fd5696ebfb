#include "recover/src/trial.h"

#include <algorithm>

namespace fvv::recover {

Writer make_writer(const fvv_output &output) {
  fvv_writer *created = nullptr;
  fvv_diagnostic why = {};
  fvv::check(fvv_writer_create(&output, nullptr, &created, &why), "", why);
  return {created, fvv_writer_destroy};
}

Checker make_checker(bool decode) {
  fvv_check_options options;
  fvv_check_options_default(&options);
  options.decode = decode;
  fvv_checker *created = nullptr;
  if (fvv_checker_create(&options, nullptr, nullptr, &created) != FVV_OK) throw std::bad_alloc();
  return Checker(created);
}

fvv_status write_block(fvv_writer *writer, const Block &block, Payloads &payloads,
                       fvv_diagnostic *diagnostic) {
  fvv_status status = FVV_OK;
  for (size_t i = 0; i < block.chunks.size() && status == FVV_OK; i++) {
    const Chunk &chunk = block.chunks[i];
    const std::vector<uint8_t> &payload = payloads.read(chunk);
    status = fvv_writer_configuration(writer, chunk.header.type, chunk.header.track, chunk.header.flags,
                                      payload.data(), payload.size(), diagnostic);
    if (status != FVV_OK && diagnostic) diagnostic->offset = chunk.offset;
  }
  return status;
}

namespace {

fvv_status push(void *user, const void *bytes, size_t size) {
  // The checker keeps its error; the trial asks for it in the end.
  const fvv_status status = fvv_checker_push(static_cast<fvv_checker *>(user), bytes, size);
  return status == FVV_ERROR_MEMORY ? FVV_ERROR_IO : FVV_OK;
}

struct Range {
  uint64_t begin, end; // in the trial
};

// Writes the group; false: result says what is wrong with it.
bool write(fvv_writer *writer, const Block &block, const Head &head, const Slots &slots,
           const std::vector<Part> &parts, Payloads &payloads, std::vector<Range> &ranges, Verdict &result) {
  fvv_diagnostic why = {};
  fvv_status status = write_block(writer, block, payloads, &why);
  if (status == FVV_OK) status = fvv_writer_begin_group(writer, head.start, head.end, &why);
  if (status != FVV_OK) {
    result.group = why;
    return false;
  }
  for (size_t i = 0; i < parts.size(); i++) {
    const Chunk &chunk = slots.slots[parts[i].slot].chunk;
    const std::vector<uint8_t> &payload = payloads.read(chunk);
    const uint64_t begin = fvv_writer_position(writer);
    status = fvv_writer_chunk(writer, chunk.header.type, chunk.header.track, chunk.header.flags,
                              parts[i].time, payload.data(), payload.size(), &why);
    if (status != FVV_OK) {
      why.offset = chunk.offset;
      result.bad.emplace_back(i, why);
      return false;
    }
    ranges.push_back({begin, fvv_writer_position(writer)});
  }
  status = fvv_writer_end_group(writer, &why);
  if (status == FVV_OK) status = fvv_writer_finish(writer, &why);
  if (status != FVV_OK) result.group = why;
  return status == FVV_OK;
}

} // namespace

Verdict try_group(const Block &block, const Head &head, const Slots &slots, const std::vector<Part> &parts,
                  Payloads &payloads) {
  const Checker checker = make_checker(true);
  const fvv_output output = {push, checker.get()};
  const Writer writer = make_writer(output);
  std::vector<Range> ranges;
  Verdict result;
  if (!write(writer.get(), block, head, slots, parts, payloads, ranges, result)) return result;
  if (fvv_checker_finish(checker.get()) == FVV_ERROR_MEMORY) throw std::bad_alloc();
  for (size_t i = 0; i < fvv_checker_problem_count(checker.get()); i++) {
    fvv_diagnostic problem = *fvv_checker_problem(checker.get(), i);
    const auto range = std::upper_bound(ranges.begin(), ranges.end(), problem.offset,
                                        [](uint64_t offset, const Range &r) { return offset < r.end; });
    const bool is_of_part = range != ranges.end() && problem.offset >= range->begin;
    const size_t part = static_cast<size_t>(range - ranges.begin());
    if (is_of_part) problem.offset += slots.slots[parts[part].slot].chunk.offset - range->begin;
    if (is_of_part)
      result.bad.emplace_back(part, problem);
    else if (result.group.status == FVV_OK)
      result.group = problem;
  }
  const fvv_check_summary *summary = fvv_checker_summary(checker.get());
  result.frames = summary->whole_frames;
  if (result.is_good() && (summary->whole_frames != summary->frames || summary->problems)) {
    result.group.status = FVV_ERROR_BUG;
    result.group.offset = slots.slots.empty() ? 0 : slots.slots.front().chunk.offset;
  }
  return result;
}

} // namespace fvv::recover
