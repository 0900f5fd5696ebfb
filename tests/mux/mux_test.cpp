// fvvmux as a library: the round trip of any kind of capture.
#include "mux_fixture.h"

#include "display_codecs.h"
#include "fvv_cxx/parallel.h"
#include "fvv_mux/report.h"
#include "mux/src/parts/plan_data.h"

#include <array>
#include <atomic>
#include <mutex>
#include <set>
#include <thread>

namespace {

bool same_camera(const fvv_camera &a, const fvv_camera &b) {
  const auto same = [](const auto &x, const auto &y) { return !memcmp(&x, &y, sizeof x); };
  return a.id == b.id && a.lens == b.lens && a.width == b.width && a.height == b.height && same(a.fx, b.fx) &&
         same(a.fy, b.fy) && same(a.cx, b.cx) && same(a.cy, b.cy) && same(a.skew, b.skew) &&
         same(a.distortion, b.distortion) && same(a.r_max, b.r_max) && same(a.rotation, b.rotation) &&
         same(a.translation, b.translation) &&
         std::string(a.name, a.name_size) == std::string(b.name, b.name_size);
}

// Largest distance along an axis of a decoded vertex from the nearest source vertex, in metres.
double worst_vertex(const fvv_mesh &mesh, const fvv_scene &scene, const geometry::Mesh &source) {
  double worst = 0;
  for (uint32_t v = 0; v < mesh.vertex_count; v++) {
    double metres[3], best = INFINITY;
    fvv_lattice_to_metres(scene.lattice_origin, scene.lattice_step, mesh.lattice + 3 * size_t(v), metres);
    for (size_t s = 0; s < source.vertex_count(); s++) {
      double off = 0;
      for (size_t k = 0; k < 3; k++) off = std::max(off, std::fabs(metres[k] - source.positions[3 * s + k]));
      best = std::min(best, off);
    }
    worst = std::max(worst, best);
  }
  return worst;
}

std::string failure(const FileOptions &options) {
  try {
    mux_file(options);
    return "";
  } catch (const fvv::Error &error) {
    return error.in(fvv::Spelling::command_line);
  }
}

} // namespace

TEST_CASE("a stream holds what the capture holds") {
  const Folder folder;
  Shape shape;
  shape.first = 20;
  shape.step = 3;
  const scene::Capture capture = make_capture(folder, shape);
  FileOptions options = options_for(folder);
  options.quality.value = 38;
  const mux::Report summary = mux_file(options);
  CHECK(!summary.warned);
  CHECK(summary.bytes == fs::file_size(options.output));
  Stream stream(options.output);
  REQUIRE(stream.frames() == 5);
  REQUIRE(fvv_stream_index_state(stream.handle()) == FVV_INDEX_PRESENT);
  REQUIRE(fvv_stream_group_count(stream.handle()) == 3);
  const fvv_group_info *last = fvv_stream_group(stream.handle(), 2);
  CHECK((last->start == 4 && last->end == 5));
  const fvv_configuration &configuration = stream.configuration();
  const fvv_scene &scene = configuration.scene;
  CHECK((scene.time_base.numerator == 1 && scene.time_base.denominator == 25 && scene.frame_duration == 1));
  CHECK((scene.up_axis == FVV_UP_Y && scene.flags == 0));
  REQUIRE(configuration.camera_count == 3);
  for (size_t k = 0; k < 3; k++) CHECK(same_camera(configuration.cameras[k], capture.cameras[k].calibration));
  REQUIRE(configuration.metadata_count == 1);
  CHECK(
      std::string(configuration.metadata[0].text, configuration.metadata[0].size) ==
      std::string(R"({"generator":"fvvmux )") + fvv_version() +
          R"(","name":"ball","frame_numbers":{"first":20,"step":3},"view":{"camera":13},"mesh_error":{"vertex":0.003}})");
  const std::vector<media::Image> pictures = stream.pictures();
  media::LumaError error;
  for (size_t i = 0; i < 5; i++) {
    const int64_t number = 20 + 3 * int64_t(i);
    const geometry::Mesh source = ball(number);
    fvv_mesh mesh = {};
    stream.mesh(i, mesh);
    CHECK(mesh.vertex_count == source.vertex_count());
    CHECK(mesh.face_count == source.face_count());
    CHECK(worst_vertex(mesh, scene, source) <= summary.lattice.error() * (1 + 1e-9));
    fvv_mesh_free(&mesh);
    for (size_t k = 0; k < 3; k++) {
      const media::LumaError one = media::luma_error(
          media::extract(pictures[i], configuration.videos[0].tiles[k]), picture_of(k, 64, 48, number));
      error.squares += one.squares;
      error.pixels += one.pixels;
    }
  }
  CHECK(error.psnr() > 37);
  CHECK(summary.videos[0].sample_psnr >= 38);
}

