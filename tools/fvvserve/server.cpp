#include "fvvserve/server.h"

#include "cli/cli.h"
#include "fvvserve/http_session.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <sstream>

namespace asio = boost::asio;
using asio::ip::tcp;

namespace fvv::serve {

namespace {

constexpr std::chrono::milliseconds farewell{300}; // for the last messages to live clients
constexpr std::chrono::milliseconds pause{100};    // after a failed accept: no descriptor is free
constexpr int longest_backlog = 1024;

// A connection takes a descriptor, and a file that is sent another one.
void raise_descriptor_limit(size_t connections) {
  rlimit limit;
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = std::max<rlim_t>(limit.rlim_cur, std::min<rlim_t>(limit.rlim_max, 2 * connections + 64));
  setrlimit(RLIMIT_NOFILE, &limit);
}

class Server {
public:
  explicit Server(const Options &options) : acceptor(io), timer(io), signals(io) {
    service.options = options;
    // What was ignored at the start (nohup, jobs of a script) stays ignored.
    for (const int number : {SIGINT, SIGTERM}) {
      struct sigaction former;
      if (sigaction(number, nullptr, &former) != 0 || former.sa_handler != SIG_IGN) signals.add(number);
    }
    if (!options.root.empty()) service.site.emplace(options.root, options.open);
    for (const LiveInput &input : options.live)
      if (!service.channels
               .emplace(input.name, std::make_shared<LiveChannel>(service.options, input,
                                                                  [this](std::function<void()> work) {
                                                                    asio::post(io, std::move(work));
                                                                  }))
               .second)
        throw Error("--live: two streams have the name " + input.name, Error::usage);
    if (std::count_if(options.live.begin(), options.live.end(),
                      [](const LiveInput &l) { return l.file == "-"; }) > 1)
      throw Error("--live: two streams from standard input", Error::usage);
    raise_descriptor_limit(options.connections);
    listen();
  }

  ~Server() {
    for (const auto &channel : service.channels) channel.second->halt();
  }

  std::string address() const {
    std::ostringstream text;
    text << acceptor.local_endpoint();
    return text.str();
  }

  void run() {
    signals.async_wait([this](boost::system::error_code error, int) {
      if (!error) stop();
    });
    for (const auto &channel : service.channels) channel.second->start();
    accept();
    io.run();
  }

private:
  void listen() {
    const std::string name = service.options.bind + ":" + std::to_string(service.options.port);
    boost::system::error_code error;
    const auto address = asio::ip::make_address(service.options.bind, error);
    if (error) throw Error("--bind: expected an address, found '" + service.options.bind + "'", Error::usage);
    const tcp::endpoint endpoint(address, service.options.port);
    acceptor.open(endpoint.protocol());
    acceptor.set_option(tcp::acceptor::reuse_address(true));
    acceptor.bind(endpoint, error);
    if (!error) acceptor.listen(longest_backlog, error);
    if (error) throw Error(name + ": cannot listen: " + error.message());
  }

  void accept() {
    acceptor.async_accept([this](boost::system::error_code error, tcp::socket socket) {
      if (!acceptor.is_open()) return;
      if (error) {
        timer.expires_after(pause);
        timer.async_wait([this](boost::system::error_code stopped) {
          if (!stopped) accept();
        });
        return;
      }
      if (service.connections < service.options.connections)
        serve_connection(std::move(socket), service);
      else
        turn_away(socket);
      accept();
    });
  }

  // One attempt, without waiting for a client that does not take these few bytes at once.
  static void turn_away(tcp::socket &socket) {
    constexpr char reply[] = "HTTP/1.1 503 Service Unavailable\r\nRetry-After: 5\r\nContent-Length: "
                             "0\r\nConnection: close\r\n\r\n";
    boost::system::error_code ignored;
    socket.non_blocking(true, ignored);
    socket.write_some(asio::buffer(reply, sizeof reply - 1), ignored);
    socket.shutdown(tcp::socket::shutdown_both, ignored);
  }

  void stop() {
    acceptor.close();
    for (const auto &channel : service.channels) channel.second->close();
    timer.expires_after(farewell);
    timer.async_wait([this](boost::system::error_code) { io.stop(); });
  }

  Service service; // outlives the connections, which die with io
  asio::io_context io{1};
  tcp::acceptor acceptor;
  asio::steady_timer timer;
  asio::signal_set signals;
};

} // namespace

void serve(const Options &options, const std::function<void(const std::string &address)> &ready) {
  Server server(options);
  ready(server.address());
  server.run();
}

} // namespace fvv::serve
