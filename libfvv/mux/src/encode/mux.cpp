#include "fvv_mux/mux.h"
#include "mux/src/encode/encode_job.h"

namespace fvv::mux {

Muxer::Muxer(const Options &options, const Observer &observer) : start(std::chrono::steady_clock::now()) {
  summary.plan = make_plan(options, observer);
}

Summary Muxer::run(const Sink &sink) {
  EncodeJob job(summary, sink);
  job.run();
  job.finish(start);
  return std::move(summary);
}

void verify(Summary &summary, const InputFile &file) {
  summary.verdict = verify(summary.plan, summary.origins, file);
}

} // namespace fvv::mux
