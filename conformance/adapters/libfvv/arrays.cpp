#include "arrays.h"

#include <openssl/evp.h>

#include <array>
#include <cstring>
#include <map>
#include <stdexcept>
#include <type_traits>
#include <vector>

namespace fvv::conformance {

using nlohmann::json;

std::string sha256(const void *bytes, size_t size) {
  std::array<unsigned char, 32> digest;
  if (EVP_Digest(bytes, size, digest.data(), nullptr, EVP_sha256(), nullptr) != 1)
    throw std::runtime_error("SHA-256 failed");
  static const char digits[] = "0123456789abcdef";
  std::string out;
  for (const unsigned char byte : digest) {
    out += digits[byte >> 4];
    out += digits[byte & 15];
  }
  return out;
}

namespace {

// Of the numbers as little-endian bytes.
template <class T> std::string hash(const T *values, size_t count) {
  using Bits =
      std::conditional_t<sizeof(T) == 8, uint64_t, std::conditional_t<sizeof(T) == 4, uint32_t, uint8_t>>;
  static_assert(sizeof(T) == sizeof(Bits));
  std::vector<uint8_t> bytes;
  bytes.reserve(count * sizeof(T));
  for (size_t i = 0; i < count; i++) {
    Bits bits;
    std::memcpy(&bits, values + i, sizeof bits);
    for (size_t k = 0; k < sizeof bits; k++) bytes.push_back(uint8_t(bits >> 8 * k));
  }
  return sha256(bytes.data(), bytes.size());
}

template <class T> std::string hash(const std::vector<T> &values) {
  return hash(values.data(), values.size());
}

struct Mesh : fvv_mesh {
  Mesh() : fvv_mesh{} {}
  ~Mesh() { fvv_mesh_free(this); }
  Mesh(const Mesh &) = delete;
  Mesh &operator=(const Mesh &) = delete;
};

// Whether there is something. Throws its status when it is damaged.
bool found(fvv_status status) {
  if (status < 0) throw status;
  return status == FVV_OK;
}

// A frame while its arrays are collected.
struct Frame {
  fvv_stream *stream;
  size_t frame;
  fvv_frame info;
  const fvv_configuration *configuration;
  json arrays = json::object();

  // The configuration is kept by the stream: its pointer is stale after calls on other groups only.
  void mesh(uint16_t track) {
    Mesh mesh;
    if (!found(fvv_stream_mesh(stream, frame, track, &mesh, nullptr))) return;
    const std::string name = "mesh/" + std::to_string(track) + "/";
    const size_t vertices = mesh.vertex_count;
    arrays[name + "lattice"] = hash(mesh.lattice, 3 * vertices);
    arrays[name + "faces"] = hash(mesh.faces, 3 * size_t(mesh.face_count));
    std::vector<float> floats(3 * vertices);
    const fvv_scene &scene = configuration->scene;
    fvv_lattice_to_floats(scene.lattice_origin, scene.lattice_step, mesh.lattice, vertices, floats.data());
    arrays[name + "positions"] = hash(floats);
    if (mesh.normals) {
      fvv_normals_to_floats(mesh.normal_bits, mesh.normals, vertices, floats.data());
      arrays[name + "normals"] = hash(floats);
    }
    if (mesh.texture) {
      floats.resize(2 * vertices);
      fvv_texture_to_floats(mesh.texture_bits, mesh.texture, vertices, floats.data());
      arrays[name + "uvs"] = hash(floats);
    }
    const uint8_t *colours;
    uint32_t count;
    if (found(fvv_stream_colours(stream, frame, track, &colours, &count, nullptr)))
      arrays[name + "colours"] = sha256(colours, 3 * size_t(count));
  }

  void visibility(uint16_t track) {
    const fvv_visibility *seen;
    if (!found(fvv_stream_visibility(stream, frame, track, &seen, nullptr))) return;
    const size_t count = seen->header.vertex_count;
    std::vector<uint8_t> weights(count);
    for (size_t i = 0; i < seen->header.camera_count; i++) {
      fvv_visibility_weights(seen->states + i * count, count, weights.data());
      arrays["visibility/" + std::to_string(track) + "/" + std::to_string(seen->cameras[i])] = hash(weights);
    }
  }

  void video(uint16_t track) {
    const std::string id = std::to_string(track);
    const uint8_t *sample;
    size_t size;
    int key;
    const bool sampled = found(fvv_stream_sample(stream, frame, track, &sample, &size, &key, nullptr));
    if (sampled) {
      const uint8_t flag = key != 0;
      arrays["video/" + id + "/sample"] = sha256(sample, size);
      arrays["video/" + id + "/key"] = sha256(&flag, 1);
    }
    const fvv_tile *tiles;
    size_t count;
    const fvv_status laid_out = fvv_stream_tiles(stream, info.group, track, &tiles, &count, nullptr);
    if (laid_out < 0 && !sampled) return; // a frame without a sample needs no layout
    if (!found(laid_out)) return;
    std::vector<uint32_t> numbers;
    for (size_t i = 0; i < count; i++) {
      numbers.push_back(tiles[i].camera_id);
      for (const fvv_rect &rect : {tiles[i].source, tiles[i].destination})
        numbers.insert(numbers.end(), {rect.x, rect.y, rect.width, rect.height});
    }
    arrays["tiles/" + id] = hash(numbers);
  }

