// fvvmux, then fvvdemux: meshes with texture coordinates, and the atlas that they address.
#include "gltf_fixture.h"
#include "make_video.h"
#include "mux_fixture.h"

#include "fvv_mux/report.h"
#include "fvvdemux/demux.h"

#include <set>

namespace {

// Red, green / blue, white, with a moving black bar: no flip or turn of it looks like another.
media::Image atlas_of(uint32_t width, uint32_t height, int64_t frame) {
  media::Image image = media::make_image(width, height, 3, 0);
  for (uint32_t y = 0; y < height; y++)
    for (uint32_t x = 0; x < width; x++) {
      uint8_t *p = &image.pixels[3 * (size_t(y) * width + x)];
      const bool right = 2 * x >= width, low = 2 * y >= height, bar = y / 4 == uint32_t(frame) % 3;
      p[0] = bar ? 0 : (right == low ? 230 : 20);
      p[1] = bar ? 0 : (right ? 220 : 30);
      p[2] = bar ? 0 : (low ? 210 : 40);
    }
  return image;
}

// Texture coordinates from the direction of a vertex of the ball: none lies on a seam, each on its own place.
geometry::Mesh textured_ball(int64_t frame) {
  geometry::Mesh mesh = ball(frame);
  for (size_t v = 0; v < mesh.vertex_count(); v++)
    mesh.texture.insert(mesh.texture.end(),
                        {0.5 + 0.9 * (mesh.positions[3 * v] - 0.05 * double(frame)), // x right
                         0.5 - 0.9 * mesh.positions[3 * v + 1]}); // y up is the picture's top
  return mesh;
}

// A capture with an atlas; cameras of shape as ever.
scene::Capture make_atlas_capture(const Folder &folder, uint32_t width = 64, uint32_t height = 32,
                                  const Shape &shape = {}, const std::string &extension = "ply") {
  scene::Capture capture = make_capture(folder, shape);
  capture.meshes = scene::Pattern::parse("meshes/%04d." + extension, nullptr);
  capture.atlas = scene::Atlas{scene::Pattern::parse("atlas/%04d.png", nullptr), {}};
  fs::create_directories(folder.path("in/atlas"));
  for (const int64_t number : capture.frames.numbers()) {
    scene::write_mesh(textured_ball(number), {{0, 0, 0}, 1e-6}, capture.mesh_path(number));
    write_png(capture.atlas_path(number), atlas_of(width, height, number));
  }
  scene::write_capture(capture, capture.path);
  return capture;
}

std::string failure(const FileOptions &options) {
  try {
    mux_file(options);
    return "";
  } catch (const fvv::Error &error) {
    return error.in(fvv::Spelling::command_line);
  }
}

demux::Result unpack(const std::string &stream, const std::string &folder,
                     demux::Meshes meshes = demux::Meshes::ply) {
  demux::Options options;
  options.meshes = meshes;
  options.force = true;
  demux::Result result;
  demux::demux(stream, folder, options, result);
  return result;
}

} // namespace

TEST_CASE("an atlas is a video track of its own, in the stream as in the capture") {
  const Folder folder;
  const scene::Capture capture = make_atlas_capture(folder);
  std::set<std::string> results;
  FileOptions options = options_for(folder);
  options.verify = true;
  options.quality.value = 40; // halves of chroma do not allow 42 in all groups
  mux::Report summary;
  for (const uint32_t threads : {1, 3}) {
    options.threads = threads;
    summary = mux_file(options);
    results.insert(read_bytes(options.output));
  }
  CHECK(results.size() == 1);
  REQUIRE(summary.videos.size() == 2);
  CHECK(summary.videos[1].sample_psnr >= 40);
  CHECK(summary.verdict->videos[1].pictures == 5);
  CHECK(summary.verdict->mesh.max_texture_error > 0);
  CHECK(summary.verdict->mesh.max_texture_error <= 0.5 / 4096);
  const std::string text = text_of(summary);
  CHECK(text.find("\n  atlas ") != text.npos);
  CHECK(text.find("over the whole atlas of") != text.npos);
  const nlohmann::ordered_json json = json_of(summary);
  CHECK(json["atlas"]["width"] == 64);
  CHECK(json["atlas"]["texture_bits"] == 12);
  CHECK(json["video"]["cameras"] == 3);
  CHECK(json["verified"]["atlas"]["pictures"] == 5);

  Stream stream(options.output);
  const fvv_configuration &configuration = stream.configuration();
  REQUIRE(configuration.video_count == 2);
  CHECK(configuration.videos[1].config.shows == FVV_SHOWS_ATLAS);
  CHECK(configuration.videos[1].tile_count == 0);
  fvv_mesh mesh = {};
  stream.mesh(2, mesh);
  CHECK(mesh.texture_bits == 12);
  // Straight from the lattice: the picture's top is where y is up.
  const fvv_scene &scene = configuration.scene;
  for (uint32_t v = 0; v < mesh.vertex_count; v++) {
    double metres[3];
    fvv_lattice_to_metres(scene.lattice_origin, scene.lattice_step, mesh.lattice + 3 * size_t(v), metres);
    CHECK(mesh.texture[2 * v] / 4096.0 == Approx(0.5 + 0.9 * (metres[0] - 0.1)).margin(0.01));
    CHECK(mesh.texture[2 * v + 1] / 4096.0 == Approx(0.5 - 0.9 * metres[1]).margin(0.01));
  }
  fvv_mesh_free(&mesh);
}

