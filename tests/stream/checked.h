// A checker that has seen a whole stream, and what it tells.
#pragma once

#include "stream_fixture.h"

#include <sstream>

struct Check {
  const fvv_limits *limits = nullptr;
  const fvv_allocator *allocator = nullptr;
  size_t step = 0; // bytes pushed at a time, 0: all
  bool decode = true;
};

// A checker that has seen all bytes.
class Checked {
public:
  explicit Checked(const Bytes &bytes, const Check &how = {}) {
    fvv_check_options options;
    fvv_check_options_default(&options);
    options.decode = how.decode;
    status = fvv_checker_create(&options, how.limits, how.allocator, &checker);
    if (status < 0) return;
    for (size_t at = 0; at < bytes.size();) {
      const size_t n = how.step && how.step < bytes.size() - at ? how.step : bytes.size() - at;
      // A block of exactly this size lets a sanitizer see any read beyond it.
      const Bytes part(bytes.begin() + std::ptrdiff_t(at), bytes.begin() + std::ptrdiff_t(at + n));
      const fvv_status pushed = fvv_checker_push(checker, part.data(), n);
      if (status >= 0) status = pushed;
      at += n;
    }
    const fvv_status finished = fvv_checker_finish(checker);
    if (status >= 0) status = finished;
  }
  Checked(const Checked &) = delete;
  ~Checked() { fvv_checker_destroy(checker); }
  const fvv_check_summary &summary() const { return *fvv_checker_summary(checker); }
  size_t problem_count() const { return fvv_checker_problem_count(checker); }
  const fvv_diagnostic &problem(size_t i) const { return *fvv_checker_problem(checker, i); }

  // Everything that it tells.
  std::string report() const {
    std::ostringstream out;
    const fvv_check_summary &s = summary();
    out << status << ' ' << s.bytes << ' ' << s.chunks << ' ' << s.groups << ' ' << s.frames << ' '
        << s.whole_frames << ' ' << s.payload_bytes << ' ' << s.problems << ' ' << s.start << ' ' << s.end
        << ' ' << s.written_major << '.' << s.written_minor << ' ' << s.configurations << ' ' << s.has_footer
        << ' ' << s.truncated << '\n';
    for (size_t i = 0; i < fvv_checker_problem_count(checker); i++) {
      char line[512];
      fvv_diagnostic_format(fvv_checker_problem(checker, i), "in", line, sizeof line);
      out << line << '\n';
    }
    for (size_t i = 0; i < fvv_checker_track_count(checker); i++) {
      const fvv_track_summary &t = *fvv_checker_track(checker, i);
      out << t.track << ' ' << int(t.kind) << ' ' << t.chunks << ' ' << t.key_chunks << ' ' << t.bytes << ' '
          << t.smallest << ' ' << t.largest << ' ' << t.min_vertices << ' ' << t.max_vertices << ' '
          << t.min_faces << ' ' << t.max_faces << ' ' << t.vertices << ' ' << t.faces << ' ' << t.textured
          << ' ' << int(t.min_texture_bits) << ' ' << int(t.max_texture_bits) << ' ' << t.with_normals << ' '
          << int(t.min_normal_bits) << ' ' << int(t.max_normal_bits) << ' ' << t.layouts << ' '
          << t.least_tile_pixels << ' ' << t.most_tile_pixels << '\n';
    }
    for (size_t i = 0; i < fvv_checker_run_count(checker); i++) {
      const fvv_frame_run &r = *fvv_checker_run(checker, i);
      out << r.first << '+' << r.count << ' ' << r.first_time << ".." << r.last_time << '\n';
    }
    return out.str();
  }

  fvv_checker *checker = nullptr;
  fvv_status status;
};

// The times of whole frames, 2 ticks apart.
inline std::vector<int64_t> whole_times(const Checked &checked) {
  std::vector<int64_t> out;
  uint64_t count = 0;
  for (size_t i = 0; i < fvv_checker_run_count(checked.checker); i++) {
    const fvv_frame_run *run = fvv_checker_run(checked.checker, i);
    CHECK(run->last_time - run->first_time == 2 * int64_t(run->count - 1));
    for (uint64_t f = 0; f < run->count; f++) out.push_back(run->first_time + 2 * int64_t(f));
    count += run->count;
  }
  CHECK(count == checked.summary().whole_frames);
  CHECK(!fvv_checker_run(checked.checker, fvv_checker_run_count(checked.checker)));
  return out;
}

inline bool has_problem(const Checked &checked, uint32_t issue, uint64_t offset) {
  for (size_t i = 0; i < fvv_checker_problem_count(checked.checker); i++) {
    const fvv_diagnostic *problem = fvv_checker_problem(checked.checker, i);
    if (problem->issue == issue && problem->offset == offset) return true;
  }
  return false;
}
