// The environment of a capture as the payload of a BACK chunk, with converted picture files.
#include "fvv/environment.h"
#include "fvv_cxx/error.h"
#include "fvv_cxx/owned.h"
#include "fvv_media/image.h"
#include "mux/src/environment.h"
#include "mux/src/meshes/meshes.h"
#include "mux/src/plan.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <deque>
#include <string>

namespace fvv::mux {

namespace {

// Longest side in pixels that every reader supports (fvv.md clause 13).
constexpr uint32_t max_picture_side = 4096;

constexpr char png_signature[] = "\x89PNG\r\n\x1a\n";
constexpr int quality = 92;

uint32_t big_endian(const std::string &file, size_t at, int bytes) {
  uint32_t value = 0;
  for (int i = 0; i < bytes; i++) value = value << 8 | uint8_t(file[at + size_t(i)]);
  return value;
}

std::string clean_png(const std::string &file) {
  std::string out = file.substr(0, 8);
  size_t at = 8;
  while (at + 12 <= file.size()) {
    const uint64_t size = uint64_t(big_endian(file, at, 4)) + 12;
    if (size > file.size() - at) return file;
    const bool critical = file[at + 4] >= 'A' && file[at + 4] <= 'Z';
    if (critical || file.compare(at + 4, 4, "tRNS") == 0) out += file.substr(at, size_t(size));
    at += size_t(size);
  }
  return at == file.size() ? out : file;
}

// Up to the first scan; there is no metadata after it.
std::string clean_jpeg(const std::string &file) {
  std::string out = file.substr(0, 2);
  size_t at = 2;
  while (at + 4 <= file.size() && uint8_t(file[at]) == 0xff) {
    const uint8_t marker = uint8_t(file[at + 1]);
    if (marker == 0xff) {
      at++;
      continue;
    }
    if (marker == 0xda) return out + file.substr(at);
    const size_t size = 2 + big_endian(file, at + 2, 2);
    if (size > file.size() - at) return file;
    const bool application = marker >= 0xe0 && marker <= 0xef && marker != 0xe0 && marker != 0xee;
    if (!application && marker != 0xfe) out += file.substr(at, size);
    at += size;
  }
  return file;
}

// Bytes of a PNG or JPEG file as they are, but for metadata: segments APPn other than JFIF's and Adobe's and
// comments of JPEG, ancillary chunks of PNG (clause 14, private data). Other data is not changed.
std::string without_metadata(const std::string &file) {
  if (file.compare(0, 8, png_signature, 8) == 0) return clean_png(file);
  return file.size() > 2 && file.compare(0, 2, "\xff\xd8") == 0 ? clean_jpeg(file) : file;
}

constexpr uint32_t texture_bits = FVV_TEXTURE_BITS_MAX; // a picture may repeat a hundred times
constexpr uint32_t normal_bits = 8;
constexpr int mesh_level = 7;
// Of the diagonal: 1 mm for a room, 1 cm for a stadium.
constexpr double steps_across = 16384;
// A payload that every reader supports (fvv.md clause 13).
constexpr size_t safe_payload = size_t(16) << 20;

class Packer {
public:
  Packer(const scene::Capture &source, PackedEnvironment &packed)
      : capture(source), name(source.resolve(source.environment->file)),
        environment(scene::load_environment(source)), out(packed) {}