TEST_CASE("within a frame the mesh comes first, and every group begins with key chunks") {
  const Folder folder;
  make_capture(folder);
  FileOptions options = options_for(folder);
  options.repeat_configuration = true;
  mux_file(options);
  const InputFile file(options.output);
  const fvv_input input = file.input();
  fvv_stream *opened = nullptr;
  REQUIRE(fvv_stream_open(&input, nullptr, nullptr, &opened, nullptr) == FVV_OK);
  int64_t frame = 0;
  std::set<uint64_t> configurations;
  for (size_t g = 0; g < fvv_stream_group_count(opened); g++) {
    configurations.insert(fvv_stream_group(opened, g)->configuration_offset);
    const fvv_chunk_info *chunks = nullptr;
    size_t count = 0;
    REQUIRE(fvv_stream_group_chunks(opened, g, &chunks, &count, nullptr) == FVV_OK);
    for (size_t c = 0; c < count; frame++) {
      const bool first = c == 0;
      CHECK((chunks[c].type == FVV_CHUNK_MESH && chunks[c].track == 1 && chunks[c].time == frame));
      CHECK(((chunks[c].flags & FVV_FLAG_KEY) != 0) == first);
      // Colours of the key mesh.
      if (first) c++;
      CHECK((!first || (chunks[c].type == FVV_CHUNK_COLOURS && chunks[c].flags & FVV_FLAG_KEY)));
      REQUIRE(++c < count);
      CHECK((chunks[c].type == FVV_CHUNK_VIDEO_PACKET && chunks[c].track == 2));
      CHECK(chunks[c].time == frame);
      CHECK(((chunks[c].flags & FVV_FLAG_KEY) != 0) == first);
      c++;
    }
  }
  fvv_stream_close(opened);
  CHECK(frame == 5);
  CHECK(configurations.size() == 3); // one before each group
}

TEST_CASE("the bytes do not depend on the number of threads", "[long]") {
  const Folder folder;
  Shape shape;
  shape.count = 9;
  shape.masks = true;
  make_capture(folder, shape);
  for (const media::VideoCodec &codec : display_codecs()) {
    std::set<std::string> results;
    for (const uint32_t threads : {1, 2, 5}) {
      FileOptions options = options_for(folder);
      options.codec = codec.code;
      options.threads = threads;
      options.quality.value = 35;
      mux_file(options);
      results.insert(read_bytes(options.output));
    }
    CHECK(results.size() == 1);
  }
}

TEST_CASE("JPEG samples are separate files, with the given quality") {
  const Folder folder;
  make_capture(folder);
  FileOptions options = options_for(folder);
  options.codec = FVV_CODEC_JPEG;
  options.quality = {false, 50};
  const mux::Report coarse = mux_file(options);
  Stream stream(options.output);
  for (size_t i = 0; i < 5; i++) {
    int key = 0;
    const std::vector<uint8_t> bytes = stream.sample(i, key);
    CHECK(key);
    CHECK((bytes[0] == 0xff && bytes[1] == 0xd8));
  }
  options.quality = {false, 95};
  const mux::Report fine = mux_file(options);
  CHECK(fine.videos[0].payload > coarse.videos[0].payload);
  CHECK(fine.videos[0].sample_psnr > coarse.videos[0].sample_psnr);
}

