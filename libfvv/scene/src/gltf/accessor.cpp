#include "scene/src/gltf/accessor.h"
#include "fvv_cxx/untrusted.h"
#include "fvv_scene/strict_json.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>
#include <string_view>

namespace fvv::scene::gltf {

namespace {

enum : unsigned { int8 = 5120, uint8 = 5121, int16 = 5122, uint16 = 5123, uint32 = 5125, float32 = 5126 };

// Bits of the forms that a purpose allows.
enum : unsigned {
  floats = 1,
  normalised_integers = 2,
  normalised_unsigned = 4,
  integers = 8,
  small_unsigned = 16,
  any_unsigned = 32
};

struct Rule {
  const char *type;
  unsigned allowed;
  const char *what;
};

const Rule &rule_of(Purpose purpose) {
  static const Rule rules[] = {
      {"SCALAR", any_unsigned, "indices as SCALAR of uint8, uint16 or uint32"},
      {"VEC3", floats | normalised_integers | integers,
       "positions as VEC3 of float32, int8, uint8, int16 or uint16"},
      {"VEC2", floats | normalised_integers | integers,
       "texture coordinates as VEC2 of float32, int8, uint8, int16 or uint16"},
      {"VEC3", floats | normalised_integers, "normals as VEC3 of float32 or normalised integers"},
      {"VEC3", floats | normalised_integers | integers,
       "displacements as VEC3 of float32, int8, uint8, int16 or uint16"},
      {"VEC4", small_unsigned, "joints as VEC4 of uint8 or uint16"},
      {"VEC4", floats | normalised_unsigned, "weights as VEC4 of float32, normalised uint8 or uint16"},
      {"MAT4", floats, "matrices as MAT4 of float32"},
      {"SCALAR", floats, "times as SCALAR of float32"},
      {"VEC3", floats, "vectors as VEC3 of float32"},
      {"VEC4", floats | normalised_integers, "rotations as VEC4 of float32 or normalised integers"},
      {"SCALAR", floats | normalised_integers, "weights as SCALAR of float32 or normalised integers"},
      {"VEC3", floats | normalised_unsigned, "colours as VEC3 of float32, normalised uint8 or uint16"},
      {"VEC4", floats | normalised_unsigned, "colours as VEC4 of float32, normalised uint8 or uint16"},
  };
  return rules[static_cast<size_t>(purpose)];
}

bool allows(unsigned allowed, unsigned type, bool normalised) {
  if (type == float32) return (allowed & floats) && !normalised;
  const bool is_unsigned = type == uint8 || type == uint16;
  if (normalised)
    return type != uint32 &&
           ((allowed & normalised_integers) || (is_unsigned && (allowed & normalised_unsigned)));
  if (type == uint32) return (allowed & any_unsigned) != 0;
  return (allowed & integers) || (is_unsigned && (allowed & (small_unsigned | any_unsigned)));
}

const char *name_of(unsigned type) {
  return type == int8     ? "int8"
         : type == uint8  ? "uint8"
         : type == int16  ? "int16"
         : type == uint16 ? "uint16"
         : type == uint32 ? "uint32"
                          : "float32";
}

// Clause 3.6.2.2 for normalised integers, in double.
double component(const uint8_t *bytes, unsigned type, bool normalised) {
  const auto scaled = [&](double value, double most) {
    return normalised ? std::max(value / most, -1.0) : value;
  };
  switch (type) {
  case int8:
    return scaled(static_cast<int8_t>(*bytes), 127);
  case uint8:
    return scaled(*bytes, 255);
  case int16:
    return scaled(static_cast<int16_t>(load_u16(bytes)), 32767);
  case uint16:
    return scaled(load_u16(bytes), 65535);
  case uint32:
    return load_u32(bytes);
  }
  const uint32_t bits = load_u32(bytes);
  float value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

uint64_t offset_of(const JsonValue &value) {
  const auto offset = value.find("byteOffset");
  return offset ? static_cast<uint64_t>(offset->integer(0, INT64_MAX)) : 0;
}

// The bytes of count elements, which must lie in the view.
std::string_view elements(const View &view, uint64_t offset, uint64_t stride, uint64_t count, uint64_t size,
                          const JsonValue &place) {
  const uint64_t available = view.bytes.size();
  // count is below 2^32 and stride below 2^8: no overflow.
  const uint64_t needed = (count - 1) * stride + size;
  if (offset > available || needed > available - offset)
    place.fail("expected " + std::to_string(needed) + " bytes from byte " + std::to_string(offset) +
               " of a bufferView of " + std::to_string(available));
  return view.bytes.substr(static_cast<size_t>(offset), static_cast<size_t>(needed));
}

void apply_sparse(Container &container, const JsonValue &sparse, const Layout &layout,
                  const JsonValue &accessor, std::vector<double> &numbers) {
  const uint64_t count =
      static_cast<uint64_t>(sparse.at("count").integer(1, static_cast<int64_t>(layout.count)));
  const JsonValue indices = sparse.at("indices"), values = sparse.at("values");
  const int64_t type = indices.at("componentType").integer(0, INT32_MAX);
  if (type != uint8 && type != uint16 && type != uint32)
    indices.at("componentType").fail("expected 5121, 5123 or 5125, found " + std::to_string(type));
  const Layout of_indices = {count, 1, static_cast<unsigned>(type), false};
  container.charge(sparse, count);
  container.charge(sparse, count * layout.components);
  const std::vector<double> places =
      unpack(of_indices,
             elements(container.view(indices.at("bufferView")), offset_of(indices), of_indices.element_size(),
                      count, of_indices.element_size(), indices),
             of_indices.element_size(), indices);
  const std::vector<double> replacements =
      unpack({count, layout.components, layout.type, layout.normalised},
             elements(container.view(values.at("bufferView")), offset_of(values), layout.element_size(),
                      count, layout.element_size(), values),
             layout.element_size(), accessor);
  for (size_t i = 0; i < places.size(); i++) {
    if (places[i] >= static_cast<double>(layout.count) || (i && places[i] <= places[i - 1]))
      indices.fail("expected indices that increase and stay below " + std::to_string(layout.count) +
                   ", index " + std::to_string(i) + " is " +
                   std::to_string(static_cast<uint64_t>(places[i])));
    std::copy_n(replacements.begin() + static_cast<ptrdiff_t>(i * layout.components), layout.components,
                numbers.begin() + static_cast<ptrdiff_t>(static_cast<size_t>(places[i]) * layout.components));
  }
}

} // namespace

unsigned Layout::component_size() const {
  return type == int8 || type == uint8 ? 1 : type == int16 || type == uint16 ? 2 : 4;
}

Layout accessor_layout(const Container &container, const JsonValue &reference, Purpose purpose) {
  const JsonValue accessor = container.item("accessors", reference);
  const JsonValue component_type = accessor.at("componentType");
  const int64_t type = component_type.integer(0, INT32_MAX);
  if (type < int8 || type > float32 || type == 5124)
    component_type.fail("expected 5120 to 5123, 5125 or 5126, found " + component_type.found());
  const auto flag = accessor.find("normalized");
  const bool normalised = flag && flag->boolean();
  const std::string shape = accessor.at("type").text();
  const Rule &rule = rule_of(purpose);
  if (shape != rule.type || !allows(rule.allowed, static_cast<unsigned>(type), normalised))
    accessor.fail(std::string("expected ") + rule.what + ", found " + (normalised ? "normalised " : "") +
                  accessor.at("type").found() + " of " + name_of(static_cast<unsigned>(type)));
  return {static_cast<uint64_t>(accessor.at("count").integer(1, UINT32_MAX)),
          shape == "SCALAR" ? 1u
          : shape == "VEC2" ? 2u
          : shape == "VEC3" ? 3u
          : shape == "VEC4" ? 4u
                            : 16u,
          static_cast<unsigned>(type), normalised};
}

std::vector<double> unpack(const Layout &layout, std::string_view bytes, uint64_t stride,
                           const JsonValue &place) {
  const auto *data = reinterpret_cast<const uint8_t *>(bytes.data());
  const unsigned size = layout.component_size();
  std::vector<double> numbers(static_cast<size_t>(layout.count) * layout.components);
  size_t next = 0;
  for (uint64_t i = 0; i < layout.count; i++)
    for (unsigned k = 0; k < layout.components; k++) {
      const double number = component(data + static_cast<size_t>(i * stride) + size_t(k) * size, layout.type,
                                      layout.normalised);
      if (!std::isfinite(number))
        place.fail("element " + std::to_string(i) + ": expected finite numbers, found nan or inf");
      numbers[next++] = number;
    }
  return numbers;
}

std::vector<double> accessor_numbers(Container &container, const JsonValue &reference, Purpose purpose) {
  const Layout layout = accessor_layout(container, reference, purpose);
  const JsonValue accessor = container.item("accessors", reference);
  std::vector<double> numbers;
  if (const auto view_key = accessor.find("bufferView")) {
    const View view = container.view(*view_key);
    const uint64_t stride = view.stride ? view.stride : layout.element_size();
    if (stride < layout.element_size())
      accessor.fail("expected a byteStride of at least " + std::to_string(layout.element_size()) +
                    ", found " + std::to_string(stride));
    const std::string_view bytes =
        elements(view, offset_of(accessor), stride, layout.count, layout.element_size(), accessor);
    container.charge(accessor, layout.count * layout.components);
    numbers = unpack(layout, bytes, stride, accessor);
  } else {
    container.charge(accessor, layout.count * layout.components);
    numbers.resize(static_cast<size_t>(layout.count) * layout.components);
  }
  if (const auto sparse = accessor.find("sparse"))
    apply_sparse(container, *sparse, layout, accessor, numbers);
  return numbers;
}

} // namespace fvv::scene::gltf
