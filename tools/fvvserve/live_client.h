// fvvserve/live_client.h: a WebSocket on which a live stream goes out. Knows the channel and the socket;
// knows nothing of chunks.
#pragma once

#include "fvvserve/live_channel.h"
#include "fvvserve/reply.h"

#include <boost/beast/core/tcp_stream.hpp>

namespace fvv::serve {

// Answers the upgrade and lives on until the client goes, is silent for Options::idle, sends a message above
// 4 KiB, or the stream ends. done is called once, at the end.
void serve_live(boost::beast::tcp_stream &&stream, const Request &request, const Options &options,
                std::shared_ptr<LiveChannel> channel, std::function<void(const char *why)> done);

} // namespace fvv::serve
