// fvvmux --ladder: coarser meshes for lower rungs, with visibility and colours of their own.
#include "ladder_fixture.h"

#include "fvv_mux/encoder.h"
#include "fvv_mux/report.h"
#include "fvvdemux/demux.h"
#include "mux/src/ladder/mesh_rungs.h"

namespace {

// A closed surface with waves that move, of far more faces than small pictures need.
geometry::Mesh bumps(int64_t frame, uint32_t columns) {
  constexpr uint32_t rows = 40;
  geometry::Mesh mesh;
  const auto vertex = [&](double polar, double around) {
    const double radius = 0.5 + 0.05 * std::sin(3 * polar + 0.2 * double(frame)) * std::cos(2 * around);
    mesh.positions.push_back(radius * std::sin(polar) * std::cos(around));
    mesh.positions.push_back(radius * std::cos(polar));
    mesh.positions.push_back(radius * std::sin(polar) * std::sin(around));
  };
  vertex(0, 0);
  for (uint32_t r = 1; r < rows; r++)
    for (uint32_t c = 0; c < columns; c++) vertex(M_PI * r / rows, 2 * M_PI * c / columns);
  vertex(M_PI, 0);
  const auto at = [&](uint32_t r, uint32_t c) { return 1 + (r - 1) * columns + c % columns; };
  for (uint32_t c = 0; c < columns; c++) {
    mesh.faces.insert(mesh.faces.end(), {0, at(1, c + 1), at(1, c)});
    for (uint32_t r = 1; r + 1 < rows; r++)
      mesh.faces.insert(mesh.faces.end(),
                        {at(r, c), at(r, c + 1), at(r + 1, c), at(r, c + 1), at(r + 1, c + 1), at(r + 1, c)});
    mesh.faces.insert(mesh.faces.end(),
                      {uint32_t(mesh.vertex_count() - 1), at(rows - 1, c), at(rows - 1, c + 1)});
  }
  return mesh;
}

// Frames have the same faces in groups of 2, 2 and 1, or each its own.
FileOptions dense(const Folder &folder, bool tracked) {
  FileOptions options = three_rungs(folder);
  const scene::Capture capture = scene::load_capture(scene::description_file(options.capture));
  for (int64_t i = 0; i < 5; i++)
    scene::write_mesh(bumps(i, tracked ? 48 : 48 + 2 * uint32_t(i)), {{0, 0, 0}, 1e-6}, capture.mesh_path(i));
  options.keep_geometry = false;
  options.max_error = mux::MaxError{0.05, mux::MaxError::pixels};
  options.visibility = mux::Visibility::weights;
  options.colours = mux::Colours::on;
  return options;
}

struct Kind {
  uint32_t type;
  uint8_t kind;
  uint16_t group; // of alternatives
  std::array<uint16_t, 3> ids;
};
const Kind kinds[] = {{FVV_CHUNK_MESH, FVV_TRACK_MESH, 2, {1, 10, 13}},
                      {FVV_CHUNK_VISIBILITY, FVV_TRACK_VISIBILITY, 3, {5, 11, 14}},
                      {FVV_CHUNK_COLOURS, FVV_TRACK_COLOURS, 4, {7, 12, 15}}};

} // namespace

