#include "fvvserve/live_channel.h"

#include "cli/cli.h"

namespace fvv::serve {

LiveChannel::LiveChannel(const Options &options, const LiveInput &input, Post to_network)
    : name(input.name), post(std::move(to_network)), source(options, input, [this](Piece piece) {
        auto shared = std::make_shared<const Piece>(std::move(piece));
        post([this, shared] {
          receive(*shared);
          source.taken();
        });
      }) {}

bool LiveChannel::join(Listener &listener) {
  if (over) return false;
  listeners.insert(&listener);
  source.audience(listeners.size());
  return true;
}

void LiveChannel::leave(Listener &listener) {
  if (listeners.erase(&listener)) source.audience(listeners.size());
}

void LiveChannel::close() {
  over = true;
  for (Listener *listener : listeners) {
    listener->queue.end("");
    listener->wake();
  }
}

void LiveChannel::receive(const Piece &piece) {
  switch (piece.kind) {
  case Piece::Kind::header:
    opening = {piece.bytes, nullptr, opening.version + 1, false};
    for (Listener *listener : listeners) listener->queue.restart();
    return;
  case Piece::Kind::configuration:
    opening.repeated = opening.configuration && *opening.configuration == *piece.bytes;
    if (!opening.repeated) opening.version++;
    opening.configuration = piece.bytes;
    return;
  case Piece::Kind::group:
    // Without a file header the stream has lost its beginning: nobody can be let in.
    if (opening.header && opening.configuration)
      for (Listener *listener : listeners) listener->queue.group(opening, piece.time, piece.bytes);
    opening.repeated = false;
    break;
  case Piece::Kind::chunk:
    for (Listener *listener : listeners) listener->queue.chunk(piece.time, piece.bytes);
    break;
  case Piece::Kind::damage:
    cli::warn("/live/" + name + ": " + piece.text);
    for (Listener *listener : listeners) listener->queue.damage(piece.text);
    break;
  case Piece::Kind::end:
    if (!piece.text.empty()) cli::warn("/live/" + name + ": " + piece.text);
    over = piece.last;
    for (Listener *listener : listeners) listener->queue.end(piece.text);
    break;
  }
  for (Listener *listener : listeners) listener->wake();
}

} // namespace fvv::serve