TEST_CASE("an atlas that was unpacked and packed again gives the same meshes") {
  const Folder folder;
  make_atlas_capture(folder);
  FileOptions options = options_for(folder);
  options.texture_bits = 10;
  mux_file(options);
  for (const demux::Meshes meshes : {demux::Meshes::ply, demux::Meshes::obj, demux::Meshes::drc}) {
    const demux::Result result = unpack(options.output, folder.path("out"), meshes);
    CHECK(result.atlases == 5);
    CHECK((result.capture && result.warnings.empty() && result.losses.empty()));
    const scene::Capture written = scene::load_capture(folder.path("out/capture.json"));
    REQUIRE(written.atlas);
    CHECK(written.atlas->texture_bits == 10u);
    const media::Image picture = media::read_image(written.atlas_path(2), 3);
    CHECK(media::psnr_luma(picture, atlas_of(64, 32, 2)) > 36);
    FileOptions again = options_for(folder);
    again.capture = folder.path("out");
    again.output = folder.path("again.fvv");
    again.verify = true;
    CHECK(mux_file(again).changes.changed_frames == 0);
    Stream first(options.output), second(again.output);
    for (size_t i = 0; i < 5; i++) {
      fvv_mesh a = {}, b = {};
      first.mesh(i, a);
      second.mesh(i, b);
      CHECK(b.texture_bits == 10);
      REQUIRE(a.vertex_count == b.vertex_count);
      const auto sorted = [](const fvv_mesh &mesh) {
        std::vector<std::array<int64_t, 5>> out;
        for (uint32_t v = 0; v < mesh.vertex_count; v++)
          out.push_back({mesh.lattice[3 * v], mesh.lattice[3 * v + 1], mesh.lattice[3 * v + 2],
                         mesh.texture[2 * v], mesh.texture[2 * v + 1]});
        std::sort(out.begin(), out.end());
        return out;
      };
      CHECK(sorted(a) == sorted(b));
      fvv_mesh_free(&a);
      fvv_mesh_free(&b);
    }
  }
}

TEST_CASE("texture coordinates go with the atlas, and only with it") {
  const Folder folder;
  scene::Capture capture = make_atlas_capture(folder);
  FileOptions options = options_for(folder);
  options.pictures = false;
  options.verify = true;
  const mux::Report bare = mux_file(options);
  CHECK((bare.videos.empty() && bare.texture_bits == 0));
  const std::string without = read_bytes(options.output);
  capture.atlas.reset();
  scene::write_capture(capture, capture.path);
  mux_file(options);
  CHECK(read_bytes(options.output) == without);
}

TEST_CASE("the size of an atlas is made even, and scaled on request") {
  const Folder folder;
  Shape shape;
  shape.sizes = {};
  shape.count = 2;
  make_atlas_capture(folder, 63, 41, shape);
  FileOptions options = options_for(folder);
  options.verify = true;
  options.quality.value = 35;
  const auto size = [&] {
    const mux::Report summary = mux_file(options);
    REQUIRE(summary.videos.size() == 1);
    return std::pair(summary.videos[0].width, summary.videos[0].height);
  };
  CHECK(size() == std::pair(62u, 40u));
  options.atlas_scale = 0.5;
  CHECK(size() == std::pair(32u, 20u));
  options.codec = FVV_CODEC_JPEG;
  options.atlas_scale = 1;
  CHECK(size() == std::pair(63u, 41u));
}

