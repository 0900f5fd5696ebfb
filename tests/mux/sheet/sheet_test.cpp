// Contact sheets: numbers and hints for right and wrong calibrations, with mesh, hull or neither.
#include "sheet_fixture.h"

TEST_CASE("sheet: a right calibration fits its masks, and the bytes are the same for any number of threads",
          "[slow]") {
  const Folder folder;
  make_sheet_capture(folder);
  fvvimport::SheetOptions options = sheet_options(folder);
  const fvvimport::SheetReport report = fvvimport::check_calibration(options);
  CHECK(report.warnings.empty());
  CHECK(report.frame == 11);
  CHECK(report.outlined == fvvimport::Outlined::mesh);
  fvvimport::SheetOptions by_masks = options;
  by_masks.meshes = false;
  by_masks.output = folder.path("hull.png");
  CHECK(fvvimport::check_calibration(by_masks).outlined == fvvimport::Outlined::hull);
  REQUIRE(report.cameras.size() == ring_cameras);
  for (const fvvimport::SheetCamera &camera : report.cameras) {
    CHECK(camera.picture);
    CHECK(*camera.match.iou > 0.98);
    CHECK(*camera.match.distance < 0.25);
    CHECK(std::hypot((*camera.match.offset)[0], (*camera.match.offset)[1]) < 0.1);
  }
  CHECK(report.outliers.empty());
  CHECK(report.suspicion == geometry::Suspicion::nothing);
  const media::ImageInfo info = media::probe_image(options.output);
  CHECK(info.width == report.width);
  CHECK(info.height == report.height);
  const std::string bytes = read_bytes(options.output);
  options.threads = 1;
  fvvimport::check_calibration(options);
  CHECK(read_bytes(options.output) == bytes);
  CHECK(folder.entries() == 3);
}

TEST_CASE("sheet: the camera with a shifted principal point is named, and its offset reported") {
  const Folder folder;
  SheetShape shape;
  shape.mistake = [](size_t k, fvv_camera &c) {
    if (k == 4) c.cx += 6, c.cy -= 3;
  };
  make_sheet_capture(folder, shape);
  const fvvimport::SheetReport report = fvvimport::check_calibration(sheet_options(folder));
  CHECK(report.outliers == std::vector<size_t>{4});
  CHECK(*report.cameras[4].match.iou < 0.9);
  CHECK(*report.cameras[3].match.iou > 0.98);
  CHECK((*report.cameras[4].match.offset)[0] == Approx(6).margin(0.2));
  CHECK((*report.cameras[4].match.offset)[1] == Approx(-3).margin(0.2));
  CHECK(fvvimport::sheet_text(report).find("camera 5 (ring 5) stands out") != std::string::npos);
}

TEST_CASE("sheet: a camera with another one's pose is an outlier") {
  const Folder folder;
  SheetShape shape;
  shape.mistake = [](size_t k, fvv_camera &c) {
    if (k == 2) std::copy_n(ring_camera(6).rotation, 9, c.rotation);
  };
  make_sheet_capture(folder, shape);
  const fvvimport::SheetReport report = fvvimport::check_calibration(sheet_options(folder));
  CHECK(report.outliers == std::vector<size_t>{2});
  CHECK(*report.cameras[2].match.iou < 0.8);
}

TEST_CASE("sheet: half a pixel in all cameras is suspected, a third is not") {
  for (const double shift : {0.5, -0.5, 0.3}) {
    const Folder folder;
    SheetShape shape;
    shape.mistake = [&](size_t, fvv_camera &c) { c.cx += shift, c.cy += shift; };
    make_sheet_capture(folder, shape);
    const fvvimport::SheetReport report = fvvimport::check_calibration(sheet_options(folder));
    CHECK((report.suspicion == geometry::Suspicion::half_pixel) == (std::abs(shift) == 0.5));
    CHECK(report.outliers.empty());
  }
}

TEST_CASE("sheet: a mesh in another unit than the cameras meets no mask") {
  const Folder folder;
  const scene::Capture capture = make_sheet_capture(folder);
  geometry::Mesh mesh = sheet_ball();
  for (double &x : mesh.positions) x = 1000 * x + 5000;
  scene::write_mesh(mesh, {}, capture.mesh_path(11));
  const fvvimport::SheetReport report = fvvimport::check_calibration(sheet_options(folder));
  CHECK(report.suspicion == geometry::Suspicion::misses_all);
  CHECK(fvvimport::sheet_text(report).find("meets no mask") != std::string::npos);
}

