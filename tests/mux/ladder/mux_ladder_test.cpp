// fvvmux --ladder: the pictures at several sizes in one stream, and a rung of it alone.
#include "ladder_fixture.h"

#include "fvv_mux/encoder.h"
#include "fvv_mux/report.h"
#include "fvvdemux/demux.h"
#include "mux/src/options/option_values.h"

TEST_CASE("a ladder has the pictures in each size, and says so") {
  const Folder folder;
  const FileOptions options = three_rungs(folder);
  const mux::Report summary = mux_file(options);
  CHECK(!summary.warned);
  Stream stream(options.output);
  const fvv_configuration &configuration = stream.configuration();
  REQUIRE(configuration.video_count == 3);
  const auto quality = [&](size_t k) { return summary.videos[k].quality; };
  const auto psnr = [&](size_t k) { return summary.videos[k].sample_psnr; };
  const uint16_t ids[] = {2, 8, 9};
  const uint32_t sides[][2] = {{64, 48}, {32, 24}, {16, 12}};
  for (size_t rung = 0; rung < 3; rung++) {
    const fvv_track *track = fvv_configuration_track(&configuration, ids[rung]);
    const fvv_video_layout *video = fvv_configuration_video(&configuration, ids[rung]);
    REQUIRE(track);
    REQUIRE(video);
    CHECK(track->alternate_group == 1);
    CHECK(track->rank == rung);
    CHECK(track->size == video->config.width * video->config.height);
    CHECK(track->bit_rate > 0);
    REQUIRE(video->tile_count == 3);
    CHECK(video->tiles[0].destination.width == sides[rung][0]);
    CHECK(video->tiles[0].destination.height == sides[rung][1]);
    CHECK(video->tiles[0].source.width == 64);
    CHECK((rung ? quality(rung) > quality(rung - 1) : quality(rung) == 20));
    CHECK(psnr(rung) > psnr(0) - 9.0 * double(rung) - 0.05); // of whole numbers the coarsest that has it
    if (rung) CHECK(psnr(rung) < psnr(rung - 1));
    CHECK(summary.verdict->videos[rung].pictures == 5);
  }
  CHECK(fvv_configuration_track(&configuration, 1)->alternate_group == 0);
  CHECK(fvv_configuration_track(&configuration, 1)->bit_rate > 0);

  const std::vector<RungInfo> rungs = rungs_of(configuration);
  REQUIRE(rungs.size() == 3);
  CHECK(rungs[1].tracks == std::vector<uint16_t>{1, 7, 8});
  CHECK(rungs[1].scale == 0.5);
  CHECK(rungs[0].bit_rate > rungs[1].bit_rate);

  const nlohmann::ordered_json json = json_of(summary);
  CHECK(json["video"]["width"] == 128);
  REQUIRE(json["ladder"].size() == 3);
  CHECK(json["ladder"][2]["scale"] == 0.25);
  CHECK(json["ladder"][2]["tracks"][0]["track"] == 9);
  CHECK(json["ladder"][2]["tracks"][0]["verified"]["pictures"] == 5);
  CHECK(json["ladder"][1]["picture_bytes"] == summary.videos[1].payload);
  CHECK(json["verified"]["pictures"] == 5);
  const std::string text = text_of(summary);
  for (const char *part : {"  rung 2  ", "  ladder    rung 0: ", "            rung 2: ", "at scale 0.25"})
    CHECK(text.find(part) != std::string::npos);
}

TEST_CASE("the first rung is the stream without a ladder, and threads change nothing") {
  const Folder folder;
  FileOptions options = three_rungs(folder);
  options.quality = {true, 36};
  mux_file(options);
  const std::string bytes = read_bytes(options.output);
  const std::vector<Chunk> best = samples_of(options.output, 2);
  CHECK(best.size() == 5);
  for (const uint32_t threads : {1u, 5u}) {
    options.threads = threads;
    mux_file(options);
    CHECK(read_bytes(options.output) == bytes);
  }
  options.ladder.clear();
  const mux::Report plain = mux_file(options);
  CHECK(samples_of(options.output, 2) == best);
  CHECK(!json_of(plain).contains("ladder"));
  Stream stream(options.output);
  for (size_t i = 0; i < stream.configuration().track_count; i++) {
    const fvv_track &track = stream.configuration().tracks[i];
    CHECK(track.alternate_group + track.rank + track.bit_rate + track.size == 0);
  }
}

