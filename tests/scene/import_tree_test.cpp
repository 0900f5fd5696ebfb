// fvv_scene: OpenCV's and Qualisys's files, and hostile XML and YAML.
#include "import_fixture.h"

#include "scene/src/import/tree.h"

#include <cstdlib>

using namespace fvv;

namespace {

const std::string yaml = "%YAML:1.0\n"
                         "---\n"
                         "calibration_time: \"Mon\"\n"
                         "image_width: 640\n"
                         "image_height: 480\n"
                         "camera_matrix: !!opencv-matrix\n"
                         "   rows: 3\n"
                         "   cols: 3\n"
                         "   dt: d\n"
                         "   data: [ 500., 0., 319.5, 0., 510., 239.5,\n"
                         "       0., 0., 1. ]\n"
                         "distortion_coefficients: !!opencv-matrix\n"
                         "   rows: 1\n"
                         "   cols: 5\n"
                         "   dt: d\n"
                         "   data: [ 1.0e-01, 0.02, 0.003, -0.004, 0.005 ]\n"
                         "rvec: !!opencv-matrix\n"
                         "   rows: 3\n"
                         "   cols: 1\n"
                         "   dt: d\n"
                         "   data: [ 0., 0., 1.5707963267948966 ]\n"
                         "tvec: !!opencv-matrix\n"
                         "   rows: 3\n"
                         "   cols: 1\n"
                         "   dt: d\n"
                         "   data: [ 1., 2., 3. ]\n";

std::string xml_matrix(const std::string &name, int rows, int columns, const std::string &data) {
  return "<" + name + " type_id=\"opencv-matrix\"><rows>" + std::to_string(rows) + "</rows><cols>" +
         std::to_string(columns) + "</cols><dt>d</dt><data>\n" + data + "</data></" + name + ">\n";
}

const std::string xml = "<?xml version=\"1.0\"?>\n<opencv_storage>\n"
                        "<image_width>640</image_width><image_height>480</image_height>\n" +
                        xml_matrix("K", 3, 3, "500. 0. 319.5 0. 510. 239.5 0. 0. 1.") +
                        xml_matrix("D", 1, 4, "0.1 0.02 0.003 -0.004") +
                        xml_matrix("R", 3, 3, "0 -1 0 1 0 0 0 0 1") + xml_matrix("T", 1, 3, "1 2 3") +
                        "</opencv_storage>\n";

const std::string qualisys =
    "<?xml version='1.0' encoding='ASCII'?>\n<calibration><cameras>\n"
    "<camera active=\"1\" serial=\"12\" viewrotation=\"0\">\n"
    "<fov_video left=\"0\" right=\"1087\" top=\"8\" bottom=\"1919\"/>\n"
    "<fov_video_max left=\"0\" right=\"1087\" top=\"0\" bottom=\"1919\"/>\n"
    "<transform x=\"1000\" y=\"2000\" z=\"3000\" r11=\"1\" r12=\"0\" r13=\"0\" r21=\"0\" r22=\"1\" r23=\"0\" "
    "r31=\"0\" r32=\"0\" r33=\"1\"/>\n"
    "<intrinsic focalLengthU=\"64000\" focalLengthV=\"64064\" centerPointU=\"34816\" centerPointV=\"61440\" "
    "sensorMinU=\"0\" sensorMaxU=\"69568\" sensorMinV=\"0\" sensorMaxV=\"122816\" skew=\"0.0\" "
    "radialDistortion1=\"0.1\" radialDistortion2=\"0.02\" radialDistortion3=\"0.005\" "
    "tangentalDistortion1=\"0.003\" tangentalDistortion2=\"-0.004\"/></camera>\n"
    "<camera active=\"0\" serial=\"13\"/>\n</cameras></calibration>\n";

void check_faults(const ImportFolder &folder, const std::string &good, const std::vector<Fault> &faults,
                  const std::function<void(const std::string &)> &read) {
  const std::string path = folder.path("file");
  folder.write("file", good);
  REQUIRE(message_of([&] { read(path); }).empty());
  for (const Fault &fault : faults) {
    folder.write("file", with(good, fault.part, fault.other));
    CHECK(message_of([&] { read(path); }) == path + fault.message);
  }
}

void read_opencv(const std::string &path) {
  import::read_opencv({path});
}
void read_qualisys(const std::string &path) {
  import::read_qualisys(path);
}

std::string repeated(const std::string &text, size_t count) {
  std::string out;
  while (count--) out += text;
  return out;
}

} // namespace