TEST_CASE("masks: the foreground counts, and a flat background is grey beyond 8 pixels") {
  const Folder folder;
  Shape shape;
  shape.masks = true;
  const scene::Capture capture = make_capture(folder, shape);
  FileOptions options = options_for(folder);
  options.codec = FVV_CODEC_JPEG;
  options.tile_fill = mux::TileFill::flat;
  const mux::Report summary = mux_file(options);
  CHECK(summary.videos[0].sample_foreground);
  Stream stream(options.output);
  const media::Image tile = media::extract(stream.pictures()[0], stream.configuration().videos[0].tiles[0]);
  const media::Image source = picture_of(0, 64, 48, 0);
  const auto off = [&](uint32_t x, uint32_t y, int expected) {
    return std::abs(int(tile.pixels[3 * (y * 64 + x) + 1]) - expected);
  };
  CHECK(off(3, 3, 128) <= 6);                                      // far away
  CHECK(off(32, 24, source.pixels[3 * (24 * 64 + 32) + 1]) <= 12); // in the disc
  CHECK(off(32, 7, 75) <= 35); // 7 px above it: from 40 to 140 as in the disc, not 21 as in the picture
  shape.masks = false;
  make_capture(folder, shape);
  CHECK(failure(options) == "--tile-fill flat: camera 3 (camera 0) has no masks");
}

TEST_CASE("unlike cameras, scaled: tiles say the scale, cameras keep their size") {
  const Folder folder;
  Shape shape;
  shape.sizes = {{64, 48}, {80, 40}, {50, 61}};
  make_capture(folder, shape);
  FileOptions options = options_for(folder);
  options.scale = 0.5;
  options.verify = true;
  options.quality.value = 36;
  const mux::Report summary = mux_file(options);
  CHECK(summary.verdict->videos[0].pictures == 5);
  Stream stream(options.output);
  const fvv_configuration &configuration = stream.configuration();
  REQUIRE(configuration.videos[0].tile_count == 3);
  const uint16_t widths[] = {32, 40, 25}, heights[] = {24, 20, 31};
  for (size_t k = 0; k < 3; k++) {
    const fvv_tile &tile = configuration.videos[0].tiles[k];
    CHECK((tile.source.width == shape.sizes[k][0] && tile.source.height == shape.sizes[k][1]));
    CHECK((tile.destination.width == widths[k] && tile.destination.height == heights[k]));
    CHECK(configuration.cameras[k].width == shape.sizes[k][0]);
  }
  options.tile = mux::TileSize{48, 40};
  mux_file(options);
  CHECK(Stream(options.output).configuration().videos[0].tiles[2].destination.width == 48);
  options.tile = mux::TileSize{64, 40};
  CHECK(failure(options) ==
        "--tile: expected at most the size of every picture, found 64x40 for camera 23 with 50x61");
}

TEST_CASE("meshes alone, pictures alone, cameras without pictures, 29.97 Hz") {
  const Folder folder;
  Shape shape;
  shape.duration = {1001, 30000};
  shape.count = 31;
  scene::Capture capture = make_capture(folder, shape);
  FileOptions options = options_for(folder);
  options.group = 0;
  options.quality.value = 30;
  options.pictures = false;
  mux_file(options);
  {
    Stream stream(options.output);
    CHECK(stream.configuration().video_count == 0);
    CHECK(stream.configuration().camera_count == 3);
    CHECK(stream.configuration().scene.time_base.numerator == 1001);
    CHECK(stream.configuration().scene.time_base.denominator == 30000);
    REQUIRE(fvv_stream_group_count(stream.handle()) == 2);
    CHECK(fvv_stream_group(stream.handle(), 0)->end == 30); // one second, rounded
  }
  options.pictures = true;
  options.meshes = false;
  mux_file(options);
  CHECK(Stream(options.output).configuration().track_count == 1);
  options.pictures = false;
  CHECK(failure(options) == capture.path + ": nothing is left to write without meshes and pictures");
  capture.cameras[1].pictures.reset();
  scene::write_capture(capture, capture.path);
  options.pictures = options.meshes = true;
  mux_file(options);
  Stream stream(options.output);
  CHECK(stream.configuration().camera_count == 3);
  REQUIRE(stream.configuration().videos[0].tile_count == 2);
  CHECK(stream.configuration().videos[0].tiles[1].camera_id == 23);
}