TEST_CASE("low rungs come first") {
  const Folder folder;
  const FileOptions options = three_rungs(folder);
  mux_file(options);
  std::vector<uint16_t> order;
  for (const Chunk &chunk : chunks_of(read_bytes(options.output), false))
    if (chunk.time == 2 && in_group(chunk)) order.push_back(chunk.track);
  CHECK(order == std::vector<uint16_t>{1, 7, 9, 8, 2});
}

TEST_CASE("every codec has rungs") {
  const Folder folder;
  FileOptions options = three_rungs(folder);
  options.group = 5;
  for (const uint32_t codec :
       {FVV_CODEC_JPEG, FVV_CODEC_HVC1, FVV_CODEC_VP09, FVV_CODEC_AV01, FVV_CODEC_OEXR}) {
    options.codec = codec;
    options.bit_depth = media::find_video_codec(codec)->shallowest;
    options.quality = codec == FVV_CODEC_JPEG ? mux::Quality{false, 80} : mux::default_quality(codec);
    const mux::Report summary = mux_file(options);
    CHECK(summary.verdict->videos.size() == 3);
    CHECK(summary.videos[2].payload < summary.videos[0].payload);
  }
}

TEST_CASE("each track of several has rungs of its own, with the same cameras") {
  const Folder folder;
  FileOptions options = three_rungs(folder, with_masks());
  options.crop = mux::Crop::automatic;
  options.video_tracks = 2;
  const mux::Report summary = mux_file(options);
  REQUIRE(summary.videos.size() == 6);
  CHECK(summary.tile_track_count() == 2);
  for (size_t i = 0; i < 6; i++) {
    const mux::VideoTrackReport &track = summary.videos[i];
    CHECK(track.rung == i / 2);
    CHECK(track.part == i % 2);
    CHECK(track.alternate_group == i % 2 + 1);
    CHECK(track.cameras == summary.videos[i % 2].cameras);
  }
  Stream stream(options.output);
  CHECK(rungs_of(stream.configuration())[2].tracks == std::vector<uint16_t>{1, 7, 11, 12});
  const nlohmann::ordered_json json = json_of(summary);
  CHECK(json["video"].size() == 2);
  CHECK(json["ladder"][1]["tracks"].size() == 2);
  CHECK(text_of(summary).find("  rung 1 video 2") != std::string::npos);
}

TEST_CASE("rates of rungs") {
  const Folder folder;
  FileOptions options = three_rungs(folder);
  const auto targets = [&] {
    std::vector<uint64_t> out;
    const mux::Report report = mux_file(options);
    for (const mux::VideoTrackReport &track : report.videos) out.push_back(track.target_rate);
    return out;
  };
  options.bit_rate = 400000;
  CHECK(targets() == std::vector<uint64_t>{400000, 39685, 3937}); // 0.5 to the power of 10/3 each
  options.bit_rate = 0;
  options.ladder = mux::ladder_of_rates({400000, 100000});
  CHECK(options.ladder[1].scale == Approx(std::pow(0.25, 0.3)));
  CHECK(targets() == std::vector<uint64_t>{400000, 100000});
  Stream stream(options.output);
  CHECK(fvv_configuration_track(&stream.configuration(), 8)->bit_rate == 100000);
}

TEST_CASE("rungs of qualities have the full size and coarser meshes") {
  const Folder folder;
  FileOptions options = three_rungs(folder);
  options.ladder = mux::parse_ladder("ladder", "40dB,34dB,28dB");
  CHECK(mux::ladder_text(options.ladder) == "40dB,34dB,28dB");
  options.mesh_ladder = mux::MeshLadder::automatic;
  const mux::Report report = mux_file(options);
  REQUIRE(report.videos.size() == 3);
  for (size_t rung = 0; rung < 3; rung++) {
    CHECK(report.videos[rung].sample_psnr == Approx(40.0 - 6 * double(rung)).margin(1.5));
    CHECK(report.videos[rung].width == report.videos[0].width);
    CHECK(report.videos[rung].target_rate == 0);
    if (rung) CHECK(report.videos[rung].payload < report.videos[rung - 1].payload);
  }
  CHECK(report.target_psnr == 40.0);
  // Half of what 6 dB are worth by the rule of sizes.
  for (const mux::LowerMeshes &lower : report.lower_meshes)
    CHECK(lower.max_error == Approx(report.budget.max_error * std::exp2(6.0 / 18 * double(lower.rung))));
  CHECK(report.rung_scale(2) == 1);
  options.bit_rate = 400000;
  CHECK_THROWS_AS(mux_file(options), fvv::Error);
  options.bit_rate = 0;
  options.codec = FVV_CODEC_OEXR;
  options.bit_depth = 16;
  CHECK_THROWS_AS(mux_file(options), fvv::Error);
}

