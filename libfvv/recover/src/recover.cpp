// The three passes: is anything wrong; which configuration blocks are there; group by group what is left.
#include "fvv_recover/recover.h"

#include "recover/src/trial.h"

#include <algorithm>
#include <cstring>

namespace fvv::recover {

namespace {

constexpr size_t most_losses = 1000;
// A group whose chunks break rules is tried again without them; damage never takes that many rounds.
constexpr int most_trials = 32;
// Configurations that a group without GRUP is tried with.
constexpr size_t most_digests = 64;

// The new stream. What is written is read by a checker, too.
class Output {
public:
  Output(const Write &to, const std::optional<std::array<uint8_t, 24>> &original_header)
      : write(to), header(original_header), checker(make_checker(false)),
        writer(make_writer({&Output::take, this})) {}

  fvv_status block(const Block &block, Payloads &payloads, bool repeat, fvv_diagnostic *why) {
    if (current && *current == block.digest)
      return repeat ? fvv_writer_repeat_configuration(writer.get(), why) : FVV_OK;
    const fvv_status status = write_block(writer.get(), block, payloads, why);
    if (status == FVV_OK) current = block.digest;
    return status;
  }

  // The group has passed its trial: no error is one of the stream.
  void group(const Head &head, const Slots &slots, const std::vector<Part> &parts, Payloads &payloads) {
    fvv_diagnostic why = {};
    check(fvv_writer_begin_group(writer.get(), head.start, head.end, &why), why);
    for (const Part &part : parts) {
      const Chunk &chunk = slots.slots[part.slot].chunk;
      const std::vector<uint8_t> &payload = payloads.read(chunk);
      check(fvv_writer_chunk(writer.get(), chunk.header.type, chunk.header.track, chunk.header.flags,
                             part.time, payload.data(), payload.size(), &why),
            why);
    }
    check(fvv_writer_end_group(writer.get(), &why), why);
  }

  uint64_t finish() {
    fvv_diagnostic why = {};
    check(fvv_writer_finish(writer.get(), &why), why);
    const fvv_status status = fvv_checker_finish(checker.get());
    if (const fvv_diagnostic *problem = fvv_checker_problem(checker.get(), 0))
      fvv::fail("new stream", *problem);
    fvv::check(status, "new stream", {});
    return fvv_writer_position(writer.get());
  }

private:
  static fvv_status take(void *user, const void *bytes, size_t size) {
    auto &self = *static_cast<Output *>(user);
    try {
      const bool is_header = self.at == 0 && size == layout::file_header::size && self.header;
      const void *out = is_header ? self.header->data() : bytes;
      self.at += size;
      if (fvv_checker_push(self.checker.get(), out, size) == FVV_ERROR_MEMORY) throw std::bad_alloc();
      self.write(out, size);
      return FVV_OK;
    } catch (...) {
      self.failure = std::current_exception(); // not through C
      return FVV_ERROR_IO;
    }
  }

  void check(fvv_status status, const fvv_diagnostic &why) {
    if (failure) std::rethrow_exception(failure);
    fvv::check(status, "new stream", why);
  }

  const Write &write;
  const std::optional<std::array<uint8_t, 24>> header;
  uint64_t at = 0;
  std::exception_ptr failure;
  Checker checker;
  Writer writer;
  std::optional<uint32_t> current; // digest of the block that holds
};

// A group that is being read.
struct OpenGroup {
  Head head = {};
  uint64_t offset = 0;
  std::vector<Chunk> chunks;
  std::optional<uint8_t> end_counter; // of GEND, also where its payload is damaged
  fvv_diagnostic damage = {};         // the first
};

class Recovery {
public:
  Recovery(const InputFile &input, const Write &to, const std::function<void(uint64_t)> &progress,
           Result &result)
      : file(input), found(survey(input, progress)), scanner(input, progress), write(to), out(result),
        payloads(input) {
    for (const auto &[digest, block] : found.blocks)
      if (digests.size() < most_digests) digests.push_back(digest);
  }

  void run() {
    fvv_event event;
    while (scanner.next(event)) {
      if (event.kind == FVV_EVENT_CHUNK) take_chunk(event);
      if (event.kind == FVV_EVENT_DAMAGE) take_damage(event);
    }
    if (scanner.stopped().status != FVV_OK) note(scanner.stopped());
    close(std::nullopt);
    if (headless) {
      Loss last;
      last.offset = *headless;
      last.why = between.status ? between : invented(*headless, FVV_ISSUE_CHUNK_PLACE, "no group is open");
      report(last);
    }
    if (output && out.has_kept()) out.bytes_written = output->finish();
    count_losses();
  }

private:
  void note(const fvv_diagnostic &damage) {
    fvv_diagnostic &place = open ? open->damage : between;
    if (place.status == FVV_OK) place = damage;
  }