  void camera(uint16_t id) {
    fvv_camera camera;
    if (!found(fvv_stream_camera(stream, frame, id, &camera, nullptr))) return;
    std::vector<double> numbers = {camera.fx, camera.fy, camera.cx, camera.cy, camera.skew};
    numbers.insert(numbers.end(), std::begin(camera.distortion), std::end(camera.distortion));
    numbers.push_back(camera.r_max);
    numbers.insert(numbers.end(), std::begin(camera.rotation), std::end(camera.rotation));
    numbers.insert(numbers.end(), std::begin(camera.translation), std::end(camera.translation));
    arrays["camera/" + std::to_string(id)] = hash(numbers);
  }

  void data(uint16_t track) {
    const fvv_chunk_info *chunks;
    size_t count;
    if (!fvv_configuration_data(configuration, track)) return;
    if (!found(fvv_stream_group_chunks(stream, info.group, &chunks, &count, nullptr))) return;
    for (size_t i = 0; i < count; i++) {
      if (chunks[i].type != FVV_CHUNK_DATA || chunks[i].track != track || chunks[i].time != info.time)
        continue;
      const uint8_t *payload;
      if (found(fvv_stream_read_chunk(stream, &chunks[i], &payload, nullptr)))
        arrays["data/" + std::to_string(track)] = sha256(payload, size_t(chunks[i].size));
    }
  }

