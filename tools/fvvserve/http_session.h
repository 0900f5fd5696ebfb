// One connection: requests in, replies out, files by sendfile; live streams by WebSocket.
#pragma once

#include "fvvserve/live_stream.h"
#include "fvvserve/reply.h"

#include <boost/asio/ip/tcp.hpp>

#include <map>

namespace fvv::serve {

// What all connections share. Outlives them.
struct Service {
  Options options;
  std::optional<Site> site;
  std::map<std::string, std::shared_ptr<LiveChannel>> channels;
  size_t connections = 0;
};

// Lives on until the connection ends; counts itself in Service::connections.
void serve_connection(boost::asio::ip::tcp::socket &&socket, Service &service);

} // namespace fvv::serve