TEST_CASE("what does not fit an atlas is refused before work starts") {
  const Folder folder;
  scene::Capture capture = make_atlas_capture(folder);
  const FileOptions options = options_for(folder);
  write_png(capture.atlas_path(3), atlas_of(62, 32, 3));
  const std::string where = capture.path + ": ",
                    advice = "\n" + where + "--skip-bad-frames leaves out frames whose files cannot be used";
  CHECK(failure(options) ==
        where + "atlas: 1 of 5 pictures is not 64 x 32, first: atlas/0003.png is 62 x 32" + advice);
  fs::remove(capture.atlas_path(3));
  CHECK(failure(options) == where + "atlas: 1 of 5 pictures is missing: 3 (first: atlas/0003.png)" + advice);
  write_png(capture.atlas_path(3), atlas_of(64, 32, 3));
  scene::write_mesh(ball(1), {}, capture.mesh_path(1));
  CHECK(failure(options).find("0001.ply:3: expected texture coordinates") != std::string::npos);
  geometry::Mesh outside = textured_ball(1);
  outside.texture[9] = 1.25;
  scene::write_mesh(outside, {}, capture.mesh_path(1));
  CHECK(failure(options).find("0001.ply: face 44: expected texture coordinates within one picture") !=
        std::string::npos);
  const auto refusal = [&](const std::string &rest) {
    try {
      scene::parse_capture(R"({"fvv_capture": 1, "frame_rate": 25, "units": "metres", "frames": )"
                           R"({"first": 0, "count": 1}, )" +
                               rest + "}",
                           "c");
      return std::string();
    } catch (const fvv::Error &error) {
      return error.in(fvv::Spelling::command_line);
    }
  };
  const std::string meshes = R"("meshes": {"pattern": "a.drc"}, "atlas": )";
  CHECK(refusal(R"("atlas": {"embedded": true})") == "c: /atlas: expected meshes wherever there is an atlas");
  CHECK(refusal(meshes + "{}") == "c: /atlas: expected pictures or embedded, found neither");
  CHECK(refusal(meshes + R"({"pictures": "a.png", "embedded": true})") ==
        "c: /atlas: expected pictures or embedded, found both");
  CHECK(refusal(meshes + R"({"embedded": true})") ==
        "c: /atlas/embedded: expected meshes in .glb, .gltf, .obj or .ply files, found \"a.drc\"");
  CHECK(refusal(meshes + R"({"pictures": "a.png", "texture_bits": 17})")
            .find("c: /atlas/texture_bits: expected") == 0);
  CHECK(refusal(meshes + R"({"pictures": "a.png", "texture_bits": 16})").empty());
}

