// Whole sequences: captures and streams in all combinations, which frames meet, and what cannot be compared.
#include "compare_fixture.h"

using namespace fvv::compare;
using namespace shapes;
using Catch::Matchers::Contains;

namespace {

// Of points on a face that is 1 m away from the origin at most.
constexpr double rounding = 1e-15;

std::string failure_of(const std::string &a, const std::string &b, Command options = {}) {
  try {
    compared(a, b, options);
  } catch (const fvv::Error &error) {
    return error.in(fvv::Spelling::command_line);
  }
  return "no failure";
}

} // namespace

TEST_CASE("a capture is at no distance of itself") {
  const Folder folder;
  const std::string path = make_capture(folder, "in", balls(3));
  const Result result = compared(path, folder.path("in")); // the folder gives the same result
  CHECK(result.frames.size() == 3);
  CHECK(result.errors.distance[symmetric].max < rounding);
  CHECK(result.errors.d1[symmetric] == 0);
  CHECK(result.errors.angle[symmetric].max < 1e-12);
  REQUIRE(result.temporal);
  CHECK(result.temporal->pairs == 2);
  CHECK(result.temporal->by_order == 2);
  CHECK(result.temporal->rms == 0);
  CHECK(result.temporal->motion == Approx(0.05)); // the ball's
  CHECK(result.warnings.empty());
  CHECK(result.losses.empty());
  // The ball is 1 m in every direction and moves by 0.1 m; its mesh touches both poles only.
  const double width = 1.1;
  CHECK(result.peak == Approx(std::sqrt(width * width + 1 + 1)));
}

TEST_CASE("normals of a stream are compared with those of the capture") {
  const Folder folder;
  Mesh flat = plane(8, 0);
  const std::string plain = make_capture(folder, "plain", {flat});
  for (size_t v = 0; v < flat.vertex_count(); v++)
    flat.normals.insert(flat.normals.end(), {0.5, 0, std::sqrt(0.75)}); // 30 degrees from the plane's own
  const std::string path = make_capture(folder, "in", {flat});
  const std::string stream = make_stream(folder, path, "out.fvv", "1mm", fvv::mux::Normals::always);
  CHECK(compared(path, stream).errors.angle[symmetric].max < 1);
  CHECK(compared(stream, path).errors.angle[symmetric].max < 1);
  CHECK(compared(stream, stream).errors.angle[symmetric].max < 1e-6);
  CHECK(compared(plain, stream).errors.angle[symmetric].mean == Approx(30).margin(1));
  CHECK(compared(plain, path).errors.angle[symmetric].max < 1e-6); // between captures both are computed
}

TEST_CASE("a stream is within half a step of its capture") {
  const Folder folder;
  const std::string path = make_capture(folder, "in", balls(6));
  constexpr double step = 0.004;
  const std::string stream = make_stream(folder, path, "out.fvv", "4mm");
  for (const bool forwards : {true, false}) {
    const Result result = forwards ? compared(path, stream) : compared(stream, path);
    CHECK(result.frames.size() == 6);
    const double most = step / 2 * std::sqrt(3);
    CHECK(result.errors.distance[symmetric].max <= most);
    CHECK(result.errors.distance[symmetric].max > step / 4);
    CHECK(result.errors.distance[symmetric].rms < step / std::sqrt(12));
    CHECK(result.errors.d1[symmetric] <= most * most);
    CHECK(result.errors.d1[symmetric] == Approx(3 * step * step / 12).epsilon(0.2));
    REQUIRE(result.temporal);
    CHECK(result.temporal->pairs == 5);
    CHECK(result.temporal->by_order == 0); // Draco orders vertices its own way
    CHECK(result.temporal->furthest <= most);
    CHECK(result.temporal->rms > 0);
    CHECK(result.temporal->max <= 2 * most);
    CHECK(result.warnings.empty());
  }
}

