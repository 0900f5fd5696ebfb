// Connections: requests of HTTP, and WebSockets on which live streams go out.
#include "fvvserve/http_session.h"

#include "fvvserve/live_stream.h"
#include "fvvserve/reply.h"

#include <boost/asio/buffer.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/websocket.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <nlohmann/json.hpp>
#include <sys/sendfile.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <sstream>
#include <string_view>

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;

namespace fvv::serve {

namespace {

constexpr size_t largest_inbound = 4096;
constexpr size_t most_rung = 65535; // number of one: a stream has no more tracks

const char *reason(beast::error_code error) {
  if (error == websocket::error::closed) return "closed";
  if (error == websocket::error::message_too_big) return "message above 4 KiB";
  return error == beast::error::timeout ? "timeout" : "gone";
}

class LiveClient : public Listener, public std::enable_shared_from_this<LiveClient> {
public:
  LiveClient(beast::tcp_stream &&stream, const Options &chosen, std::shared_ptr<LiveChannel> live,
             std::optional<size_t> rung, std::function<void(const char *)> when_done)
      : Listener(chosen.queue_bytes), socket(std::move(stream)), channel(std::move(live)),
        done(std::move(when_done)) {
    wanted = rung;
    // The socket's own timer would run beside that of the WebSocket.
    beast::get_lowest_layer(socket).expires_never();
    websocket::stream_base::timeout timeout;
    timeout.handshake_timeout = chosen.request;
    timeout.idle_timeout = chosen.idle;
    timeout.keep_alive_pings = true;
    socket.set_option(timeout);
    socket.read_message_max(largest_inbound);
    socket.auto_fragment(false);
    socket.binary(true);
  }

  ~LiveClient() override {
    channel->leave(*this);
    done(why);
  }

  void accept(const Request &request) {
    // Before the response, so that later messages are not missed.
    if (!channel->join(*this)) channel->ended() ? queue.end("") : queue.restarting();
    socket.async_accept(request, [self = shared_from_this()](beast::error_code error) {
      if (error) return self->finish("handshake");
      self->writing = false;
      self->read();
      self->write();
    });
  }

  void wake() override {
    if (!writing && !finished) write();
  }

private:
  // Messages of a client are read, as its pongs are; all but the wish for a rung and its own ping are
  // ignored.
  void read() {
    socket.async_read(inbound, [self = shared_from_this()](beast::error_code error, size_t) {
      if (error) return self->finish(self->queue.ended() ? "end of stream" : reason(error));
      if (self->socket.got_text()) self->take_message();
      self->inbound.clear();
      self->read();
    });
  }

  void take_message() {
    const auto shallow = [](int depth, nlohmann::json::parse_event_t, nlohmann::json &) {
      return depth <= 1;
    };
    const auto *text = static_cast<const char *>(inbound.data().data());
    const auto message = nlohmann::json::parse(text, text + inbound.size(), shallow, false);
    if (!message.is_object()) return;
    const auto type = message.value("type", nlohmann::json());
    if (type == "ping") {
      asked = true;
      return wake();
    }
    if (type != "rung") return;
    const auto rung = message.find("rung");
    if (rung != message.end() && rung->is_number_unsigned() && *rung <= most_rung)
      wanted = rung->get<size_t>();
  }

  void write() {
    if (asked) return respond();
    const Message *message = queue.next();
    if (!message) {
      if (queue.ended()) close();
      return;
    }
    writing = true;
    socket.text(message->kind == Message::Kind::text);
    socket.async_write(asio::buffer(*message->bytes),
                       [self = shared_from_this()](beast::error_code error, size_t) {
                         self->writing = false;
                         if (error) return self->finish(reason(error));
                         self->queue.sent();
                         self->write();
                       });
  }

  // Pages don't see pings of the protocol.
  void respond() {
    static constexpr std::string_view pong = R"({"type":"pong"})";
    asked = false;
    writing = true;
    socket.text(true);
    socket.async_write(asio::buffer(pong), [self = shared_from_this()](beast::error_code error, size_t) {
      self->writing = false;
      if (error) return self->finish(reason(error));
      self->write();
    });
  }