  void take_chunk(const fvv_event &event) {
    const Chunk chunk = {event.chunk, event.offset, is_regular(event.chunk)};
    switch (place_of(event.chunk.type, event.chunk.flags)) {
    case Place::configuration:
      if (event.chunk.type == FVV_CHUNK_SCENE || open) close(std::nullopt);
      in_block = block_passed = true;
      return;
    case Place::unknown:
      if (!in_block) add(chunk);
      return;
    case Place::frame:
      add(chunk);
      return;
    case Place::group:
      if (event.chunk.type == FVV_CHUNK_GROUP)
        begin(event);
      else
        end(event);
      return;
    case Place::end:
      close(std::nullopt);
      has_footer = event.chunk.type == FVV_CHUNK_FOOTER;
    }
  }

  // The header of a chunk is good, its payload is not; or bytes without a header.
  void take_damage(const fvv_event &event) {
    note(event.diagnostic);
    if (!event.has_chunk) return;
    const Place place = place_of(event.chunk.type, event.chunk.flags);
    if (place == Place::configuration || event.chunk.type == FVV_CHUNK_GROUP) {
      close(std::nullopt);
      note(event.diagnostic);
      block_passed = block_passed || place == Place::configuration;
    } else if (event.chunk.type == FVV_CHUNK_GROUP_END) {
      if (open && event.chunk.time == open->head.end) open->end_counter = event.chunk.counter;
      close(std::nullopt);
    } else if (place == Place::frame || (place == Place::unknown && !in_block)) {
      add({event.chunk, event.offset, false});
    }
  }

  void add(const Chunk &chunk) {
    in_block = false;
    const bool is_own = open && chunk.header.time >= open->head.start && chunk.header.time < open->head.end;
    std::vector<Chunk> &list = is_own ? open->chunks : strays;
    if (list.size() < most_chunks) list.push_back(chunk);
  }

  void begin(const fvv_event &event) {
    const std::optional<Head> head = parse_head(event);
    // The same GRUP again: bytes were repeated.
    if (head && open && !std::memcmp(&*head, &open->head, sizeof *head)) return;
    close(std::nullopt);
    if (!head) return;
    open.emplace();
    open->head = *head;
    open->offset = event.offset;
    open->damage = between;
    between = {};
  }

  void end(const fvv_event &event) {
    const std::optional<End> parsed = parse_end(event);
    if (open && parsed && parsed->sequence == open->head.sequence && parsed->time == open->head.end) {
      open->end_counter = event.chunk.counter;
      close(parsed);
      return;
    }
    const std::vector<Chunk> remains = strays;
    close(std::nullopt);
    if (parsed) take_headless(remains, *parsed, event);
  }

  void take_headless(const std::vector<Chunk> &chunks, const End &parsed, const fvv_event &event) {
    const std::optional<Head> head = prove_head(chunks, parsed, digests);
    if (!head) return;
    open.emplace();
    open->head = *head;
    open->offset = chunks.front().offset;
    open->chunks = chunks;
    open->end_counter = event.chunk.counter;
    open->damage = between;
    between = {};
    close(parsed);
  }

  void close(const std::optional<End> &parsed) {
    in_block = false;
    if (!strays.empty() && !headless) headless = strays.front().offset;
    strays.clear();
    if (!open) return;
    OpenGroup group = std::move(*open);
    open.reset();
    const fvv_diagnostic damage = group.damage;
    finish(group, parsed);
    // What follows the group up to the next one.
    if (!parsed) between = damage;
  }

  void finish(const OpenGroup &group, const std::optional<End> &parsed) {
    const Head &head = group.head;
    if (has_any && head.sequence < next) return; // bytes were repeated, or are in another order
    if (head.sequence != next) {
      Loss missing;
      missing.offset = group.offset;
      missing.sequence = next;
      missing.groups = head.sequence - next;
      missing.why = group.damage;
      if (missing.why.status == FVV_OK)
        missing.why = invented(group.offset, FVV_ISSUE_GROUP_SEQUENCE, "groups are missing");
      report(missing);
    }
    has_any = true;
    headless.reset(); // the numbers count it
    next = head.sequence + 1;
    Loss loss;
    loss.offset = group.offset;
    loss.sequence = head.sequence;
    loss.start = head.start;
    loss.end = head.end;
    loss.why = group.damage;
    Slots slots = arrange(group.chunks, head.start, parsed, group.end_counter);
    const size_t had_frames = slots.frames().size();
    const bool is_exact = !slots.has_gaps();
    const bool was_whole = slots.is_whole();
    const uint64_t frames = keep(group, parsed, slots, loss);
    loss.frames_kept = frames;
    const size_t kept_chunks = last_parts;
    if (is_exact) loss.frames_lost = had_frames - std::min<uint64_t>(frames, had_frames);
    known_frames += had_frames;
    loss.chunks_lost = slots.slots.size() - kept_chunks;
    out.frames_kept += frames;
    if (was_whole && !loss.chunks_lost && kept) {
      (new_number == head.sequence ? out.groups_copied : out.groups_renumbered)++;
      return;
    }
    if (kept) out.groups_reduced++;
    loss.groups = kept ? 0 : 1;
    if (loss.why.status == FVV_OK)
      loss.why = invented(group.offset, FVV_ISSUE_GROUP_UNFINISHED, "the group has no end");
    report(loss);
  }

