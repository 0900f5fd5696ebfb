// capture/gltf/meshopt.cpp: bufferViews by meshoptimizer. Clauses are those of EXT_meshopt_compression.
#include "capture/gltf/meshopt.h"

#include <algorithm>
#include <meshoptimizer.h>

namespace fvv::capture::gltf {

namespace {

constexpr const char *names[] = {"EXT_meshopt_compression", "KHR_meshopt_compression"};

enum class Mode { attributes, triangles, indices };

Mode mode_of(const JsonValue &extension) {
  const JsonValue mode = extension.at("mode");
  if (mode.text() == "ATTRIBUTES") return Mode::attributes;
  if (mode.text() == "TRIANGLES") return Mode::triangles;
  if (mode.text() == "INDICES") return Mode::indices;
  mode.fail("expected ATTRIBUTES, TRIANGLES or INDICES, found " + mode.found());
}

std::string filter_of(const JsonValue &extension) {
  const auto filter = extension.find("filter");
  if (!filter) return "NONE";
  for (const char *known : {"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"})
    if (filter->text() == known) return known;
  filter->fail("expected NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL, found " + filter->found());
}

// "JSON schema updates", the list of what must hold.
void check_stride(const JsonValue &extension, uint64_t stride) {
  const JsonValue place = extension.at("byteStride");
  const std::string filter = filter_of(extension);
  const auto expect = [&](bool fits, const char *what) {
    if (!fits) place.fail(std::string("expected ") + what + ", found " + place.found());
  };
  if (mode_of(extension) != Mode::attributes) {
    expect(stride == 2 || stride == 4, "2 or 4 bytes an index");
    if (filter != "NONE") extension.at("filter").fail("expected NONE for indices, found " + filter);
    return;
  }
  expect(stride % 4 == 0, "a multiple of 4");
  if (filter == "OCTAHEDRAL") expect(stride == 4 || stride == 8, "4 or 8 for OCTAHEDRAL");
  if (filter == "QUATERNION") expect(stride == 8, "8 for QUATERNION");
}

// Appendix A: the bytes that so many elements take when each is coded as short as can be.
uint64_t least_size(Mode mode, uint64_t stride, uint64_t count) {
  switch (mode) {
  case Mode::attributes:
    return 1 + stride * ((count + 63) / 64) + std::max<uint64_t>(stride, 32);
  case Mode::triangles:
    return 1 + count / 3 + 16;
  case Mode::indices:
    break;
  }
  return 1 + count + 4;
}

bool decode(Mode mode, const Compressed &c, std::string_view bytes, std::string &out) {
  const auto *data = reinterpret_cast<const unsigned char *>(bytes.data());
  const auto count = static_cast<size_t>(c.count), stride = static_cast<size_t>(c.stride);
  if (mode == Mode::attributes)
    return !meshopt_decodeVertexBuffer(out.data(), count, stride, data, bytes.size());
  if (mode == Mode::triangles)
    return !meshopt_decodeIndexBuffer(out.data(), count, stride, data, bytes.size());
  return !meshopt_decodeIndexSequence(out.data(), count, stride, data, bytes.size());
}

void apply(const std::string &filter, const Compressed &c, std::string &out) {
  const auto count = static_cast<size_t>(c.count), stride = static_cast<size_t>(c.stride);
  if (filter == "OCTAHEDRAL") meshopt_decodeFilterOct(out.data(), count, stride);
  if (filter == "QUATERNION") meshopt_decodeFilterQuat(out.data(), count, stride);
  if (filter == "EXPONENTIAL") meshopt_decodeFilterExp(out.data(), count, stride);
}

} // namespace

std::optional<Compressed> compression_of(const JsonValue &view) {
  const auto extensions = view.find("extensions");
  if (!extensions) return std::nullopt;
  std::optional<JsonValue> extension;
  for (const char *name : names)
    if (const auto found = extensions->find(name)) {
      if (extension) view.fail("expected one of EXT_ and KHR_meshopt_compression, found both");
      extension = found;
    }
  if (!extension) return std::nullopt;
  const auto stride = static_cast<uint64_t>(extension->at("byteStride").integer(1, 256));
  const auto count = static_cast<uint64_t>(extension->at("count").integer(1, UINT32_MAX));
  check_stride(*extension, stride);
  if (mode_of(*extension) == Mode::triangles && count % 3)
    extension->at("count").fail("expected a multiple of 3 for TRIANGLES, found " + std::to_string(count));
  const JsonValue size = view.at("byteLength");
  if (static_cast<uint64_t>(size.integer(1, INT64_MAX)) != stride * count)
    size.fail("expected the " + std::to_string(stride * count) + " bytes that are compressed, found " +
              size.found());
  const auto outer = view.find("byteStride");
  if (outer && static_cast<uint64_t>(outer->integer(4, 252)) != stride)
    outer->fail("expected the byteStride of what is compressed, " + std::to_string(stride) + ", found " +
                outer->found());
  return Compressed{*extension, stride, count};
}

std::string decompress(const Compressed &compressed, std::string_view bytes) {
  const JsonValue &place = compressed.extension;
  const Mode mode = mode_of(place);
  const uint64_t least = least_size(mode, compressed.stride, compressed.count);
  if (bytes.size() < least)
    place.fail("expected at least " + std::to_string(least) + " bytes for " +
               std::to_string(compressed.count) + " elements, found " + std::to_string(bytes.size()));
  std::string out(static_cast<size_t>(compressed.size()), '\0');
  if (!decode(mode, compressed, bytes, out))
    place.fail("expected " + place.at("mode").text() + " that meshoptimizer decodes, found " +
               std::to_string(bytes.size()) + " other bytes, which begin with " +
               std::to_string(static_cast<unsigned char>(bytes[0])));
  apply(filter_of(place), compressed, out);
  return out;
}

} // namespace fvv::capture::gltf
