// The whole server: listens, accepts connections, and shuts down cleanly on SIGINT and SIGTERM. One thread
// for the network and one for each live stream.
#pragma once

#include "fvvserve/options.h"

#include <functional>

namespace fvv::serve {

// Returns after a signal. ready: called once with the address that is served, "127.0.0.1:8035". Throws
// Error when the root, an input or the address can't be opened.
void serve(const Options &options, const std::function<void(const std::string &address)> &ready);

} // namespace fvv::serve
