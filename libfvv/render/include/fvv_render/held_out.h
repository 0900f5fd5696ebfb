// The measure of what viewers see of a stream: cameras that are drawn from the other cameras of their frame,
// compared with what they filmed, and views between two cameras, compared with what the finest pictures and
// meshes show there. PSNR and SSIM count inside silhouettes.
#pragma once

#include "fvv_render/view.h"

#include <deque>
#include <limits>

namespace fvv::render {

// A camera's picture; all is borrowed. mask: a byte a pixel, above 127 where it shows the scene; NULL:
// everywhere.
struct HeldOutView {
  SourceView source;
  const uint8_t *mask = nullptr;
};

// positions and faces borrowed, in the unit of the cameras.
struct HeldOutFrame {
  Mesh mesh;
  std::vector<HeldOutView> views;
};

// Sums over pixels of one or several pictures, of display values 0 to 1.
struct ViewScore {
  double squares = 0; // of the differences of red, green and blue
  double luma = 0;    // likewise, of BT.709 luma
  size_t pixels = 0;
  double similarity = 0; // SSIM of luma (Wang et al. 2004, Gaussian window of 11 x 11), summed over windows
  size_t windows = 0;    // that have their centre on a pixel that counts

  void add(const ViewScore &other);
  double luma_error() const { return pixels ? luma / double(pixels) : 0; } // mean square
  // dB of luma; infinite where nothing differs, or no pixel counts.
  double psnr() const;
  double ssim() const { return windows ? similarity / double(windows) : 1; }
};

// The views that are drawn of frames.
class DrawnFrames {
public:
  // frames: borrowed. options: how players blend; one sample a pixel, and mid-grey without surface.
  DrawnFrames(const std::vector<HeldOutFrame> &frames, ViewOptions options);

  const ViewRenderer &operator[](size_t frame) const { return *renderers[frame]; }

private:
  std::vector<std::unique_ptr<const ViewRenderer>> renderers;
};

// Pixels of a view that are compared, about: enough for errors of a hundredth of a dB.
constexpr size_t compared_pixels = 4000;

// Cameras that are drawn from the others of their frame, against what they filmed.
class ViewMeasure {
public:
  // frames: as fine as there are, borrowed; finest: the same, drawn. Which pixels count is decided here:
  // those of a camera inside its mask that another camera shows on these meshes. most_pixels: of a view;
  // pictures are compared on a grid of their pixels when they have more.
  ViewMeasure(const std::vector<HeldOutFrame> &frames, const DrawnFrames &finest,
              size_t most_pixels = compared_pixels);
  ~ViewMeasure();

  // That count, of all cameras.
  size_t pixels() const;

  // Of each camera of each frame. drawn: the same cameras in the same order, with any meshes and pictures.
  // inset: in place of that of the options. Without similarity no windows are compared. The same for every
  // executor.
  std::vector<ViewScore> held_out(const DrawnFrames &drawn, std::optional<double> inset = {},
                                  bool similarity = true) const;
  ViewScore held_out_sum(const DrawnFrames &drawn) const;

private:
  class Camera;
  std::deque<Camera> cameras;
};

// Views half-way between a camera and the one whose direction is nearest, against what the finest show there.
class BetweenMeasure {
public:
  // As of ViewMeasure.
  BetweenMeasure(const std::vector<HeldOutFrame> &frames, const DrawnFrames &finest,
                 size_t most_pixels = compared_pixels);
  ~BetweenMeasure();

  // The sum over all views; drawn: as above.
  ViewScore score(const DrawnFrames &drawn) const;

private:
  class Place;
  std::deque<Place> places;
};

// What is lost in dB by a mean square error in place of another one.
double loss_db(double finest, double error);

} // namespace fvv::render
