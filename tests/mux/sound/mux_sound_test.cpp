// Sound from a capture to a stream and back, exact to the sample, and each group decoded alone.
#include "../mux_fixture.h"

#include "fvv_demux/sounds.h"
#include "fvv_media/sound.h"
#include "fvvdemux/demux.h"
#include "make_sound.h"
#include "mux/src/sound/sound.h"

namespace {

constexpr double click_time = 1.0321;

// Two seconds with a click at click_time of the capture, which begins 0.25 s after the recorder.
scene::Capture with_sound(const Folder &folder, const char *encoder, const char *leaf, int rate = 48000) {
  Shape shape;
  shape.pictures = false;
  shape.count = 50;
  shape.first = 7;
  scene::Capture capture = make_capture(folder, shape);
  write_sound(folder.path(std::string("in/") + leaf), encoder, clicks(rate, 2, 2.3, {0.25 + click_time}), 2,
              rate);
  scene::SoundSource source;
  source.file = leaf;
  source.offset = {1, 4};
  source.first = 7;
  source.title = "hall";
  source.language = "de-CH";
  capture.sounds.push_back(source);
  scene::write_capture(capture, capture.path);
  return capture;
}

FileOptions sound_options(const Folder &folder) {
  FileOptions options = options_for(folder);
  options.group = 10;
  options.verify = true;
  return options;
}

std::vector<float> decoded(const media::SoundPackets &packets) {
  media::SoundDecoder decoder(packets.format);
  std::vector<float> samples;
  for (const std::vector<uint8_t> &packet : packets.packets) decoder.decode(packet, samples);
  return samples;
}

int64_t click_in(const media::SoundPackets &packets, double about) {
  const uint32_t rate = packets.format.rate;
  return packets.start + find_click(decoded(packets), packets.format.channels, rate,
                                    std::llround(about * rate) - packets.start);
}

size_t groups_in(const std::string &path) {
  const InputFile file(path);
  const fvv_input input = file.input();
  fvv_stream *opened = nullptr;
  REQUIRE(fvv_stream_open(&input, nullptr, nullptr, &opened, nullptr) == FVV_OK);
  const size_t count = fvv_stream_group_count(opened);
  fvv_stream_close(opened);
  return count;
}

// Warnings of a run.
struct Warnings {
  std::vector<std::string> texts;
  mux::Observer observer() {
    mux::Observer out;
    out.on_warning = [this](const std::string &text) { texts.push_back(text); };
    return out;
  }
};

mux::Plan plan_of(const FileOptions &options, Warnings &warnings) {
  return mux::make_plan(options, warnings.observer());
}

// Of a capture that deserves exactly this warning about a.wav.
mux::Plan warned_plan(const FileOptions &options, const std::string &warning) {
  Warnings warnings;
  mux::Plan plan = plan_of(options, warnings);
  CHECK(plan.warned);
  CHECK(warnings.texts ==
        std::vector<std::string>{options.capture + "/capture.json: audio: a.wav: " + warning});
  return plan;
}

} // namespace