  void pack() {
    for (const std::string &note : environment.notes) out.warnings.push_back(name + ": " + note);
    choose_lattice();
    for (size_t i = 0; i < environment.pictures.size(); i++) add_picture(i);
    meshes.resize(environment.parts.size());
    for (size_t i = 0; i < environment.parts.size(); i++) add_part(i);
    encode();
    out.parts = parts.size();
    out.pictures = pictures.size();
    out.lights = environment.lights.size();
    if (out.payload.size() > safe_payload)
      out.warnings.push_back(name + ": the environment takes " + std::to_string(out.payload.size()) +
                             " bytes, more than the 16 MiB that every reader supports");
  }

private:
  void choose_lattice() {
    if (capture.environment->lattice) {
      out.lattice = *capture.environment->lattice;
      out.reason = "as the capture says";
      return;
    }
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (const scene::EnvironmentPart &part : environment.parts)
      for (size_t i = 0; i < part.mesh.positions.size(); i++) {
        low[i % 3] = std::min(low[i % 3], part.mesh.positions[i]);
        high[i % 3] = std::max(high[i % 3], part.mesh.positions[i]);
      }
    const double diagonal = std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
    if (!(diagonal > 1e-12 && diagonal < 1e12))
      throw Error(name + ": expected an environment of some extent");
    out.lattice.step = geometry::round_down_125(diagonal / steps_across);
    // The multiple of the step next to the middle: indices are small, and planes at 0 stay there.
    for (int k = 0; k < 3; k++)
      out.lattice.origin[k] = std::round((low[k] + high[k]) / 2 / out.lattice.step) * out.lattice.step;
    out.reason = "1/16384 of its diagonal, or a little less";
  }

  void add_picture(size_t i) {
    files.push_back(
        fit_picture(environment.pictures[i], name + ": picture " + std::to_string(i), capture.memory_limit));
    const FittedPicture &fitted = files.back();
    if (fitted.scaled)
      out.warnings.push_back(name + ": picture " + std::to_string(i) + " is sent with " +
                             std::to_string(fitted.width) + "x" + std::to_string(fitted.height) + " pixels");
    out.picture_bytes += fitted.file.size();
  }

  // Texture coordinates from 0 to 1, and where these lie in the picture: whole repetitions.
  static void normalise(std::vector<double> &texture, fvv_environment_part &part) {
    for (size_t k = 0; k < 2; k++) {
      double low = 0, high = 1;
      for (size_t i = k; i < texture.size(); i += 2) {
        low = std::min(low, std::floor(texture[i] + FVV_TEXTURE_TOLERANCE));
        high = std::max(high, std::ceil(texture[i] - FVV_TEXTURE_TOLERANCE));
      }
      part.texture_origin[k] = low;
      part.texture_size[k] = high - low;
      for (size_t i = k; i < texture.size(); i += 2) texture[i] = (texture[i] - low) / (high - low);
    }
  }

  void add_part(size_t i) {
    scene::EnvironmentPart &source = environment.parts[i];
    fvv_environment_part part = {};
    part.picture = source.picture ? uint32_t(*source.picture) : FVV_NO_PICTURE;
    for (int k = 0; k < 3; k++) part.colour[k] = uint16_t(std::lround(source.colour[k] * 65535));
    part.flags =
        uint8_t((source.unlit ? FVV_PART_UNLIT : 0) | (source.double_sided ? FVV_PART_DOUBLE_SIDED : 0) |
                (source.clamped ? FVV_PART_CLAMPED : 0));
    normalise(source.mesh.texture, part);
    encode_mesh(i, source);
    part.mesh = meshes[i].data;
    part.mesh_size = meshes[i].size;
    out.mesh_bytes += part.mesh_size;
    parts.push_back(part);
  }