TEST_CASE("lower rungs have coarser meshes, with visibility and colours of their own") {
  const bool tracked = GENERATE(false, true);
  const Folder folder;
  const FileOptions options = dense(folder, tracked);
  const mux::Report summary = mux_file(options); // verifies
  CHECK(summary.has_constant_topology == tracked);
  CHECK((summary.delta.chunks > 0) == tracked);
  REQUIRE(summary.lower_meshes.size() == 2);
  CHECK(summary.lower_meshes[1].max_error == 4 * summary.budget.max_error);
  Stream stream(options.output);
  const fvv_configuration &configuration = stream.configuration();
  for (const Kind &kind : kinds)
    for (uint16_t rung = 0; rung < 3; rung++) {
      const fvv_track *track = fvv_configuration_track(&configuration, kind.ids[rung]);
      REQUIRE(track);
      CHECK(track->kind == kind.kind);
      CHECK(track->alternate_group == kind.group);
      CHECK(track->rank == rung);
      CHECK(track->bit_rate > 0);
      CHECK((track->size > 0) == (kind.kind == FVV_TRACK_MESH));
    }
  const std::vector<RungInfo> rungs = rungs_of(configuration);
  REQUIRE(rungs.size() == 3);
  CHECK(rungs[0].tracks == std::vector<uint16_t>{1, 2, 5, 7});
  CHECK(rungs[2].tracks == std::vector<uint16_t>{9, 13, 14, 15});
  for (size_t frame = 0; frame < 5; frame++) {
    uint32_t faces = UINT32_MAX;
    for (size_t rung = 0; rung < 3; rung++) {
      OwnedMesh mesh;
      REQUIRE(fvv_stream_mesh(stream.handle(), frame, kinds[0].ids[rung], &mesh, nullptr) == FVV_OK);
      CHECK(mesh.face_count < faces);
      faces = mesh.face_count;
      const fvv_visibility *seen = nullptr;
      REQUIRE(fvv_stream_visibility(stream.handle(), frame, kinds[1].ids[rung], &seen, nullptr) == FVV_OK);
      REQUIRE(seen);
      CHECK(seen->header.mesh_track == kinds[0].ids[rung]);
      CHECK(seen->header.vertex_count == mesh.vertex_count);
      const uint8_t *colours = nullptr;
      uint32_t count = 0;
      REQUIRE(fvv_stream_colours(stream.handle(), frame, kinds[0].ids[rung], &colours, &count, nullptr) ==
              FVV_OK);
      CHECK(count == mesh.vertex_count);
    }
  }
  for (size_t k = 0; k < 2; k++) {
    CHECK(summary.verdict->lower_meshes[k].meshes == 5);
    CHECK(summary.verdict->lower_meshes[k].visible == 5);
    CHECK(summary.lower_meshes[k].payload() < summary.meshes(k).payload());
  }
  uint64_t payload = 0;
  for (const Chunk &chunk : only(chunks_of(read_bytes(options.output), false), in_group))
    payload += chunk.payload.size();
  CHECK(payload == summary.meshes(0).payload() + summary.meshes(1).payload() + summary.meshes(2).payload() +
                       summary.videos[0].payload + summary.videos[1].payload + summary.videos[2].payload);

  // The error is that many pixels of the rung's own pictures.
  const nlohmann::ordered_json json = json_of(summary);
  for (size_t rung = 0; rung < 3; rung++) {
    const nlohmann::ordered_json &meshes = json["ladder"][rung]["meshes"];
    CHECK(meshes["rung"] == rung);
    CHECK(meshes["track"] == kinds[0].ids[rung]);
    CHECK(meshes["max_error"] == Approx(0.05 * double(1u << rung)));
    CHECK(meshes["rms_pixels"] <= 0.05);
    CHECK(meshes["bytes"] == summary.meshes(rung).mesh.payload);
    CHECK(meshes.contains("saving") == (rung > 0));
    if (rung) CHECK(meshes["verified"]["meshes"] == 5);
  }
  CHECK(json["mesh"]["bytes"] == summary.mesh.payload);
  const std::string text = text_of(summary);
  for (const char *part : {"rung 1: error 0.1 px", "rung 2: error 0.2 px", "; meshes of its own save ",
                           "and 5 meshes of rung 2"})
    CHECK(text.find(part) != std::string::npos);
}

TEST_CASE("a rung is whole before the better ones begin") {
  const Folder folder;
  const FileOptions options = dense(folder, false);
  mux_file(options);
  std::vector<uint16_t> order;
  for (const Chunk &chunk : chunks_of(read_bytes(options.output), false))
    if (chunk.time == 2 && in_group(chunk)) order.push_back(chunk.track);
  CHECK(order == std::vector<uint16_t>{13, 14, 15, 9, 10, 11, 12, 8, 1, 5, 7, 2});
}

