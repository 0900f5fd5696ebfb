// Held-out and half-way views of a textured plane, whose scores are known.
#include "fvv_render/held_out.h"

#include "fvv_catch.h"
#include "view_fixture.h"

namespace {

using namespace view_fixture;

Vec3 bands(Vec3 at) {
  const double value = 0.5 + 0.2 * std::sin(31.4 * at.x) + 0.2 * std::sin(31.4 * at.y + 1);
  return {value, 1 - value, 0.5};
}

const std::vector<Vec3> around = {
    {0, 0, -4}, {1.5, 0, -3.7}, {-1.5, 0.5, -3.7}, {0, 1.6, -3.7}, {0.3, -1.7, -3.6}};

// The plane z = 0 with a mesh, and the cameras around it that film it.
struct Scene {
  template <class Colour> explicit Scene(const Colour &colour, double mesh_at = 0) {
    shape.square(1, mesh_at);
    for (const Vec3 eye : around) sources.film(looking(eye, {}, 320, 240, 420), colour);
  }
  std::vector<HeldOutFrame> frames() const {
    HeldOutFrame out = {shape.mesh(), {}};
    for (const SourceView &view : sources.views) out.views.push_back({view});
    return {out};
  }
  Shape shape;
  Sources sources;
};

// Held-out and between, of frames against others.
struct Scores {
  ViewScore held_out, between;
};
Scores scores(const std::vector<HeldOutFrame> &finest, const std::vector<HeldOutFrame> &shown,
              const ViewOptions &options = {}, size_t most = compared_pixels) {
  const DrawnFrames reference(finest, options), drawn(shown, options);
  return {ViewMeasure(finest, reference, most).held_out_sum(drawn),
          BetweenMeasure(finest, reference, most).score(drawn)};
}

} // namespace

TEST_CASE("cameras that film one colour draw each other exactly") {
  const Scene scene([](Vec3) { return Vec3{0.25, 0.5, 0.75}; });
  const Scores found = scores(scene.frames(), scene.frames());
  CHECK(found.held_out.pixels > 5000);
  CHECK(found.held_out.psnr() > 100);
  CHECK(found.held_out.ssim() > 0.9999);
  CHECK(found.between.pixels > 1000);
  CHECK(std::isinf(found.between.psnr()));
  CHECK(found.between.ssim() > 0.9999);
  CHECK(loss_db(found.held_out.luma_error(), found.held_out.luma_error()) == 0);
}

TEST_CASE("a difference of a hundredth of white is 40 dB") {
  const Scene scene([](Vec3) {
    return Vec3{0.5, 0.5, 0.5};
  }),
      brighter([](Vec3) {
        return Vec3{0.51, 0.51, 0.51};
      });
  const Scores found = scores(scene.frames(), brighter.frames());
  CHECK(std::abs(found.held_out.psnr() - 40) < 0.01);
  CHECK(std::abs(found.between.psnr() - 40) < 0.01);
  CHECK(std::abs(10 * std::log10(3 * double(found.held_out.pixels) / found.held_out.squares) - 40) < 0.01);
}

TEST_CASE("a texture is drawn well, and worse with a mesh or calibration that is off") {
  const Scene scene(bands), off(bands, -0.02);
  const Scores exact = scores(scene.frames(), scene.frames());
  CHECK(exact.held_out.psnr() > 35);
  CHECK(exact.held_out.ssim() > 0.97);
  const Scores moved = scores(scene.frames(), off.frames());
  CHECK(moved.held_out.psnr() < exact.held_out.psnr() - 6);
  CHECK(moved.held_out.ssim() < exact.held_out.ssim() - 0.01);
  CHECK(moved.between.psnr() < 70); // the two cameras err in opposite directions
  std::vector<HeldOutFrame> shifted = scene.frames();
  double before = exact.held_out.psnr();
  for (const double pixels : {1.0, 3.0}) {
    shifted = scene.frames();
    shifted[0].views[0].source.camera.cx += pixels;
    const Scores worse = scores(scene.frames(), shifted);
    CHECK(worse.held_out.psnr() < before - 0.5);
    CHECK(worse.between.psnr() < 45);
    before = worse.held_out.psnr();
  }
}

TEST_CASE("the sum is that of the cameras, for any executor, on any grid") {
  const Scene scene(bands);
  const std::vector<HeldOutFrame> frames = scene.frames();
  const DrawnFrames drawn(frames, {});
  const ViewMeasure measure(frames, drawn);
  ViewScore sum;
  for (const ViewScore &score : measure.held_out(drawn)) sum.add(score);
  const ViewScore whole = measure.held_out_sum(drawn);
  CHECK(sum.pixels == measure.pixels());
  CHECK(whole.luma == sum.luma);
  CHECK(measure.held_out(drawn, {}, false)[0].windows == 0);
  ViewOptions backwards;
  backwards.executor = [](size_t count, const std::function<void(size_t)> &work) {
    while (count) work(--count);
  };
  const Scores again = scores(frames, frames, backwards);
  CHECK(again.held_out.luma == whole.luma);
  CHECK(again.held_out.similarity == whole.similarity);
  const Scores all = scores(frames, frames, {}, SIZE_MAX);
  CHECK(all.held_out.pixels > 4 * whole.pixels);
  CHECK(std::abs(all.held_out.psnr() - whole.psnr()) < 0.5);
}

TEST_CASE("pixels beside the mask, and surface that no other camera shows, do not count") {
  const Scene scene(bands);
  std::vector<HeldOutFrame> frames = scene.frames();
  const std::vector<uint8_t> mask(320 * 240, 127);
  const size_t all = scores(frames, frames).held_out.pixels;
  frames[0].views[0].mask = mask.data();
  CHECK(scores(frames, frames).held_out.pixels < all);
  frames[0].views.resize(1);
  frames[0].views[0].mask = nullptr;
  const Scores alone = scores(frames, frames);
  CHECK(alone.held_out.pixels == 0);
  CHECK(alone.between.pixels == 0);
  CHECK(std::isinf(alone.held_out.psnr()));
}
