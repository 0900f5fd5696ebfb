// fvvcodecs: bytes, error and time of mesh codecs over a sequence of mesh files, each at several settings, as
// a JSON array with one object a line of the table. codecs_table.py runs it and lays the tables out.
//   fvvcodecs key|delta [--height METRES] [--up 0|1|2] --step MILLIMETRES[,...] FILE...
//   fvvcodecs peers [--height METRES] [--up 0|1|2] --bits BITS[,...] FILE...
// key: every file by itself. peers: the same by codecs of others (fvvpeers.cpp). delta: files after the first
// as delta frames; all have the faces of the first, and bytes and times are those of the delta frames alone.
// --height scales the sequence so that the first mesh has this height along the axis --up. Times are of the
// processor on one thread, a mean over the frames of the faster of two runs (delta frames: of one).
#include "fvvcodecs.h"

#include "fvv/mesh.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace fvv::codecs {

void Row::measure(const Mesh &source, const Mesh &decoded) {
  constexpr size_t samples = 20000;
  const compare::Measure apart = compare::measure(compare::Surface(source), compare::Surface(decoded),
                                                  samples, compare::Points::vertices);
  measured++;
  size_t way = 0;
  for (const compare::DirectedErrors *direction : {&apart.a_to_b, &apart.b_to_a}) {
    const double rms = direction->distance.figures().rms;
    squares[way] += rms * rms;
    distances[way++].add(direction->distance.histogram());
  }
}

nlohmann::ordered_json Row::json() const {
  const double n = double(frames);
  const double rms = std::sqrt(std::max(squares[0], squares[1]) / double(std::max<size_t>(measured, 1)));
  const double p99 = std::max(distances[0].quantile(0.99), distances[1].quantile(0.99));
  return {{"codec", codec},
          {"setting", setting},
          {"step_mm", step * 1e3},
          {"frames", frames},
          {"bytes_per_frame", bytes / n},
          {"bits_per_vertex", bytes * 8 / vertices},
          {"rms_mm", rms * 1e3},
          {"p99_mm", p99 * 1e3},
          {"encode_ms", encode / n * 1e3},
          {"decode_ms", decode / n * 1e3}};
}