TEST_CASE("the first rung has the meshes of the stream without a ladder, and threads change nothing",
          "[slow][long]") {
  const Folder folder;
  FileOptions options = dense(folder, true);
  mux_file(options);
  const std::string bytes = read_bytes(options.output);
  const auto first = [&] {
    return only(chunks_of(read_bytes(options.output), false), [](const Chunk &chunk) {
      return in_group(chunk) &&
             (chunk.track == 1 || chunk.track == 2 || chunk.track == 5 || chunk.track == 7);
    });
  };
  const std::vector<Chunk> best = first();
  for (const uint32_t threads : {1u, 5u}) {
    options.threads = threads;
    mux_file(options);
    CHECK(read_bytes(options.output) == bytes);
  }
  options.ladder.clear();
  mux_file(options);
  CHECK(first() == best);
}

TEST_CASE("meshes of a rung's own can be forbidden and asked for, and need decimation") {
  const Folder folder;
  FileOptions options = dense(folder, false);
  options.verify = false;
  const auto meshes = [&] {
    const mux::Report summary = mux_file(options);
    return json_of(summary)["ladder"][2]["meshes"];
  };
  options.mesh_ladder = mux::MeshLadder::off;
  nlohmann::ordered_json found = meshes();
  CHECK(found["rung"] == 0);
  CHECK(found["track"] == 1);
  CHECK(found["reason"] == "as --mesh-ladder says");
  CHECK(Stream(options.output).configuration().track_count == 6);
  options.mesh_ladder = mux::MeshLadder::automatic;
  options.keep_geometry = true;
  found = meshes();
  CHECK(found["rung"] == 0);
  CHECK(found["reason"] == "as --keep-geometry says");
  options.mesh_ladder = mux::MeshLadder::on;
  CHECK_THROWS_WITH(mux::make_plan(options, {}), Catch::Matchers::Contains("as keep-geometry says"));
  options.keep_geometry = false;
  CHECK(meshes()["rung"] == 2);
  options.meshes = false;
  CHECK_THROWS_WITH(mux::make_plan(options, {}), Catch::Matchers::Contains("there are no meshes"));
  options.meshes = true;
  options.ladder.clear();
  CHECK_THROWS_AS(mux::make_plan(options, {}), fvv::Error);

  mux::set_option(options, "mesh-ladder", "off");
  CHECK(options.mesh_ladder == mux::MeshLadder::off);
  CHECK_THROWS_AS(mux::set_option(options, "mesh-ladder", "yes"), fvv::Error);
  const ToolResult run = run_tool({folder.path("in"), "-o", folder.path("x.fvv"), "--mesh-ladder", "on"});
  CHECK(run.exit == 2);
  CHECK(run.err.find("--ladder") != std::string::npos);
}

TEST_CASE("what coarser meshes lose is one warning for each rung") {
  const Folder folder;
  FileOptions options = dense(folder, false);
  const scene::Capture capture = scene::load_capture(scene::description_file(options.capture));
  for (int64_t i = 0; i < 5; i++) {
    geometry::Mesh mesh = bumps(i, 48 + 2 * uint32_t(i));
    const auto first = uint32_t(mesh.vertex_count());
    const geometry::Mesh speck = ball(0);
    for (size_t k = 0; k < speck.positions.size(); k++)
      mesh.positions.push_back((k % 3 ? 0 : 0.8) + 0.01 * speck.positions[k]);
    for (const uint32_t corner : speck.faces) mesh.faces.push_back(first + corner);
    scene::write_mesh(mesh, {{0, 0, 0}, 1e-6}, capture.mesh_path(i));
  }
  options.max_error.reset();
  options.triangles = 400;
  size_t frames = 0, rungs = 0;
  std::set<std::string> kinds_of_loss;
  mux::Observer observer;
  observer.on_warning = [&](const std::string &text) {
    const std::string rung = capture.path + ": rung ";
    if (text.find(rung) != 0) {
      CHECK(text.find(": frame ") != std::string::npos);
      frames++;
      return;
    }
    rungs++;
    const char *kind = text.find(" vanish in decimation") == std::string::npos ? " thin" : " vanish";
    kinds_of_loss.insert(text.substr(rung.size(), 1) + kind);
  };
  const mux::Report summary = mux::Muxer(options, observer).run([](const void *, size_t) {});
  CHECK(summary.warned);
  CHECK(frames > 1); // of the first rung
  CHECK(kinds_of_loss.count("1 vanish") == 1);
  CHECK(kinds_of_loss.count("2 vanish") == 1);
  CHECK(rungs == kinds_of_loss.size());
}