TEST_CASE("a stream that went through a second lattice is off by both") {
  const Folder folder;
  const std::string path = make_capture(folder, "in", balls(2));
  const std::string fine = make_stream(folder, path, "fine.fvv", "1mm");
  const std::string coarse = make_stream(folder, path, "coarse.fvv", "16mm");
  const Result same = compared(fine, fine), other = compared(fine, coarse);
  CHECK(same.errors.distance[symmetric].max < rounding);
  CHECK(other.errors.distance[symmetric].max <= (0.001 + 0.016) / 2 * std::sqrt(3));
  CHECK(other.errors.distance[symmetric].max >= (0.016 - 0.001) / 4);
}

TEST_CASE("pooled figures are those of all frames, the worse direction counts") {
  const Folder folder;
  const std::string a = make_capture(folder, "a", {plane(4, 0), plane(4, 0)});
  const std::string b = make_capture(folder, "b", {plane(4, 0.3), plane(4, 0.4)});
  const Result result = compared(a, b);
  const Figures &f = result.errors.distance[symmetric];
  CHECK(f.rms == Approx(std::sqrt((0.09 + 0.16) / 2)));
  CHECK(f.mean == Approx(0.35));
  CHECK(f.max == Approx(0.4));
  CHECK(f.p99 == Approx(0.4).epsilon(1e-3));
  CHECK(result.errors.d1[symmetric] == Approx((0.09 + 0.16) / 2));
  CHECK(result.frames[1].errors.distance[symmetric].rms == Approx(0.4));
  CHECK(result.peak == Approx(std::sqrt(2)));
  REQUIRE(result.temporal);
  CHECK(result.temporal->rms == Approx(0.1));
  Command options;
  options.peak = 3;
  CHECK(compared(a, b, options).peak == 3);
  // Half of the plane: all of it is on the whole plane, but not the other way round.
  Mesh half = plane(4, 0);
  half.faces.resize(half.faces.size() / 2);
  const Result one_way =
      compared(make_capture(folder, "half", {half}), make_capture(folder, "all", {plane(4, 0)}));
  CHECK(one_way.errors.distance[a_to_b].max < rounding);
  CHECK(one_way.errors.distance[b_to_a].max == Approx(0.5));
  CHECK(one_way.errors.distance[symmetric].max == Approx(0.5));
  CHECK(one_way.errors.distance[symmetric].rms == one_way.errors.distance[b_to_a].rms);
}

TEST_CASE("figures do not depend on the number of threads") {
  const Folder folder;
  const std::string a = make_capture(folder, "a", balls(7));
  std::vector<Mesh> moved;
  for (size_t i = 0; i < 7; i++) moved.push_back(noisy(::ball(int64_t(i)), 0.003, i));
  const std::string b = make_capture(folder, "b", moved);
  Command options;
  options.samples = 2000;
  const Result one = compared(a, b, options);
  options.threads = 5;
  const Result five = compared(a, b, options);
  CHECK(one.errors.distance[symmetric].rms == five.errors.distance[symmetric].rms);
  CHECK(one.errors.distance[symmetric].p99 == five.errors.distance[symmetric].p99);
  CHECK(one.errors.angle[symmetric].mean == five.errors.angle[symmetric].mean);
  CHECK(one.temporal->rms == five.temporal->rms);
}

TEST_CASE("motion is compared only where both keep their faces") {
  const Folder folder;
  const std::string a =
      make_capture(folder, "a", {plane(4, 0), plane(4, 0), plane(4, 0), plane(4, 0), plane(4, 0)});
  const std::string b =
      make_capture(folder, "b", {plane(4, 0), plane(5, 0), plane(5, 0), plane(4, 0), plane(4, 0.5)});
  const Result result = compared(a, b);
  REQUIRE(result.temporal);
  CHECK(result.temporal->pairs == 2);
  CHECK(!result.frames[1].motion);
  CHECK(result.frames[2].motion);
  CHECK(result.frames[2].motion->rms == 0);
  CHECK(!result.frames[3].motion);
  CHECK(result.frames[4].motion->rms == Approx(0.5));
  CHECK(result.temporal->by_order == 1);
  CHECK(!compared(make_capture(folder, "c", {plane(4, 0), plane(3, 0)}),
                  make_capture(folder, "d", {plane(4, 0), plane(3, 0)}))
             .temporal);
}