TEST_CASE("the pictures inside glTF files are an atlas") {
  const Folder folder;
  fs::create_directories(folder.path("in"));
  const auto write_frame = [&](int frame, uint32_t width) {
    gltf_fixture::File file = gltf_fixture::triangle();
    auto &primitive = file.document["meshes"][0]["primitives"][0];
    primitive["attributes"]["TEXCOORD_0"] = file.add("VEC2", gltf_fixture::float32, {0, 0, 1, 0, 0, 1});
    primitive["material"] = 0;
    const std::vector<uint8_t> png = media::encode_png(atlas_of(width, 32, frame));
    const size_t from = file.binary.size();
    file.binary.append(png.begin(), png.end());
    file.document["images"] = {{{"bufferView", file.view(from)}, {"mimeType", "image/png"}}};
    file.document["textures"] = {{{"source", 0}}};
    file.document["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
    const std::string glb = file.glb();
    write_bytes(folder.path("in/" + std::to_string(frame) + ".glb"), glb.data(), glb.size());
  };
  for (int frame = 0; frame < 3; frame++) write_frame(frame, 64);
  const std::string text =
      R"({"fvv_capture": 1, "frame_rate": 25, "units": "metres", "frames": {"first": 0, "count": 3},)"
      R"( "meshes": {"pattern": "%d.glb"}, "atlas": {"embedded": true}})";
  write_bytes(folder.path("in/capture.json"), text.data(), text.size());
  FileOptions options = options_for(folder);
  options.verify = true;
  options.quality.value = 38;
  CHECK(mux_file(options).verdict->videos[0].min_psnr > 35);
  unpack(options.output, folder.path("out"));
  const media::Image picture = media::read_image(folder.path("out/atlas/0001.png"), 3);
  CHECK(media::psnr_luma(picture, atlas_of(64, 32, 1)) > 35);
  // Unlike ones have the size that is needed most.
  write_frame(2, 128);
  CHECK(mux_file(options).verdict->videos[0].min_psnr > 35);
  fs::remove_all(folder.path("out"));
  unpack(options.output, folder.path("out"));
  const media::Image small = media::read_image(folder.path("out/atlas/0001.png"), 3),
                     large = media::read_image(folder.path("out/atlas/0002.png"), 3);
  CHECK(media::psnr_luma(small, media::scale(atlas_of(64, 32, 1), 128, 32)) > 35);
  CHECK(media::psnr_luma(large, atlas_of(128, 32, 2)) > 35);
}

TEST_CASE("one atlas picture for all frames gives the stream that a copy for each gives") {
  const Folder folder;
  Shape shape;
  shape.first = 7;
  scene::Capture capture = make_atlas_capture(folder, 64, 32, shape);
  for (const int64_t number : capture.frames.numbers())
    write_png(capture.atlas_path(number), atlas_of(64, 32, 0));
  FileOptions options = options_for(folder);
  mux_file(options);
  const std::string copies = read_bytes(options.output);
  fs::remove_all(folder.path("in/atlas"));
  write_png(folder.path("in/one.png"), atlas_of(64, 32, 0));
  capture.atlas->pictures = scene::Pattern::parse("one.png", nullptr).value();
  scene::write_capture(capture, capture.path);
  options.verify = true;
  for (const uint32_t threads : {1, 3}) {
    options.threads = threads;
    CHECK(mux_file(options).verdict->videos[1].pictures == 5);
    CHECK(read_bytes(options.output) == copies);
  }
  // Turned before texture coordinates address it.
  capture.atlas->pictures->rotate = 180;
  scene::write_capture(capture, capture.path);
  mux_file(options);
  unpack(options.output, folder.path("out"));
  const media::Image turned = media::read_image(folder.path("out/atlas/0009.png"), 3);
  CHECK(media::psnr_luma(turned, media::rotate(atlas_of(64, 32, 0), 180)) > 36);

  const std::string subject = capture.path + ": atlas: 1 of 1 pictures is ";
  write_bytes(folder.path("in/one.png"), "", 0);
  CHECK(failure(options) == subject + "empty, first: one.png");
  write_bytes(folder.path("in/one.png"), "JFIF", 4);
  CHECK(failure(options).find(subject + "unreadable, first: " + folder.path("in/one.png")) == 0);
  fs::remove(folder.path("in/one.png"));
  CHECK(failure(options) == subject + "missing, first: one.png");
}

TEST_CASE("an atlas may be a video, met and turned as those of cameras are") {
  const Folder folder;
  Shape shape;
  shape.sizes = {};
  scene::Capture capture = make_atlas_capture(folder, 64, 32, shape);
  fs::remove_all(folder.path("in/atlas"));
  Clip clip;
  clip.times = steady(20, 3600);
  clip.b_frames = 2;
  clip.display_rotation = 90;
  write_video(folder.path("in/atlas.mp4"), clip);
  scene::VideoSource video;
  video.file = "atlas.mp4";
  video.start = {1, 5};
  const auto describe = [&](std::optional<int> rotate) {
    capture.atlas->pictures = video;
    capture.atlas->pictures->rotate = rotate;
    scene::write_capture(capture, capture.path);
  };
  FileOptions options = options_for(folder);
  options.quality = {false, 4};
  options.verify = true;
  describe(0);
  const mux::Report summary = mux_file(options);
  REQUIRE(summary.videos.size() == 1);
  CHECK(summary.videos[0].width == 64);
  REQUIRE(summary.sources.size() == 1);
  const mux::SourceReport &report = summary.sources[0];
  CHECK((!report.camera && report.met == 5 && report.before == 5 && report.behind == 10));
  CHECK(text_of(summary).find("  source    atlas pictures atlas.mp4: 20 pictures at 25/s") !=
        std::string::npos);
  CHECK(json_of(summary)["sources"][0]["camera"].is_null());
  unpack(options.output, folder.path("out"));
  for (int i = 0; i < 5; i++)
    CHECK(number_in(media::read_image(folder.path("out/atlas/000" + std::to_string(i) + ".png"), 3), 60,
                    44) == 5 + i);

  describe({}); // by the video
  const mux::Report turned = mux_file(options);
  CHECK((turned.videos[0].width == 48 && turned.videos[0].height == 64));

  fs::remove(folder.path("in/atlas.mp4"));
  CHECK(failure(options) == capture.path + ": atlas: pictures atlas.mp4: is missing");
  write_bytes(folder.path("in/atlas.mp4"), "no video", 8);
  CHECK(failure(options).find(capture.path + ": atlas: pictures: " + folder.path("in/atlas.mp4") + ": ") ==
        0);
}
