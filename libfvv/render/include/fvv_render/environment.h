// The static environment around the action as the reference picture shows it (fvv.md clause 18): meshes in
// one colour or with one picture, unlit. Lights and shadows are the player's.
#pragma once

#include "fvv_render/rasteriser.h"

#include <memory>
#include <optional>

namespace fvv::render {

// Three bytes a pixel, sRGB, rows from the top.
struct EnvironmentImage {
  uint32_t width = 0, height = 0;
  std::vector<uint8_t> pixels;
};

// Positions in world metres. texture: u v of each vertex as places in the picture, (0, 0) its top left
// corner, (1, 1) its bottom right one; empty without a picture. Faces are seen from where they are
// counter-clockwise.
struct EnvironmentPart {
  std::vector<float> positions;
  std::vector<uint32_t> faces;
  std::vector<double> texture;
  std::shared_ptr<const EnvironmentImage> picture; // NULL: none
  Vec3 colour{1, 1, 1};                            // linear light; a factor where there is a picture
  bool double_sided = false;                       // faces are drawn from behind too
  bool clamped = false; // beyond its edge the picture's last pixel, else it begins again
};

// Of a sample of a target's picture.
struct EnvironmentPoint {
  double depth; // z_c in metres
  Vec3 colour;  // display values, 0 to 1
};

// An environment, ready to be drawn from several places. Pictures are read bilinearly at the sample, in
// display values, at their full size: what is far away is smooth with several samples a pixel only.
class Environment {
public:
  // Throws std::invalid_argument for indices or texture coordinates that do not fit the vertices.
  explicit Environment(std::vector<EnvironmentPart> parts);
  ~Environment();

  // What a target sees of it: valid as long as the environment is.
  class View {
  public:
    virtual ~View() = default;
    virtual std::optional<EnvironmentPoint> at(uint32_t x, uint32_t y, uint32_t sample) const = 0;
  };
  std::unique_ptr<const View> view(const fvv_camera &target, uint32_t samples) const;

private:
  class Drawn;
  const std::vector<EnvironmentPart> parts;
};

} // namespace fvv::render
