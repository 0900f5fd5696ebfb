// tools/import: COLMAP, Middlebury and nerfstudio; what is read and what is refused.
#include "import_fixture.h"

#include "scene/src/import/camera.h"

using namespace fvv;

namespace {

const std::string cameras_txt = "# Camera list with one line of data per camera:\n"
                                "1 OPENCV 640 480 500 510 320 240 0.1 0.02 0.003 -0.004\n"
                                "2 RADIAL_FISHEYE 800 600 400 400 300 0.01 0.002\n";
const std::string images_txt = "# Image list\n"
                               "5 1 0 0 0 1 2 3 1 rig/left one.png\n"
                               "10.5 20 -1 30 40.5 7\n"
                               "6 0.5 0.5 0.5 0.5 0 0 4 2 rig/right.png\n"
                               "\n";

const std::string par_txt = "2\n"
                            "a.png 500 0.5 320 0 510 240 0 0 1 1 0 0 0 1 0 0 0 1 1 2 3\n"
                            "b.png 500 0 320 0 510 240 0 0 1 0 1 0 0 0 1 1 0 0 1 2 3\n";

const std::string transforms =
    R"({"w": 640, "h": 480.0, "fl_x": 500, "cx": 320.25, "cy": 239, "k1": 0.1, "k2": 0.02, "p1": 0.003,
 "frames": [
  {"file_path": "./images/left.png", "transform_matrix": [[1,0,0,1],[0,1,0,2],[0,0,1,3],[0,0,0,1]]},
  {"file_path": "./images/right.png", "fl_x": 400, "camera_model": "OPENCV_FISHEYE", "p1": 0, "k4": 0.001,
   "transform_matrix": [[0,0,1,0],[1,0,0,0],[0,1,0,0],[0,0,0,1]]}]})";

// Every fault turns good into a file that is refused with exactly that message.
void check_faults(const ImportFolder &folder, const std::string &leaf, const std::string &good,
                  const std::vector<Fault> &faults, const std::function<void()> &read) {
  folder.write(leaf, good);
  REQUIRE(message_of(read).empty());
  for (const Fault &fault : faults) {
    folder.write(leaf, with(good, fault.part, fault.other));
    CHECK(message_of(read) == folder.path(leaf) + fault.message);
  }
  folder.write(leaf, good);
}

} // namespace

TEST_CASE("COLMAP: models, identifiers, names and poses") {
  const ImportFolder folder;
  folder.write("cameras.txt", cameras_txt);
  folder.write("images.txt", images_txt);
  const auto calibration = import::read_colmap(folder.path());
  REQUIRE(calibration.cameras.size() == 2);
  CHECK(calibration.metres_per_unit == 0);
  const fvv_camera &left = calibration.cameras[0].calibration, &right = calibration.cameras[1].calibration;
  CHECK(*calibration.cameras[0].name == "left one");
  CHECK(*calibration.cameras[1].name == "right");
  CHECK(left.id == 5);
  CHECK(left.cx == 320);
  CHECK(left.lens == FVV_LENS_RADTAN);
  CHECK(left.distortion[3] == -0.004);
  CHECK(left.translation[2] == 3);
  CHECK(right.lens == FVV_LENS_FISHEYE);
  CHECK(right.fx == 400);
  CHECK(right.fy == 400);
  CHECK(right.distortion[1] == 0.002);
  // A third of a turn about (1, 1, 1) takes x to y.
  const double rotation[9] = {0, 0, 1, 1, 0, 0, 0, 1, 0};
  for (int i = 0; i < 9; i++) CHECK(right.rotation[i] == Approx(rotation[i]).margin(1e-15));
}

TEST_CASE("COLMAP: a line of keypoints may be of any length") {
  const ImportFolder folder;
  folder.write("cameras.txt", cameras_txt);
  std::string keypoints;
  for (int i = 0; i < 5000; i++) keypoints += "10.5 20 -1 ";
  folder.write("images.txt", with(images_txt, "10.5 20 -1", keypoints));
  CHECK(import::read_colmap(folder.path()).cameras.size() == 2);
  folder.write("images.txt", with(images_txt, "10.5 20 -1", keypoints + "1"));
  CHECK(message_of([&] { import::read_colmap(folder.path()); }) ==
        folder.path("images.txt") +
            ":3: expected the line of keypoints (X Y POINT3D_ID ...; may be empty) after an image, found "
            "\"10.5 20 -1 10.5 20 -1 10.5 20 -1 10.5 20...\"");
}

