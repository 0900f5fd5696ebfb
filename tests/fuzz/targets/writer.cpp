// The writer as a program of calls, in any order and with any arguments. What it accepts, the checker
// accepts.
#include "meshes.h"

#include "fvv/stream.h"

namespace {

template <class Encode> fuzz::Bytes record(const Encode &encode) {
  size_t size = 0;
  (void)!encode(nullptr, 0, &size);
  fuzz::Bytes out(size);
  if (encode(out.data(), out.size(), &size) != FVV_OK) out.clear();
  return out;
}

fuzz::Bytes scene_of(fuzz::Input &input) {
  fvv_scene scene = {{1, 25}, 1, {0, 0, 0}, 0.001, FVV_UP_Y, 0};
  if (!input.below(8)) scene.frame_duration = input.i64();
  if (!input.below(8)) scene.lattice_step = input.f64();
  return record([&](uint8_t *out, size_t room, size_t *size) {
    return fvv_scene_encode(&scene, out, room, size, nullptr);
  });
}

fuzz::Bytes track_of(fuzz::Input &input, uint16_t id) {
  fvv_track track = {};
  track.id = id;
  track.kind = uint8_t(input.below(10));
  track.alternate_group = uint16_t(input.below(3));
  track.rank = uint16_t(input.below(3));
  if (!input.below(8)) track.time_base = {input.u16(), input.u16()};
  const fuzz::Bytes name = input.bytes(input.below(9));
  track.name = reinterpret_cast<const char *>(name.data());
  track.name_size = name.size();
  return record([&](uint8_t *out, size_t room, size_t *size) {
    return fvv_track_encode(&track, out, room, size, nullptr);
  });
}

// A tetrahedron, as a payload of one of three profiles.
fuzz::Bytes mesh_of(fuzz::Input &input) {
  int32_t positions[12] = {0, 0, 0, 10, 0, 0, 0, 20, 0, 0, 0, 30};
  for (int32_t &value : positions) value += input.below(8);
  uint32_t faces[12] = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  const fvv_mesh mesh = {positions, faces, 4, 4, nullptr, 0, nullptr, 0, {}};
  const uint8_t profiles[] = {FVV_MESH_RAW, FVV_MESH_DRACO, FVV_MESH_FAST};
  fuzz::Payload payload;
  const fvv_status status =
      fvv_mesh_encode(&mesh, profiles[input.below(3)], 5, nullptr, &payload.bytes, nullptr);
  fuzz::expect_status(status);
  if (status != FVV_OK) return {};
  return fuzz::Bytes(payload.bytes.data, payload.bytes.data + payload.bytes.size);
}

const uint32_t group_types[] = {FVV_CHUNK_MESH,       FVV_CHUNK_VIDEO_PACKET, FVV_CHUNK_CALIBRATION,
                                FVV_CHUNK_VISIBILITY, FVV_CHUNK_COLOURS,      FVV_CHUNK_ENVIRONMENT,
                                FVV_CHUNK_AUDIO,      FVV_CHUNK_TILES,        0x7a7a7a7a,
                                FVV_CHUNK_GROUP_END};
const uint32_t block_types[] = {FVV_CHUNK_SCENE,  FVV_CHUNK_TRACK,        FVV_CHUNK_METADATA,
                                FVV_CHUNK_CAMERA, FVV_CHUNK_VIDEO_CONFIG, FVV_CHUNK_TEXTURING,
                                0x7a7a7a7a,       FVV_CHUNK_FOOTER,       FVV_CHUNK_AUDIO_CONFIG};

fvv_status configure(fvv_writer *writer, fuzz::Input &input) {
  const uint32_t type = block_types[input.below(9)];
  const uint16_t track = uint16_t(input.below(5));
  const uint8_t flags = input.below(4) ? 0 : input.u8();
  fuzz::Bytes payload;
  if (type == FVV_CHUNK_SCENE)
    payload = scene_of(input);
  else if (type == FVV_CHUNK_TRACK)
    payload = track_of(input, track);
  else
    payload = input.bytes(input.below(64));
  return fvv_writer_configuration(writer, type, track, flags, payload.data(), payload.size(), nullptr);
}

fvv_status put(fvv_writer *writer, fuzz::Input &input, int64_t &time) {
  const uint32_t type = input.below(3) ? uint32_t(FVV_CHUNK_MESH) : group_types[input.below(10)];
  time += int64_t(input.below(4)) - (input.below(16) ? 0 : 2);
  const uint16_t track = uint16_t(input.below(5));
  const uint8_t flags = input.below(4) ? uint8_t(FVV_FLAG_KEY) : input.u8();
  const fuzz::Bytes payload =
      type == FVV_CHUNK_MESH && input.below(8) ? mesh_of(input) : input.bytes(input.below(64));
  return fvv_writer_chunk(writer, type, track, flags, time, payload.data(), payload.size(), nullptr);
}

// The container of what was written is right: the writer leaves payloads to those who encode them.
void expect_container(const fuzz::Bytes &stream, bool finished) {
  fvv_reader *reader = nullptr;
  fuzz::expect(fvv_reader_create(nullptr, nullptr, 0, &reader) == FVV_OK, "a reader is created");
  fuzz::expect_status(fvv_reader_push(reader, stream.data(), stream.size()));
  fvv_reader_finish(reader);
  bool ended = false;
  fvv_event event;
  fvv_status status;
  while ((status = fvv_reader_next(reader, &event, nullptr)) == FVV_OK) {
    fuzz::expect(event.kind != FVV_EVENT_DAMAGE || event.diagnostic.issue == FVV_ISSUE_GROUP_UNFINISHED,
                 "nothing that the writer wrote is damaged");
    ended |= event.kind == FVV_EVENT_END;
  }
  fuzz::expect(status == FVV_END && ended == finished, "a finished stream is complete");
  fvv_reader_destroy(reader);
}

} // namespace