  void close() {
    writing = true; // nothing goes out after the close frame
    socket.async_close(queue.comes_back() ? websocket::close_code::service_restart
                                          : websocket::close_code::normal,
                       [self = shared_from_this()](beast::error_code) { self->finish("end of stream"); });
  }

  // The last handler that ends frees the client.
  void finish(const char *reason) {
    if (finished) return;
    finished = true;
    why = reason;
    channel->leave(*this);
    beast::get_lowest_layer(socket).cancel();
  }

  websocket::stream<beast::tcp_stream> socket;
  std::shared_ptr<LiveChannel> channel;
  std::function<void(const char *)> done;
  beast::flat_buffer inbound{largest_inbound};
  bool writing = true, finished = false; // writing: the response to the handshake, at first
  bool asked = false;                    // by a ping of the client's
  const char *why = "gone";
};

// Accepts the upgrade and lives until the client goes, is silent for Options::idle, sends a message above
// 4 KiB, or the stream ends. done is called once, at the end.
void serve_live(beast::tcp_stream &&stream, const Request &request, const Options &options,
                std::shared_ptr<LiveChannel> channel, std::optional<size_t> rung,
                std::function<void(const char *why)> done) {
  std::make_shared<LiveClient>(std::move(stream), options, std::move(channel), rung, std::move(done))
      ->accept(request);
}

constexpr uint32_t longest_header = 8192;
constexpr size_t largest_turn = 1 << 20; // bytes of a file before other connections are served
constexpr std::string_view live_prefix = "/live/";

// One line for each request, on stderr. Text of clients cannot control the terminal.
void log(const std::string &peer, std::string text) {
  for (char &c : text)
    if (c < 32 || c > 126) c = '?';
  std::fprintf(stderr, "%s %s\n", peer.c_str(), text.c_str());
}

std::string_view query_of(const Request &request) {
  const std::string_view target(request.target().data(), request.target().size());
  const size_t begin = target.find('?');
  return begin == target.npos ? std::string_view() : target.substr(begin + 1);
}

// "rung=2", among other members, which are ignored. False when its value is not the number of a rung.
bool read_rung(std::string_view query, std::optional<size_t> &rung) {
  constexpr std::string_view key = "rung=";
  while (!query.empty()) {
    const size_t end = std::min(query.find('&'), query.size());
    std::string_view value = query.substr(0, end);
    query.remove_prefix(std::min(end + 1, query.size()));
    if (value.substr(0, key.size()) != key) continue;
    value.remove_prefix(key.size());
    size_t number = 0;
    const auto [rest, error] = std::from_chars(value.data(), value.data() + value.size(), number);
    if (error != std::errc() || rest != value.data() + value.size() || number > most_rung) return false;
    rung = number;
  }
  return true;
}

class HttpSession : public std::enable_shared_from_this<HttpSession> {
public:
  HttpSession(asio::ip::tcp::socket &&socket, Service &shared)
      : stream(std::move(socket)), deadline(stream.get_executor()), service(shared) {
    beast::error_code ignored;
    std::ostringstream text;
    text << stream.socket().remote_endpoint(ignored);
    peer = text.str();
    stream.socket().set_option(asio::ip::tcp::no_delay(true), ignored);
    service.connections++;
  }

  ~HttpSession() {
    if (!handed_on) service.connections--;
  }

  void read() {
    parser.emplace();
    parser->header_limit(longest_header);
    // One deadline for the whole request, not one for each byte.
    stream.expires_after(service.options.request);
    http::async_read(stream, buffer, *parser,
                     [self = shared_from_this()](beast::error_code error, size_t) { self->answer(error); });
  }

private:
  void answer(beast::error_code error) {
    if (error == http::error::header_limit) return refuse_unread(431, "the header is longer than 8 KiB");
    // Errors of the parser: the bytes are not a request. All others: the client is gone.
    if (error && error.category() == make_error_code(http::error::bad_version).category() &&
        error != http::error::end_of_stream && error != http::error::partial_message)
      return refuse_unread(400, "expected a request without a body");
    if (error) return close();
    const Request &request = parser->get();
    std::optional<Reply> refusal = refuse(service.options, request);
    if (refusal) return send(std::move(*refusal));
    const std::string_view path = path_of(request);
    if (path.substr(0, live_prefix.size()) == live_prefix)
      return answer_live(std::string(path.substr(live_prefix.size())));
    send(reply_to(service.options, service.site ? &*service.site : nullptr, request));
  }