TEST_CASE("a number of triangles falls with the size") {
  const Folder folder;
  FileOptions options = dense(folder, false);
  options.max_error.reset();
  options.triangles = 800;
  options.visibility = mux::Visibility::none;
  options.colours = mux::Colours::off;
  const mux::Report summary = mux_file(options);
  for (size_t rung = 0; rung < 3; rung++) {
    const double triangles = double(summary.meshes(rung).faces) / 5;
    CHECK(triangles <= 800 >> rung);
    CHECK(triangles > 0.9 * (800 >> rung));
  }
}

TEST_CASE("a rung has meshes of its own where they save a share of its bytes") {
  mux::Plan plan;
  plan.options.ladder = {{1}, {0.75}, {0.5}, {0.25}};
  for (size_t rung = 0; rung < 4; rung++) {
    plan.meshes.emplace_back();
    plan.meshes.back().rung = rung;
  }
  mux::Decisions decisions;
  const auto sent = [&](const std::vector<uint64_t> &meshes, const std::vector<uint64_t> &pictures) {
    decisions.meshes = mux::decide_mesh_rungs(plan, meshes, pictures);
    std::string out;
    for (size_t rung = 0; rung < 4; rung++)
      out += std::to_string(plan.meshes[decisions.mesh_of(plan, rung)].rung);
    return out;
  };
  // Each is compared with those that the rung would take otherwise.
  CHECK(sent({100, 94, 90, 80}, {1000, 900, 100, 50}) == "0023");
  CHECK(decisions.meshes[1].saving == Approx(0.006));
  CHECK(decisions.meshes[2].saving == Approx(0.05));
  CHECK(decisions.meshes[3].saving == Approx(10.0 / 140));
  CHECK(sent({100, 94, 91, 80}, {1000, 900, 100, 50}) == "0003");
  CHECK(sent({100, 100, 110, 100}, {0, 0, 0, 0}) == "0000"); // they may take more
  CHECK(sent({0, 0, 0, 0}, {0, 0, 0, 0}) == "0000");
  CHECK(!decisions.has_mesh_rungs(plan));
  plan.options.mesh_ladder = mux::MeshLadder::on;
  CHECK(sent({100, 100, 110, 100}, {0, 0, 0, 0}) == "0123");
  CHECK(decisions.has_mesh_rungs(plan));
}

TEST_CASE("a rung that shares the meshes of a better one, above one with its own") {
  const Folder folder;
  FileOptions options = dense(folder, false);
  options.ladder = {{1}, {0.99}, {0.25}}; // nearly the same error: nothing is saved
  const mux::Report summary = mux_file(options);
  CHECK(!summary.lower_meshes[0].sent);
  Stream stream(options.output);
  const std::vector<RungInfo> rungs = rungs_of(stream.configuration());
  REQUIRE(rungs.size() == 3);
  CHECK(rungs[1].tracks == std::vector<uint16_t>{1, 5, 7, 8});
  CHECK(rungs[2].tracks == std::vector<uint16_t>{9, 13, 14, 15});
  CHECK(fvv_configuration_track(&stream.configuration(), 13)->rank == 2);
  std::vector<uint16_t> order;
  for (const Chunk &chunk : chunks_of(read_bytes(options.output), false))
    if (chunk.time == 2 && in_group(chunk)) order.push_back(chunk.track);
  CHECK(order == std::vector<uint16_t>{13, 14, 15, 9, 1, 5, 7, 8, 2});
  CHECK(json_of(summary)["ladder"][1]["meshes"]["rung"] == 0);
  CHECK(text_of(summary).find("; meshes of rung 0: its own would save ") != std::string::npos);
  // Alone each is one rung, whatever the ranks of its tracks.
  Files files = segments_of(options.output);
  for (size_t rung = 0; rung < 3; rung++) {
    const std::string part = "rung-" + std::to_string(rung) + "/";
    std::string alone = files[part + "configuration.fvv"];
    for (int group = 0; group < 3; group++)
      alone += files[part + "group-00000" + std::to_string(group) + ".fvv"];
    std::set<uint16_t> tracks;
    for (const Chunk &chunk : only(chunks_of(alone, false), in_group)) tracks.insert(chunk.track);
    CHECK(std::vector<uint16_t>(tracks.begin(), tracks.end()) == rungs[rung].tracks);
    const std::string path = folder.path("alone" + std::to_string(rung) + ".fvv");
    write_bytes(path, alone.data(), alone.size());
    Stream opened(path);
    CHECK(rungs_of(opened.configuration()).size() == 1);
    for (const uint16_t track : rungs[rung].tracks) CHECK(in_rung(opened.configuration(), track, 0));
  }
}