  // Writes what can be kept of a group and returns its frames. loss.why: the reason for what cannot.
  uint64_t keep(const OpenGroup &group, const std::optional<End> &parsed, Slots &slots, Loss &loss) {
    const Head &head = group.head;
    kept = false;
    last_parts = 0;
    const auto reason = [&](const fvv_diagnostic &why) {
      if (loss.why.status == FVV_OK) loss.why = why;
    };
    const auto block = found.blocks.find(head.digest);
    if (block == found.blocks.end()) {
      reason(invented(group.offset, FVV_ISSUE_GROUP_CONFIGURATION,
                      "the configuration block of the group is lost"));
      return 0;
    }
    if (head.start < last_end) {
      reason(invented(group.offset, FVV_ISSUE_GROUP_TIME, "the group begins before the former one ends"));
      return 0;
    }
    if (parsed && !fits_chain(head, *parsed, slots)) {
      reason(invented(group.offset, FVV_ISSUE_GROUP_END,
                      "a chunk is not of this group: the chain in GEND does not match"));
      return 0;
    }
    drop_other_environments(head.digest, slots, loss);
    std::vector<Part> parts;
    Verdict verdict;
    for (int trial = 0; trial < most_trials; trial++) {
      parts = select(slots, block->second.tiled);
      if (parts.empty() && !slots.slots.empty()) return 0;
      if (parts.empty() && slots.has_gaps()) return 0;
      verdict = try_group(block->second, head, slots, parts, payloads);
      for (const auto &[part, why] : verdict.bad) {
        slots.slots[parts[part].slot].usable = false;
        reason(why);
      }
      if (verdict.bad.empty()) break;
    }
    if (!verdict.is_good()) {
      reason(verdict.group);
      return 0;
    }
    fvv_diagnostic why = {};
    if (!output) output = std::make_unique<Output>(write, scanner.file_header());
    const fvv_status status = output->block(block->second, payloads, block_passed, &why);
    if (status != FVV_OK) { // another time base or lattice than the first block
      reason(why);
      return 0;
    }
    block_passed = false;
    output->group(head, slots, parts, payloads);
    remember_environments(head.digest, slots, parts);
    last_end = head.end;
    last_parts = parts.size();
    kept = true;
    new_number = numbered++;
    return verdict.frames;
  }

  // Where all headers are known: whether they are those of the group.
  static bool fits_chain(const Head &head, const End &end, const Slots &slots) {
    if (slots.has_gaps() || slots.slots.size() != end.table.size()) return true;
    std::vector<Chunk> chunks;
    for (const Slot &slot : slots.slots) {
      if (!slot.chunk.offset) return true; // the table alone tells of it
      chunks.push_back(slot.chunk);
    }
    return chunks.empty() || prove_head(chunks, end, {head.digest}).has_value();
  }

  // All BACK chunks of a track under one configuration are equal (FVV-8004).
  void drop_other_environments(uint32_t digest, Slots &slots, Loss &loss) {
    if (digest != environment_digest) return;
    for (Slot &slot : slots.slots) {
      const fvv_chunk_header &h = slot.chunk.header;
      const auto first = environments.find(h.track);
      if (h.type != FVV_CHUNK_ENVIRONMENT || first == environments.end() ||
          first->second == std::make_pair(h.size, h.payload_crc))
        continue;
      slot.usable = false;
      if (loss.why.status == FVV_OK)
        loss.why = invented(slot.chunk.offset, FVV_ISSUE_ENVIRONMENT_SAME,
                            "another environment than before under the same configuration");
    }
  }
  void remember_environments(uint32_t digest, const Slots &slots, const std::vector<Part> &parts) {
    if (digest != environment_digest) environments.clear();
    environment_digest = digest;
    for (const Part &part : parts) {
      const fvv_chunk_header &h = slots.slots[part.slot].chunk.header;
      if (h.type == FVV_CHUNK_ENVIRONMENT)
        environments.emplace(h.track, std::make_pair(h.size, h.payload_crc));
    }
  }