TEST_CASE("fast meshes are those of the other profiles, in another order") {
  const Folder folder;
  make_capture(folder, Shape());
  FileOptions options = options_for(folder);
  options.pictures = false;
  const auto corners = [&](uint8_t profile) {
    options.mesh_profile = profile;
    const mux::Report summary = mux_file(options);
    CHECK(json_of(summary)["mesh"]["profile"] == (profile == FVV_MESH_FAST ? "fast" : "raw"));
    Stream stream(options.output);
    fvv_mesh mesh;
    stream.mesh(1, mesh);
    std::multiset<std::array<int32_t, 3>> out;
    for (size_t i = 0; i < 3 * size_t(mesh.face_count); i++) {
      const int32_t *p = mesh.lattice + 3 * size_t(mesh.faces[i]);
      out.insert({p[0], p[1], p[2]});
    }
    fvv_mesh_free(&mesh);
    return out;
  };
  CHECK(corners(FVV_MESH_FAST) == corners(FVV_MESH_RAW));
}

TEST_CASE("a live stream has no index, and readers make one") {
  const Folder folder;
  make_capture(folder);
  FileOptions options = options_for(folder);
  options.live = options.verify = true;
  const mux::Report summary = mux_file(options);
  CHECK(summary.verdict->meshes == 5);
  Stream stream(options.output);
  CHECK(fvv_stream_index_state(stream.handle()) == FVV_INDEX_REBUILT);
  CHECK(fvv_stream_damage_count(stream.handle()) == 0);
  CHECK(stream.frames() == 5);
  options.live = false;
  CHECK(mux_file(options).bytes > summary.bytes);
}

TEST_CASE("verification finds another mesh, another picture, another camera") {
  const Folder folder;
  const scene::Capture capture = make_capture(folder);
  FileOptions options = options_for(folder);
  options.verify = true;
  Encoded encoded = encode_file(options);
  const double step = encoded.report.lattice.step;
  const mux::Verdict verdict = encoded.verify(options.output);
  CHECK(verdict.mesh.max_vertex_error > 0);
  CHECK(verdict.mesh.max_vertex_error <= (0.5 + encoded.report.lattice.delta_error) * step * (1 + 1e-9));
  CHECK(verdict.max_reprojection == 0);
  CHECK(verdict.videos[0].min_psnr > 35);
  const auto complaint = [&] {
    try {
      encoded.verify(options.output);
      return std::string();
    } catch (const fvv::Error &error) {
      return error.in(fvv::Spelling::command_line);
    }
  };
  encoded.plan.capture.cameras[1].calibration.fx += 1e-3;
  CHECK(complaint() == options.output + ": camera 13 is not the camera of the capture");
  encoded.plan.capture.cameras[1].calibration.fx -= 1e-3;
  scene::write_mesh(ball(4), {}, capture.mesh_path(3));
  CHECK(complaint().find(options.output + ": frame 3: decoded vertex ") == 0);
  FileOptions keys = options;
  keys.delta = keys.verify = false;
  keys.output = folder.path("keys.fvv");
  Encoded alone = encode_file(keys); // of the mesh that is there now
  scene::write_mesh(ball(5), {}, capture.mesh_path(3));
  alone.origins = {std::vector<mux::MeshOrigins>(5)};
  CHECK_THROWS_WITH(alone.verify(keys.output),
                    keys.output + ": frame 3: the decoded mesh has other faces than " + capture.mesh_path(3));
  scene::write_mesh(ball(3), {}, capture.mesh_path(3));
  for (const scene::Camera &camera : capture.cameras)
    write_png(capture.picture_path(camera, 2), media::make_image(64, 48, 3, 200));
  CHECK(complaint().find(options.output + ": frame 2: ") == 0);
  CHECK(complaint().find(" dB of luma PSNR, expected at least ") != std::string::npos);
}