TEST_CASE("OpenCV: YAML and XML say the same, pixel centres move by half a pixel") {
  const ImportFolder folder;
  const auto calibration = import::read_opencv({folder.write("a.yml", yaml), folder.write("b.xml", xml)});
  REQUIRE(calibration.cameras.size() == 2);
  CHECK(*calibration.cameras[1].name == "b");
  for (const auto &camera : calibration.cameras) {
    const fvv_camera &c = camera.calibration;
    CHECK(c.cx == 320);
    CHECK(c.cy == 240);
    CHECK(c.fy == 510);
    CHECK(c.distortion[3] == -0.004);
    CHECK(c.distortion[4] == (c.id == 0 ? 0.005 : 0));
    CHECK(c.rotation[1] == Approx(-1));
    CHECK(c.rotation[0] == Approx(0).margin(1e-15));
    CHECK(c.translation[2] == 3);
  }
}

TEST_CASE("OpenCV: fisheye, eight coefficients, and prisms only where they do nothing") {
  const ImportFolder folder;
  const auto lens = [&](int count, const std::string &data, const std::string &more) {
    const std::string text =
        with(with(xml, xml_matrix("D", 1, 4, "0.1 0.02 0.003 -0.004"), xml_matrix("D", count, 1, data)),
             "<image_width>", more + "<image_width>");
    return import::read_opencv({folder.write("c.xml", text)}).cameras[0].calibration;
  };
  CHECK(lens(4, "0.01 0 0 0.001", "<fisheye_model>1</fisheye_model>").lens == FVV_LENS_FISHEYE);
  CHECK(lens(8, "0.1 0 0 0 0 0.1 0.01 0.001", "").distortion[7] == 0.001);
  CHECK(lens(14, "0.1 0 0 0 0 0.1 0.01 0.002 0 0 0 0 0 0", "").distortion[7] == 0.002);
  CHECK(lens(4, "0 0 0 0", "").lens == FVV_LENS_NONE);
  const auto message = [&](int count, const std::string &data) {
    return message_of([&] { lens(count, data, ""); });
  };
  const std::string where = folder.path("c.xml") + ":6: expected ";
  CHECK(message(12, "0 0 0 0 0 0 0 0 1e-9 0 0 0") ==
        where + "0 for the coefficients of thin prism, which fvv does not have, in D");
  CHECK(message(14, "0 0 0 0 0 0 0 0 0 0 0 0 0 1e-9") ==
        where + "0 for the coefficients of a tilted sensor, which fvv does not have, in D");
  CHECK(message(6, "0 0 0 0 0 0") == where + "4, 5, 8, 12 or 14 coefficients in D, found 6");
}

TEST_CASE("OpenCV: malformed YAML, each with its message") {
  check_faults(
      ImportFolder(), yaml,
      {{"510.", ".Nan", ":10: expected a finite number for camera_matrix, found \".Nan\""},
       {", 0.005", "", ":16: expected 5 numbers in distortion_coefficients, found 4"},
       {"image_width: 640\n", "", ": expected the key image_width or width, found none"},
       {"image_height", "image_width", ":5: expected one image_width, found a second"},
       {"640", "640.5", ":4: expected an integer from 1 to 2147483647 for image_width, found \"640.5\""},
       {"500., 0.,", "500., 1.,", ":6: expected fx 0 cx, 0 fy cy, 0 0 1 for camera_matrix, found others"},
       {"dt: d", "dt: u", ":9: expected d, f or i for dt, found \"u\""},
       {"rvec: !!opencv-matrix", "rvec: !!map",
        ":17: expected an opencv-matrix or a list for rvec, found \"map\""},
       {"rvec: !!opencv-matrix\n   rows: 3", "rvec: !!opencv-nd-matrix\n   sizes: [ 1, 3, 1 ]",
        ":18: expected one or two sizes of rvec, found 3"},
       {"rvec: !!opencv-matrix\n   rows: 3", "rvec: !!opencv-nd-matrix\n   sizes: [ 3, -1 ]",
        ":18: expected an integer from 1 to 16 for sizes, found \"-1\""},
       {"[ 1., 2., 3. ]", "[ 1., [ 2. ], 3. ]", ":26: expected a finite number for tvec, found \"\""},
       {"rvec: ", "R: ", ":17: expected 3 x 3 numbers for R, found 3 x 1"},
       {"calibration_time: \"Mon\"", "T: 1", ":3: expected tvec or T, found both"},
       {"\"Mon\"", "*a", ":3: expected YAML, found: the referenced anchor is not defined"},
       {"\"Mon\"", "&a 1", ":3: expected no anchors and aliases, found an anchor"},
       {"\"Mon\"", "{[a]: b}", ":3: expected a key, found a sequence or a map"},
       {"\"Mon\"", repeated("[", 40) + repeated("]", 40), ":3: expected values at most 16 deep, found more"},
       {yaml, "- 1\n", ":1: expected a key, found a sequence or a map"},
       {yaml, "one", ":1: expected keys and values, found \"one\""},
       {yaml, "", ":1: expected keys and values, found nothing"}},
      read_opencv);
}

