// capture/gltf/material.cpp: the base colour of a primitive (glTF 2.0 clause 3.9.2): which image, and where
// on it. Nothing else of a material matters to an atlas.
#include "capture/gltf/scene.h"

namespace fvv::capture::gltf {

namespace {

void read_pair(const JsonValue &transform, const char *key, double (&out)[2]) {
  const auto pair = transform.find(key);
  for (size_t k = 0; pair && k < 2; k++) out[k] = pair->items(2, k).number();
}

// The extension KHR_texture_transform of Khronos. Sine and cosine differ between machines in their last bit,
// and atlases are not rotated as a whole: rotations are refused.
void read_transform(const JsonValue &transform, BaseColour &out) {
  read_pair(transform, "offset", out.offset);
  read_pair(transform, "scale", out.scale);
  if (const auto rotation = transform.find("rotation"); rotation && rotation->number() != 0)
    rotation->fail("expected a texture that is not rotated, found " + rotation->found() +
                   ": bake the rotation into the texture coordinates");
  if (const auto set = transform.find("texCoord")) out.set = set->integer(0, INT32_MAX);
}

} // namespace

BaseColour read_base_colour(const Container &container, const JsonValue &primitive) {
  BaseColour out;
  const auto reference = primitive.find("material");
  if (!reference) return out;
  const auto metallic = container.item("materials", *reference).find("pbrMetallicRoughness");
  const auto info = metallic ? metallic->find("baseColorTexture") : std::nullopt;
  if (!info) return out;
  const JsonValue source = container.item("textures", info->at("index")).at("source");
  container.item("images", source);
  out.image = source.integer(0, INT32_MAX);
  if (const auto set = info->find("texCoord")) out.set = set->integer(0, INT32_MAX);
  if (const auto extensions = info->find("extensions"))
    if (const auto transform = extensions->find("KHR_texture_transform")) read_transform(*transform, out);
  return out;
}

void BaseColour::transform(std::vector<double> &texture) const {
  for (size_t i = 0; i < texture.size(); i++) texture[i] = texture[i] * scale[i % 2] + offset[i % 2];
}

} // namespace fvv::capture::gltf
