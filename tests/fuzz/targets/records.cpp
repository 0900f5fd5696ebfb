// Payloads of single records: what is decoded is encoded as it was.
#include "meshes.h"

#include "fvv/audio.h"
#include "fvv/colours.h"
#include "fvv/container.h"
#include "fvv/data.h"
#include "fvv/environment.h"
#include "fvv/video.h"
#include "fvv/visibility.h"

namespace {

// The same bytes come back, and a buffer that is too small is reported with the size that is needed.
template <class Encode> void expect_same(const fuzz::Bytes &payload, const Encode &encode) {
  fuzz::Bytes again(payload.size());
  size_t written = 0;
  if (!payload.empty())
    fuzz::expect(encode(again.data(), again.size() - 1, &written) == FVV_ERROR_BUFFER_TOO_SMALL &&
                     written == payload.size(),
                 "the needed size is reported");
  fuzz::expect(encode(again.data(), again.size(), &written) == FVV_OK && written == payload.size() &&
                   again == payload,
               "records that are read are written as they were");
}

// Of ancillary chunks, which may have a tail of a later version.
template <class Encode> void expect_same_beginning(const fuzz::Bytes &payload, const Encode &encode) {
  size_t written = 0;
  fuzz::expect(encode(nullptr, 0, &written) == FVV_ERROR_BUFFER_TOO_SMALL && written <= payload.size(),
               "what is written is no longer than what was read");
  expect_same({payload.begin(), payload.begin() + std::ptrdiff_t(written)}, encode);
}

} // namespace

FVV_FUZZ_TARGET(records, fuzz::Form::bytes) {
  fuzz::Input input(data, size);
  const uint8_t kind = input.u8();
  const fuzz::Bytes payload = input.rest();
  const uint8_t *const p = payload.data();
  const size_t n = payload.size();
  fvv_status status = FVV_OK;
  if (kind % 5 == 0) {
    fvv_scene scene;
    status = fvv_scene_decode(&scene, p, n, nullptr);
    if (status == FVV_OK)
      expect_same(payload, [&](uint8_t *out, size_t room, size_t *written) {
        return fvv_scene_encode(&scene, out, room, written, nullptr);
      });
  } else if (kind % 5 == 1) {
    fvv_track track = {};
    status = fvv_track_decode(&track, p, n, nullptr, nullptr);
    track.id = 1;
    if (status == FVV_OK)
      expect_same(payload, [&](uint8_t *out, size_t room, size_t *written) {
        return fvv_track_encode(&track, out, room, written, nullptr);
      });
  } else if (kind % 5 == 2) {
    std::vector<fvv_tile> tiles(256);
    size_t count = 0;
    status = fvv_tiles_decode(tiles.data(), tiles.size(), &count, p, n, nullptr, nullptr);
    if (status == FVV_OK) {
      expect_same(payload, [&](uint8_t *out, size_t room, size_t *written) {
        return fvv_tiles_encode(tiles.data(), count, out, room, written, nullptr);
      });
      uint32_t width, height;
      fuzz::expect_status(fvv_tiles_arrange(tiles.data(), count, 16384, &width, &height, nullptr));
    }
  } else if (kind % 5 == 3) {
    fvv_data_config config;
    status = fvv_data_config_decode(&config, p, n, nullptr, nullptr);
    if (status == FVV_OK)
      expect_same_beginning(payload, [&](uint8_t *out, size_t room, size_t *written) {
        return fvv_data_config_encode(&config, out, room, written, nullptr);
      });
  } else {
    fvv_texturing texturing;
    status = fvv_texturing_decode(&texturing, p, n, nullptr);
    if (status == FVV_OK)
      expect_same_beginning(payload, [&](uint8_t *out, size_t room, size_t *written) {
        return fvv_texturing_encode(&texturing, out, room, written, nullptr);
      });
  }
  fuzz::expect_status(status);
}