  void refuse_unread(unsigned status, const char *line) {
    send(plain_reply(Request{http::verb::get, "-", 11}, status, line, false));
  }

  void answer_live(const std::string &name) {
    const Request &request = parser->get();
    const auto refusal = [&](unsigned status, const char *line) {
      send(plain_reply(request, status, line, false));
    };
    const auto found = service.channels.find(name);
    if (found == service.channels.end()) return refusal(404, "no such live stream");
    if (!beast::websocket::is_upgrade(request)) return refusal(426, "expected a WebSocket");
    const auto origin = request[http::field::origin], host = request[http::field::host];
    if (!origin_allowed(service.options, {origin.data(), origin.size()}, {host.data(), host.size()}))
      return refusal(403, "this origin is not allowed; --allow-origin allows it");
    std::optional<size_t> rung;
    if (!read_rung(query_of(request), rung)) return refusal(400, "expected ?rung=N, N from 0 to 65535");
    if (found->second->ended()) return refusal(410, "the live stream has ended");
    if (found->second->closed()) return refusal(503, "the server is restarting");
    note(101);
    handed_on = true;
    const bool verbose = service.options.verbose;
    serve_live(std::move(stream), request, service.options, found->second, rung,
               [&shared = service, verbose, who = peer, name](const char *why) {
                 shared.connections--;
                 if (verbose) log(who, "/live/" + name + ": " + why);
               });
  }

  void note(unsigned status) {
    if (!service.options.verbose) return;
    std::ostringstream text;
    text << '"' << parser->get().method_string() << ' ' << parser->get().target() << "\" " << status << ' '
         << reply.count;
    log(peer, text.str());
  }

  void send(Reply answer) {
    reply = std::move(answer);
    note(reply.status);
    asio::async_write(stream, asio::buffer(reply.text),
                      [self = shared_from_this()](beast::error_code error, size_t) {
                        if (error) return self->close();
                        self->stream.expires_never();
                        if (self->reply.count) self->stream.socket().native_non_blocking(true, error);
                        self->send_file();
                      });
  }

  void send_file() {
    for (size_t turn = 0; reply.count && turn < largest_turn;) {
      auto offset = static_cast<off_t>(reply.first);
      const size_t wanted = size_t(std::min<uint64_t>(reply.count, largest_turn - turn));
      const ssize_t n = sendfile(stream.socket().native_handle(), reply.file.get(), &offset, wanted);
      if (n < 0 && errno == EINTR) continue;
      if (n < 0 && errno == EAGAIN) break;
      if (n <= 0) return close(); // 0: the file has become shorter; the length was sent already
      reply.first += static_cast<uint64_t>(n);
      reply.count -= static_cast<uint64_t>(n);
      turn += static_cast<size_t>(n);
    }
    if (reply.count) return wait_to_write();
    deadline.cancel();
    if (!reply.keep_alive) return close();
    read();
  }

  void wait_to_write() {
    // Moved at each step: a client may be slow, but not silent.
    deadline.expires_after(service.options.idle);
    deadline.async_wait([self = shared_from_this()](beast::error_code error) {
      if (!error) self->stream.socket().close(error);
    });
    stream.socket().async_wait(asio::ip::tcp::socket::wait_write,
                               [self = shared_from_this()](beast::error_code error) {
                                 if (!error) self->send_file();
                               });
  }

  void close() {
    deadline.cancel();
    beast::error_code ignored;
    stream.socket().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
  }

  beast::tcp_stream stream;
  asio::steady_timer deadline;
  Service &service;
  std::string peer;
  beast::flat_buffer buffer{2 * longest_header};
  std::optional<http::request_parser<http::empty_body>> parser;
  Reply reply;
  bool handed_on = false;
};

} // namespace

void serve_connection(asio::ip::tcp::socket &&socket, Service &service) {
  std::make_shared<HttpSession>(std::move(socket), service)->read();
}

} // namespace fvv::serve