TEST_CASE("captures are matched by frame number, streams by time, unless --start is given") {
  const Folder folder;
  const std::vector<Mesh> all = balls(8);
  const std::string whole = make_capture(folder, "whole", all, {{100, 1, 2}});
  const std::vector<Mesh> part(all.begin() + 3, all.begin() + 6);
  const std::string cut = make_capture(folder, "cut", part, {{106, 1, 2}});
  const Result by_number = compared(whole, cut);
  CHECK(by_number.frames.size() == 3);
  CHECK(by_number.errors.distance[symmetric].max < rounding);
  CHECK(by_number.frames[0].number_a == 106);
  REQUIRE(by_number.warnings.size() == 1);
  CHECK_THAT(by_number.warnings[0],
             Contains("whole/capture.json: 5 of 8 frames have no partner: 100 to 104, 112 to 114"));
  Command options;
  options.frames = {106, 110};
  CHECK(compared(whole, cut, options).warnings.empty());

  const std::string stream = make_stream(folder, cut, "cut.fvv", "1mm");
  CHECK(compared(cut, stream).errors.distance[symmetric].max < 0.001);
  CHECK(compared(whole, stream).errors.distance[symmetric].max > 0.1); // the first frames of both
  options.start = 106;
  const Result shifted = compared(whole, stream, options);
  CHECK(shifted.errors.distance[symmetric].max < 0.001);
  CHECK(shifted.warnings.empty());
  CHECK(shifted.frames[2].number_a == 110);
  CHECK(shifted.frames[2].number_b == 2);

  options = {};
  options.start = 107;
  CHECK_THAT(failure_of(whole, stream, options),
             Contains("--start: expected a frame of ") && Contains("100 to 114, found 107"));
  options = {};
  options.frames = {100, 116};
  CHECK_THAT(failure_of(whole, stream, options),
             Contains("--frames: expected a frame of ") && Contains("found 116"));
  CHECK_THAT(failure_of(cut, make_capture(folder, "early", part, {{0, 1, 2}})),
             Contains("no frame in common"));
}

TEST_CASE("frames that cannot be compared are reported, the others are compared") {
  const Folder folder;
  const std::string a = make_capture(folder, "a", balls(4)), b = make_capture(folder, "b", balls(4));
  fs::remove(folder.path("b/0001.ply"));
  Mesh nothing;
  nothing.positions = {0, 0, 0, 1, 0, 0, 2, 0, 0};
  nothing.faces = {0, 1, 2}; // no area
  fvv::scene::write_mesh(nothing, {}, folder.path("a/0003.ply"));
  const Result result = compared(a, b);
  CHECK(result.frames.size() == 2);
  REQUIRE(result.losses.size() == 2);
  CHECK_THAT(result.losses[0], Contains("b/0001.ply: cannot be opened"));
  CHECK_THAT(result.losses[1],
             Contains("a/capture.json: frame 3: expected a surface with a finite area above 0"));
  CHECK(!result.temporal);
  CHECK(result.frames[1].number_a == 2);
  fs::remove(folder.path("b/0000.ply"));
  fs::remove(folder.path("b/0002.ply"));
  CHECK_THAT(failure_of(a, b), Contains("no frame could be compared"));
}

TEST_CASE("a heat map is the second mesh, with its distance at each vertex") {
  const Folder folder;
  const std::string a = make_capture(folder, "a", {plane(1, 0), plane(1, 0)}, {{5, 1, 5}});
  Mesh bent = plane(1, 0);
  bent.positions[2] = 0.5; // of the first vertex
  const std::string b = make_capture(folder, "b", {plane(1, 0.25), bent}, {{5, 1, 5}});
  Command options;
  options.heatmap = folder.path("heat");
  const Result result = compared(a, b, options);
  const std::string path = folder.path("heat/0010.ply");
  const Mesh back = fvv::scene::read_mesh(path);
  CHECK(back.positions == bent.positions);
  CHECK(back.faces == bent.faces);
  const std::string bytes = read_bytes(path);
  const size_t start = bytes.find("end_header\n") + 11, stride = 3 * 8 + 4 + 3;
  const auto vertex = [&](size_t v) {
    float distance;
    memcpy(&distance, &bytes[start + v * stride + 24], sizeof distance);
    const auto *c = reinterpret_cast<const uint8_t *>(&bytes[start + v * stride + 28]);
    return std::make_pair(distance, std::array<int, 3>{c[0], c[1], c[2]});
  };
  CHECK(result.errors.distance[b_to_a].p99 < 0.5); // beyond it all is yellow
  CHECK(vertex(0) == std::make_pair(0.5f, std::array<int, 3>{253, 231, 37}));
  CHECK(vertex(3) == std::make_pair(0.0f, std::array<int, 3>{68, 1, 84}));
  CHECK(fs::exists(folder.path("heat/0005.ply")));
  CHECK_THAT(failure_of(a, b, options), Contains("already exists"));
  options.force = true;
  CHECK(failure_of(a, b, options) == "no failure");
}

