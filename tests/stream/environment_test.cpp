// Environments in a stream: found from every group, the same under one configuration, and checked by the
// checker.
#include "../environment/environment_fixture.h"
#include "stream_fixture.h"

#include <iterator>

namespace {

constexpr uint16_t mesh_track = 1, environment_track = 2;

Chunk environment_chunk(int64_t time, const Bytes &payload, uint16_t track = environment_track) {
  return {FVV_CHUNK_ENVIRONMENT, track, FVV_FLAG_KEY, time, payload};
}

// Groups of two frames of 2 ticks with a mesh each; the environment after the second frame of the first.
Stream stage(int groups, const Bytes &payload, bool repeat = false) {
  Stream out;
  out.configuration = {scene_chunk(), track_chunk(mesh_track, FVV_TRACK_MESH),
                       track_chunk(environment_track, FVV_TRACK_ENVIRONMENT)};
  out.repeat = repeat;
  for (int g = 0; g < groups; g++)
    out.groups.push_back({4 * g, 4 * g + 4, {mesh_chunk(4 * g, 2 * g), mesh_chunk(4 * g + 2, 2 * g + 1)}});
  out.groups[0].chunks.push_back(environment_chunk(2, payload));
  return out;
}

// The environment that two streams of different configurations have when they follow each other.
Bytes other_payload() {
  Environment environment;
  environment.step = 0.5;
  return environment.payload();
}

Bytes vector_bytes() {
  std::ifstream file(FVV_CASES "/vector_environment_stage/input.fvv", std::ios::binary);
  return Bytes(std::istreambuf_iterator<char>(file), {});
}

// Of the vector: raw meshes alone, for a decoder without other profiles.
Bytes raw_payload() {
  Environment environment;
  environment.meshes[1] = square_mesh(40, false);
  return environment.payload();
}

} // namespace

TEST_CASE("the environment is found from every group, with the configuration repeated or not") {
  const Bytes payload = Environment().payload();
  for (const bool repeat : {false, true}) {
    const Opened opened(write(stage(4, payload, repeat)));
    REQUIRE(opened.status == FVV_OK);
    const fvv_environment *first = nullptr;
    for (const size_t group : {3, 0, 2, 1}) {
      const fvv_environment *environment = nullptr;
      REQUIRE(fvv_stream_environment(opened.stream, group, environment_track, &environment, nullptr) ==
              FVV_OK);
      REQUIRE(environment->part_count == 2);
      CHECK(Bytes(environment->payload, environment->payload + payload.size()) == payload);
      CHECK((!first || first == environment));
      first = environment;
      fvv_mesh mesh;
      REQUIRE(fvv_environment_mesh(environment, 0, nullptr, nullptr, &mesh, nullptr) == FVV_OK);
      CHECK(mesh.texture_bits == 4);
      fvv_mesh_free(&mesh);
    }
  }
}

TEST_CASE("frames of the action are what they are without an environment") {
  Stream with = stage(3, Environment().payload()), without = with;
  without.groups[0].chunks.pop_back();
  const Opened a(write(with)), b(write(without));
  REQUIRE(fvv_stream_frame_count(a.stream) == fvv_stream_frame_count(b.stream));
  const fvv_environment *environment;
  CHECK(fvv_stream_environment(a.stream, 0, mesh_track, &environment, nullptr) == FVV_END);
  CHECK(fvv_stream_environment(a.stream, 0, 77, &environment, nullptr) == FVV_END);
  CHECK(fvv_stream_environment(b.stream, 2, environment_track, &environment, nullptr) == FVV_END);
  CHECK(!environment);
  fvv_diagnostic diagnostic;
  CHECK(fvv_stream_environment(a.stream, 3, environment_track, &environment, &diagnostic) ==
        FVV_ERROR_ARGUMENT);
}