TEST_CASE("groups are collected in order, few at a time, and the first failure counts") {
  const std::vector<size_t> group_of = {0, 1, 0, 2, 2, 2, 3, 4, 5, 6, 7};
  for (const unsigned threads : {1u, 3u, 16u}) {
    std::vector<size_t> order;
    std::atomic<size_t> collected{0}, most{0}, rests{0};
    run_ordered(
        threads, group_of,
        [&](size_t piece) {
          const size_t ahead = group_of[piece] - collected;
          for (size_t seen = most; ahead > seen && !most.compare_exchange_weak(seen, ahead);) continue;
          std::this_thread::sleep_for(std::chrono::milliseconds(piece % 3));
        },
        [&](size_t group) {
          order.push_back(group);
          collected++;
        },
        [&] { rests++; });
    CHECK(rests == threads);
    CHECK(order == std::vector<size_t>{0, 1, 2, 3, 4, 5, 6, 7});
    CHECK(most <= threads);
    CHECK_THROWS_WITH(run_ordered(
                          threads, group_of,
                          [&](size_t piece) {
                            if (piece == 3) std::this_thread::sleep_for(std::chrono::milliseconds(20));
                            if (piece >= 3) throw std::runtime_error("piece " + std::to_string(piece));
                          },
                          [](size_t) {}),
                      "piece 3");
    CHECK_THROWS_WITH(run_ordered(
                          threads, group_of, [](size_t) {}, [](size_t) { throw std::runtime_error("full"); }),
                      "full");
  }
}

TEST_CASE("encoding changes nothing of a plan, and what it settles is in the decisions") {
  const Folder folder;
  Shape shape = with_masks();
  make_capture(folder, shape);
  FileOptions options = options_for(folder);
  options.visibility = mux::Visibility::automatic;
  options.ladder = {{1}, {0.5}};
  options.mesh_ladder = mux::MeshLadder::automatic;
  options.keep_geometry = false;
  options.max_error = mux::MaxError{2, mux::MaxError::pixels};
  mux::PlanData data;
  data.plan = mux::make_plan(options, {});
  const std::string before = mux::save_plan(data);
  std::string stream;
  const mux::Sink sink = [&](const void *bytes, size_t size) {
    stream.append(static_cast<const char *>(bytes), size);
  };
  mux::EncodeJob job(data.plan, sink);
  job.run();
  job.finish(std::chrono::steady_clock::now());
  CHECK(mux::save_plan(data) == before);
  const mux::Decisions decisions = job.decisions();
  REQUIRE(decisions.videos.size() == data.plan.tracks.size());
  for (const mux::VideoDecision &video : decisions.videos) CHECK(!video.record.empty());
  REQUIRE(decisions.meshes.size() == data.plan.meshes.size());
  CHECK(decisions.meshes[0].sent);
  CHECK(data.plan.visibility.open);
  CHECK(decisions.visibility.reason.find(" of the pictures' bytes in the first group, ") !=
        std::string::npos);
  CHECK(decisions.nominal.rates.count(mux::camera_track) == 1);
  // The same plan and the same decisions give the same stream again.
  std::string again;
  const mux::Sink other = [&](const void *bytes, size_t size) {
    again.append(static_cast<const char *>(bytes), size);
  };
  mux::EncodeJob repeated(data.plan, other);
  repeated.run();
  repeated.finish(std::chrono::steady_clock::now());
  CHECK(again == stream);
}

TEST_CASE("a report is usable when capture, options and muxer are gone") {
  std::optional<mux::Report> report;
  std::string name;
  {
    const Folder folder;
    make_capture(folder, with_masks());
    FileOptions options = options_for(folder);
    options.verify = true;
    mux::Muxer muxer(options, {});
    cli::OutputFile output(options.output, false);
    report.emplace(muxer.run([&](const void *bytes, size_t size) { output.write(bytes, size); }));
    output.commit();
    report->verdict = muxer.verify(options.output, options.output);
    name = folder.path("in");
  }
  REQUIRE(!fs::exists(name));
  const mux::Report copy = *report;
  report.reset();
  CHECK(copy.frames == 5);
  CHECK(copy.videos[0].cameras.size() == 3);
  CHECK(copy.verdict->meshes == 5);
  const nlohmann::ordered_json json = json_of(copy);
  CHECK(json["frames"] == copy.frames);
  CHECK(json["bytes"] == copy.bytes);
  CHECK(json["verified"]["meshes"] == 5);
  CHECK(text_of(copy).find("out.fvv: " + std::to_string(copy.bytes) + " bytes, 5 frames") == 0);
}
