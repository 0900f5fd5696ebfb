// Data tracks: what DCFG says, and frames that nothing else shows.
#include "stream_fixture.h"

namespace {

constexpr uint16_t track = 6;

fvv_data_config captions() {
  fvv_data_config config = {};
  config.media_type = "text/vtt";
  config.media_type_size = 8;
  config.codec = "wvtt";
  config.codec_size = 4;
  config.record = reinterpret_cast<const uint8_t *>("rec");
  config.record_size = 3;
  return config;
}

Bytes payload_of(const fvv_data_config &config) {
  return record([&](uint8_t *out, size_t n, size_t *size) {
    return fvv_data_config_encode(&config, out, n, size, nullptr);
  });
}

uint32_t issue_of(const Bytes &payload) {
  fvv_data_config config;
  fvv_diagnostic diagnostic = {};
  const fvv_status status =
      fvv_data_config_decode(&config, payload.data(), payload.size(), nullptr, &diagnostic);
  CHECK((status == FVV_OK) == (diagnostic.issue == 0));
  return diagnostic.issue;
}

Chunk data_track_chunk(uint8_t flags) {
  fvv_track declared = {};
  declared.id = track;
  declared.kind = FVV_TRACK_DATA;
  declared.flags = flags;
  return {FVV_CHUNK_TRACK, track, 0, 0, record([&](uint8_t *out, size_t n, size_t *size) {
            return fvv_track_encode(&declared, out, n, size, nullptr);
          })};
}

} // namespace

TEST_CASE("DCFG comes back, and what it lacks has a number") {
  const Bytes good = payload_of(captions());
  fvv_data_config found;
  REQUIRE(fvv_data_config_decode(&found, good.data(), good.size(), nullptr, nullptr) == FVV_OK);
  CHECK(std::string(found.media_type, found.media_type_size) == "text/vtt");
  CHECK(std::string(found.codec, found.codec_size) == "wvtt");
  CHECK(Bytes(found.record, found.record + found.record_size) == Bytes{'r', 'e', 'c'});
  for (size_t n = 0; n < good.size(); n++)
    CHECK(issue_of({good.begin(), good.begin() + std::ptrdiff_t(n)}) == FVV_ISSUE_DATA_CONFIG_PAYLOAD);
  Bytes longer = good;
  longer.push_back(0); // of a later version
  CHECK(issue_of(longer) == 0);
  Bytes wrong = good;
  wrong[11] = 0xff; // the media type begins there
  CHECK(issue_of(wrong) == FVV_ISSUE_TEXT);

  fvv_data_config empty = captions();
  empty.media_type_size = 0;
  size_t size = 0;
  CHECK(fvv_data_config_encode(&empty, nullptr, 0, &size, nullptr) == FVV_ERROR_ARGUMENT);
  fvv_limits limits;
  fvv_limits_default(&limits);
  limits.max_text = 7;
  CHECK(fvv_data_config_decode(&found, good.data(), good.size(), &limits, nullptr) == FVV_ERROR_LIMIT);
}

TEST_CASE("a stream of data alone has frames, if its track says so") {
  for (const uint8_t flags : {uint8_t(FVV_TRACK_FLAG_FRAMES), uint8_t(0)}) {
    Stream stream;
    stream.configuration = {
        scene_chunk(), data_track_chunk(flags), {FVV_CHUNK_DATA_CONFIG, track, 0, 0, payload_of(captions())}};
    for (int64_t g = 0; g < 2; g++) {
      Group group = {3 * g, 3 * g + 3, {}};
      for (int64_t i = 0; i < 3; i++)
        group.chunks.push_back(
            {FVV_CHUNK_DATA, track, uint8_t(i ? 0 : FVV_FLAG_KEY), 3 * g + i, Bytes(size_t(i), uint8_t(g))});
      stream.groups.push_back(group);
    }
    const Opened opened(write(stream));
    REQUIRE(fvv_stream_frame_count(opened.stream) == (flags ? 6u : 0u));
    const fvv_configuration *configuration = nullptr;
    REQUIRE(fvv_stream_configuration(opened.stream, 1, &configuration, nullptr) == FVV_OK);
    CHECK(fvv_configuration_data(configuration, track)->record_size == 3);
    CHECK(fvv_configuration_data(configuration, 1) == nullptr);
    CHECK(fvv_configuration_makes_frame(configuration, FVV_CHUNK_DATA, track) == (flags != 0));
    CHECK(fvv_configuration_makes_frame(nullptr, FVV_CHUNK_DATA, track) == 0);
    if (!flags) continue;
    fvv_frame frame;
    REQUIRE(fvv_stream_frame(opened.stream, 4, &frame, nullptr) == FVV_OK);
    CHECK(frame.time == 4);
    CHECK(frame.group == 1);
  }
}

TEST_CASE("a writer refuses the flag of frames on tracks that show nothing, and sets it on those that do") {
  fvv_track declared = {};
  declared.id = 1;
  Bytes out(64);
  size_t size = 0;
  for (const uint8_t kind : {FVV_TRACK_MESH, FVV_TRACK_VIDEO, FVV_TRACK_CALIBRATION, FVV_TRACK_VISIBILITY,
                             FVV_TRACK_ENVIRONMENT, FVV_TRACK_AUDIO, FVV_TRACK_COLOURS}) {
    const bool shows = kind == FVV_TRACK_MESH || kind == FVV_TRACK_VIDEO;
    declared.kind = kind;
    declared.flags = 0;
    REQUIRE(fvv_track_encode(&declared, out.data(), out.size(), &size, nullptr) == FVV_OK);
    CHECK(out[1] == (shows ? FVV_TRACK_FLAG_FRAMES : 0));
    declared.flags = FVV_TRACK_FLAG_FRAMES;
    CHECK((fvv_track_encode(&declared, out.data(), out.size(), &size, nullptr) == FVV_OK) == shows);
  }
}