TEST_CASE("another configuration has another environment, or none") {
  const Bytes payload = Environment().payload();
  Stream stream = stage(2, payload);
  Bytes bytes;
  const fvv_output output = {append, &bytes};
  fvv_writer *writer = nullptr;
  REQUIRE(fvv_writer_create(&output, nullptr, &writer, nullptr) == FVV_OK);
  int64_t shift = 0;
  for (const bool lit : {true, false, true}) {
    for (const Chunk &chunk : stream.configuration)
      REQUIRE(fvv_writer_configuration(writer, chunk.type, chunk.track, chunk.flags, chunk.payload.data(),
                                       chunk.payload.size(), nullptr) == FVV_OK);
    const std::string text = "{\"act\": " + std::to_string(shift) + "}";
    REQUIRE(fvv_writer_configuration(writer, FVV_CHUNK_METADATA, 0, 0, text.data(), text.size(), nullptr) ==
            FVV_OK);
    for (const Group &group : stream.groups) {
      REQUIRE(fvv_writer_begin_group(writer, group.start + shift, group.end + shift, nullptr) == FVV_OK);
      for (const Chunk &chunk : group.chunks) {
        const Bytes content = chunk.type == FVV_CHUNK_ENVIRONMENT && shift ? other_payload() : chunk.payload;
        if (chunk.type != FVV_CHUNK_ENVIRONMENT || lit)
          REQUIRE(fvv_writer_chunk(writer, chunk.type, chunk.track, chunk.flags, chunk.time + shift,
                                   content.data(), content.size(), nullptr) == FVV_OK);
      }
      REQUIRE(fvv_writer_end_group(writer, nullptr) == FVV_OK);
    }
    shift += 8;
  }
  REQUIRE(fvv_writer_finish(writer, nullptr) == FVV_OK);
  fvv_writer_destroy(writer);
  const Opened opened(bytes);
  REQUIRE(opened.status == FVV_OK);
  const double steps[6] = {0.25, 0.25, 0, 0, 0.5, 0.5};
  for (const size_t group : {5, 0, 3, 1, 4, 2}) {
    const fvv_environment *environment;
    const fvv_status status =
        fvv_stream_environment(opened.stream, group, environment_track, &environment, nullptr);
    CHECK(status == (steps[group] > 0 ? FVV_OK : FVV_END));
    if (environment) CHECK(environment->lattice_step == steps[group]);
  }
  const Checked checked(bytes);
  CHECK(checked.summary().problems == 0);
  CHECK(checked.summary().whole_frames == 12);
}

TEST_CASE("the checker counts what an environment holds and finds nothing wrong") {
  const Bytes bytes = write(stage(2, Environment().payload()));
  for (const bool decode : {true, false}) {
    Check how;
    how.decode = decode;
    how.step = 1000;
    const Checked checked(bytes, how);
    CHECK(checked.summary().problems == 0);
    CHECK(checked.summary().frames == 4);
    CHECK(checked.summary().whole_frames == 4);
    REQUIRE(fvv_checker_track_count(checked.checker) == 2);
    const fvv_track_summary *track = fvv_checker_track(checked.checker, 1);
    CHECK(track->kind == FVV_TRACK_ENVIRONMENT);
    CHECK(track->parts == 2);
    CHECK(track->pictures == 2);
    CHECK(track->lights == 3);
    CHECK(track->vertices == 8);
    CHECK(track->faces == 4);
  }
}

