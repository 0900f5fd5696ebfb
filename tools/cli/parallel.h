// Independent pieces of work on several threads. Knows nothing of the work; results must not depend on its
// order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

namespace fvv::cli {

// Calls work(0) ... work(count - 1), each once, on up to that many threads besides the calling one, which
// calls done() after each piece that has ended. The first exception stops the rest and is thrown here.
void parallel(
    uint32_t threads, size_t count, const std::function<void(size_t)> &work,
    const std::function<void()> &done = [] {});

} // namespace fvv::cli
