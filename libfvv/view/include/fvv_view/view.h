// A frame of a stream as pictures from anywhere, textured from the cameras that see best.
#pragma once

#include "fvv/calibration.h"
#include "fvv_cxx/values.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace fvv::view {

struct Size {
  uint32_t width, height; // pixels
};

// One of camera, calibration and pose.
struct Target {
  std::optional<uint16_t> camera;        // of the stream, with its lens
  std::optional<fvv_camera> calibration; // valid, with its lens
  std::vector<double> pose;              // eye, the point looked at, and maybe up: 6 or 9 numbers, metres
  std::optional<double> focal;           // pixels, with pose only; default: the width, 53 degrees across
  std::optional<Size> size;              // none: the camera's, or default_width x default_height
};
constexpr uint32_t default_width = 960, default_height = 540;

struct ViewSettings {
  Target target;
  std::vector<uint16_t> excluded;          // identifiers of cameras whose pictures are not used
  uint32_t samples = 1;                    // of a pixel, along its side: 1, 3, 5 or 7
  std::array<double, 3> background = {{}}; // display values 0 to 1, where there is no surface
  bool pictures = true;                    // without, the mesh has the colours of its vertices
  bool environment = true;                 // draw the stream's static surroundings, if it has some
  uint32_t threads = 1;                    // the picture is the same for any number
};

struct View {
  media::Image picture;          // RGB
  std::vector<float> depth;      // of each pixel along the camera's axis, metres; infinite: no surface
  uint64_t surface = 0;          // pixels whose centre shows the mesh
  std::vector<uint16_t> sources; // identifiers of the cameras that were used
  std::vector<std::string> warnings;
  std::vector<std::string> losses; // what of the frame is damaged or missing; whole lines
};

// A decoded frame. Several threads may draw at once.
class Viewer {
public:
  // Decodes frame number of the stream in a file, counted as fvvdemux does. rung: of a ladder of quality; 0
  // is the best. Throws Error when the frame is not there, the stream has no meshes, or its mesh is damaged.
  Viewer(const std::string &path, int64_t number, size_t rung = 0);
  ~Viewer();
  Viewer(Viewer &&) noexcept;

  // Throws Error (usage) for settings that do not fit the frame.
  View draw(const ViewSettings &settings) const;

private:
  struct State;
  std::unique_ptr<State> state;
};

} // namespace fvv::view
