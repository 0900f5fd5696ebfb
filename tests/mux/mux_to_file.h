// A capture packed into a file, as fvvmux does it.
#pragma once

#include "cli/cli.h"
#include "cli/output.h"
#include "fvv_mux/mux.h"

struct FileOptions : fvv::mux::Options {
  std::string output;
  bool force = false;
};

inline fvv::mux::Summary mux_file(const FileOptions &options) {
  fvv::mux::Muxer muxer(options, {});
  fvv::cli::OutputFile output(options.output, options.force);
  fvv::mux::Summary summary = muxer.run([&](const void *bytes, size_t size) { output.write(bytes, size); });
  output.commit();
  if (options.verify) fvv::mux::verify(summary, fvv::InputFile(options.output));
  return summary;
}

inline std::string text_of(const fvv::mux::Summary &summary) {
  return fvv::mux::summary_text(summary, "out.fvv");
}
inline nlohmann::ordered_json json_of(const fvv::mux::Summary &summary) {
  return fvv::mux::summary_json(summary, "out.fvv");
}