TEST_CASE("the checker finds each broken rule of clause 18 in a stream") {
  const Bytes payload = Environment().payload();
  const auto check_broken = [&](const Stream &stream, size_t nth, uint32_t issue, uint64_t within) {
    const Bytes bytes = write(stream);
    size_t offset = 0;
    for (const Place &place : chunks_of(bytes))
      if (place.type == FVV_CHUNK_ENVIRONMENT && !nth--) offset = place.offset;
    const Checked checked(bytes);
    CHECK(checked.summary().problems == 1);
    CHECK(has_problem(checked, issue, offset + within));
  };
  Stream stream = stage(2, payload);
  stream.groups[1].chunks.push_back(environment_chunk(6, payload));
  CHECK(Checked(write(stream)).summary().problems == 0); // a repetition
  stream.groups[1].chunks.back().payload = other_payload();
  check_broken(stream, 1, FVV_ISSUE_ENVIRONMENT_SAME, 32);
  stream = stage(1, payload);
  stream.groups[0].chunks.insert(stream.groups[0].chunks.begin() + 1, environment_chunk(0, payload));
  stream.groups[0].chunks.back().flags = 0;
  check_broken(stream, 1, FVV_ISSUE_ENVIRONMENT_KEY, 32);
  stream = stage(1, payload);
  stream.groups[0].chunks.back().payload[44] = 1;
  check_broken(stream, 0, FVV_ISSUE_ENVIRONMENT_PAYLOAD, 32 + 44);
  // A corner of a face that is no vertex: only decoding shows it.
  stream = stage(1, payload);
  const size_t corner = 48 + 2 * 48 + 2 * 16 + 3 * 112 + 16 + 4 * 20;
  stream.groups[0].chunks.back().payload[corner + 4] = 9;
  const Bytes bytes = write(stream);
  const Checked checked(bytes);
  CHECK(checked.summary().problems == 1);
  CHECK(fvv_checker_problem(checked.checker, 0)->issue == FVV_ISSUE_MESH_INDEX);
  CHECK(fvv_checker_problem(checked.checker, 0)->chunk_type == FVV_CHUNK_ENVIRONMENT);
  Check shallow;
  shallow.decode = false;
  CHECK(Checked(bytes, shallow).summary().problems == 0);
  const Opened opened(bytes);
  const fvv_environment *environment;
  REQUIRE(fvv_stream_environment(opened.stream, 0, environment_track, &environment, nullptr) == FVV_OK);
  fvv_mesh mesh;
  fvv_diagnostic diagnostic;
  CHECK(fvv_environment_mesh(environment, 0, nullptr, nullptr, &mesh, &diagnostic) == FVV_ERROR_INVALID);
  CHECK(diagnostic.offset >= corner);
}

TEST_CASE("an environment that is damaged costs no frame before it and is never returned") {
  Bytes bytes = write(stage(2, Environment().payload()));
  for (const Place &place : chunks_of(bytes))
    if (place.type == FVV_CHUNK_ENVIRONMENT) bytes[place.offset + 100] ^= 1;
  const Checked checked(bytes);
  CHECK(checked.summary().problems >= 1);
  CHECK(whole_times(checked) == std::vector<int64_t>{0, 4, 6});
  const Opened opened(bytes);
  const fvv_environment *environment;
  fvv_diagnostic diagnostic;
  CHECK(fvv_stream_environment(opened.stream, 1, environment_track, &environment, &diagnostic) ==
        FVV_ERROR_DAMAGED);
  CHECK(!environment);
  fvv_mesh mesh;
  CHECK(fvv_stream_mesh(opened.stream, 3, mesh_track, &mesh, nullptr) == FVV_OK);
  fvv_mesh_free(&mesh);
}

TEST_CASE("failing memory leaks nothing of an environment") {
  const Bytes bytes = write(stage(2, Environment().payload()));
  fvv_status status = FVV_ERROR_MEMORY;
  for (int64_t n = 0; status == FVV_ERROR_MEMORY && n < 200; n++)
    with_failing_memory(n, [&](const fvv_allocator *allocator) {
      const Opened opened(bytes, allocator);
      const fvv_environment *environment;
      status = opened.status;
      if (status == FVV_OK)
        status = fvv_stream_environment(opened.stream, 1, environment_track, &environment, nullptr);
    });
  CHECK(status == FVV_OK);
}

TEST_CASE("the conformance vector of environments holds the environment that it was made of") {
  const Bytes bytes = vector_bytes();
  CHECK(bytes == write(stage(2, raw_payload(), true)));
  const Checked checked(bytes);
  CHECK(checked.summary().problems == 0);
}

TEST_CASE("write the vector of environments", "[.][make]") {
  write_vector(FVV_CASES "/vector_environment_stage/input.fvv", write(stage(2, raw_payload(), true)));
}
