// What fvvdemux writes of damaged streams: never a wrong file, and everything that is whole.
#include "demux_fixture.h"
#include "fvv_scene/capture.h"
#include "fvvdemux/demux.h"

#include <array>
#include <set>

using namespace fvv;

namespace {

// FAILED: nothing was written, and there is no folder.
struct Outcome {
  demux::Result result;
  std::map<std::string, Bytes> files;
  bool failed = false;
};

Outcome attempt(const Scratch &scratch, const Bytes &stream, const demux::Options &chosen = {}) {
  Outcome out;
  demux::Options options = chosen;
  options.force = true;
  const std::string folder = scratch.path("attempt");
  fs::remove_all(folder);
  try {
    demux::demux(scratch.file("attempt.fvv", stream), folder, options, out.result);
    out.files = files_of(folder);
  } catch (const fvv::Error &failure) {
    out.failed = true;
    CHECK(failure.kind == fvv::Error::failed);
    CHECK(!fs::exists(folder));
  }
  return out;
}

// Every file is one of the undamaged run's, and capture.json names only files that are there.
void check_good(const Outcome &outcome, const std::map<std::string, Bytes> &all, const std::string &folder) {
  for (const auto &[name, bytes] : outcome.files)
    if (name != "capture.json") {
      REQUIRE(all.count(name) == 1);
      CHECK((all.at(name) == bytes));
    }
  if (!outcome.result.capture) return;
  const scene::Capture capture = scene::load_capture(folder + "/capture.json");
  CHECK(capture.frames.count == outcome.result.frames_written);
  CHECK(scene::check_files(capture, {}).problems.empty());
}

uint64_t whole_frames(const Bytes &stream) {
  fvv_checker *checker = nullptr;
  REQUIRE(fvv_checker_create(nullptr, nullptr, nullptr, &checker) == FVV_OK);
  (void)!fvv_checker_push(checker, stream.data(), stream.size());
  (void)!fvv_checker_finish(checker);
  const uint64_t whole = fvv_checker_summary(checker)->whole_frames;
  fvv_checker_destroy(checker);
  return whole;
}

// Offset and extent of every chunk.
std::vector<std::pair<size_t, size_t>> chunks_of(const Bytes &stream) {
  std::vector<std::pair<size_t, size_t>> out;
  for (size_t at = 24; at < stream.size();) {
    uint64_t size = 0;
    for (int i = 7; i >= 0; i--) size = size << 8 | stream[at + 16 + size_t(i)];
    const size_t extent = size_t((32 + size + 7) / 8 * 8);
    out.emplace_back(at, extent);
    at += extent;
  }
  return out;
}

std::map<std::string, Bytes> whole_run(const Scratch &scratch, const Bytes &stream) {
  const Outcome outcome = attempt(scratch, stream);
  REQUIRE(!outcome.failed);
  REQUIRE(outcome.result.losses.empty());
  return outcome.files;
}

bool mentions(const demux::Result &result, const std::string &part) {
  for (const std::string &line : result.losses)
    if (line.find(part) != std::string::npos) return true;
  return false;
}

} // namespace

TEST_CASE("of a truncated stream the whole frames are written") {
  const Scratch scratch;
  StreamOptions options;
  options.codec = FVV_CODEC_AVC1;
  const Bytes stream = make_stream(options);
  const auto all = whole_run(scratch, stream);
  std::set<size_t> cuts;
  for (const auto &[at, extent] : chunks_of(stream))
    for (const size_t cut : {at, at + 1, at + 31, at + 32, at + extent / 2, at + extent - 1})
      cuts.insert(cut);
  for (const size_t cut : cuts) {
    INFO("cut at " << cut << " of " << stream.size());
    const Bytes part(stream.begin(), stream.begin() + std::ptrdiff_t(cut));
    const uint64_t whole = whole_frames(part);
    const Outcome outcome = attempt(scratch, part);
    REQUIRE(outcome.failed == (whole == 0));
    if (outcome.failed) continue;
    CHECK(uint64_t(outcome.result.frames_written) == whole);
    CHECK(outcome.files.size() == whole * 4 + 1);
    CHECK(outcome.result.capture);
    CHECK(mentions(outcome.result, "the index was rebuilt"));
    const uint64_t begun = whole % 3 ? (whole + 2) / 3 * 3 : whole;
    if (begun > whole)
      CHECK(mentions(outcome.result, begun == whole + 1 ? "frame " + std::to_string(whole) + " is lost"
                                                        : "frames " + std::to_string(whole) + " to " +
                                                              std::to_string(begun - 1) + " are lost"));
    check_good(outcome, all, scratch.path("attempt"));
  }
}

TEST_CASE("a flipped bit in any chunk never gives a wrong file", "[slow]") {
  const Scratch scratch;
  for (const int repeat : {-1, 1})
    for (const bool finish : {true, false}) {
      StreamOptions options;
      options.codec = repeat < 0 ? FVV_CODEC_AVC1 : FVV_CODEC_JPEG;
      options.repeat_before = repeat;
      const Bytes good = [&] {
        options.finish = true;
        return make_stream(options);
      }();
      const auto all = whole_run(scratch, good);
      options.finish = finish;
      const Bytes stream = make_stream(options);
      // All places in turn: neighbours among the chunks are alike.
      size_t turn = 0;
      for (const auto &[at, extent] : chunks_of(stream)) {
        const std::array<size_t, 7> places = {3, 8, 18, 26, 32, extent / 2 + 16, extent - 9};
        for (size_t k = 0; k < 2; k++) {
          const size_t where = places[turn++ % places.size()];
          Bytes damaged = stream;
          damaged[at + std::min(where, extent - 1)] ^= 0x10;
          INFO("finish " << finish << " repeat " << repeat << " chunk at " << at << " byte " << where);
          const Outcome outcome = attempt(scratch, damaged);
          if (outcome.failed) continue;
          std::string lines;
          for (const std::string &line : outcome.result.losses) lines += line + "\n";
          INFO(lines);
          check_good(outcome, all, scratch.path("attempt"));
          // A block that is there twice, and damaged once, costs random access more than it costs a reader.
          if (repeat < 0) CHECK(uint64_t(outcome.result.frames_written) >= whole_frames(damaged));
          if (outcome.files.size() < all.size()) CHECK(!outcome.result.losses.empty());
        }
      }
    }
}