TEST_CASE("OpenCV: malformed XML, each with its message") {
  check_faults(
      ImportFolder(), xml,
      {{"</opencv_storage>", "", ":13: expected XML, found: no element found"},
       {"opencv_storage", "storage", ":12: expected XML, found: mismatched tag"},
       {xml, "<storage/>", ":1: expected <opencv_storage>, found <storage>"},
       {"<rows>3</rows>", "", ":4: expected rows in K, found none"},
       {"<rows>3</rows>", "<rows>3000</rows>",
        ":4: expected an integer from 1 to 16 for rows, found \"3000\""},
       {"1 2 3<", "1 1e999 3<", ":10: expected a finite number for T, found \"1e999\""},
       {"0 -1 0 1", "0 -1 0 2", ": rows 1 and 1 of the rotation have the product 4, expected 1 within 1e-4"}},
      read_opencv);
}

TEST_CASE("Qualisys: millimetres, 64ths of a pixel, the window of the video, axes with y up") {
  const ImportFolder folder;
  const auto calibration = import::read_qualisys(folder.write("room.qca.txt", qualisys));
  REQUIRE(calibration.cameras.size() == 1); // the other one is not active
  CHECK(calibration.metres_per_unit == 0.001);
  CHECK(*calibration.cameras[0].name == "12");
  const fvv_camera &c = calibration.cameras[0].calibration;
  CHECK(c.width == 1088);
  CHECK(c.height == 1912);
  CHECK(c.fx == 1000);
  CHECK(c.fy == 1001);
  CHECK(c.cx == 544.5);
  CHECK(c.cy == 960 - 8 + 0.5);
  CHECK(c.distortion[2] == 0.003);
  CHECK(c.distortion[4] == 0.005);
  CHECK(c.rotation[4] == -1);
  CHECK(c.translation[0] == -1000);
  CHECK(c.translation[1] == 2000);
  CHECK(c.translation[2] == 3000);
}

TEST_CASE("Qualisys: malformed files, each with its message") {
  check_faults(
      ImportFolder(), qualisys,
      {{" r22=\"1\"", "", ":6: expected an attribute r22 of <transform>, found none"},
       {"r22=\"1\"", "r22=\"1,0\"", ":6: expected a finite number for r22, found \"1,0\""},
       {"\"69568\"", "\"1087\"",
        ":7: expected sensorMaxU - sensorMinU to be about 69568, 64 for each pixel of fov_video_max, found "
        "1087"},
       {"skew=\"0.0\"", "skew=\"0.1\"", ":7: expected skew to be 0, found 0.1"},
       {"viewrotation=\"0\"", "viewrotation=\"90\"",
        ":3: expected viewrotation to be 0 (turned pictures are not supported), found 90"},
       {"<fov_video left=\"0\" right=\"1087\" top=\"8\" bottom=\"1919\"/>", "",
        ":3: expected fov_video in camera, found none"},
       {"top=\"8\"", "top=\"1920\"", ":4: expected an integer from 1920 to 65535 for bottom, found \"1919\""},
       {"active=\"1\"", "active=\"0\"", ": expected at least one camera, found none"},
       {"<camera active=\"0\" serial=\"13\"/>", "<lens/>", ":8: expected <camera>, found <lens>"},
       {"'ASCII'", "'EBCDIC'", ":1: expected XML, found: unknown encoding"},
       {qualisys, "<Calibration/>", ":1: expected <calibration>, found <Calibration>"}},
      read_qualisys);
}