TEST_CASE("the scale of the first rung counts too") {
  const Folder folder;
  FileOptions options = three_rungs(folder);
  options.ladder = {{0.5}, {0.25}};
  options.tile = mux::TileSize{32, 24};
  mux_file(options);
  Stream stream(options.output);
  CHECK(stream.configuration().videos[0].tiles[0].destination.width == 16);
  CHECK(stream.configuration().videos[1].tiles[0].destination.width == 8);
}

TEST_CASE("ladders that are refused") {
  const Folder folder;
  FileOptions options = three_rungs(folder);
  using Ladder = std::vector<mux::Rung>;
  for (const Ladder &ladder :
       {Ladder{{1}}, Ladder{{1}, {1}}, Ladder{{0.5}, {1}}, Ladder{{1}, {0}}, Ladder{{1}, {-0.5}},
        Ladder{{2}, {1}}, Ladder{{1, 1000}, {0.5}}, Ladder{{1, 0, 36}, {1, 0, 40}}, Ladder{{1, 0, 40}, {1}},
        Ladder{{1, 0, 40}, {0.5, 0, 36}},
        Ladder{{0.9}, {0.8}, {0.7}, {0.6}, {0.5}, {0.4}, {0.3}, {0.2}, {0.1}}}) {
    options.ladder = ladder;
    CHECK_THROWS_AS(mux::make_plan(options, {}), fvv::Error);
  }
  for (const char *text :
       {"",         "1",       "1,1",      "0.5,1",     "1,0",
        "1,-0.5",   "1,0.5,",  "1,nan",    "1,8M",      "2M,8M",
        "8M,8M",    "8M,10",   "40dB",     "36dB,40dB", "40dB,40dB",
        "40dB,0.5", "40dB,1M", "40dB,xdB", "1,a",       "1,0.9,0.8,0.7,0.6,0.5,0.4,0.3,0.2"})
    CHECK_THROWS_AS(mux::parse_ladder("ladder", text), fvv::Error);
  CHECK(mux::parse_ladder("ladder", "1,0.5,0.25").size() == 3);
  const Ladder rates = mux::parse_ladder("ladder", "8M,2M,500k");
  CHECK(rates[2].bit_rate == 500000);
  CHECK(rates[2].scale == Approx(std::pow(1.0 / 16, 0.3)));
  const auto refused = [&](const std::vector<std::string> &more) {
    std::vector<std::string> words = {folder.path("in"), "-o", folder.path("out.fvv")};
    words.insert(words.end(), more.begin(), more.end());
    const ToolResult run = run_tool(words);
    CHECK(run.err.find("--ladder") != std::string::npos);
    return run.exit == 2;
  };
  CHECK(refused({"--ladder", "1,2"}));
  CHECK(refused({"--ladder", ""}));
  CHECK(refused({"--ladder", "8M,2M", "--quality", "30"}));
  CHECK(refused({"--ladder", "8M,2M", "--bitrate", "8M"}));
  CHECK(refused({"--ladder", "1,0.5", "--no-pictures"}));
}

