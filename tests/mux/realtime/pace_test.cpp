// When effort falls and rises.
#include "fvv_catch.h"

#include "mux/src/realtime/pace.h"

#include <string>
#include <vector>

using fvv::mux::Pace;

namespace {

// Steps after groups of half a second with these loads, and nothing that waits.
std::string steps(Pace &pace, const std::vector<double> &loads) {
  std::string out;
  for (const double load : loads) {
    pace.add(load / 2, 0.5, 0.01);
    out += std::to_string(pace.step());
  }
  return out;
}

} // namespace

TEST_CASE("effort falls with each group that takes too long, and no further than it can") {
  Pace pace(4);
  CHECK(steps(pace, {0.8, 0.9, 0.7, 1.2, 1.2, 1.2}) == "011233");
}

TEST_CASE("a group that had to wait for long lowers the effort, however quick it was") {
  Pace pace(4);
  pace.add(0.1, 0.5, 0.6);
  CHECK(pace.step() == 1);
  pace.add(0.1, 0.5, 0.4); // neither behind nor easy
  CHECK(pace.step() == 1);
}

TEST_CASE("effort rises after some easy groups, and later where that was too early") {
  Pace pace(4);
  CHECK(steps(pace, {2, 2, 0.4, 0.4, 0.4, 0.4}) == "122221");
  CHECK(steps(pace, {0.9}) == "2");
  CHECK(steps(pace, {0.4, 0.4, 0.4, 0.4, 0.4, 0.4, 0.4, 0.4}) == "22222221");
  CHECK(steps(pace, std::vector<double>(8, 0.4)) == "11111110");
  CHECK(pace.load() == Approx(0.4));
}