TEST_CASE("sheet: without meshes the outline is that of the masks' hull", "[slow]") {
  const Folder folder;
  SheetShape shape;
  shape.meshes = false;
  make_sheet_capture(folder, shape);
  fvvimport::SheetOptions options = sheet_options(folder);
  const fvvimport::SheetReport report = fvvimport::check_calibration(options);
  CHECK(report.outlined == fvvimport::Outlined::hull);
  CHECK(!report.excluded);
  CHECK(report.outliers.empty());
  for (const fvvimport::SheetCamera &camera : report.cameras) CHECK(*camera.match.iou > 0.95);
  const std::string bytes = read_bytes(options.output);
  options.threads = 3;
  fvvimport::check_calibration(options);
  CHECK(read_bytes(options.output) == bytes);
}

TEST_CASE("sheet: one wrong camera does not spoil the hull, it is named", "[slow]") {
  const Folder folder;
  SheetShape shape;
  shape.meshes = false;
  shape.mistake = [](size_t k, fvv_camera &c) {
    if (k == 7) c.cx -= 7;
  };
  make_sheet_capture(folder, shape);
  const fvvimport::SheetReport report = fvvimport::check_calibration(sheet_options(folder));
  CHECK(report.excluded == std::optional<size_t>(7));
  CHECK(report.outliers == std::vector<size_t>{7});
  CHECK((*report.cameras[7].match.offset)[0] == Approx(-7).margin(0.4));
  CHECK(*report.cameras[0].match.iou > 0.95);
}

TEST_CASE("sheet: with two masks there is no hull, but axes and cameras") {
  const Folder folder;
  SheetShape shape;
  shape.meshes = false;
  shape.cameras = 2;
  make_sheet_capture(folder, shape);
  const fvvimport::SheetReport report = fvvimport::check_calibration(sheet_options(folder));
  CHECK(report.outlined == fvvimport::Outlined::nothing);
  CHECK(!report.cameras[0].match.iou);
  CHECK(!report.median_iou);
  CHECK(report.warnings.empty());
}

TEST_CASE("sheet: a mesh far from the origin in a small unit is drawn as well") {
  const Folder folder;
  const double shift = 4e6; // beyond what float32 resolves
  SheetShape shape;
  shape.cameras = 3;
  shape.mistake = [&](size_t, fvv_camera &c) {
    for (int row = 0; row < 3; row++) c.translation[row] -= c.rotation[3 * row] * shift;
  };
  const scene::Capture capture = make_sheet_capture(folder, shape);
  geometry::Mesh mesh = sheet_ball();
  for (size_t i = 0; i < mesh.positions.size(); i += 3) mesh.positions[i] += shift;
  scene::write_mesh(mesh, {}, capture.mesh_path(11));
  for (const fvvimport::SheetCamera &camera : fvvimport::check_calibration(sheet_options(folder)).cameras)
    CHECK(*camera.match.iou > 0.98);
}

TEST_CASE("sheet: cameras and frames may be chosen, and a camera that moves has the pose of the frame") {
  const Folder folder;
  scene::Capture capture = make_sheet_capture(folder);
  scene::Camera &camera = capture.cameras[1];
  for (const int64_t frame : capture.frames.numbers()) {
    camera.per_frame[frame] = camera.calibration;
    camera.per_frame[frame].name = nullptr;
    camera.per_frame[frame].name_size = 0;
    if (frame == 12) camera.per_frame[frame].cx += 9;
  }
  scene::write_capture(capture, capture.path);
  fvvimport::SheetOptions options = sheet_options(folder);
  options.cameras = {"2-4"};
  CHECK(fvvimport::check_calibration(options).outliers.empty());
  options.frames = fvv::Range{12, 12};
  const fvvimport::SheetReport report = fvvimport::check_calibration(options);
  CHECK(report.frame == 12);
  REQUIRE(report.cameras.size() == 3);
  CHECK(report.cameras[0].id == 2);
  CHECK(report.outliers == std::vector<size_t>{0});
}
