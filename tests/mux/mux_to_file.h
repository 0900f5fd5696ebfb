// A capture packed into a file, as fvvmux does it.
#pragma once

#include "cli/cli.h"
#include "cli/output.h"
#include "fvv_mux/muxer.h"
#include "mux/src/encode/encode_job.h"
#include "mux/src/verify.h"

#include <nlohmann/json.hpp>

struct FileOptions : fvv::mux::Options {
  std::string output;
  bool force = false;
};

inline fvv::mux::Report mux_file(const FileOptions &options) {
  fvv::mux::Muxer muxer(options, {});
  fvv::cli::OutputFile output(options.output, options.force);
  fvv::mux::Report report = muxer.run([&](const void *bytes, size_t size) { output.write(bytes, size); });
  output.commit();
  if (options.verify) report.verdict = muxer.verify(options.output, options.output);
  return report;
}

// The same for tests that look inside.
struct Encoded {
  fvv::mux::Plan plan;
  fvv::mux::Decisions decisions;
  std::vector<std::vector<fvv::mux::MeshOrigins>> origins;
  fvv::mux::Report report;

  fvv::mux::Verdict verify(const std::string &path) const {
    return fvv::mux::verify(plan, decisions, origins, fvv::InputFile(path));
  }
};
inline Encoded encode_file(const FileOptions &options) {
  Encoded out;
  out.plan = fvv::mux::make_plan(options, {});
  fvv::cli::OutputFile output(options.output, options.force);
  const fvv::mux::Sink sink = [&](const void *bytes, size_t size) { output.write(bytes, size); };
  fvv::mux::EncodeJob job(out.plan, sink);
  job.run();
  out.report = job.finish(std::chrono::steady_clock::now());
  out.decisions = job.decisions();
  out.origins = job.sums().origins;
  output.commit();
  return out;
}

inline std::string text_of(const fvv::mux::Report &report) {
  return fvv::mux::report_text(report, "out.fvv", fvv::Spelling::command_line);
}
inline nlohmann::ordered_json json_of(const fvv::mux::Report &report) {
  return nlohmann::ordered_json::parse(fvv::mux::report_json(report, "out.fvv", fvv::Spelling::command_line));
}
