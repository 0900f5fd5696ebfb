// What players interpolate: shares of the faces around a vertex, worked out by hand.
#include "fvv/visibility.h"
#include "fvv_catch.h"
#include "mesh_of.h"

namespace {

// A fan about vertex 0 of four faces, and vertex 6 that no face uses.
std::vector<int32_t> positions(21);
std::vector<uint32_t> faces = {0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5};

std::vector<uint8_t> shares(uint8_t domain, const std::vector<uint8_t> &states) {
  const fvv_mesh mesh = mesh_of(positions, faces);
  std::vector<uint32_t> counts(14, 77);
  std::vector<uint8_t> out(7, 99);
  fvv_visibility_shares(&mesh, domain, states.data(),
                        domain == FVV_VISIBILITY_FACES ? counts.data() : nullptr, out.data());
  return out;
}

constexpr uint8_t averse = FVV_ELEMENT_AVERSE, hidden = FVV_ELEMENT_HIDDEN, seen = FVV_ELEMENT_SEEN;
using Shares = std::vector<uint8_t>;

} // namespace

TEST_CASE("the share of a vertex is that of the faces around it that have a bit") {
  CHECK(shares(FVV_VISIBILITY_FACES, {seen, seen, hidden, hidden}) == Shares{128, 255, 255, 128, 0, 0, 127});
  CHECK(shares(FVV_VISIBILITY_FACES, {seen, hidden, hidden, hidden}) == Shares{64, 255, 128, 0, 0, 0, 127});
  CHECK(shares(FVV_VISIBILITY_FACES, {seen, seen, seen, hidden}) == Shares{191, 255, 255, 255, 128, 0, 127});
}

TEST_CASE(
    "faces without a bit take what is seen around them, and nothing around is a little less than half") {
  CHECK(shares(FVV_VISIBILITY_FACES, {seen, averse, averse, averse}) ==
        Shares{255, 255, 255, 127, 127, 127, 127});
  CHECK(shares(FVV_VISIBILITY_FACES, {averse, averse, averse, averse}) == Shares(7, 127));
  CHECK(shares(FVV_VISIBILITY_FACES, {hidden, averse, averse, seen}) ==
        Shares{128, 0, 0, 127, 255, 255, 127});
}

TEST_CASE("coded shares are what they say, and a vertex without one is a little less than half") {
  CHECK(shares(FVV_VISIBILITY_SHARES, {averse, hidden, seen, FVV_ELEMENT_HIDDEN_NEAR, FVV_ELEMENT_SEEN_NEAR,
                                       FVV_ELEMENT_HIDDEN_NEARER, FVV_ELEMENT_SEEN_NEARER}) ==
        Shares{127, 0, 255, 85, 170, 113, 142});
}

TEST_CASE("vertices that have bits are seen or not") {
  CHECK(shares(FVV_VISIBILITY_VERTICES, {seen, averse, hidden, seen, averse, seen, hidden}) ==
        Shares{255, 0, 0, 255, 0, 255, 0});
}