TEST_CASE("a rung alone is a stream with the chunks that it has in the whole one") {
  const Folder folder;
  const FileOptions options = three_rungs(folder);
  mux_file(options);
  const std::string whole = read_bytes(options.output);
  const std::vector<Chunk> all = only(chunks_of(whole, false), in_group);
  const std::vector<std::vector<uint16_t>> tracks = {{1, 2, 7}, {1, 7, 8}, {1, 7, 9}};
  Files files = segments_of(options.output);
  const nlohmann::json manifest = nlohmann::json::parse(files["manifest.json"]);
  REQUIRE(manifest["rungs"].size() == 3);
  for (size_t rung = 0; rung < 3; rung++) {
    const std::string folder_of = "rung-" + std::to_string(rung) + "/";
    CHECK(manifest["rungs"][rung]["tracks"] == tracks[rung]);
    std::string alone = files[folder_of + "configuration.fvv"];
    for (int group = 0; group < 3; group++) {
      const std::string name = folder_of + "group-00000" + std::to_string(group) + ".fvv";
      CHECK(manifest["rungs"][rung]["groups"][group]["bytes"] == files[name].size());
      alone += files[name];
    }
    std::vector<uint32_t> numbers;
    const std::vector<Chunk> found = only(chunks_of(alone, false, &numbers), in_group);
    CHECK(numbers == std::vector<uint32_t>{0, 1, 2});
    CHECK(found == only(all, [&](const Chunk &chunk) {
            return std::count(tracks[rung].begin(), tracks[rung].end(), chunk.track) > 0;
          }));
    // One that begins in the middle keeps its number.
    numbers.clear();
    chunks_of(files[folder_of + "configuration.fvv"] + files[folder_of + "group-000002.fvv"], true, &numbers);
    CHECK(numbers == std::vector<uint32_t>{2});
  }
  // From rung to rung at groups: one stream.
  const std::string mixed = files["rung-2/configuration.fvv"] + files["rung-2/group-000000.fvv"] +
                            files["rung-0/configuration.fvv"].substr(24) + files["rung-0/group-000001.fvv"] +
                            files["rung-1/configuration.fvv"].substr(24) + files["rung-1/group-000002.fvv"];
  std::vector<uint32_t> numbers;
  chunks_of(mixed, false, &numbers);
  CHECK(numbers == std::vector<uint32_t>{0, 1, 2});
  CHECK(manifest["groups"][1]["file"] == "rung-0/group-000001.fvv");
  CHECK(manifest["groups"][1]["sequence"] == 1);
}

TEST_CASE("a rung that was written alone is the only one of its stream") {
  const Folder folder;
  const FileOptions options = three_rungs(folder);
  mux_file(options);
  Files files = segments_of(options.output);
  const std::string alone = files["rung-1/configuration.fvv"] + files["rung-1/group-000000.fvv"];
  const std::string path = folder.path("alone.fvv");
  write_bytes(path, alone.data(), alone.size());
  Stream stream(path);
  const fvv_configuration &configuration = stream.configuration();
  CHECK(fvv_configuration_track(&configuration, 8)->alternate_group == 0);
  CHECK(fvv_configuration_track(&configuration, 8)->rank == 0);
  CHECK(rungs_of(configuration).size() == 1);
  for (const size_t rung : {size_t(0), size_t(1), size_t(65535)}) {
    CHECK(in_rung(configuration, 8, rung));
    CHECK(in_rung(configuration, 1, rung));
  }
  CHECK(!segments_of(path).count("rung-0/configuration.fvv"));
}

TEST_CASE("ranks with holes, and numbers beyond the last") {
  const auto track = [](uint16_t id, uint16_t group, uint16_t rank) {
    fvv_track out = {};
    out.id = id;
    out.kind = FVV_TRACK_VIDEO;
    out.alternate_group = group;
    out.rank = rank;
    return out;
  };
  const std::vector<fvv_track> tracks = {track(1, 0, 0),     track(2, 9, 7), track(3, 9, 0),
                                         track(4, 9, 65535), track(5, 8, 0), track(6, 8, 1)};
  CHECK(rung_count(tracks.data(), tracks.size()) == 4);
  CHECK(rung_count(nullptr, 0) == 1);
  const auto rung = [&](size_t number) {
    std::vector<uint16_t> out;
    for (const fvv_track &one : tracks)
      if (in_rung(tracks.data(), tracks.size(), one, number)) out.push_back(one.id);
    return out;
  };
  CHECK(rung(0) == std::vector<uint16_t>{1, 3, 5});
  CHECK(rung(1) == std::vector<uint16_t>{1, 3, 6}); // the first one's rank, and of group 9 the nearest better
  CHECK(rung(2) == std::vector<uint16_t>{1, 2, 6});
  CHECK(rung(3) == std::vector<uint16_t>{1, 4, 6});
  CHECK(rung(SIZE_MAX) == rung(3));
}