TEST_CASE("fvvdemux takes the meshes of a rung") {
  const Folder folder;
  const FileOptions options = dense(folder, true);
  mux_file(options);
  size_t before = SIZE_MAX;
  for (const size_t rung : {size_t(0), size_t(1), size_t(7)}) {
    demux::Options chosen;
    chosen.rung = rung;
    demux::Result result;
    const std::string out = folder.path("back" + std::to_string(rung));
    demux::demux(options.output, out, chosen, result);
    CHECK(result.warnings.empty());
    CHECK(result.meshes == 5);
    const scene::Capture back = scene::load_capture(scene::description_file(out));
    const size_t faces = scene::load_mesh(back, 3).face_count();
    CHECK(faces < before);
    before = faces;
  }
}

TEST_CASE("frames from memory have rungs of meshes too") {
  mux::Configuration configuration;
  for (size_t k = 0; k < 2; k++) {
    mux::CameraInput input;
    input.calibration = camera_of(k, 64, 48).calibration;
    input.calibration.name = nullptr;
    input.calibration.name_size = 0;
    input.visibility = k == 1;
    configuration.cameras.push_back(input);
  }
  mux::Options options;
  options.codec = FVV_CODEC_JPEG;
  options.quality = {false, 40};
  options.group = 2;
  options.max_error = mux::MaxError{0.05, mux::MaxError::pixels};
  options.visibility = mux::Visibility::weights;
  options.ladder = {{1}, {0.5}};
  const Folder folder;
  const auto encode = [&](uint32_t threads) {
    options.threads = threads;
    std::string bytes;
    mux::Encoder encoder(configuration, options, [&](const void *data, size_t size) {
      bytes.append(static_cast<const char *>(data), size);
    });
    for (int64_t i = 0; i < 5; i++) {
      mux::Frame frame;
      if (i != 2) frame.mesh = bumps(i, 48); // the stage is empty
      for (size_t k = 0; k < 2; k++) frame.pictures.push_back(picture_of(k, 64, 48, 4 * i));
      frame.visibility = {{}, std::vector<uint8_t>(frame.mesh.vertex_count(), 255)};
      encoder.add(std::move(frame));
    }
    const mux::Report summary = encoder.finish();
    CHECK(summary.lower_meshes[0].mesh.chunks == 4);
    CHECK(summary.lower_meshes[0].faces < summary.faces);
    return bytes;
  };
  const std::string bytes = encode(1);
  CHECK(encode(3) == bytes);
  write_bytes(folder.path("out.fvv"), bytes.data(), bytes.size());
  Stream stream(folder.path("out.fvv"));
  const RungInfo low = rungs_of(stream.configuration())[1];
  for (size_t frame = 0; frame < 5; frame++) {
    size_t vertices[2] = {}, k = 0;
    for (const uint16_t track : {uint16_t(1), uint16_t(9)}) {
      OwnedMesh mesh;
      CHECK(fvv_stream_mesh(stream.handle(), frame, track, &mesh, nullptr) ==
            (frame == 2 ? FVV_END : FVV_OK));
      vertices[k++] = mesh.vertex_count;
    }
    CHECK((frame == 2 || vertices[1] < vertices[0]));
    const fvv_visibility *seen = nullptr;
    REQUIRE(fvv_stream_visibility(stream.handle(), frame, 10, &seen, nullptr) >= FVV_OK);
    CHECK((seen ? seen->header.vertex_count : 0) == vertices[1]);
  }
  CHECK(low.tracks == std::vector<uint16_t>{8, 9, 10, 11});
}