  void texturing() {
    const fvv_texturing &t = configuration->texturing;
    const std::vector<double> numbers = {t.threshold,
                                         t.depth_bias,
                                         t.depth_slope,
                                         double(t.best),
                                         65536.0 * t.unseen[0] + 256.0 * t.unseen[1] + t.unseen[2],
                                         double(t.blend)};
    arrays["texturing"] = hash(numbers);
  }
};

} // namespace

json frame_arrays(fvv_stream *stream, size_t frame) {
  Frame f{stream, frame, {}, nullptr};
  try {
    if (!found(fvv_stream_frame(stream, frame, &f.info, nullptr))) return nullptr;
    found(fvv_stream_configuration(stream, f.info.group, &f.configuration, nullptr));
    for (size_t i = 0; i < f.configuration->track_count; i++) {
      const fvv_track &track = f.configuration->tracks[i];
      if (track.rank) continue;
      if (track.kind == FVV_TRACK_MESH) f.mesh(track.id);
      if (track.kind == FVV_TRACK_VISIBILITY) f.visibility(track.id);
      if (track.kind == FVV_TRACK_VIDEO) f.video(track.id);
      if (track.kind == FVV_TRACK_DATA && track.flags & FVV_TRACK_FLAG_FRAMES) f.data(track.id);
    }
    for (size_t i = 0; i < f.configuration->camera_count; i++) f.camera(f.configuration->cameras[i].id);
    f.texturing();
  } catch (fvv_status) {
    return nullptr;
  }
  return {{"time", f.info.time}, {"arrays", f.arrays}};
}

namespace {

struct Sound {
  size_t packets = 0;
  int64_t start = 0;
  std::vector<uint8_t> bytes;
  json chunks = json::array();
};

void take_packets(Sound &sound, const fvv_audio_chunk &chunk, const std::vector<fvv_audio_packet> &packets) {
  const size_t before = sound.bytes.size();
  if (!sound.packets) sound.start = chunk.start;
  for (size_t i = 0; i < chunk.packet_count; i++)
    sound.bytes.insert(sound.bytes.end(), packets[i].data, packets[i].data + packets[i].size);
  sound.packets += chunk.packet_count;
  sound.chunks.push_back({{"start", chunk.start},
                          {"packets", chunk.packet_count},
                          {"sha256", sha256(sound.bytes.data() + before, sound.bytes.size() - before)}});
}

// What is taken is removed from offsets: a group that only a wrong index lists may overlap with another.
void take_sound_of_group(fvv_stream *stream, size_t group, std::set<uint64_t> &offsets,
                         std::map<uint16_t, Sound> &tracks) {
  const fvv_configuration *configuration;
  const fvv_chunk_info *chunks;
  size_t count;
  if (fvv_stream_configuration(stream, group, &configuration, nullptr) != FVV_OK) return;
  if (!configuration->sound_count ||
      fvv_stream_group_chunks(stream, group, &chunks, &count, nullptr) != FVV_OK)
    return;
  std::map<uint16_t, fvv_audio_place> places;
  std::map<uint16_t, bool> lost; // what follows a wrong chunk in its group cannot be placed
  for (size_t i = 0; i < count; i++) {
    if (!offsets.count(chunks[i].offset) || lost[chunks[i].track]) continue;
    const fvv_audio_config *config = fvv_configuration_audio(configuration, chunks[i].track);
    if (!config || !fvv_audio_codec_known(config->codec)) continue;
    const uint8_t *payload;
    fvv_audio_chunk chunk = {};
    std::vector<fvv_audio_packet> packets(chunks[i].size / 3 + 1);
    fvv_status status = fvv_stream_read_chunk(stream, &chunks[i], &payload, nullptr);
    if (status == FVV_OK)
      status = fvv_audio_decode(config, payload, size_t(chunks[i].size), &chunk, packets.data(),
                                packets.size(), nullptr);
    if (status == FVV_OK)
      status = fvv_audio_follow(&places[chunks[i].track], config, configuration->scene.time_base, &chunk,
                                chunks[i].flags & FVV_FLAG_KEY, chunks[i].time,
                                fvv_stream_group(stream, group)->end, nullptr);
    if (status == FVV_OK) {
      take_packets(tracks[chunks[i].track], chunk, packets);
      offsets.erase(chunks[i].offset);
    } else {
      lost[chunks[i].track] = true;
    }
  }
}

} // namespace

json sounds(fvv_stream *stream, std::set<uint64_t> offsets) {
  std::map<uint16_t, Sound> tracks;
  for (size_t i = 0; i < fvv_stream_group_count(stream); i++) take_sound_of_group(stream, i, offsets, tracks);
  json out = json::object();
  for (const auto &[track, sound] : tracks)
    if (sound.packets)
      out[std::to_string(track)] = {{"packets", sound.packets},
                                    {"start", sound.start},
                                    {"sha256", hash(sound.bytes)},
                                    {"chunks", sound.chunks}};
  return out;
}

namespace {

json environment_arrays(const fvv_environment &environment) {
  json out = json::object();
  for (size_t i = 0; i < environment.part_count; i++) {
    Mesh mesh;
    found(fvv_environment_mesh(&environment, i, nullptr, nullptr, &mesh, nullptr));
    const fvv_environment_part &part = environment.parts[i];
    const std::string name = "part/" + std::to_string(i) + "/";
    const size_t vertices = mesh.vertex_count;
    std::vector<float> floats(3 * vertices);
    fvv_lattice_to_floats(environment.lattice_origin, environment.lattice_step, mesh.lattice, vertices,
                          floats.data());
    out[name + "positions"] = hash(floats);
    out[name + "faces"] = hash(mesh.faces, 3 * size_t(mesh.face_count));
    if (!mesh.texture) continue;
    floats.resize(2 * vertices);
    fvv_texture_to_floats(mesh.texture_bits, mesh.texture, vertices, floats.data());
    for (size_t k = 0; k < 2 * vertices; k++)
      floats[k] = float(part.texture_origin[k % 2] + part.texture_size[k % 2] * double(floats[k]));
    out[name + "uvs"] = hash(floats);
  }
  for (size_t i = 0; i < environment.picture_count; i++)
    out["picture/" + std::to_string(i)] = sha256(environment.pictures[i].data, environment.pictures[i].size);
  for (size_t i = 0; i < environment.light_count; i++) {
    const fvv_light &l = environment.lights[i];
    std::vector<double> numbers;
    for (const auto *triple : {&l.position, &l.direction, &l.colour})
      numbers.insert(numbers.end(), std::begin(*triple), std::end(*triple));
    numbers.insert(numbers.end(), {l.intensity, l.range, l.inner_cone, l.outer_cone});
    out["light/" + std::to_string(i)] = hash(numbers);
  }
  return out;
}

} // namespace

json environments(fvv_stream *stream) {
  json out = json::object();
  // Readers look in a few places only. Clause 18.5: all groups of one configuration have the same
  // environment.
  uint64_t last_configuration = 0;
  for (size_t group = fvv_stream_group_count(stream); group-- > 0;) {
    const fvv_configuration *configuration;
    if (fvv_stream_configuration(stream, group, &configuration, nullptr) != FVV_OK) continue;
    const uint64_t place = fvv_stream_group(stream, group)->configuration_offset;
    if (last_configuration && place != last_configuration) break;
    last_configuration = place;
    for (size_t i = 0; i < configuration->track_count; i++) {
      if (configuration->tracks[i].kind != FVV_TRACK_ENVIRONMENT || configuration->tracks[i].rank) continue;
      const uint16_t track = configuration->tracks[i].id;
      const fvv_environment *environment;
      if (out.contains(std::to_string(track)) ||
          fvv_stream_environment(stream, group, track, &environment, nullptr) != FVV_OK)
        continue;
      try {
        out[std::to_string(track)] = environment_arrays(*environment);
      } catch (fvv_status) {
        // Nothing of it is called intact.
      }
    }
  }
  return out;
}

} // namespace fvv::conformance
