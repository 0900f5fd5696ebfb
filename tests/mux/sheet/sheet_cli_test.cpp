// fvvimport capture --sheet as a program: exit codes, messages, JSON, and no half-written sheets.
#include "sheet_fixture.h"

namespace {

ToolResult run_sheet(const Folder &folder, std::vector<std::string> more = {}) {
  std::vector<std::string> words = {"capture", folder.path("in"), "--sheet", folder.path("sheet.png")};
  words.insert(words.end(), more.begin(), more.end());
  return run_tool(words);
}

} // namespace

TEST_CASE("sheet command: a summary, and a JSON whose keys are documented") {
  const Folder folder;
  make_sheet_capture(folder);
  const ToolResult run = run_sheet(folder);
  CHECK(run.exit == 0);
  CHECK(run.err.empty());
  CHECK(run.out.find(folder.path("sheet.png") + ": ") == 0);
  CHECK(run.out.find("  1 ring 1: 200x150, IoU 0.9") != std::string::npos);
  const ToolResult json_run = run_sheet(folder, {"--json", "--force", "--sheet-width", "200"});
  CHECK(json_run.exit == 0);
  const nlohmann::json json = nlohmann::json::parse(json_run.out);
  CHECK(json.at("fvvimport") == 1);
  CHECK(json.at("sheet") == folder.path("sheet.png"));
  CHECK(json.at("frame") == 11);
  CHECK(json.at("outline") == "mesh");
  CHECK(json.at("panel") == 200);
  CHECK(json.at("width") == media::probe_image(folder.path("sheet.png")).width);
  CHECK(json.at("median_iou").is_number());
  CHECK(json.at("median_distance").is_number());
  CHECK(json.at("outliers") == nlohmann::json::array());
  CHECK(json.at("excluded").is_null());
  CHECK(json.at("suspected").is_null());
  CHECK(json.at("warnings") == nlohmann::json::array());
  CHECK(json.size() == 14);
  REQUIRE(json.at("cameras").size() == ring_cameras);
  const nlohmann::json &camera = json.at("cameras")[2];
  CHECK(camera.at("id") == 3);
  CHECK(camera.at("name") == "ring 3");
  CHECK(camera.at("width") == 200);
  CHECK(camera.at("picture") == true);
  CHECK(camera.at("mask") == true);
  CHECK(camera.at("covered").get<double>() > 0.05);
  CHECK(camera.at("iou").get<double>() > 0.98);
  CHECK(camera.at("distance").is_number());
  CHECK(camera.at("offset").size() == 2);
  CHECK(camera.size() == 10);
}

TEST_CASE("sheet command: what is missing for one camera is a warning") {
  const Folder folder;
  const scene::Capture capture = make_sheet_capture(folder);
  fs::remove(capture.picture_path(capture.cameras[0], 11));
  write_png(capture.mask_path(capture.cameras[1], 11), media::make_image(20, 10, 1, 255));
  const ToolResult run = run_sheet(folder, {"--json"});
  CHECK(run.exit == 3);
  CHECK(run.err == "fvvimport: warning: " + capture.picture_path(capture.cameras[0], 11) +
                       ": cannot be opened: No such file or directory\nfvvimport: warning: " +
                       capture.mask_path(capture.cameras[1], 11) +
                       ": expected 160x120 pixels, as the camera has, found 20x10\n");
  const nlohmann::json json = nlohmann::json::parse(run.out);
  CHECK(json.at("warnings").size() == 2);
  CHECK(json.at("cameras")[0].at("picture") == false);
  CHECK(json.at("cameras")[0].at("iou").is_number());
  CHECK(json.at("cameras")[1].at("iou").is_null());
  CHECK(fs::exists(folder.path("sheet.png")));
}

TEST_CASE("sheet command: a camera that is lost in the frame is left out, with a warning") {
  const Folder folder;
  scene::Capture capture = make_sheet_capture(folder, {true, true, 4});
  for (const int64_t frame : {10, 12}) capture.cameras[1].per_frame[frame] = capture.cameras[1].calibration;
  capture.cameras[1].lost = {11};
  scene::write_capture(capture, capture.path);
  const ToolResult run = run_sheet(folder, {"--json"});
  CHECK(run.exit == 3);
  const std::string warning = capture.path + ": left out: camera 2 is not calibrated in frame 11";
  CHECK(run.err == "fvvimport: warning: " + warning + "\n");
  const nlohmann::json json = nlohmann::json::parse(run.out);
  CHECK(json.at("warnings") == nlohmann::json::array({warning}));
  REQUIRE(json.at("cameras").size() == 3);
  CHECK(json.at("cameras")[1].at("id") == 3);
  CHECK(json.at("cameras")[1].at("iou").get<double>() > 0.98);
  CHECK(run_sheet(folder, {"--force", "--frames", "12-12"}).exit == 0);
  CHECK(run_sheet(folder, {"--force", "--cameras", "2"}).exit == 1); // nothing is left
}

TEST_CASE(
    "sheet command: without a single picture that can be read, or without the mesh, there is no sheet") {
  const Folder folder;
  const scene::Capture capture = make_sheet_capture(folder);
  for (const scene::Camera &camera : capture.cameras)
    write_bytes(capture.picture_path(camera, 11),
                "\0\0\0\x20"
                "ftypisom",
                12); // a film
  const ToolResult film = run_sheet(folder);
  CHECK(film.exit == 1);
  CHECK(film.err.find("no camera's picture of frame 11 can be read; the first problem is: " +
                      capture.picture_path(capture.cameras[0], 11)) != std::string::npos);
  CHECK(folder.entries() == 1);
  fs::remove(capture.mesh_path(11));
  const ToolResult mesh = run_sheet(folder);
  CHECK(mesh.exit == 1);
  CHECK(mesh.err.find("mesh11.ply") != std::string::npos);
  CHECK(folder.entries() == 1);
}

TEST_CASE("sheet command: usage") {
  const Folder folder;
  make_sheet_capture(folder, {true, true, 3});
  CHECK(run_tool({"capture", folder.path("in")}).exit == 2);
  CHECK(run_tool({"capture", folder.path("in")}).err.find("expected --sheet FILE") != std::string::npos);
  CHECK(run_sheet(folder, {"-o", folder.path("out.fvv")}).exit == 2);
  CHECK(run_sheet(folder, {"--frames", "40-41"}).exit == 2);
  CHECK(run_sheet(folder, {"--cameras", "99"}).exit == 2);
  CHECK(run_sheet(folder, {"--sheet-width", "20"}).exit == 2);
  CHECK(run_tool({"capture", folder.path("in"), "--sheet-width", "300"}).exit == 2);
  CHECK(run_tool({"capture", folder.path("in"), "--sheet", "-", "--json"}).exit == 2);
  CHECK(folder.entries() == 1);
  write_bytes(folder.path("sheet.png"), "mine", 4);
  CHECK(run_sheet(folder).exit == 1);
  CHECK(read_bytes(folder.path("sheet.png")) == "mine");
  CHECK(run_sheet(folder, {"--force"}).exit == 0);
  CHECK(run_tool({"capture", folder.path("in"), "--sheet", "-"}).out == read_bytes(folder.path("sheet.png")));
}
