// Linear least squares with a fixed pattern: normal equations in square blocks, solved by Eigen's sparse
// LDL^T, of which the symbolic part is done once. Sums are added in the order of the calls and solved on one
// thread, so that results do not depend on the number of threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace fvv::track {

class SparseSystem {
public:
  // count unknown blocks of size numbers each. pairs: of blocks that occur in one equation, in any order,
  // also several times; each block is paired with itself.
  SparseSystem(size_t count, size_t size, std::vector<std::pair<uint32_t, uint32_t>> pairs);
  ~SparseSystem();

  void clear();
  // The block of row and column: size * size numbers, column by column, to which a caller adds. row >=
  // column, and the pair is one of the pattern; of a diagonal block the lower half is read.
  double *at(uint32_t row, uint32_t column);
  // The right side, of all unknowns.
  std::vector<double> &right();
  // The solution; empty where the matrix is not positive definite.
  std::vector<double> solve();

private:
  struct State;
  std::unique_ptr<State> state;
};

} // namespace fvv::track