  void encode_mesh(size_t i, const scene::EnvironmentPart &part) {
    const geometry::Mesh &mesh = part.mesh;
    const bool lit_by_normals = !part.unlit && !mesh.normals.empty();
    const fvv_mesh_source source = {mesh.positions.data(),
                                    mesh.faces.data(),
                                    mesh.vertex_count(),
                                    mesh.face_count(),
                                    mesh.texture.empty() ? nullptr : mesh.texture.data(),
                                    lit_by_normals ? mesh.normals.data() : nullptr};
    fvv_mesh_options options;
    fvv_mesh_options_default(&options);
    std::copy_n(out.lattice.origin, 3, options.lattice_origin);
    options.lattice_step = out.lattice.step;
    options.texture_bits = texture_bits;
    options.normal_bits = lit_by_normals ? normal_bits : 0;
    options.keep_winding = !part.double_sided; // the inside of a room is visible
    const std::string place = name + ": part " + std::to_string(i);
    fvv_mesh_report report = {};
    report.struct_size = sizeof report;
    fvv_diagnostic diagnostic = {};
    OwnedMesh holder;
    fvv::check(fvv_mesh_canonicalise(&source, &options, nullptr, &holder, &report, &diagnostic), place,
               diagnostic);
    fvv::check(fvv_mesh_encode(&holder, FVV_MESH_DRACO, mesh_level, nullptr, &meshes[i], &diagnostic), place,
               diagnostic);
    out.max_error = std::max(out.max_error, report.max_error);
    fvv_mesh_header header;
    fvv::check(fvv_mesh_peek(meshes[i].data, meshes[i].size, nullptr, &header, &diagnostic), place,
               diagnostic);
    out.vertices += header.vertex_count;
    out.faces += header.face_count;
  }

  void encode() {
    for (const FittedPicture &file : files) {
      fvv_environment_picture picture = {};
      picture.data = reinterpret_cast<const uint8_t *>(file.file.data());
      picture.size = file.file.size();
      fvv_diagnostic diagnostic = {};
      fvv::check(fvv_environment_picture_inspect(&picture, &diagnostic), name, diagnostic);
      pictures.push_back(picture);
    }
    fvv_environment sent = {};
    std::copy_n(out.lattice.origin, 3, sent.lattice_origin);
    sent.lattice_step = out.lattice.step;
    sent.parts = parts.data();
    sent.part_count = parts.size();
    sent.pictures = pictures.data();
    sent.picture_count = pictures.size();
    sent.lights = environment.lights.data();
    sent.light_count = environment.lights.size();
    OwnedBytes payload;
    fvv_diagnostic diagnostic = {};
    fvv::check(fvv_environment_encode(&sent, nullptr, &payload, &diagnostic), name, diagnostic);
    out.payload.assign(payload.data, payload.data + payload.size);
  }

  const scene::Capture &capture;
  const std::string name;
  scene::Environment environment;
  PackedEnvironment &out;
  std::deque<OwnedBytes> meshes; // they do not move
  std::vector<FittedPicture> files;
  std::vector<fvv_environment_part> parts;
  std::vector<fvv_environment_picture> pictures;
};

} // namespace

FittedPicture fit_picture(const std::string &file, const std::string &name, const media::MemoryLimit &limit) {
  FittedPicture out = {without_metadata(file)};
  fvv_environment_picture entry = {};
  entry.data = reinterpret_cast<const uint8_t *>(out.file.data());
  entry.size = out.file.size();
  fvv_diagnostic diagnostic = {};
  if (fvv_environment_picture_inspect(&entry, &diagnostic) != FVV_OK)
    throw Error(name + ": " + diagnostic.message);
  out.width = entry.width;
  out.height = entry.height;
  // Always decoded: otherwise a picture that does not decode would be noticed only by players.
  media::check_image_memory(entry.data, entry.size, name, limit);
  const media::Image image = media::decode_image(entry.data, entry.size, 3, name);
  const uint32_t side = std::max(out.width, out.height);
  if (side <= max_picture_side) return out;
  const auto shorter = [&](uint32_t length) {
    return std::max<uint32_t>(1, uint32_t(uint64_t(length) * max_picture_side / side));
  };
  out.width = shorter(out.width);
  out.height = shorter(out.height);
  const std::vector<uint8_t> bytes =
      media::encode_jpeg(media::scale(image, out.width, out.height), quality, media::Subsampling::yuv420);
  out.file.assign(bytes.begin(), bytes.end());
  out.scaled = true;
  return out;
}

std::shared_ptr<const PackedEnvironment> pack_environment(const scene::Capture &capture) {
  auto packed = std::make_shared<PackedEnvironment>();
  Packer(capture, *packed).pack();
  return packed;
}

} // namespace fvv::mux