FVV_FUZZ_TARGET(environment, fuzz::Form::bytes) {
  const fuzz::Bytes payload(data, data + size);
  fvv_environment environment;
  const fvv_status status =
      fvv_environment_decode(payload.data(), payload.size(), nullptr, nullptr, &environment, nullptr);
  fuzz::expect_status(status);
  if (status != FVV_OK) return;
  for (size_t i = 0; i < environment.part_count && i < 8; i++) {
    fvv_mesh mesh;
    const fvv_status decoded = fvv_environment_mesh(&environment, i, nullptr, nullptr, &mesh, nullptr);
    fuzz::expect_status(decoded);
    if (decoded == FVV_OK) fvv_mesh_free(&mesh);
  }
  for (size_t i = 0; i < environment.picture_count; i++) {
    fvv_environment_picture picture = environment.pictures[i];
    fuzz::expect(fvv_environment_picture_inspect(&picture, nullptr) == FVV_OK &&
                     picture.width == environment.pictures[i].width,
                 "pictures of an environment have their size");
  }
  fuzz::Payload again;
  fuzz::expect(fvv_environment_encode(&environment, nullptr, &again.bytes, nullptr) == FVV_OK &&
                   again.bytes.size <= payload.size() &&
                   std::equal(again.bytes.data, again.bytes.data + again.bytes.size, payload.begin()),
               "an environment that is read is written as it was, without a tail");
  fvv_environment_free(&environment);
}

FVV_FUZZ_TARGET(video, fuzz::Form::bytes) {
  fuzz::Input input(data, size);
  const int key = input.u8() & 1;
  const fuzz::Bytes record = input.part(), sample = input.rest();
  fvv_video_config config;
  const fvv_status status = fvv_video_config_decode(&config, record.data(), record.size(), nullptr, nullptr);
  fuzz::expect_status(status);
  if (status != FVV_OK) return;
  expect_same(record, [&](uint8_t *out, size_t room, size_t *written) {
    return fvv_video_config_encode(&config, out, room, written, nullptr);
  });
  const fvv_status checked = fvv_video_sample_check(&config, key, sample.data(), sample.size(), nullptr);
  fuzz::expect_status(checked);
  int found = 0;
  const fvv_status inspected =
      fvv_video_sample_inspect(&config, sample.data(), sample.size(), &found, nullptr);
  fuzz::expect_status(inspected);
  if (checked == FVV_OK) fuzz::expect(inspected == FVV_OK && found == key, "a good sample has its key flag");
}

FVV_FUZZ_TARGET(audio, fuzz::Form::bytes) {
  fuzz::Input input(data, size);
  const fuzz::Bytes record = input.part();
  fvv_audio_config config;
  const fvv_status status = fvv_audio_config_decode(&config, record.data(), record.size(), nullptr, nullptr);
  fuzz::expect_status(status);
  if (status != FVV_OK) return;
  expect_same_beginning(record, [&](uint8_t *out, size_t room, size_t *written) {
    return fvv_audio_config_encode(&config, out, room, written, nullptr);
  });
  fuzz::expect(fvv_audio_sample_rate(&config) > 0, "a codec that is known has a rate");
  fvv_audio_place place = {};
  const fvv_rational time_base = {1, 1 + input.below(100)};
  while (input.left()) {
    const int64_t time = input.u16();
    const fuzz::Bytes payload = input.part();
    std::vector<fvv_audio_packet> packets(payload.size() / 3 + 1);
    fvv_audio_chunk chunk;
    const fvv_status decoded = fvv_audio_decode(&config, payload.data(), payload.size(), &chunk,
                                                packets.data(), packets.size(), nullptr);
    fuzz::expect_status(decoded);
    fuzz::expect(decoded != FVV_ERROR_BUFFER_TOO_SMALL,
                 "no chunk has more packets than a third of its bytes");
    if (decoded != FVV_OK) continue;
    expect_same_beginning(payload, [&](uint8_t *out, size_t room, size_t *written) {
      return fvv_audio_encode(&config, &chunk, packets.data(), out, room, written, nullptr);
    });
    fuzz::expect_status(fvv_audio_follow(&place, &config, time_base, &chunk, 0, time, time + 100, nullptr));
  }
}

FVV_FUZZ_TARGET(colours, fuzz::Form::bytes) {
  fuzz::Input input(data, size);
  const fuzz::Mesh mesh(input.part());
  const fuzz::Bytes payload = input.rest();
  fvv_colours_header header;
  const fvv_status peeked = fvv_colours_peek(payload.data(), payload.size(), nullptr, &header, nullptr);
  fuzz::expect_status(peeked);
  if (!mesh.there) return;
  std::vector<uint8_t> colours(3 * size_t(mesh.mesh.vertex_count));
  const fvv_status status = fvv_colours_decode(payload.data(), payload.size(), &mesh.mesh, nullptr, nullptr,
                                               colours.data(), nullptr);
  fuzz::expect_status(status);
  fuzz::expect(status != FVV_OK || peeked == FVV_OK, "what decodes has a good header");
}
