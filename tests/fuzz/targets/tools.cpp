// What tools do with a stream, from the file to their outputs. They throw Error or are done; any other
// exception is a fault.
#include "../fuzz.h"
#include "scratch.h"

#include "fvvcompare/command.h"
#include "fvvcompare/report.h"
#include "fvvdemux/demux.h"
#include "fvvrecover/command.h"
#include "fvvrender/film.h"
#include "fvvrender/render.h"

#include <cmath>
#include <limits>

namespace {

using fuzz::Random;
using fuzz::Scratch;

// Larger pictures take the time of many inputs, and show nothing else.
constexpr uint64_t memory = uint64_t(64) << 20;
const fvv::media::MemoryLimit memory_limit = {memory, "the target's limit"};

// What a user may type.
double number(Random &random) {
  static const double odd[] = {0,     -0.0,   1e-300, 1e-9,     -1e9,
                               1e160, -1e300, 5e-324, INFINITY, std::numeric_limits<double>::quiet_NaN()};
  return random.below(8) ? double(random.below(2001)) / 250 - 4 : odd[random.below(10)];
}

template <class Run> void no_other_exception(const Run &run) {
  try {
    run();
  } catch (const fvv::Error &) {
    // In its own words.
  }
}

} // namespace

FVV_FUZZ_TARGET(demux_tool, fuzz::Form::stream) {
  const Scratch scratch;
  Random random(fuzz::digest(data, size));
  using namespace fvv;
  demux::Options options;
  const demux::Meshes meshes[] = {demux::Meshes::ply, demux::Meshes::obj,  demux::Meshes::drc,
                                  demux::Meshes::glb, demux::Meshes::gltf, demux::Meshes::none};
  options.meshes = meshes[random.below(6)];
  if (options.meshes == demux::Meshes::glb)
    options.compression = scene::Compression(random.below(3));
  else if (options.meshes == demux::Meshes::gltf && random.below(2))
    options.compression = scene::Compression::meshopt;
  options.pictures = demux::Pictures(random.below(5));
  options.rung = random.below(4) ? 0 : random.below(3);
  options.mp4 = random.below(2);
  options.threads = 1 + random.below(2);
  options.environment = random.below(4);
  options.sound = random.below(4);
  options.memory = memory_limit;
  if (!random.below(4)) options.frames = demux::Selection::parse("frames", "1-2");
  if (!random.below(4)) options.cameras = demux::Selection::parse("cameras", "0");
  const std::string input = scratch.write("in.fvv", data, size);
  demux::Result result;
  no_other_exception([&] { demux::demux(input, scratch.path("out"), options, result); });
}

FVV_FUZZ_TARGET(compare_tool, fuzz::Form::stream) {
  const Scratch scratch;
  Random random(fuzz::digest(data, size));
  using namespace fvv;
  compare::Command command;
  command.a = command.b = scratch.write("in.fvv", data, size);
  command.samples = 1 + random.below(100);
  command.points = random.below(2) ? compare::Points::vertices : compare::Points::samples;
  command.threads = 1 + random.below(2);
  if (!random.below(4)) command.start = random.below(3);
  if (!random.below(4)) command.peak = random.below(2) ? 1e-300 : 1e300;
  if (random.below(2)) command.table = scratch.path("table.csv");
  if (random.below(2)) command.heatmap = scratch.path("heatmap");
  compare::Result result;
  no_other_exception([&] {
    compare::run(command, result);
    (void)compare::text(command, result);
    (void)compare::json(command, result);
  });
}

