// fvvcompare: how far two sequences of meshes are apart. Argument parsing only.
#include "cli/cli.h"
#include "cli/help.h"
#include "cli/max_memory.h"
#include "fvv_cxx/range.h"
#include "fvvcompare/report.h"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <thread>

using namespace fvv;

namespace {

constexpr const char *footer =
    "docs/tools/fvvcompare.md defines every figure. Lengths are in metres, or in units "
    "of sources of unknown scale.\n"
    "Exit code: 0 done, 1 nothing could be compared or a bound is exceeded, 2 "
    "usage, 3 done but for frames that\n"
    "could not be compared.\n"
    "spec/fvvcompare.schema.json describes the output of --json.";

struct Bounds {
  std::optional<double> rms, distance;
};

// One line for each bound that is exceeded.
cli::Exit check(const Bounds &bounds, const compare::Result &result) {
  const compare::Figures &found = result.errors.distance[compare::symmetric];
  cli::Exit exit = cli::done;
  const auto bound = [&](const char *what, double value, const std::optional<double> &most) {
    if (!most || value <= *most) return;
    std::fprintf(stderr, "fvvcompare: %s is %.9g, expected at most %.9g\n", what, value, *most);
    exit = cli::failed;
  };
  bound("symmetric rms distance", found.rms, bounds.rms);
  bound("Hausdorff distance", found.max, bounds.distance);
  return exit;
}

void tell(const compare::Result &result) {
  for (const std::string &text : result.warnings) cli::warn(text);
  for (const std::string &line : result.losses) std::fprintf(stderr, "%s\n", line.c_str());
}

} // namespace

int main(int argc, char **argv) {
  CLI::App app{"Measure how far two sequences of meshes are apart."};
  compare::Command options;
  options.threads = std::clamp(std::thread::hardware_concurrency(), 1u, 256u);
  Bounds bounds;
  std::string frames, table;
  bool as_json = false;
  const std::map<std::string, compare::Points> points = {{"vertices", compare::Points::vertices},
                                                         {"samples", compare::Points::samples}};
  const CLI::Range positive(1e-300, 1e300, "POSITIVE");
  app.add_option("A", options.a, "the reference: a capture.json, its folder, or a fvv stream")
      ->required()
      ->type_name("FILE.json|fvv");
  app.add_option("B", options.b, "the sequence to compare with A")->required()->type_name("FILE.json|fvv");
  app.add_option("--frames", frames, "frame numbers of A to compare: 10-19");
  app.add_option("--start", options.start, "frame number of A that the first frame of B shows");
  app.add_option("--samples", options.samples, "of each surface and frame, besides its vertices")
      ->check(CLI::Range(1, 100000000))
      ->capture_default_str();
  app.add_option("--points", options.points,
                 "where D1 and D2 are taken: vertices (default) or samples, which "
                 "means both")
      ->transform(CLI::CheckedTransformer(points).description(""))
      ->type_name("vertices|samples");
  app.add_option("--peak", options.peak, "of PSNR; default: the diagonal of A's bounding box")
      ->check(positive);
  app.add_option("--max-rms", bounds.rms, "exit with 1 when the symmetric rms distance exceeds this")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--max-distance", bounds.distance, "exit with 1 when the Hausdorff distance exceeds this")
      ->check(CLI::NonNegativeNumber);
  options.memory = {cli::max_memory_default, cli::max_memory_option};
  cli::add_max_memory(app, options.memory.bytes,
                      "that a mesh file of a capture, or the mesh of a frame of a stream, may take");
  app.add_option("--csv", table, "file for the figures of each frame; - is standard output")
      ->type_name("FILE.csv");
  app.add_option("--heatmap", options.heatmap,
                 "folder for B as PLY, coloured by its distance from A: yellow is the p99 of B to A")
      ->type_name("FOLDER");
  app.add_flag("--json", as_json, "print everything as JSON");
  app.add_flag("--force", options.force,
               "replace an existing file, and a folder that fvvcompare wrote (docs/tools/outputs.md)");
  app.add_option("--threads", options.threads, "frames at a time; default: one for each processor")
      ->check(CLI::Range(1, 256));
  app.footer(footer);
  cli::set_help(app, "fvvcompare",
                {
                    "fvvcompare players players.fvv",
                    "fvvcompare players players.fvv --max-rms 0.002 --json",
                });
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError &error) {
    return cli::end_of_parsing(app, error);
  }
  return cli::run("fvvcompare", [&] {
    if (table == "-" && as_json)
      throw Error("--json: standard output is taken by the table (--csv -)", Error::usage);
    if (!frames.empty()) options.frames = fvv::parse_range("frames", frames);
    if (table != "-") options.table = table;
    compare::Result result;
    try {
      compare::run(options, result);
    } catch (...) {
      tell(result);
      throw;
    }
    tell(result);
    std::fputs(table == "-" ? compare::csv(result).c_str()
               : as_json    ? (compare::json(options, result) + "\n").c_str()
                            : compare::text(options, result).c_str(),
               stdout);
    const cli::Exit exit = result.warnings.empty() && result.losses.empty() ? cli::done : cli::loss;
    return cli::worse(exit, check(bounds, result));
  });
}
