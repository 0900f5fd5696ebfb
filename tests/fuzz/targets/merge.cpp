// fvvmux --merge: the folder of a plan with its parts, in which an input changes some bytes. The plan's
// checksum is made right again, so that what is wrong is found where it is.
#include "../fuzz.h"
#include "../mutate/mutate.h"
#include "scratch.h"

#include "fvv_media/image.h"
#include "fvv_scene/capture.h"
#include "fvv_scene/mesh_file.h"
#include "fvvmux/parts.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace {

using fuzz::Bytes;
using Json = nlohmann::json;

constexpr int64_t frames = 3;
constexpr uint32_t side = 32;

fvv::scene::Capture describe(const fuzz::Scratch &scratch) {
  using namespace fvv;
  scene::Capture capture;
  capture.path = scratch.path("capture.json");
  capture.name = "tetrahedron";
  capture.frame_duration = {1, 25};
  capture.frames = {0, frames, 1};
  capture.up = FVV_UP_Y;
  capture.meshes = scene::Pattern::parse("%04d.ply", nullptr);
  scene::Camera camera;
  fvv_camera &c = camera.calibration;
  c.width = c.height = side;
  c.fx = c.fy = 40;
  c.cx = c.cy = side / 2.0;
  for (int i = 0; i < 9; i += 4) c.rotation[i] = 1;
  c.translation[2] = 3;
  c.r_max = fvv_camera_r_max(&c);
  camera.set_name("front");
  camera.pictures = scene::Pattern::parse("%04d.png", nullptr);
  capture.cameras.push_back(camera);
  return capture;
}

// A plan of three groups with its parts. The first file has the fields that the plan's checksum covers.
struct Made {
  Json plan;
  std::vector<Bytes> files;
};

Made make_files() {
  using namespace fvv;
  const fuzz::Scratch scratch;
  const scene::Capture capture = describe(scratch);
  for (int64_t i = 0; i < frames; i++) {
    geometry::Mesh mesh;
    mesh.positions = {0.1 * double(i), 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    mesh.faces = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    scene::write_mesh(mesh, {}, capture.mesh_path(i));
    media::Image image = media::make_image(side, side, 3, 0);
    for (size_t k = 0; k < image.pixels.size(); k++) image.pixels[k] = uint8_t(k * 5 + size_t(i) * 40);
    const std::vector<uint8_t> png = media::encode_png(image);
    scratch.write("000" + std::to_string(i) + ".png", png.data(), png.size());
  }
  scene::write_capture(capture, capture.path);
  mux::Options options;
  options.capture = capture.path;
  options.codec = FVV_CODEC_JPEG;
  options.group = 1;
  options.ladder = {{1, 0}, {0.5, 0}};
  options = mux::settled(options);
  std::vector<Bytes> files(1 + 2 * size_t(frames));
  const auto sink = [](Bytes &out) {
    return [&out](const void *bytes, size_t size) { fuzz::append(&out, bytes, size); };
  };
  const auto text = [](const std::string &from) { return Bytes(from.begin(), from.end()); };
  const mux::PartPlan plan(options, {}, sink(files[1]));
  fuzz::expect(plan.group_count() == size_t(frames), "a group for each frame");
  files[2] = text(plan.first_report());
  for (size_t group = 1; group < plan.group_count(); group++)
    files[2 + 2 * group] = text(plan.encode(group, 1, sink(files[1 + 2 * group]), {}));
  Made made = {Json::from_cbor(plan.bytes()), std::move(files)};
  made.files[0] = made.plan.at("plan").get_binary();
  return made;
}

void change(Bytes &file, fuzz::Input &input) {
  static const uint64_t odd[] = {0,
                                 UINT64_MAX,
                                 uint64_t(INT64_MAX),
                                 uint64_t(1) << 63,
                                 0x6126c2d4256ffcc3,  // 1e160
                                 0x7ff8000000000000}; // no number
  const size_t at = std::min<size_t>(input.u16() % (file.size() + 1), file.size());
  const auto place = file.begin() + ptrdiff_t(at);
  const size_t left = file.size() - at;
  switch (input.below(6)) {
  case 0:
    file.erase(place, place + ptrdiff_t(std::min<size_t>(left, input.below(300))));
    break;
  case 1: {
    const Bytes more = input.bytes(input.u8());
    file.insert(place, more.begin(), more.end());
    break;
  }
  case 2: {
    const uint64_t value = odd[input.below(6)];
    for (size_t k = 0; k < std::min<size_t>(left, 8); k++) file[at + k] = uint8_t(value >> (56 - 8 * k));
    break;
  }
  case 3:
    file = input.part();
    break;
  default: {
    const Bytes over = input.bytes(input.u8() % 32);
    std::copy_n(over.begin(), std::min(left, over.size()), place);
  }
  }
}

// Reports that know their plan and stream, where they are still JSON.
void repair_reports(std::vector<Bytes> &files, const Json &plan) {
  for (size_t i = 1; i < files.size(); i += 2) {
    Json report = Json::parse(files[i + 1].begin(), files[i + 1].end(), nullptr, false);
    if (!report.is_object()) continue;
    report["plan"] = plan;
    report["bytes"] = files[i].size();
    report["crc32c"] = fvv_crc32c(0, files[i].data(), files[i].size());
    const std::string text = report.dump(1, ' ', false, Json::error_handler_t::replace);
    files[i + 1].assign(text.begin(), text.end());
  }
}

std::string name_of(size_t file) {
  return "group-" + std::to_string((file - 1) / 2) + (file % 2 ? ".fvv" : ".json");
}

} // namespace

FVV_FUZZ_TARGET(merge_tool, fuzz::Form::bytes) {
  static const Made made = make_files();
  const fuzz::Scratch scratch;
  fuzz::Input input(data, size);
  std::vector<Bytes> files = made.files;
  const uint32_t repairs = input.u8();
  for (uint32_t count = 1 + input.below(4); count && input.left(); count--) {
    const size_t number = input.below(uint32_t(files.size()));
    change(files[number], input);
    if (number % 2 && repairs & 1) files[number] = fuzz::repair_stream(files[number], fuzz::Repair::all);
  }
  Json plan = made.plan;
  plan["crc32c"] = fvv_crc32c(0, files[0].data(), files[0].size());
  if (repairs & 2) repair_reports(files, plan["crc32c"]);
  for (size_t i = 1; i < files.size(); i++) scratch.write(name_of(i), files[i].data(), files[i].size());
  plan["plan"] = Json::binary(files[0]);
  const std::vector<uint8_t> bytes = Json::to_cbor(plan);
  scratch.write("plan.cbor", bytes.data(), bytes.size());
  try {
    (void)fvv::merge_parts(scratch.path(""), scratch.path("out.fvv"), true);
  } catch (const fvv::Error &) {
    return;
  }
  fuzz::expect(size || !scratch.read("out.fvv").empty(), "a plan that is not changed makes a stream");
}