namespace {

constexpr double origin[3] = {0, 0, 0};

// One line for each profile of key frames.
const struct Key {
  const char *codec, *setting;
  uint8_t profile;
  int level;
} keys[] = {{"raw", "", FVV_MESH_RAW, 0},
            {"draco", "level 0", FVV_MESH_DRACO, 0},
            {"draco", "level 5", FVV_MESH_DRACO, 5},
            {"draco", "level 7", FVV_MESH_DRACO, 7},
            {"draco", "level 9", FVV_MESH_DRACO, 9},
            {"draco", "level 10", FVV_MESH_DRACO, 10},
            {"fast", "", FVV_MESH_FAST, 0}};
constexpr int plain_levels[] = {7, 10};

// Errors in steps of the lattice. With an error of e the quantiser of motion has 2 e + 1 steps of it: all are
// off by half a step of the quantiser at most, on each axis and from the requested lattice point.
constexpr uint32_t delta_errors[] = {0, 1, 2, 4};
constexpr size_t measure_each = 7; // frames of a tracked sequence

void require(fvv_status status, const fvv_diagnostic &d) {
  if (status < 0) throw std::runtime_error(d.message[0] ? d.message : fvv_status_text(status));
}

struct Holder {
  fvv_mesh mesh = {};
  Holder() = default;
  Holder(const Holder &) = delete;
  ~Holder() { fvv_mesh_free(&mesh); }
};

struct Bytes {
  fvv_bytes bytes = {};
  Bytes() = default;
  Bytes(const Bytes &) = delete;
  ~Bytes() { fvv_bytes_free(&bytes); }
};

// later: of the other frames of a tracked sequence.
void canonicalise(const Mesh &source, double step, fvv_mesh &mesh, std::vector<uint32_t> *map = nullptr,
                  const std::vector<std::vector<int32_t>> &later = {}) {
  fvv_mesh_options options;
  fvv_mesh_options_default(&options);
  options.lattice_step = step;
  const fvv_mesh_source borrowed = {source.positions.data(),
                                    source.faces.data(),
                                    source.vertex_count(),
                                    source.face_count(),
                                    nullptr,
                                    nullptr};
  std::vector<const int32_t *> frames;
  for (const std::vector<int32_t> &frame : later) frames.push_back(frame.data());
  if (map) map->resize(source.vertex_count());
  fvv_diagnostic d{};
  require(fvv_mesh_canonicalise_run(&borrowed, frames.data(), frames.size(), &options, nullptr, &mesh,
                                    map ? map->data() : nullptr, nullptr, &d),
          d);
}

Mesh in_metres(const fvv_mesh &mesh, double step) {
  Mesh out;
  out.positions.resize(3 * size_t(mesh.vertex_count));
  for (uint32_t v = 0; v < mesh.vertex_count; v++)
    fvv_lattice_to_metres(origin, step, mesh.lattice + 3 * size_t(v), &out.positions[3 * size_t(v)]);
  out.faces.assign(mesh.faces, mesh.faces + 3 * size_t(mesh.face_count));
  return out;
}

std::vector<Row> key_rows(const std::vector<Mesh> &frames, double step) {
  std::vector<Row> rows, plain;
  for (const Key &key : keys) rows.emplace_back(key.codec, key.setting, step);
  for (const int level : plain_levels) {
    rows.emplace_back("libdraco", "level " + std::to_string(level) + ", same lattice", step);
    plain.emplace_back("libdraco", "", 0);
  }
  for (const Mesh &source : frames) {
    Holder mesh;
    canonicalise(source, step, mesh.mesh);
    size_t r = 0;
    for (const Key &key : keys) {
      Bytes payload;
      Holder decoded;
      fvv_diagnostic d{};
      const double encode = faster([&] {
        require(fvv_mesh_encode(&mesh.mesh, key.profile, key.level, nullptr, &payload.bytes, &d), d);
      });
      const double decode = faster([&] {
        fvv_mesh_free(&decoded.mesh);
        require(fvv_mesh_decode(payload.bytes.data, payload.bytes.size, nullptr, nullptr, &decoded.mesh, &d),
                d);
      });
      // All profiles give the same triangles; one of them is enough to measure these.
      if (r == 0) rows[0].measure(source, in_metres(decoded.mesh, step));
      rows[r++].count(source, payload.bytes.size, encode, decode);
    }
    const PlainDraco draco(source);
    for (size_t i = 0; i < plain.size(); i++) {
      std::string bytes;
      double encode = faster([&] { bytes = draco.encode_on_lattice(source, step, plain_levels[i]); });
      double decode = faster([&] { PlainDraco::decode(bytes); });
      if (i == 0) rows[r].measure(source, scene::parse_drc(bytes, "libdraco"));
      rows[r + i].count(source, bytes.size(), encode, decode);
      double coarser = 0;
      const int bits = draco.bits_for(step, &coarser);
      encode = faster([&] { bytes = draco.encode(source, bits, plain_levels[i]); });
      decode = faster([&] { PlainDraco::decode(bytes); });
      if (i == 0) plain[0].measure(source, scene::parse_drc(bytes, "libdraco"));
      plain[i].count(source, bytes.size(), encode, decode);
      plain[i].step += coarser / double(frames.size());
      plain[i].setting = "level " + std::to_string(plain_levels[i]) + ", " + std::to_string(bits) + " bits";
    }
  }
  const size_t own = std::size(keys);
  for (size_t r = 1; r < rows.size(); r++)
    if (r != own) rows[r].take_errors(rows[r < own ? 0 : own]);
  for (Row &row : plain) {
    if (&row != &plain[0]) row.take_errors(plain[0]);
    rows.push_back(row);
  }
  return rows;
}

// All frames but the first.
std::vector<std::vector<int32_t>> on_lattice(const std::vector<Mesh> &frames, double step) {
  std::vector<std::vector<int32_t>> out;
  for (size_t f = 1; f < frames.size(); f++) {
    if (frames[f].faces != frames[0].faces || frames[f].vertex_count() != frames[0].vertex_count())
      throw std::runtime_error("mesh " + std::to_string(f) + " has other faces than the first");
    out.emplace_back(frames[f].positions.size());
    fvv_diagnostic d{};
    require(fvv_lattice_from_metres(origin, step, frames[f].positions.data(), frames[f].vertex_count(),
                                    out.back().data(), &d),
            d);
  }
  return out;
}

// For each vertex of the decoded key mesh the first vertex of the source that it represents.
std::vector<uint32_t> source_vertices(const Mesh &source, const std::vector<std::vector<int32_t>> &later,
                                      double step, Holder &key) {
  Holder mesh;
  std::vector<uint32_t> map;
  canonicalise(source, step, mesh.mesh, &map, later);
  Bytes payload;
  fvv_diagnostic d{};
  std::vector<uint32_t> first(mesh.mesh.vertex_count), out(3 * size_t(mesh.mesh.face_count));
  require(fvv_mesh_encode_mapped(&mesh.mesh, FVV_MESH_DRACO, 7, nullptr, &payload.bytes, &key.mesh,
                                 out.data(), &d),
          d);
  for (size_t v = map.size(); v-- > 0;)
    if (map[v] != UINT32_MAX) first[map[v]] = uint32_t(v);
  out.resize(key.mesh.vertex_count);
  for (uint32_t &v : out) v = first[v];
  return out;
}

using Sequence = std::unique_ptr<fvv_mesh_sequence, void (*)(fvv_mesh_sequence *)>;
Sequence open(const fvv_mesh &key) {
  fvv_diagnostic d{};
  fvv_mesh_sequence *sequence = nullptr;
  require(fvv_mesh_sequence_open(&key, nullptr, &sequence, &d), d);
  return {sequence, fvv_mesh_sequence_close};
}

Row delta_row(const std::vector<Mesh> &frames, double quantiser, uint32_t error) {
  const double step = quantiser / (2 * error + 1);
  char setting[64];
  std::snprintf(setting, sizeof setting, "%.4g mm +- %u", step * 1e3, error);
  Row row("delta", setting, quantiser);
  Holder key;
  const std::vector<std::vector<int32_t>> later = on_lattice(frames, step);
  const std::vector<uint32_t> vertices = source_vertices(frames[0], later, step, key);
  const Sequence encoder = open(key.mesh), decoder = open(key.mesh);
  fvv_mesh_delta_options options;
  fvv_mesh_delta_options_default(&options);
  options.max_error = error;
  Bytes payload;
  std::vector<int32_t> positions(3 * vertices.size());
  for (size_t f = 1; f < frames.size(); f++) {
    for (size_t v = 0; v < vertices.size(); v++)
      std::copy_n(&later[f - 1][3 * size_t(vertices[v])], 3, &positions[3 * v]);
    fvv_diagnostic d{};
    const double encode = seconds([&] {
      require(fvv_mesh_sequence_encode(encoder.get(), positions.data(), &options, &payload.bytes, &d), d);
    });
    const double decode = seconds([&] {
      require(fvv_mesh_sequence_decode(decoder.get(), payload.bytes.data, payload.bytes.size, &d), d);
    });
    row.count(frames[f], payload.bytes.size, encode, decode);
    if (f % measure_each == 0 || f + 1 == frames.size())
      row.measure(frames[f], in_metres(*fvv_mesh_sequence_mesh(decoder.get()), step));
  }
  return row;
}

std::vector<Mesh> read(const std::vector<std::string> &files, double height, size_t up) {
  std::vector<Mesh> frames;
  double factor = 1;
  for (const std::string &file : files) {
    frames.push_back(scene::read_mesh(file));
    std::vector<double> &positions = frames.back().positions;
    if (height > 0 && frames.size() == 1) {
      double low = INFINITY, high = -INFINITY;
      for (size_t i = up; i < positions.size(); i += 3) {
        low = std::min(low, positions[i]);
        high = std::max(high, positions[i]);
      }
      if (!(high > low)) throw std::runtime_error(file + ": has no height along axis " + std::to_string(up));
      factor = height / (high - low);
    }
    for (double &x : positions) x *= factor;
  }
  return frames;
}

} // namespace
} // namespace fvv::codecs

