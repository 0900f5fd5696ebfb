#include "fvvserve/live_client.h"

#include <boost/asio/buffer.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket.hpp>

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;

namespace fvv::serve {

namespace {

constexpr size_t largest_inbound = 4096;

const char *reason(beast::error_code error) {
  if (error == websocket::error::closed) return "closed";
  if (error == websocket::error::message_too_big) return "message above 4 KiB";
  return error == beast::error::timeout ? "timeout" : "gone";
}

class LiveClient : public Listener, public std::enable_shared_from_this<LiveClient> {
public:
  LiveClient(beast::tcp_stream &&stream, const Options &chosen, std::shared_ptr<LiveChannel> live,
             std::function<void(const char *)> when_done)
      : Listener(chosen.queue_bytes), socket(std::move(stream)), channel(std::move(live)),
        done(std::move(when_done)) {
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
    // Before the answer: what comes in behind it must not be missed.
    if (!channel->join(*this)) queue.end("");
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
  // What a client says is read, so that its pongs are, and has no meaning.
  void read() {
    socket.async_read(inbound, [self = shared_from_this()](beast::error_code error, size_t) {
      if (error) return self->finish(self->queue.ended() ? "end of stream" : reason(error));
      self->inbound.clear();
      self->read();
    });
  }

  void write() {
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

  void close() {
    writing = true; // nothing goes out behind the close frame
    socket.async_close(websocket::close_code::normal,
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
  bool writing = true, finished = false; // writing: the answer to the handshake, at first
  const char *why = "gone";
};

} // namespace

void serve_live(beast::tcp_stream &&stream, const Request &request, const Options &options,
                std::shared_ptr<LiveChannel> channel, std::function<void(const char *why)> done) {
  std::make_shared<LiveClient>(std::move(stream), options, std::move(channel), std::move(done))
      ->accept(request);
}

} // namespace fvv::serve
