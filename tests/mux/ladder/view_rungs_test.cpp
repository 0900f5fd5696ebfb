// Which rungs of qualities lie on the hull of what views show over bytes.
#include "fvv_catch.h"
#include "mux/src/ladder/view_rungs.h"

#include <cmath>

using fvv::mux::RungCandidate;
namespace mux = fvv::mux;

namespace {

std::vector<double> qualities(const std::vector<mux::Rung> &rungs) {
  std::vector<double> out;
  for (const mux::Rung &rung : rungs) {
    CHECK(rung.scale == 1);
    out.push_back(rung.psnr);
  }
  return out;
}

} // namespace

TEST_CASE("rungs lie on the hull of what views show over bytes") {
  const RungCandidate first = {38, 1, 1000, 0.001};
  // The second has the same bytes as the third and shows less; the fourth is below the line of its
  // neighbours.
  const std::vector<RungCandidate> candidates = {{32, 1, 600, 0.0012},
                                                 {29, 2, 300, 0.0030},
                                                 {29, 1, 300, 0.0016},
                                                 {26, 1, 250, 0.0050},
                                                 {26, 2, 100, 0.0060}};
  const std::vector<mux::Rung> rungs = mux::choose_view_rungs(first, candidates);
  CHECK(qualities(rungs) == std::vector<double>{38, 32, 29, 26});
  CHECK(rungs[2].times == 1);
  CHECK(rungs[3].times == 2);
  std::vector<RungCandidate> turned(candidates.rbegin(), candidates.rend());
  CHECK(qualities(mux::choose_view_rungs(first, turned)) == qualities(rungs));
}

TEST_CASE("a rung takes at most two thirds of the better one, and has coarser pictures and meshes") {
  const RungCandidate first = {38, 1, 1000, 0.001};
  CHECK(qualities(mux::choose_view_rungs(
            first, {{36, 1, 900, 0.00101}, {34, 1, 650, 0.0011}, {33, 1, 600, 0.0012}})) ==
        std::vector<double>{38, 34});
  // Pictures of one quality are one rung, whatever their meshes; meshes do not become finer again.
  CHECK(qualities(mux::choose_view_rungs(first, {{32, 2, 500, 0.002}, {32, 2.5, 200, 0.004}})) ==
        std::vector<double>{38, 32});
  CHECK(qualities(mux::choose_view_rungs(first, {{32, 2, 500, 0.0011}, {29, 1, 200, 0.0013}})) ==
        std::vector<double>{38, 32});
  // Never more than four.
  std::vector<RungCandidate> many;
  for (int i = 1; i < 8; i++)
    many.push_back({38.0 - i, 1, 1000 * std::pow(0.5, i), 0.001 * std::pow(1.1, i * i)});
  CHECK(mux::choose_view_rungs(first, many).size() == 4);
}

TEST_CASE("where no candidate saves a third the smallest is the second rung") {
  const RungCandidate first = {38, 1, 1000, 0.001};
  CHECK(qualities(mux::choose_view_rungs(first, {{35, 1, 950, 0.0011}, {32, 1, 900, 0.0012}})) ==
        std::vector<double>{38, 32});
  CHECK(mux::choose_view_rungs(first, {}).size() == 1);
  CHECK(mux::choose_view_rungs(first, {{35, 1, 1000, 0.0011}, {39, 1, 500, 0.0011}}).size() == 1);
}

TEST_CASE("without a measure rungs are 6 dB apart, and never fall below 0") {
  CHECK(qualities(mux::usual_rungs(42)) == std::vector<double>{42, 36, 30});
  const std::vector<double> low = qualities(mux::usual_rungs(8));
  CHECK((low[0] > low[1] && low[1] > low[2] && low[2] > 0));
}