int main(int argc, char **argv) {
  using namespace fvv::codecs;
  CLI::App app("Bytes, error and time of mesh codecs over a sequence of mesh files.");
  std::string mode;
  std::vector<std::string> files;
  std::vector<double> steps;
  std::vector<int> bits;
  double height = 0;
  size_t up = 1;
  app.add_option("mode", mode, "key, delta or peers")
      ->required()
      ->check(CLI::IsMember({"key", "delta", "peers"}));
  app.add_option("files", files, "one mesh a frame")->required();
  app.add_option("--step", steps, "millimetres: of the lattice (key), of the quantiser (delta)")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::PositiveNumber);
  app.add_option("--bits", bits, "of a coordinate, over the box of each mesh (peers)")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::Range(4, 16));
  app.add_option("--height", height, "metres; the first mesh is scaled to it, and all others alike");
  app.add_option("--up", up, "axis of the height")->check(CLI::Range(0, 2));
  CLI11_PARSE(app, argc, argv);
  try {
    const std::vector<Mesh> frames = read(files, height, up);
    if (mode == "delta" && frames.size() < 2) throw std::runtime_error("one mesh has no delta frames");
    if (mode == "peers" ? bits.empty() : steps.empty())
      throw std::runtime_error(mode == "peers" ? "peers needs --bits" : mode + " needs --step");
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (const int precision : bits)
      for (const Row &row : peer_rows(frames, precision)) rows.push_back(row.json());
    for (const double millimetres : steps)
      if (mode == "key")
        for (const Row &row : key_rows(frames, millimetres * 1e-3)) rows.push_back(row.json());
      else
        for (const uint32_t error : delta_errors)
          rows.push_back(delta_row(frames, millimetres * 1e-3, error).json());
    std::printf("%s\n", rows.dump().c_str());
    return 0;
  } catch (const std::exception &error) {
    std::fprintf(stderr, "fvvcodecs: %s\n", error.what());
    return 1;
  }
}