TEST_CASE("sound is in the stream where it was in the capture, and comes back") {
  struct Case {
    const char *encoder, *file;
    int rate;
    bool encoded;
  };
  for (const Case &c : {Case{"pcm_s16le", "a.wav", 48000, true}, Case{"flac", "b.flac", 44100, true},
                        Case{"libopus", "c.opus", 48000, false}, Case{"aac", "d.m4a", 44100, false}}) {
    INFO(c.file);
    const Folder folder;
    with_sound(folder, c.encoder, c.file, c.rate);
    const FileOptions options = sound_options(folder);
    const mux::Report summary = mux_file(options);
    REQUIRE(summary.sounds.size() == 1);
    CHECK(summary.sounds[0].encoded == c.encoded);
    CHECK(summary.verdict->sounds == 5);
    const nlohmann::ordered_json json = json_of(summary)["audio"][0];
    CHECK(json["encoded"] == c.encoded);
    CHECK(json["codec"] == (std::string(c.encoder) == "aac" ? "aac" : "opus"));
    CHECK(json["title"] == "hall");
    CHECK(json["language"] == "de-CH");
    CHECK(text_of(summary).find("  audio ") != std::string::npos);
    REQUIRE(groups_in(options.output) == 5);
    const demux::UnpackedSounds all = demux::unpack_sounds(InputFile(options.output), 0, 4);
    CHECK(all.losses.empty());
    REQUIRE(all.sounds.size() == 1); // without a gap
    const demux::UnpackedSound &sound = all.sounds[0];
    CHECK(sound.title == "hall");
    CHECK(sound.language == "de-CH");
    CHECK(!sound.position);
    const uint32_t rate = sound.packets.format.rate;
    CHECK(sound.packets.start <= 0);
    CHECK(sound.packets.end() >= 2 * rate);
    CHECK(std::llabs(click_in(sound.packets, click_time) - std::llround(click_time * rate)) <= 2);

    // Each group decoded alone gives the same samples from its beginning on.
    const std::vector<float> whole = decoded(sound.packets);
    for (size_t group = 1; group < 5; group++) {
      const demux::UnpackedSounds one = demux::unpack_sounds(InputFile(options.output), group, group);
      REQUIRE(one.sounds.size() == 1);
      const media::SoundPackets &packets = one.sounds[0].packets;
      const int64_t begin = int64_t(group) * 2 * rate / 5;
      CHECK(packets.start + int64_t(packets.format.preroll) * packets.format.packet_duration <= begin);
      const std::vector<float> alone = decoded(packets);
      double signal = 1e-9, noise = 1e-12;
      for (int64_t i = begin - packets.start; i < int64_t(alone.size() / 2); i++)
        for (int64_t channel = 0; channel < 2; channel++) {
          const double wanted = whole[size_t(2 * (i + packets.start - sound.packets.start) + channel)],
                       found = alone[size_t(2 * i + channel)];
          signal += wanted * wanted;
          noise += (found - wanted) * (found - wanted);
        }
      INFO("group " << group << ": " << 10 * std::log10(signal / noise) << " dB");
      CHECK((noise < 1e-6 || 10 * std::log10(signal / noise) > 25));
    }

    // Unpacked and packed again: the same packets at the same times.
    demux::Options unpack;
    demux::Result result;
    demux::demux(options.output, folder.path("out"), unpack, result);
    CHECK(result.losses.empty());
    CHECK(result.sounds == 1);
    FileOptions again = sound_options(folder);
    again.capture = folder.path("out");
    again.output = folder.path("again.fvv");
    mux_file(again);
    const mux::Plan second = mux::make_plan(again, {});
    REQUIRE(second.sounds.size() == 1);
    CHECK(!second.sounds[0].packets.encoded);
    CHECK(second.sounds[0].packets.packets == sound.packets.packets);
    CHECK(second.sounds[0].packets.start == sound.packets.start);
    CHECK(second.sounds[0].packets.format.record == sound.packets.format.record);
    CHECK(second.sounds[0].source.language == "de-CH");

    // A part of the frames has the sound of its groups, at the same time of the scene.
    unpack.frames = demux::Selection::parse("frames", "20-34");
    unpack.force = true;
    demux::Result part;
    demux::demux(options.output, folder.path("out"), unpack, part);
    FileOptions rest = again;
    rest.verify = false;
    rest.capture = folder.path("out");
    mux_file(rest);
    const mux::Plan third = mux::make_plan(rest, {});
    REQUIRE(third.sounds.size() == 1);
    CHECK(std::llabs(click_in(third.sounds[0].packets, click_time - 0.8) -
                     std::llround((click_time - 0.8) * rate)) <= 2);
  }
}

TEST_CASE("the first picture does not wait for sound") {
  const Folder folder;
  with_sound(folder, "pcm_s16le", "a.wav");
  const FileOptions options = sound_options(folder);
  mux_file(options);
  const InputFile file(options.output);
  const fvv_input input = file.input();
  fvv_stream *opened = nullptr;
  REQUIRE(fvv_stream_open(&input, nullptr, nullptr, &opened, nullptr) == FVV_OK);
  for (size_t group = 0; group < fvv_stream_group_count(opened); group++) {
    const fvv_chunk_info *chunks = nullptr;
    size_t count = 0, sounds = 0;
    REQUIRE(fvv_stream_group_chunks(opened, group, &chunks, &count, nullptr) == FVV_OK);
    for (size_t i = 0; i < count; i++) {
      if (chunks[i].type != FVV_CHUNK_AUDIO) continue;
      CHECK(i > 0);
      CHECK(((chunks[i].flags & FVV_FLAG_KEY) != 0) == !sounds);
      sounds++;
      // Everything else of its time is before it.
      for (size_t k = i + 1; k < count; k++)
        CHECK((chunks[k].time > chunks[i].time || chunks[k].type == FVV_CHUNK_AUDIO));
    }
    CHECK(sounds == 2); // of 0.4 s
  }
  fvv_stream_close(opened);
}