TEST_CASE("a lost sample takes the pictures that depend on it, not those of other groups") {
  const Scratch scratch;
  StreamOptions options;
  for (const uint32_t codec : {uint32_t(FVV_CODEC_JPEG), uint32_t(FVV_CODEC_AVC1)}) {
    options.codec = codec;
    Bytes stream = make_stream(options);
    const auto all = whole_run(scratch, stream);
    std::vector<size_t> samples;
    for (const auto &[at, extent] : chunks_of(stream))
      if (std::equal(stream.begin() + std::ptrdiff_t(at), stream.begin() + std::ptrdiff_t(at) + 4, "VPKT"))
        samples.push_back(at);
    REQUIRE(samples.size() == 6);
    stream[samples[1] + 40] ^= 1;
    const Outcome outcome = attempt(scratch, stream);
    REQUIRE(!outcome.failed);
    check_good(outcome, all, scratch.path("attempt"));
    if (codec == FVV_CODEC_JPEG) {
      CHECK(outcome.result.frames_written == 5);
      CHECK(mentions(outcome.result, ": frame 1 is lost: 0x"));
    } else {
      CHECK(outcome.result.frames_written == 4);
      CHECK(mentions(outcome.result, ": frames 1 to 2 are lost: 0x"));
    }
    CHECK(mentions(outcome.result, "[FVV-1103]"));
    CHECK(outcome.result.losses.size() == 1);
    CHECK(!outcome.result.capture);
    // With meshes only, all of them are written; with other frames only, nothing is lost.
    demux::Options choice;
    choice.pictures = demux::Pictures::none;
    CHECK(attempt(scratch, stream, choice).result.meshes == 6);
    choice = {};
    choice.frames = demux::Selection::parse("frames", "3-5");
    CHECK(attempt(scratch, stream, choice).result.losses.empty());
    // Three in four frames still fit a step when a hole is at an end.
    choice.frames = demux::Selection::parse("frames", "1,3-5");
    CHECK(attempt(scratch, stream, choice).result.capture);
  }
}

TEST_CASE("a lost group keeps its numbers") {
  const Scratch scratch;
  StreamOptions options;
  options.groups = 4;
  const auto all = whole_run(scratch, make_stream(options));
  options.finish = false;
  const Bytes stream = make_stream(options);
  // Cut out the second group: from its GRUP to the third one's.
  std::vector<size_t> groups;
  for (const auto &[at, extent] : chunks_of(stream))
    if (std::equal(stream.begin() + std::ptrdiff_t(at), stream.begin() + std::ptrdiff_t(at) + 4, "GRUP"))
      groups.push_back(at);
  Bytes damaged = stream;
  for (size_t i = groups[1]; i < groups[2]; i++) damaged[i] = 0;
  const Outcome outcome = attempt(scratch, damaged);
  REQUIRE(!outcome.failed);
  CHECK(outcome.result.frames_written == 9);
  CHECK(mentions(outcome.result, ": frames 3 to 5 are lost: 0x"));
  CHECK((outcome.files.count("meshes/0006.ply") == 1 && outcome.files.count("meshes/0003.ply") == 0));
  check_good(outcome, all, scratch.path("attempt"));

  // The same group twice: the second one counts for nothing.
  Bytes twice(stream.begin(), stream.begin() + std::ptrdiff_t(groups[2]));
  twice.insert(twice.end(), stream.begin() + std::ptrdiff_t(groups[1]), stream.end());
  const Outcome doubled = attempt(scratch, twice);
  REQUIRE(!doubled.failed);
  check_good(doubled, all, scratch.path("attempt"));
  CHECK(doubled.result.frames_written == 12);
  CHECK(!doubled.result.losses.empty());

  // Without the first group the number of frames before follows only from times.
  Bytes headless = stream;
  headless[groups[0] + 8] ^= 1;
  const Outcome cut = attempt(scratch, headless);
  REQUIRE(!cut.failed);
  CHECK(cut.result.frames_written == 9);
  CHECK(!cut.result.capture);
  CHECK(mentions(cut.result, "the first group is missing"));
  check_good(cut, all, scratch.path("attempt"));
}

TEST_CASE("damage that a repetition of the configuration hides is reported") {
  const Scratch scratch;
  StreamOptions options;
  options.repeat_before = 1;
  const auto all = whole_run(scratch, make_stream(options));
  for (const bool finish : {true, false}) {
    options.finish = finish;
    const Bytes stream = make_stream(options);
    for (const auto &[at, extent] : chunks_of(stream)) {
      if (stream[at] == 'G') break; // the first GRUP
      for (const size_t byte : {size_t(9), size_t(33)}) {
        INFO("chunk at " << at << ", byte " << byte);
        Bytes damaged = stream;
        damaged[at + byte] ^= 1;
        const Outcome outcome = attempt(scratch, damaged);
        REQUIRE(!outcome.failed);
        CHECK(outcome.result.frames_written == int64_t(whole_frames(stream)));
        CHECK(!outcome.result.losses.empty());
        CHECK(mentions(outcome.result, byte == 9 ? "FVV-1101" : "FVV-1103"));
        check_good(outcome, all, scratch.path("attempt"));
      }
    }
  }
}
