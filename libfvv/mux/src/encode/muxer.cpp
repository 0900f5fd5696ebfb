#include "fvv_mux/muxer.h"
#include "fvv_cxx/input_file.h"
#include "mux/src/encode/encode_job.h"
#include "mux/src/verify.h"

#include <chrono>

namespace fvv::mux {

struct Muxer::State {
  std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
  Plan plan;
  Decisions decisions;                           // once run() has returned
  std::vector<std::vector<MeshOrigins>> origins; // likewise
};

Muxer::Muxer(const Options &options, const Observer &observer) : state(std::make_unique<State>()) {
  state->plan = make_plan(options, observer);
}

Muxer::~Muxer() = default;
Muxer::Muxer(Muxer &&) noexcept = default;

size_t Muxer::frame_count() const {
  return state->plan.frame_count();
}

Report Muxer::run(const Sink &sink) {
  EncodeJob job(state->plan, sink);
  job.run();
  Report report = job.finish(state->start);
  state->decisions = job.decisions();
  state->origins = job.sums().origins;
  return report;
}

Verdict Muxer::verify(const std::string &path, const std::string &shown) const {
  return mux::verify(state->plan, state->decisions, state->origins, InputFile(path, shown));
}

} // namespace fvv::mux
