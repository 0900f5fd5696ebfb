// fvvbench: times parts of libfvv on a given file. Prints one JSON object: figure -> number. Every time is
// the median of several runs; what can be compared within one run is (copying the same bytes, beside
// demultiplexing).
//   fvvbench demux FILE.fvv    push reader with all CRCs, over the file's chunks repeated to some 400 MB
//   fvvbench draco FILE.fvv    Draco coding of the file's meshes at level 7
//   fvvbench fast FILE.fvv     the same meshes as meshoptimizer codes them, beside Draco and raw
//   fvvbench delta FILE.fvv    the file's meshes, which share their triangles, as delta frames after the
//                              first, off by one step of the lattice at most
//   fvvbench first FILE.fvv    its first mesh as a new process reads it, and as the same process does again
//   fvvbench read FILE.fvv     all meshes of the file as bindings/python gives them: positions in metres as
//                              floats, faces, and colours where the stream has some
//   fvvbench visibility FILE.fvv
//                              what its cameras see of its meshes (visibility.cpp)
//   fvvbench depth FILE.fvv    the same by depth maps of several sizes and tolerances (visibility.cpp)
#include "fvvbench.h"

#include "fvv_cxx/input_file.h"

#include <ctime>

namespace {

// The groups of the file repeated as one long stream.
Bytes long_stream(Bytes &source, size_t wanted) {
  fvv_diagnostic d{};
  fvv_stream *file = nullptr;
  const fvv_input input = input_of(source);
  require(fvv_stream_open(&input, nullptr, nullptr, &file, &d), d);
  Bytes out;
  const fvv_output output = {[](void *user, const void *data, size_t size) -> fvv_status {
                               auto *bytes = static_cast<Bytes *>(user);
                               const auto *p = static_cast<const uint8_t *>(data);
                               bytes->insert(bytes->end(), p, p + size);
                               return FVV_OK;
                             },
                             &out};
  fvv_writer *writer = nullptr;
  require(fvv_writer_create(&output, nullptr, &writer, &d), d);
  const fvv_chunk_info *chunks = nullptr;
  size_t count = 0;
  const uint8_t *payload = nullptr;
  require(fvv_stream_configuration_chunks(file, 0, &chunks, &count, &d), d);
  for (size_t c = 0; c < count; c++) {
    require(fvv_stream_read_chunk(file, &chunks[c], &payload, &d), d);
    require(fvv_writer_configuration(writer, chunks[c].type, chunks[c].track, chunks[c].flags, payload,
                                     size_t(chunks[c].size), &d),
            d);
  }
  for (int64_t shift = 0; out.size() < wanted;) {
    int64_t end = 0;
    for (size_t g = 0; g < fvv_stream_group_count(file) && out.size() < wanted; g++) {
      const fvv_group_info *group = fvv_stream_group(file, g);
      end = shift + group->end;
      require(fvv_writer_begin_group(writer, shift + group->start, end, &d), d);
      require(fvv_stream_group_chunks(file, g, &chunks, &count, &d), d);
      for (size_t c = 0; c < count; c++) {
        require(fvv_stream_read_chunk(file, &chunks[c], &payload, &d), d);
        require(fvv_writer_chunk(writer, chunks[c].type, chunks[c].track, chunks[c].flags,
                                 shift + chunks[c].time, payload, size_t(chunks[c].size), &d),
                d);
      }
      require(fvv_writer_end_group(writer, &d), d);
    }
    shift = end;
  }
  require(fvv_writer_finish(writer, &d), d);
  fvv_writer_destroy(writer);
  fvv_stream_close(file);
  return out;
}

nlohmann::ordered_json demux(const char *path) {
  Bytes source = read_file(path);
  const Bytes stream = long_stream(source, size_t(400) << 20);
  constexpr size_t block = 1 << 20;
  const double reading = median([&] {
    fvv_reader *reader = nullptr;
    fvv_diagnostic d{};
    require(fvv_reader_create(nullptr, nullptr, 0, &reader), d);
    fvv_event event;
    bool ended = false;
    for (size_t at = 0; at < stream.size(); at += block) {
      require(fvv_reader_push(reader, stream.data() + at, std::min(block, stream.size() - at)), d);
      while (fvv_reader_next(reader, &event, &d) == FVV_OK) {
        if (event.kind == FVV_EVENT_DAMAGE) throw std::runtime_error(event.diagnostic.message);
        ended = ended || event.kind == FVV_EVENT_END;
      }
    }
    if (!ended) throw std::runtime_error("the stream did not end");
    fvv_reader_destroy(reader);
  });
  Bytes copy(block);
  volatile uint8_t sink = 0;
  const double copying = median([&] {
    for (size_t at = 0; at < stream.size(); at += block) {
      std::memcpy(copy.data(), stream.data() + at, std::min(block, stream.size() - at));
      sink = copy[at % block];
    }
  });
  (void)sink;
  return {{"demux.gb_per_s", double(stream.size()) / reading / 1e9},
          {"demux.copy_gb_per_s", double(stream.size()) / copying / 1e9}};
}

// Means of the first ten frames.
struct Coding {
  double encode = 0, decode = 0, normals = 0, vertices = 0, faces = 0, bytes = 0; // times in seconds
};

std::vector<Coding> code(const char *path, const std::vector<uint8_t> &profiles) {
  Bytes source = read_file(path);
  fvv_diagnostic d{};
  fvv_stream *stream = nullptr;
  const fvv_input input = input_of(source);
  require(fvv_stream_open(&input, nullptr, nullptr, &stream, &d), d);
  const size_t frames = std::min<size_t>(fvv_stream_frame_count(stream), 10);
  const double share = 1 / double(frames);
  std::vector<Coding> out(profiles.size());
  for (size_t f = 0; f < frames; f++) {
    fvv_mesh mesh;
    require(fvv_stream_mesh(stream, f, 1, &mesh, &d), d);
    for (size_t p = 0; p < profiles.size(); p++) {
      fvv_bytes payload{};
      out[p].encode +=
          share * median([&] { require(fvv_mesh_encode(&mesh, profiles[p], 7, nullptr, &payload, &d), d); });
      out[p].decode +=
          share * median([&] {
            fvv_mesh again;
            require(fvv_mesh_decode(payload.data, payload.size, nullptr, nullptr, &again, &d), d);
            fvv_mesh_free(&again);
          });
      std::vector<float> computed(3 * size_t(mesh.vertex_count));
      out[p].normals +=
          share * median([&] { require(fvv_mesh_normals(&mesh, nullptr, computed.data(), &d), d); });
      out[p].vertices += share * mesh.vertex_count;
      out[p].faces += share * mesh.face_count;
      out[p].bytes += share * double(payload.size);
      fvv_bytes_free(&payload);
    }
    fvv_mesh_free(&mesh);
  }
  fvv_stream_close(stream);
  return out;
}

nlohmann::ordered_json draco(const char *path) {
  const Coding c = code(path, {FVV_MESH_DRACO})[0];
  return {{"draco.encode_ms", c.encode * 1e3},
          {"draco.decode_ms", c.decode * 1e3},
          {"draco.normals_ms", c.normals * 1e3},
          {"draco.bits_per_vertex", c.bytes * 8 / c.vertices},
          {"draco.triangles", c.faces}};
}

nlohmann::ordered_json fast(const char *path) {
  const std::vector<Coding> all = code(path, {FVV_MESH_FAST, FVV_MESH_DRACO, FVV_MESH_RAW});
  const Coding &fast = all[0], &draco = all[1], &raw = all[2];
  return {{"fast.encode_ms", fast.encode * 1e3},
          {"fast.decode_ms", fast.decode * 1e3},
          {"fast.bits_per_vertex", fast.bytes * 8 / fast.vertices},
          {"fast.bytes_over_draco", fast.bytes / draco.bytes},
          {"fast.decode_time_over_draco", fast.decode / draco.decode},
          {"fast.bytes_over_raw", fast.bytes / raw.bytes},
          {"fast.decode_time_over_raw", fast.decode / raw.decode}};
}

nlohmann::ordered_json delta(const char *path) {
  Bytes source = read_file(path);
  fvv_diagnostic d{};
  fvv_stream *stream = nullptr;
  const fvv_input input = input_of(source);
  require(fvv_stream_open(&input, nullptr, nullptr, &stream, &d), d);
  fvv_mesh key;
  require(fvv_stream_mesh(stream, 0, 1, &key, &d), d);
  fvv_mesh_sequence *encoder = nullptr, *decoder = nullptr;
  const double open = median([&] {
    fvv_mesh_sequence_close(encoder);
    require(fvv_mesh_sequence_open(&key, nullptr, &encoder, &d), d);
  });
  require(fvv_mesh_sequence_open(&key, nullptr, &decoder, &d), d);
  fvv_mesh_delta_options options;
  fvv_mesh_delta_options_default(&options);
  fvv_bytes payload{};
  double encode = 0, bytes = 0;
  std::vector<double> decode;
  const size_t frames = fvv_stream_frame_count(stream);
  for (size_t f = 1; f < frames; f++) {
    fvv_mesh mesh;
    require(fvv_stream_mesh(stream, f, 1, &mesh, &d), d);
    // A face without area on the lattice was dropped: a muxer would begin a group here.
    const bool same =
        mesh.face_count == key.face_count && !std::memcmp(mesh.faces, key.faces, 12 * size_t(key.face_count));
    if (!same) {
      fvv_mesh_free(&mesh);
      break;
    }
    encode +=
        seconds([&] { require(fvv_mesh_sequence_encode(encoder, mesh.lattice, &options, &payload, &d), d); });
    decode.push_back(
        seconds([&] { require(fvv_mesh_sequence_decode(decoder, payload.data, payload.size, &d), d); }));
    bytes += double(payload.size);
    if (std::memcmp(fvv_mesh_sequence_mesh(encoder)->lattice, fvv_mesh_sequence_mesh(decoder)->lattice,
                    12 * size_t(key.vertex_count)) != 0)
      throw std::runtime_error("frame " + std::to_string(f) + " is not what was encoded");
    fvv_mesh_free(&mesh);
  }
  if (decode.empty()) throw std::runtime_error("the second frame has other triangles than the first");
  std::sort(decode.begin(), decode.end());
  const double coded = double(decode.size());
  const nlohmann::ordered_json figures = {{"delta.open_ms", open * 1e3},
                                          {"delta.encode_ms", encode / coded * 1e3},
                                          {"delta.decode_ms", decode[decode.size() / 2] * 1e3},
                                          {"delta.bits_per_vertex", bytes * 8 / coded / key.vertex_count},
                                          {"delta.triangles", key.face_count},
                                          {"delta.frames", coded}};
  fvv_bytes_free(&payload);
  fvv_mesh_sequence_close(encoder);
  fvv_mesh_sequence_close(decoder);
  fvv_mesh_free(&key);
  fvv_stream_close(stream);
  return figures;
}

nlohmann::ordered_json first(const char *path) {
  Bytes source = read_file(path);
  const fvv_input input = input_of(source);
  std::vector<double> times;
  uint32_t faces = 0;
  for (int i = 0; i <= runs; i++) {
    fvv_diagnostic d{};
    fvv_stream *stream = nullptr;
    fvv_mesh mesh;
    require(fvv_stream_open(&input, nullptr, nullptr, &stream, &d), d);
    times.push_back(seconds([&] { require(fvv_stream_mesh(stream, 0, 1, &mesh, &d), d); }));
    faces = mesh.face_count;
    fvv_mesh_free(&mesh);
    fvv_stream_close(stream);
  }
  std::sort(times.begin() + 1, times.end());
  return {{"first_ms", times[0] * 1e3}, {"again_ms", times[1 + runs / 2] * 1e3}, {"triangles", faces}};
}

nlohmann::ordered_json read_meshes(const char *path) {
  // The least time of the processor, as bench/python_package.py has it: other programs slow down both.
  double least = 1e9;
  for (int i = 0; i < runs; i++) {
    const std::clock_t begin = std::clock();
    const fvv::InputFile file(path);
    const fvv_input input = file.input();
    fvv_diagnostic d{};
    fvv_stream *stream = nullptr;
    require(fvv_stream_open(&input, nullptr, nullptr, &stream, &d), d);
    for (size_t f = 0; f < fvv_stream_frame_count(stream); f++) {
      fvv_frame frame;
      require(fvv_stream_frame(stream, f, &frame, &d), d);
      const fvv_configuration *configuration = nullptr;
      require(fvv_stream_configuration(stream, frame.group, &configuration, &d), d);
      const fvv_scene scene = configuration->scene;
      fvv_mesh mesh;
      require(fvv_stream_mesh(stream, f, 1, &mesh, &d), d);
      const uint8_t *colours = nullptr;
      uint32_t count = 0;
      require(fvv_stream_colours(stream, f, 1, &colours, &count, &d), d);
      std::vector<float> positions(3 * size_t(mesh.vertex_count));
      fvv_lattice_to_floats(scene.lattice_origin, scene.lattice_step, mesh.lattice, mesh.vertex_count,
                            positions.data());
      const Bytes kept(colours, colours + 3 * size_t(count));
      fvv_mesh_free(&mesh);
    }
    fvv_stream_close(stream);
    least = std::min(least, double(std::clock() - begin) / CLOCKS_PER_SEC);
  }
  return {{"python.c_read_ms", least * 1e3}};
}

} // namespace

int main(int argc, char **argv) {
  try {
    const std::string what = argc == 3 ? argv[1] : "";
    const auto part = what == "demux"        ? demux
                      : what == "draco"      ? draco
                      : what == "fast"       ? fast
                      : what == "delta"      ? delta
                      : what == "first"      ? first
                      : what == "read"       ? read_meshes
                      : what == "visibility" ? visibility
                      : what == "depth"      ? depth_maps
                                             : nullptr;
    if (!part) {
      std::fputs("usage: fvvbench demux|draco|fast|delta|first|read|visibility|depth FILE.fvv\n", stderr);
      return 2;
    }
    std::printf("%s\n", part(argv[2]).dump().c_str());
    return 0;
  } catch (const std::exception &error) {
    std::fprintf(stderr, "fvvbench: %s\n", error.what());
    return 1;
  }
}