namespace {

void aim(fvv::view::Target &target, Random &random) {
  if (random.below(3))
    target.camera = uint16_t(random.below(2));
  else
    for (int i = 0, count = random.below(2) ? 6 : 9; i < count; i++) target.pose.push_back(number(random));
  if (target.pose.empty()) return;
  if (random.below(2)) target.focal = random.below(2) ? 1e-3 : 1e9;
}

// The whole way of a film but for most of its pictures: an MP4 with odd sides is refused after the first one.
void film(fvv::rendering::Options &options, const Scratch &scratch, Random &random) {
  options.output = scratch.path(random.below(2) ? "film/%04d.png" : "film.mp4");
  if (random.below(2)) {
    options.film.count = 2;
  } else {
    options.output = scratch.path("film.mp4");
    options.draw.target.size = fvv::view::Size{31, 17};
    if (random.below(2)) options.film.frames = fvv::demux::Selection::parse("frames", "0-2");
    if (random.below(2)) options.film.fps = fvv_rational{1 + random.below(60), 1 + random.below(3)};
  }
  if (!random.below(3)) return;
  options.draw.target.camera.reset();
  options.draw.target.pose.clear();
  options.film.orbit = double(random.below(721)) - 360;
  if (random.below(2)) return;
  options.film.target = fvv::render::Vec3{number(random), number(random), number(random)};
  options.film.radius = random.below(2) ? 1e-6 : 1e6;
}

} // namespace

FVV_FUZZ_TARGET(render_tool, fuzz::Form::stream) {
  const Scratch scratch;
  Random random(fuzz::digest(data, size));
  using namespace fvv;
  rendering::Options options;
  options.input = scratch.write("in.fvv", data, size);
  options.output = scratch.path(random.below(4) ? "out.png" : "out.exr");
  options.frame = random.below(3) ? 0 : random.below(4);
  options.load.memory = memory_limit;
  options.load.pictures = options.draw.pictures = random.below(4);
  options.load.rung = random.below(4) ? 0 : random.below(3);
  view::Options &draw = options.draw;
  draw.target.size = view::Size{1 + random.below(32), 1 + random.below(32)};
  draw.environment = random.below(4);
  draw.threads = 1 + random.below(2);
  draw.leave_one_out = !random.below(4);
  if (random.below(2)) draw.blend = random.below(2) ? render::Blend::viewer : render::Blend::paper;
  if (!random.below(4)) draw.inset = random.below(2) ? 0.001 : 1e6;
  if (!random.below(4)) draw.threshold = random.below(2);
  if (!random.below(4)) draw.best = 1 + random.below(render::max_best);
  draw.visible_by_default = random.below(2);
  if (!draw.visible_by_default) {
    const render::Visibility tests[] = {render::Visibility::given, render::Visibility::depth_map,
                                        render::Visibility::rays};
    draw.view.visibility = tests[random.below(3)];
  }
  draw.view.samples = random.below(4) ? 1 : 3;
  aim(draw.target, random);
  const bool is_film = !random.below(3);
  if (is_film) {
    film(options, scratch, random);
  } else {
    if (!random.below(3)) options.depth = scratch.path("depth.exr");
    if (!random.below(3)) options.weights = scratch.path("weights.exr");
    if (!random.below(3)) options.visibility = scratch.path("visibility.exr");
    if (!random.below(3)) options.mask = scratch.path("mask.png");
    draw.view.keep_visibility = !options.visibility.empty();
  }
  rendering::Result result;
  no_other_exception([&] {
    is_film ? rendering::run_film(options, result) : rendering::run(options, result);
    (void)rendering::json(options, result);
  });
}

// What is recovered is whole, and recovering it again changes no byte.
FVV_FUZZ_TARGET(recover_tool, fuzz::Form::stream) {
  const Scratch scratch;
  using namespace fvv;
  recover::Command command;
  command.input = scratch.write("in.fvv", data, size);
  command.output = scratch.path("out.fvv");
  no_other_exception([&] {
    const recover::Result result = recover::run(command);
    (void)recover::messages(command, result);
    (void)recover::text(command.input, result);
    (void)recover::json(command.input, command.output, result).dump();
    if (recover::is_empty(result)) return;
    const recover::Command again = {command.output, scratch.path("again.fvv")};
    fuzz::expect(recover::run(again).state == recover::State::whole, "what is recovered is whole");
    fuzz::expect(scratch.read("out.fvv") == scratch.read("again.fvv"), "a whole stream keeps its bytes");
  });
}
