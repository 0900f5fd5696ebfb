// Independent pieces of work on several threads. Results do not depend on the number of threads, nor on which
// thread is faster.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace fvv {

// group_of: for every piece, in the order in which pieces begin, the number of its group; every number from 0
// to the largest occurs. Calls work(piece) once for each on the given number of threads, and collect(group)
// on the calling thread, in order, when all pieces of a group are done. A piece begins only when its group is
// among the first threads + 1 that are not collected, which bounds what is held in memory. So a group's
// pieces may come after pieces of the next group, but not after those of any later one. rest() is called once
// on each thread when no piece is left to begin; it may help with pieces that other threads still work on.
//
// An exception of work or collect stops the rest and is rethrown here; of several exceptions of work, that of
// the first piece.
void run_ordered(
    unsigned threads, const std::vector<size_t> &group_of, const std::function<void(size_t piece)> &work,
    const std::function<void(size_t group)> &collect, const std::function<void()> &rest = [] {});

// Calls work(0) ... work(count - 1), each once, on the given number of threads, and done() on the calling
// thread after each. Exceptions as above.
void parallel(
    unsigned threads, size_t count, const std::function<void(size_t)> &work,
    const std::function<void()> &done = [] {});

} // namespace fvv
