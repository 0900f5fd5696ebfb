// fvvmux/ordered.h: pieces of work on several threads, their results taken in order. Knows nothing of the
// work; what is taken does not depend on the number of threads, nor on who is quicker.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

namespace fvv::mux {

// group_of: for every piece, in the order in which pieces are begun, the number of its group; every number
// from 0 to the largest occurs. Calls work(piece) once for each on the given number of threads, and
// collect(group) on the calling thread, in order, when all pieces of a group are done. A piece begins only
// when its group is among the first threads + 1 that are not collected, which bounds what is held in memory.
// A group's pieces may therefore stand behind pieces of the next group, but of none further on.
//
// An exception of work or collect stops the rest and is thrown here; of several exceptions of work the one
// of the first piece.
void run_ordered(unsigned threads, const std::vector<size_t> &group_of,
                 const std::function<void(size_t piece)> &work,
                 const std::function<void(size_t group)> &collect);

} // namespace fvv::mux