TEST_CASE("meshes in memory and streams of the caller are compared as files are") {
  const Folder folder;
  const std::vector<Mesh> a = balls(3),
                          b = {noisy(a[0], 0.01, 1), noisy(a[1], 0.01, 2), noisy(a[2], 0.01, 3)};
  Shown shown;
  shown.frames = {7, 1, 7}; // by place, not by number
  shown.scale_unknown = true;
  shown.duration = {1, 50};
  const std::string path_a = make_capture(folder, "a", a, shown),
                    path_b = make_capture(folder, "b", b, shown);
  const Result expected = compared(path_a, path_b);
  const auto same = [&](const Sequence &in_a, const Sequence &in_b, const Result &as) {
    Result found;
    fvv::compare::compare(in_a, in_b, {}, found);
    CHECK(found.frames.size() == 3);
    for (const Direction direction : {a_to_b, b_to_a}) {
      CHECK(found.errors.distance[direction].rms == as.errors.distance[direction].rms);
      CHECK(found.errors.d2[direction] == as.errors.d2[direction]);
    }
    CHECK(found.temporal->rms == as.temporal->rms);
    CHECK(found.scale_unknown == as.scale_unknown);
    CHECK(found.warnings.empty());
  };
  same(Sequence("a", a), Sequence(path_b), expected);
  same(Sequence(path_a), Sequence("b", b), expected);
  CHECK_THROWS_WITH(Sequence("empty", std::vector<Mesh>{}), Contains("empty: no frame has a mesh"));

  const std::string stream = make_stream(folder, path_a, "a.fvv", "0.01");
  const fvv::InputFile file(stream);
  same(Sequence(file.input(), stream), Sequence(path_b), compared(stream, path_b));
  size_t calls = 0, last = 0;
  Options options;
  options.progress = [&](size_t done, size_t pairs) {
    CHECK((pairs == 3 && done == calls++));
    last = done;
  };
  Result found;
  fvv::compare::compare(Sequence(file.input(), stream), Sequence(file.input(), stream), options, found);
  CHECK(last == 3);
}

TEST_CASE("what has no common measure is refused") {
  const Folder folder;
  const std::vector<Mesh> two = balls(2);
  const std::string metres = make_capture(folder, "metres", two);
  Shown shown;
  shown.scale_unknown = true;
  const std::string unknown = make_capture(folder, "unknown", two, shown);
  CHECK_THAT(failure_of(metres, unknown),
             Contains("unlike units") && Contains("unknown/capture.json in units of its source"));
  CHECK(compared(unknown, unknown).scale_unknown);
  shown = {};
  shown.duration = {1, 30};
  CHECK_THAT(failure_of(metres, make_capture(folder, "fast", two, shown)),
             Contains("unlike frame rates") && Contains("1/25 s") && Contains("1/30 s"));
  CHECK_THAT(failure_of(metres, folder.path("nothing.fvv")), Contains("nothing.fvv: cannot be opened"));
  CHECK_THAT(failure_of(metres, folder.path("metres/0000.ply")), Contains("0000.ply"));
  fvv::scene::Capture empty;
  empty.path = folder.path("empty.json");
  empty.cameras.push_back(camera_of(0, 64, 48));
  empty.cameras[0].pictures = fvv::scene::Pattern::parse("%04d.png", nullptr);
  fvv::scene::write_capture(empty, empty.path);
  CHECK_THAT(failure_of(metres, empty.path), Contains("the capture has no meshes"));
}