TEST_CASE("colours of a mesh that a rung lacks are left out with it") {
  ConfigurationBlock block;
  uint8_t payload[64];
  size_t size = 0;
  const auto add = [&](uint32_t type, uint16_t id) {
    fvv_chunk_header header = {};
    header.type = type;
    header.track = id;
    header.size = size;
    block.add(header, payload);
  };
  fvv_scene scene = {};
  scene.time_base = {1, 25};
  scene.frame_duration = 1;
  scene.lattice_step = 1;
  REQUIRE(fvv_scene_encode(&scene, payload, sizeof payload, &size, nullptr) == FVV_OK);
  add(FVV_CHUNK_SCENE, 0);
  for (const uint16_t id : {1, 2, 3}) {
    fvv_track track = {};
    track.id = id;
    track.kind = id == 3 ? FVV_TRACK_COLOURS : FVV_TRACK_MESH;
    track.alternate_group = id == 3 ? 0 : 1;
    track.rank = uint16_t(id == 2);
    track.name = "";
    REQUIRE(fvv_track_encode(&track, payload, sizeof payload, &size, nullptr) == FVV_OK);
    add(FVV_CHUNK_TRACK, id);
  }
  // Steps, mesh track, 4 vertices, cells of 1, of which there is 1.
  const uint8_t colours[] = {1, 1, 2, 0, 4, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
  fvv_chunk_header header = {};
  header.type = FVV_CHUNK_COLOURS;
  header.track = 3;
  header.flags = FVV_FLAG_KEY;
  header.size = sizeof colours;
  for (const size_t rung : {size_t(0), size_t(1)}) {
    RungGroup group(block, rung);
    CHECK(group.begin(5, 0, 1).size() == 32 + 24);
    CHECK(group.chunk(header, colours).empty() == (rung == 0));
    CHECK(!group.end().empty());
  }
}

TEST_CASE("fvvdemux takes one rung") {
  const Folder folder;
  const FileOptions options = three_rungs(folder);
  mux_file(options);
  for (const size_t rung : {size_t(0), size_t(1), size_t(7)}) {
    demux::Options chosen;
    chosen.rung = rung;
    demux::Result result;
    const std::string out = folder.path("back" + std::to_string(rung));
    demux::demux(options.output, out, chosen, result);
    CHECK(result.warnings.empty());
    CHECK(result.meshes == 5);
    CHECK(result.pictures.size() == 3);
    const media::Image picture = media::read_image<uint8_t>(out + "/cam13/0002.png", 3);
    CHECK(picture.width == (rung == 0 ? 64u : rung == 1 ? 32u : 16u));
  }
}

TEST_CASE("frames from memory have rungs too") {
  mux::Configuration configuration;
  configuration.meshes = false;
  const auto camera = [](uint16_t id) {
    mux::CameraInput input;
    input.calibration = camera_of(id, 64, 48).calibration;
    input.calibration.name = nullptr;
    input.calibration.name_size = 0;
    input.masks = true;
    return input;
  };
  configuration.cameras = {camera(0), camera(1)};
  mux::Options options;
  options.codec = FVV_CODEC_JPEG;
  options.quality = {false, 80};
  options.group = 2;
  options.ladder = {{1}, {0.5}};
  const auto encode = [&](uint32_t threads) {
    options.threads = threads;
    std::string bytes;
    mux::Encoder encoder(configuration, options, [&](const void *data, size_t size) {
      bytes.append(static_cast<const char *>(data), size);
    });
    for (int64_t i = 0; i < 5; i++) {
      mux::Frame frame;
      for (size_t k = 0; k < 2; k++) {
        frame.pictures.push_back(picture_of(k, 64, 48, 4 * i));
        frame.masks.push_back(mask_of(64, 48, 4 * i));
      }
      encoder.add(std::move(frame));
    }
    encoder.finish();
    return bytes;
  };
  const std::string bytes = encode(1);
  CHECK(encode(3) == bytes);
  const Folder folder;
  write_bytes(folder.path("out.fvv"), bytes.data(), bytes.size());
  Stream stream(folder.path("out.fvv"));
  REQUIRE(stream.configuration().video_count == 2);
  CHECK(stream.frames() == 5);
  // Later groups are laid out in each rung's own size.
  size_t layouts[2] = {};
  for (size_t group = 0; group < 3; group++)
    for (size_t rung = 0; rung < 2; rung++) {
      const fvv_video_layout &video = stream.configuration().videos[rung];
      size_t count = 0;
      const fvv_tile *tiles = nullptr;
      REQUIRE(fvv_stream_tiles(stream.handle(), group, video.track, &tiles, &count, nullptr) == FVV_OK);
      REQUIRE(count == 2);
      for (size_t k = 0; k < 2; k++)
        CHECK(double(tiles[k].destination.width) / tiles[k].source.width ==
              Approx(rung ? 0.5 : 1).epsilon(0.1));
      layouts[rung]++;
    }
  CHECK(layouts[1] == 3);
  configuration.encoded.clear();
  configuration.cameras.clear();
  configuration.meshes = true;
  mux::Encoder nothing(configuration, options, [](const void *, size_t) {});
  mux::Frame frame;
  frame.mesh = ball(0);
  nothing.add(frame);
  CHECK_THROWS_AS(nothing.finish(), fvv::Error);
}