TEST_CASE("COLMAP: malformed files, each with its message") {
  const ImportFolder folder;
  folder.write("images.txt", images_txt);
  const auto read = [&] { import::read_colmap(folder.path()); };
  check_faults(
      folder, "cameras.txt", cameras_txt,
      {{"1 OPENCV", "1 FOV",
        ":2: expected one of the camera models SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, "
        "FULL_OPENCV, SIMPLE_RADIAL_FISHEYE, RADIAL_FISHEYE, OPENCV_FISHEYE, SIMPLE_FISHEYE, FISHEYE, found "
        "\"FOV\""},
       {" -0.004", "", ":2: expected 8 parameters for OPENCV, found 7"},
       {"500 510", "500 nan", ":2: expected a finite number for PARAMS[], found \"nan\""},
       {"640 480", "0 480", ":2: expected an integer from 1 to 2147483647 for WIDTH, found \"0\""},
       {"2 RADIAL", "1 RADIAL", ":3: expected every CAMERA_ID once, found 1 again"},
       {"1 OPENCV 640 480 500 510 320 240 0.1 0.02 0.003 -0.004", "1 OPENCV",
        ":2: expected CAMERA_ID MODEL WIDTH HEIGHT PARAMS[], found \"1 OPENCV\""}},
      read);
  check_faults(
      folder, "images.txt", images_txt,
      {{"5 1 0 0 0", "5 1.001 0 0 0",
        ":2: expected a quaternion QW QX QY QZ of length 1 within 1e-4, found length 1.001"},
       {"3 1 rig/left", "3 9 rig/left", ":2: expected a CAMERA_ID of cameras.txt, found \"9\""},
       {"6 0.5", "5 0.5", ":4: expected an identifier of its own for every camera, found 5 again"},
       {"6 0.5", "65535 0.5", ":4: expected an integer from 0 to 65534 for IMAGE_ID, found \"65535\""},
       {" rig/right.png", "", ":4: expected NAME after CAMERA_ID, found the end of the line"},
       {"10.5 20 -1 30 40.5 7\n", "",
        ":3: expected the line of keypoints (X Y POINT3D_ID ...; may be empty) after an image, found \"6 "
        "0.5 0.5 0.5 0.5 0 0 4 2 rig/right.png\""},
       {images_txt, "# none\n", ": expected at least one camera, found none"},
       {"1 2 3 1 rig/left one.png", "1 2 3 rig/left one.png",
        ":2: expected an integer from 0 to 4294967295 for CAMERA_ID, found \"rig/left\""},
       {"10.5 20", "10.5 x", ":3: expected a finite number for X Y POINT3D_ID, found \"x\""}},
      read);
}

TEST_CASE("Middlebury: K, R and t, with pixel centres at integers") {
  const ImportFolder folder;
  const auto calibration = import::read_middlebury(folder.write("x_par.txt", par_txt), 640, 480);
  REQUIRE(calibration.cameras.size() == 2);
  const fvv_camera &a = calibration.cameras[0].calibration;
  CHECK(*calibration.cameras[1].name == "b");
  CHECK(a.width == 640);
  CHECK(a.cx == 320.5);
  CHECK(a.cy == 240.5);
  CHECK(a.skew == 0.5);
  CHECK(a.lens == FVV_LENS_NONE);
  CHECK(calibration.cameras[1].calibration.rotation[1] == 1);
}

TEST_CASE("Middlebury: malformed files, each with its message") {
  const ImportFolder folder;
  check_faults(
      folder, "x_par.txt", par_txt,
      {{"2\n", "3\n", ":3: expected 3 pictures as the first line says, found 2"},
       {"2\n", "1\n", ":3: expected 1 pictures as the first line says, found more"},
       {"2\n", "2 3\n", ":1: expected the number of pictures alone, found \"2 3\""},
       {" 1 2 3\n", " 1 2\n", ":2: expected a name and 21 numbers (K, R, t), found 21 words"},
       {"500 0.5", "inf 0.5", ":2: expected a finite number for K, R or t, found \"inf\""},
       {"240 0 0 1", "240 0 0 2", ":2: expected K with k21 = k31 = k32 = 0 and k33 = 1, found others"},
       {"1 1 0 0 0 1", "1 2 0 0 0 1",
        ":2: rows 0 and 0 of the rotation have the product 4, expected 1 within 1e-4"},
       {par_txt, "", ": expected the number of pictures, found nothing"}},
      [&] { import::read_middlebury(folder.path("x_par.txt"), 640, 480); });
}

