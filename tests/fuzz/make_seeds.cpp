// Seeds that need an encoder: meshes of several shapes in Draco and the fast profile, with delta and patched
// frames.
#include "make_seeds.h"

#include "fvv/mesh.h"

#include <algorithm>
#include <string>

namespace {

struct Shape {
  std::vector<double> positions, texture, normals;
  std::vector<uint32_t> faces;
};

// A bent sheet of side x side vertices; closed: a tube, whose seam of the texture is a second row of
// vertices.
Shape sheet(uint32_t side, bool closed) {
  Shape out;
  for (uint32_t y = 0; y < side; y++)
    for (uint32_t x = 0; x < side; x++) {
      const double angle = 6.283185307179586 * x / (side - 1), u = double(x) / (side - 1),
                   v = double(y) / (side - 1);
      const double round[3] = {closed ? double(int(1000 * (angle < 3.14 ? angle : 6.28 - angle))) / 1000 : u,
                               closed ? (x && x + 1 < side ? (x * 7) % 5 / 4.0 : 0) : 0.25 * u * v, v};
      out.positions.insert(out.positions.end(), round, round + 3);
      out.texture.insert(out.texture.end(), {u, v});
      out.normals.insert(out.normals.end(), {u - 0.5, v - 0.5, 1});
      if (x + 1 == side || y + 1 == side) continue;
      const uint32_t a = y * side + x, b = a + 1, c = a + side, d = c + 1;
      out.faces.insert(out.faces.end(), {a, b, c, b, d, c});
    }
  return out;
}

void append_part(fuzz::Bytes &out, const fvv_bytes &payload) {
  fuzz::expect(payload.size < 65536, "seeds are small");
  out.push_back(uint8_t(payload.size));
  out.push_back(uint8_t(payload.size >> 8));
  out.insert(out.end(), payload.data, payload.data + payload.size);
}

void write_delta(const fuzz::Folder &folder, const std::string &name, const fvv_mesh &mesh,
                 const fvv_bytes &key) {
  fuzz::Bytes out;
  append_part(out, key);
  fvv_mesh_sequence *sequence = nullptr;
  fuzz::expect(fvv_mesh_sequence_open(&mesh, nullptr, &sequence, nullptr) == FVV_OK, "a mesh may be a key");
  // Frames 2, 3 and 5 are patched: the key mesh again is in the place of a growing part of the faces, at last
  // of all; frame 5 adds nothing.
  for (int frame = 1; frame < 7; frame++) {
    const fvv_mesh &now = *fvv_mesh_sequence_mesh(sequence);
    std::vector<int32_t> positions(now.lattice, now.lattice + 3 * size_t(now.vertex_count));
    for (size_t i = 0; i < positions.size(); i++)
      positions[i] += int32_t(i % 3 == 0 ? frame : positions[i] / 40 % 3);
    std::vector<uint8_t> absent(now.face_count);
    std::fill_n(absent.begin(), frame == 3 ? absent.size() : absent.size() / 2, uint8_t(1));
    const fvv_mesh_patch patch = {sizeof patch,
                                  absent.data(),
                                  frame == 5 ? nullptr : &mesh,
                                  nullptr,
                                  uint8_t(frame == 2 ? FVV_MESH_RAW : FVV_MESH_FAST),
                                  0,
                                  nullptr};
    fuzz::Payload payload;
    const fvv_status status =
        frame == 2 || frame == 3 || frame == 5
            ? fvv_mesh_sequence_encode_patched(sequence, positions.data(), nullptr, &patch, &payload.bytes,
                                               nullptr)
            : fvv_mesh_sequence_encode(sequence, positions.data(), nullptr, &payload.bytes, nullptr);
    fuzz::expect(status == FVV_OK, "a frame can be encoded");
    append_part(out, payload.bytes);
  }
  fvv_mesh_sequence_close(sequence);
  folder.write("delta", name, out);
}

void write_shape(const fuzz::Folder &folder, const Shape &shape, const std::string &name) {
  const fvv_mesh_source source = {shape.positions.data(), shape.faces.data(),   shape.positions.size() / 3,
                                  shape.faces.size() / 3, shape.texture.data(), shape.normals.data()};
  for (int with = 0; with < 4; with++) {
    fvv_mesh_options options;
    fvv_mesh_options_default(&options);
    options.lattice_step = 1.0 / 256;
    options.texture_bits = with & 1 ? 8 : 0;
    options.normal_bits = with & 2 ? 8 : 0;
    fvv_mesh mesh;
    fuzz::expect(fvv_mesh_canonicalise(&source, &options, nullptr, &mesh, nullptr, nullptr) == FVV_OK,
                 "a shape is a mesh");
    for (int level = -1; level <= 10; level += level < 0 ? 1 : 2) {
      const bool fast = level < 0;
      fuzz::Payload payload;
      fuzz::expect(fvv_mesh_encode(&mesh, fast ? FVV_MESH_FAST : FVV_MESH_DRACO, std::max(level, 0), nullptr,
                                   &payload.bytes, nullptr) == FVV_OK,
                   "a mesh can be encoded");
      const std::string file = name + "-" + std::to_string(with) + "-" + std::to_string(level);
      folder.write(fast ? "fast" : "draco", file,
                   fuzz::Bytes(payload.bytes.data, payload.bytes.data + payload.bytes.size));
      fvv_mesh decoded;
      fuzz::expect(fvv_mesh_decode(payload.bytes.data, payload.bytes.size, nullptr, nullptr, &decoded,
                                   nullptr) == FVV_OK,
                   "what was encoded decodes");
      if (fast || level == 6) write_delta(folder, file, decoded, payload.bytes);
      fvv_mesh_free(&decoded);
    }
    fvv_mesh_free(&mesh);
  }
}

} // namespace

int main(int count, char **given) {
  if (count != 2) {
    std::fprintf(stderr, "usage: fuzz_seeds FOLDER\n");
    return 2;
  }
  const fuzz::Folder folder = {given[1]};
  for (const uint32_t side : {2u, 5u, 12u})
    for (const bool closed : {false, true})
      write_shape(folder, sheet(side, closed && side > 2), std::to_string(side) + (closed ? "t" : "s"));
  fuzz::write_worst_streams(folder);
  return 0;
}