TEST_CASE("XML: document types, entities, depth and floods are refused") {
  const ImportFolder folder;
  const auto message = [&](const std::string &bytes) {
    return message_of([&] { import::parse_xml(bytes, "x.xml"); });
  };
  std::string laughs = "<!DOCTYPE lolz [<!ENTITY a0 \"lol\">\n";
  for (int i = 1; i < 10; i++)
    laughs +=
        "<!ENTITY a" + std::to_string(i) + " \"" + repeated("&a" + std::to_string(i - 1) + ";", 10) + "\">\n";
  const std::string refused = "x.xml:1: expected no document type (<!DOCTYPE>), found one";
  CHECK(message(laughs + "]><calibration>&a9;</calibration>") == refused);
  CHECK(message("<!DOCTYPE c [<!ENTITY e SYSTEM \"file:///etc/hostname\">]><c>&e;</c>") == refused);
  CHECK(message("<!DOCTYPE c SYSTEM \"http://localhost/c.dtd\"><c/>") == refused);
  CHECK(message("<!DOCTYPE c><c/>") == refused);
  CHECK(message("<c>&e;</c>") == "x.xml:1: expected XML, found: undefined entity");
  CHECK(message(repeated("<a>", 16) + repeated("</a>", 16)).empty());
  CHECK(message(repeated("<a>", 17)) == "x.xml:1: expected elements at most 16 deep, found <a>");
  CHECK(message("<a>" + repeated("<b c=\"\"/>\n", 100000) + "</a>") ==
        "x.xml:100000: expected at most 200000 elements and attributes, found more");
  CHECK(message("") == "x.xml:1: expected XML, found: no element found");
  CHECK(import::parse_xml("<a>1 &lt; &#50;</a>", "x.xml").text == "1 < 2");
  std::ofstream(folder.path("big")).close();
  std::filesystem::resize_file(folder.path("big"), import::max_xml_size + 1); // a hole: no disk is filled
  CHECK(message_of([&] { import::read_qualisys(folder.path("big")); }) ==
        folder.path("big") + ": has 67108865 bytes, at most 67108864 are allowed");
}

TEST_CASE("every cut of a file is refused, none crashes") {
  const ImportFolder folder;
  for (size_t size = 0; size + 2 < qualisys.size(); size++) {
    const std::string cut = qualisys.substr(0, size);
    if (message_of([&] { import::parse_xml(cut, "x"); }).empty())
      FAIL("a cut to " << size << " bytes passed");
  }
  // YAML does not say where it ends: a cut within the last vector must still be one.
  const size_t last = yaml.rfind(" ]");
  for (size_t size = 0; size <= last; size++) {
    const std::string path = folder.write("cut.yml", yaml.substr(0, size));
    if (message_of([&] { read_opencv(path); }).empty()) FAIL("a cut to " << size << " bytes passed");
  }
}

TEST_CASE("Qualisys: the axes of a real room meet where it was found that they do") {
  const char *data = std::getenv("FVV_DATA");
  const std::string path =
      std::string(data ? data : "") + "/pose2sim_4cam/Demo_SinglePerson/calibration/Calib.qca.txt";
  if (!data || !std::filesystem::exists(path)) {
    WARN("skipped: no pose2sim_4cam under FVV_DATA");
    return;
  }
  const auto calibration = import::read_qualisys(path);
  REQUIRE(calibration.cameras.size() == 4);
  const double point[3] = {-940, -20, 590};
  for (const auto &camera : calibration.cameras) {
    double pixel[2], depth;
    REQUIRE(fvv_camera_project(&camera.calibration, point, pixel, &depth));
    const double off = std::hypot((pixel[0] - camera.calibration.cx) / camera.calibration.fx,
                                  (pixel[1] - camera.calibration.cy) / camera.calibration.fy);
    CHECK(off * depth < 120); // millimetres
  }
}
