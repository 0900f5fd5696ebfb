#include "geometry/src/track/sparse_system.h"

#define EIGEN_MPL2_ONLY
#include <Eigen/SparseCholesky>

#include <algorithm>

namespace fvv::track {

struct SparseSystem::State {
  size_t count, size;
  std::vector<size_t> first;  // of each column of blocks, in rows
  std::vector<uint32_t> rows; // of blocks, the diagonal one first
  Eigen::SparseMatrix<double> matrix;
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower> factor;
  std::vector<double> blocks; // one after the other, each column by column
  std::vector<double> right;
};

SparseSystem::SparseSystem(size_t count, size_t size, std::vector<std::pair<uint32_t, uint32_t>> pairs)
    : state(std::make_unique<State>()) {
  State &s = *state;
  s.count = count;
  s.size = size;
  for (auto &[a, b] : pairs) // column, row
    if (a > b) std::swap(a, b);
  for (uint32_t k = 0; k < count; k++) pairs.emplace_back(k, k);
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  s.first.assign(count + 1, 0);
  for (const auto &[column, row] : pairs) {
    s.first[column + 1]++;
    s.rows.push_back(row);
  }
  for (size_t k = 0; k < count; k++) s.first[k + 1] += s.first[k];
  const auto unknowns = Eigen::Index(count * size);
  s.matrix.resize(unknowns, unknowns);
  s.matrix.resizeNonZeros(Eigen::Index(s.rows.size() * size * size));
  int *outer = s.matrix.outerIndexPtr(), *inner = s.matrix.innerIndexPtr();
  size_t at = 0;
  for (size_t column = 0; column < count; column++)
    for (size_t c = 0; c < size; c++) {
      outer[column * size + c] = int(at);
      for (size_t i = s.first[column]; i < s.first[column + 1]; i++)
        for (size_t r = 0; r < size; r++) inner[at++] = int(s.rows[i] * size + r);
    }
  outer[count * size] = int(at);
  s.right.assign(count * size, 0);
  s.blocks.assign(s.rows.size() * size * size, 0);
  std::fill_n(s.matrix.valuePtr(), s.matrix.nonZeros(), 0.0);
  s.factor.analyzePattern(s.matrix);
}

SparseSystem::~SparseSystem() = default;

void SparseSystem::clear() {
  std::fill(state->blocks.begin(), state->blocks.end(), 0.0);
  std::fill(state->right.begin(), state->right.end(), 0.0);
}

double *SparseSystem::at(uint32_t row, uint32_t column) {
  const State &s = *state;
  const auto begin = s.rows.begin() + std::ptrdiff_t(s.first[column]);
  const auto end = s.rows.begin() + std::ptrdiff_t(s.first[column + 1]);
  return state->blocks.data() + size_t(std::lower_bound(begin, end, row) - s.rows.begin()) * s.size * s.size;
}

std::vector<double> &SparseSystem::right() {
  return state->right;
}

std::vector<double> SparseSystem::solve() {
  State &s = *state;
  double *to = s.matrix.valuePtr();
  for (size_t column = 0; column < s.count; column++)
    for (size_t c = 0; c < s.size; c++)
      for (size_t i = s.first[column]; i < s.first[column + 1]; i++)
        for (size_t r = 0; r < s.size; r++) *to++ = s.blocks[(i * s.size + c) * s.size + r];
  s.factor.factorize(s.matrix);
  if (s.factor.info() != Eigen::Success) return {};
  const Eigen::VectorXd x =
      s.factor.solve(Eigen::Map<const Eigen::VectorXd>(s.right.data(), Eigen::Index(s.right.size())));
  return {x.data(), x.data() + x.size()};
}

} // namespace fvv::track