TEST_CASE("placed sound is mono, and moves from frame to frame") {
  const Folder folder;
  scene::Capture capture = with_sound(folder, "pcm_s16le", "a.wav");
  scene::SoundSource still = capture.sounds[0];
  still.position = scene::Place{1, 2, 3};
  scene::SoundSource moving = capture.sounds[0];
  for (const int64_t number : capture.frames.numbers()) moving.per_frame[number] = {double(number), 0.5, -1};
  capture.sounds = {still, moving};
  scene::write_capture(capture, capture.path);
  const FileOptions options = sound_options(folder);
  const mux::Report summary = mux_file(options);
  REQUIRE(summary.sounds.size() == 2);
  CHECK(summary.sounds[0].channels == 1);
  CHECK(summary.sounds[1].chunks == 50);
  const demux::UnpackedSounds all = demux::unpack_sounds(InputFile(options.output), 0, 4);
  REQUIRE(all.sounds.size() == 2);
  CHECK(all.sounds[0].position == still.position);
  CHECK(all.sounds[1].places.size() == 50);
  CHECK(all.sounds[1].position_at(3) == scene::Place{10, 0.5, -1});
  CHECK(all.sounds[1].packets.packets == all.sounds[0].packets.packets);
  demux::Result result;
  demux::demux(options.output, folder.path("out"), {}, result);
  const scene::Capture back = scene::load_capture(folder.path("out/capture.json"));
  REQUIRE(back.sounds.size() == 2);
  CHECK(back.sounds[0].position == still.position);
  CHECK(back.sounds[1].per_frame == moving.per_frame);
}

TEST_CASE("sound that is dropped or cut is named") {
  const Folder folder;
  scene::Capture capture = with_sound(folder, "pcm_s16le", "a.wav");
  FileOptions options = sound_options(folder);
  warned_plan(options, "0.25 s of sound before the first frame are not used");
  capture.sounds[0].offset = {0, 1};
  scene::write_capture(capture, capture.path);
  warned_plan(options, "its sound goes on after the last frame and is cut there");
  capture.sounds[0].offset = {5, 1};
  scene::write_capture(capture, capture.path);
  CHECK(warned_plan(options, "has no sound at the time of the frames and is left out").sounds.empty());
  // It begins within the capture: nothing is lost, and its time is kept.
  capture.sounds[0].offset = {-1, 2};
  scene::write_capture(capture, capture.path);
  {
    Warnings warnings;
    const mux::Plan plan = plan_of(options, warnings);
    REQUIRE(plan.sounds.size() == 1);
    CHECK(std::llabs(click_in(plan.sounds[0].packets, click_time + 0.75) -
                     std::llround((click_time + 0.75) * 48000)) <= 2);
    CHECK(mux::span_of(plan, plan.sounds[0]).start > 0.45);
  }
  capture.sounds[0].offset = {1, 4};
  scene::write_capture(capture, capture.path);
  // A part of the frames is what was asked: without a warning.
  options.frames = Range{20, 39};
  {
    Warnings warnings;
    const mux::Plan plan = plan_of(options, warnings);
    CHECK(warnings.texts.empty());
    const double begin = 13 / 25.0;
    CHECK(std::llabs(click_in(plan.sounds[0].packets, click_time - begin) -
                     std::llround((click_time - begin) * 48000)) <= 2);
  }
  options.frames.reset();
  options.sound = false;
  Warnings warnings;
  CHECK(plan_of(options, warnings).sounds.empty());
  CHECK(warnings.texts.empty());
  options.sound = true;
  options.sound_bit_rate = 6000;
  CHECK_THROWS_WITH(plan_of(options, warnings),
                    "sound-bitrate: expected 12000 to 512000 bit/s for the 2 channels of " + options.capture +
                        "/a.wav, found 6000");
}

TEST_CASE("damaged sound is a loss, and the rest is there") {
  const Folder folder;
  with_sound(folder, "pcm_s16le", "a.wav");
  const FileOptions options = sound_options(folder);
  mux_file(options);
  std::string bytes = read_bytes(options.output);
  // The second chunk of the second group.
  size_t at = 0;
  {
    const InputFile file(options.output);
    const fvv_input input = file.input();
    fvv_stream *opened = nullptr;
    REQUIRE(fvv_stream_open(&input, nullptr, nullptr, &opened, nullptr) == FVV_OK);
    const fvv_chunk_info *chunks = nullptr;
    size_t count = 0;
    REQUIRE(fvv_stream_group_chunks(opened, 1, &chunks, &count, nullptr) == FVV_OK);
    for (size_t i = 0; i < count; i++)
      if (chunks[i].type == FVV_CHUNK_AUDIO) at = size_t(chunks[i].offset) + 32 + 100;
    fvv_stream_close(opened);
  }
  bytes[at] = char(bytes[at] ^ 1);
  write_bytes(options.output, bytes.data(), bytes.size());
  const demux::UnpackedSounds all = demux::unpack_sounds(InputFile(options.output), 0, 4);
  CHECK(all.losses.size() == 1);
  CHECK(all.sounds.size() == 2); // before and after
  demux::Result result;
  demux::demux(options.output, folder.path("out"), {}, result);
  CHECK(result.sounds == 2);
  CHECK(!result.losses.empty());
  CHECK(scene::load_capture(folder.path("out/capture.json")).sounds.size() == 2);
}