  static fvv_diagnostic invented(uint64_t offset, uint32_t issue, const char *text) {
    fvv_diagnostic out = {};
    out.status = FVV_ERROR_DAMAGED;
    out.issue = issue;
    out.chunk_type = FVV_CHUNK_GROUP;
    out.offset = offset;
    std::strncpy(out.message, text, sizeof out.message - 1);
    return out;
  }

  void report(const Loss &loss) {
    out.groups_lost += loss.groups;
    if (loss.frames_lost)
      listed_lost += *loss.frames_lost;
    else
      out.frames_lost_is_exact = false;
    if (out.losses.size() < most_losses) out.losses.push_back(loss);
  }

  void count_losses() {
    out.frames_lost = std::max(listed_lost, known_frames - std::min(known_frames, out.frames_kept));
    if (found.frames && *found.frames >= out.frames_kept + out.frames_lost) {
      out.frames_lost = *found.frames - out.frames_kept;
      out.frames_lost_is_exact = true;
    } else if (!found.frames && !has_footer) {
      out.frames_lost_is_exact = false; // nothing says what followed
    }
    const uint64_t groups = out.groups_copied + out.groups_renumbered + out.groups_reduced;
    if (found.groups && *found.groups > groups) out.groups_lost = *found.groups - groups;
  }

  const InputFile &file;
  const Survey found;
  Scanner scanner;
  const Write &write;
  Result &out;
  Payloads payloads;
  std::unique_ptr<Output> output;
  std::vector<uint32_t> digests;
  std::optional<OpenGroup> open;
  std::vector<Chunk> strays;        // of a group whose GRUP is lost
  std::optional<uint64_t> headless; // where such a group begins that was left out, after the last other one
  fvv_diagnostic between = {};      // the first damage between two groups
  bool in_block = false, block_passed = false, has_footer = false, has_any = false, kept = false;
  uint32_t next = 0, numbered = 0, new_number = 0;
  size_t last_parts = 0;
  int64_t last_end = INT64_MIN;
  uint64_t listed_lost = 0, known_frames = 0;
  uint32_t environment_digest = 0;
  std::map<uint16_t, std::pair<uint64_t, uint32_t>> environments;
};

// What fvvinfo --check reports.
void check_input(const InputFile &file, const std::function<void(uint64_t)> &progress, Result &result) {
  const Checker checker = make_checker(true);
  const fvv_input input = file.input();
  std::vector<uint8_t> portion(size_t(1) << 18);
  const auto read = [&](bool counts) {
    fvv_status status = FVV_OK;
    for (uint64_t at = 0; at < input.size && status == FVV_OK;) {
      const auto size = static_cast<size_t>(std::min<uint64_t>(input.size - at, portion.size()));
      if (input.read_at(input.user, at, portion.data(), size) != FVV_OK)
        throw Error(file.path(), "cannot read");
      status = fvv_checker_push(checker.get(), portion.data(), size);
      if (progress && counts) progress(size);
      at += size;
    }
    return fvv_checker_finish(checker.get());
  };
  fvv_status status = read(true);
  if (status == FVV_NEED_DATA) status = read(false);
  if (status == FVV_ERROR_MEMORY) throw std::bad_alloc();
  const fvv_check_summary *summary = fvv_checker_summary(checker.get());
  result.bytes_read = input.size;
  result.problem_count = summary->problems;
  bool is_cut_only = true;
  for (size_t i = 0; i < fvv_checker_problem_count(checker.get()); i++) {
    result.problems.push_back(*fvv_checker_problem(checker.get(), i));
    is_cut_only = is_cut_only && result.problems.back().status == FVV_ERROR_TRUNCATED;
  }
  const bool is_whole = status == FVV_OK && !summary->problems && summary->has_footer;
  result.state = is_whole                          ? State::whole
                 : is_cut_only && status == FVV_OK ? State::unfinished
                                                   : State::damaged;
  if (!is_whole) return;
  result.groups_copied = summary->groups;
  result.frames_kept = summary->frames;
}

void copy(const InputFile &file, const Write &write, const std::function<void(uint64_t)> &progress) {
  const fvv_input input = file.input();
  std::vector<uint8_t> portion(size_t(1) << 18);
  for (uint64_t at = 0; at < input.size; at += portion.size()) {
    portion.resize(static_cast<size_t>(std::min<uint64_t>(input.size - at, portion.size())));
    if (input.read_at(input.user, at, portion.data(), portion.size()) != FVV_OK)
      throw Error(file.path(), "cannot read");
    write(portion.data(), portion.size());
    if (progress) progress(portion.size());
  }
}

} // namespace

Result recover(const InputFile &file, const Write &write, const Options &options) {
  Result result;
  check_input(file, options.progress, result);
  if (result.state == State::whole) {
    copy(file, write, options.progress);
    result.bytes_written = file.size();
    return result;
  }
  Recovery(file, write, options.progress, result).run();
  return result;
}

} // namespace fvv::recover