TEST_CASE("nerfstudio: intrinsics of the document and of a frame, poses in OpenGL's axes") {
  const ImportFolder folder;
  const auto calibration = import::read_nerfstudio(folder.write("transforms.json", transforms));
  REQUIRE(calibration.cameras.size() == 2);
  const fvv_camera &left = calibration.cameras[0].calibration, &right = calibration.cameras[1].calibration;
  CHECK(*calibration.cameras[0].name == "left");
  CHECK(left.height == 480);
  CHECK(left.cx == 320.25);
  CHECK(left.fy == 500);
  CHECK(left.lens == FVV_LENS_RADTAN);
  CHECK(left.distortion[2] == 0.003);
  CHECK(left.rotation[4] == -1);
  CHECK(left.translation[0] == -1);
  CHECK(left.translation[1] == 2);
  CHECK(left.translation[2] == 3);
  CHECK(right.fx == 400);
  CHECK(right.lens == FVV_LENS_FISHEYE);
  CHECK(right.distortion[3] == 0.001);
  // Looks along the negative of the third column.
  CHECK(right.rotation[6] == -1);
}

TEST_CASE("instant-ngp: an angle of view, and the centre as principal point") {
  const ImportFolder folder;
  const std::string text = with(transforms, R"("fl_x": 500, "cx": 320.25, "cy": 239)",
                                R"("camera_angle_x": 1.5707963267948966, "is_fisheye": false)");
  const auto calibration = import::read_nerfstudio(folder.write("transforms.json", text));
  CHECK(calibration.cameras[0].calibration.fx == Approx(320));
  CHECK(calibration.cameras[0].calibration.cx == 320);
  CHECK(calibration.cameras[0].calibration.cy == 240);
}

TEST_CASE("nerfstudio: malformed files, each with its message") {
  const ImportFolder folder;
  check_faults(
      folder, "transforms.json", transforms,
      {{"\"fl_x\": 500, ", "",
        ": /frames/0: expected \"fl_x\" or \"camera_angle_x\" here or at the top, found neither"},
       {"\"w\": 640, ", "", ": /frames/0: expected \"w\" here or at the top, found neither"},
       {"480.0", "480.5", ": /h: expected a whole number of pixels > 0, found 480.5"},
       {"OPENCV_FISHEYE", "EQUIRECTANGULAR",
        ": /frames/1/camera_model: expected one of the camera models SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, "
        "RADIAL, OPENCV, OPENCV_FISHEYE, found "
        "\"EQUIRECTANGULAR\""},
       {"OPENCV_FISHEYE", "PINHOLE", ": /k1: expected 0 for the camera model PINHOLE, found 0.1"},
       {"\"p1\": 0,", "", ": /p1: expected 0 for the camera model OPENCV_FISHEYE, found 0.003"},
       {"OPENCV_FISHEYE", "OPENCV",
        ": /frames/1/k4: expected 0 for the camera model OPENCV, where k4 has no agreed meaning, found "
        "0.001"},
       {"[0,0,0,1]]", "[0,0,0,2]]", ": /frames/0/transform_matrix/3/3: expected 1 in the last row, found 2"},
       {"[1,0,0,1]", "[1,0,0]", ": /frames/0/transform_matrix/0: expected 4 items, found 3"},
       {"\"fl_x\": 500", "\"camera_angle_x\": 4",
        ": /camera_angle_x: expected an angle between 0 and pi, found 4"},
       {"\"file_path\": \"./images/left.png\", ", "", ": /frames/0: expected key \"file_path\", found none"},
       {"[[1,0,0,1]", "[[-1,0,0,1]",
        ": /frames/0: the rotation has the determinant -1, expected a positive one: it mirrors"}},
      [&] { import::read_nerfstudio(folder.path("transforms.json")); });
}

TEST_CASE("names of pictures: what all of them share is left out") {
  using Names = std::vector<std::string>;
  CHECK(import::names_of_pictures({"images/a.png", "images/b.png"}) == Names{"a", "b"});
  CHECK(import::names_of_pictures({"x/a/0001.png", "x/b/0001.png"}) == Names{"a", "b"});
  CHECK(import::names_of_pictures({"./v1.2/a.b.png", "./v1.3/a.b.png"}) == Names{"v1.2", "v1.3"});
  CHECK(import::names_of_pictures({"a/b/c.png"}) == Names{"c"});
  CHECK(import::names_of_pictures({"a/0001", "0001"}) == Names{"a/0001", "0001"});
  CHECK(import::names_of_pictures({"a", "a/a"}) == Names{"a", "a/a"});
  CHECK(import::names_of_pictures({"C:\\x\\1.png", "C:\\x\\2.png"}) == Names{"1", "2"});
}