FVV_FUZZ_TARGET(writer, fuzz::Form::bytes) {
  fuzz::Input input(data, size);
  fuzz::Bytes stream;
  const fvv_output output = {fuzz::append, &stream};
  fvv_writer *writer = nullptr;
  fuzz::expect(fvv_writer_create(&output, nullptr, &writer, nullptr) == FVV_OK, "a writer is created");
  int64_t time = 0;
  bool finished = false, joined = input.below(8) == 0 && fvv_writer_join(writer, input.u32()) == FVV_OK;
  if (input.below(4)) { // a good beginning
    const fuzz::Bytes scene = scene_of(input);
    (void)!fvv_writer_configuration(writer, FVV_CHUNK_SCENE, 0, 0, scene.data(), scene.size(), nullptr);
    const uint8_t track[24] = {FVV_TRACK_MESH};
    (void)!fvv_writer_configuration(writer, FVV_CHUNK_TRACK, 1, 0, track, sizeof track, nullptr);
  }
  for (int calls = 0; input.left() && calls < 300; calls++) {
    fvv_status status = FVV_OK;
    switch (input.below(12)) {
    case 0:
    case 1:
      status = configure(writer, input);
      break;
    case 2:
      status = fvv_writer_repeat_configuration(writer, nullptr);
      break;
    case 3:
    case 4: {
      const int64_t end = input.below(16) ? time + 1 + input.below(50) : input.i64();
      status = fvv_writer_begin_group(writer, time, end, nullptr);
      break;
    }
    case 5:
      status = fvv_writer_end_group(writer, nullptr);
      break;
    case 6:
      if (input.below(8)) break;
      status = fvv_writer_finish(writer, nullptr);
      finished |= status == FVV_OK;
      break;
    case 7:
      if (input.below(8)) break;
      joined |= fvv_writer_join(writer, input.u32()) == FVV_OK;
      break;
    default:
      status = put(writer, input, time);
    }
    fuzz::expect_status(status);
    fuzz::expect(fvv_writer_position(writer) == stream.size(), "the position is what was written");
  }
  fvv_writer_destroy(writer);
  // What a part of a stream begins with is not checked here.
  if (!joined) expect_container(stream, finished);
}
