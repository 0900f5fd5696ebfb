#include "mux/src/realtime/intake.h"

namespace fvv::mux {

Intake::Intake(std::unique_ptr<FrameSource> from, size_t frames) : source(std::move(from)), ahead(frames) {
  reader = std::thread([this] {
    try {
      while (!is_closed()) {
        Item item = source->next();
        const bool last = item.is_last();
        push(std::move(item));
        if (last) return;
      }
    } catch (...) {
      const std::lock_guard<std::mutex> lock(mutex);
      failure = std::current_exception();
      changed.notify_all();
    }
  });
}

Intake::~Intake() {
  {
    const std::lock_guard<std::mutex> lock(mutex);
    closed = true;
    changed.notify_all();
  }
  source->close();
  reader.join();
}

bool Intake::is_closed() {
  const std::lock_guard<std::mutex> lock(mutex);
  return closed;
}

Intake::Item Intake::next() {
  std::unique_lock<std::mutex> lock(mutex);
  changed.wait(lock, [this] { return failure || !items.empty(); });
  if (items.empty()) std::rethrow_exception(failure);
  if (items.front().is_last()) return items.front();
  Item item = std::move(items.front());
  items.pop_front();
  changed.notify_all();
  return item;
}

void Intake::push(Item item) {
  std::unique_lock<std::mutex> lock(mutex);
  changed.wait(lock, [this] { return closed || items.size() < ahead; });
  items.push_back(std::move(item));
  changed.notify_all();
}

} // namespace fvv::mux
