#include "mux/src/realtime/arrivals.h"
#include "fvv_cxx/format.h"

#include <sys/stat.h>

namespace fvv::mux {

namespace {

// Often enough not to add to the delay, and seldom enough to take no time that counts.
constexpr std::chrono::milliseconds pause{5};
// Places without a whole frame after which no further one is looked for.
constexpr int most_gaps = 25;

bool exists(const std::string &path) {
  struct stat found;
  return stat(path.c_str(), &found) == 0;
}

} // namespace

Arrivals::Arrivals(const scene::Capture &from, const RealtimeOptions &given, std::function<bool()> stopped)
    : capture(from), options(given), is_stopped(std::move(stopped)), marker(from.resolve(end_marker)),
      last(Clock::now()) {
  const Clock::time_point start = last;
  look();
  // What is there already was not made just now: it counts as if it came at the rate of the capture.
  const double duration = capture.frame_seconds();
  for (auto &[place, time] : whole)
    time = start + std::chrono::duration_cast<Clock::duration>(
                       std::chrono::duration<double>(duration * double(place - whole.begin()->first)));
  watcher = std::thread([this] { watch(); });
}

Arrivals::~Arrivals() {
  close();
  watcher.join();
}

void Arrivals::close() {
  const std::lock_guard<std::mutex> lock(mutex);
  closed = true;
  changed.notify_all();
}

bool Arrivals::has_ended() {
  const std::lock_guard<std::mutex> lock(mutex);
  return !end.empty();
}

// all: every file that will come is there.
bool Arrivals::is_whole(const std::function<std::string(int64_t)> &file, int64_t place, bool all) const {
  const auto at = [&](int64_t of) { return file(capture.frames.number_at(of)); };
  const std::string own = at(place);
  if (!exists(own)) return false;
  if (options.arrival == Arrival::by_name || all || at(place + 1) == own) return true;
  constexpr int64_t most_missing = 8; // of the source, one after the other
  for (int64_t later = place + 1; later <= place + most_missing; later++)
    if (exists(at(later))) return true;
  return false;
}

std::string Arrivals::missing_file(int64_t place, bool all) const {
  const int64_t number = capture.frames.number_at(place);
  const auto mesh = [this](int64_t frame) { return capture.mesh_path(frame); };
  if (capture.has_mesh(number) && !is_whole(mesh, place, all)) return mesh(number);
  for (const scene::Camera &camera : capture.cameras) {
    const auto picture = [&](int64_t frame) { return capture.picture_path(camera, frame); };
    const auto mask = [&](int64_t frame) { return capture.mask_path(camera, frame); };
    if (camera.pictures && !is_whole(picture, place, all)) return picture(number);
    if (camera.masks && !is_whole(mask, place, all)) return mask(number);
  }
  return "";
}

// The marker is read before the files: those that the show wrote before it are seen.
void Arrivals::look() {
  const bool stopped = is_stopped && is_stopped(), marked = exists(marker), all = stopped || marked;
  int64_t place;
  {
    const std::lock_guard<std::mutex> lock(mutex);
    place = next;
  }
  for (int gaps = 0; place < capture.frames.places() && gaps < most_gaps; place++) {
    {
      const std::lock_guard<std::mutex> lock(mutex);
      if (closed) return;
      if (whole.count(place)) continue;
    }
    if (!missing_file(place, all).empty()) {
      gaps++;
      continue;
    }
    gaps = 0;
    const std::lock_guard<std::mutex> lock(mutex);
    last = Clock::now();
    if (place >= next) whole[place] = last;
    changed.notify_all();
  }
  const std::lock_guard<std::mutex> lock(mutex);
  if (all && end.empty()) end = stopped ? "it was stopped" : std::string(end_marker) + " is there";
  changed.notify_all();
}

void Arrivals::watch() {
  while (true) {
    {
      std::unique_lock<std::mutex> lock(mutex);
      changed.wait_for(lock, pause, [this] { return closed || !end.empty(); });
      if (closed || !end.empty()) return;
    }
    look();
  }
}

Arrivals::Fate Arrivals::await(int64_t place) {
  std::unique_lock<std::mutex> lock(mutex);
  next = place;
  while (true) {
    if (const auto found = whole.find(place); found != whole.end()) {
      const Clock::time_point time = found->second;
      whole.erase(whole.begin(), std::next(found));
      next = place + 1;
      return {Fate::arrived, time, ""};
    }
    const auto later = whole.upper_bound(place);
    const Clock::time_point now = Clock::now();
    if (later != whole.end() && (!end.empty() || now - later->second > patience)) {
      lock.unlock();
      const std::string missing = missing_file(place, false);
      lock.lock();
      if (whole.count(place)) continue;
      next = place + 1;
      return {Fate::lost, now, (missing.empty() ? "it was not whole" : missing + " is missing")};
    }
    if (!end.empty()) return {Fate::ended, now, end};
    if (closed) return {Fate::ended, now, "it was stopped"};
    if (seconds_of(now - last) > options.idle)
      return {Fate::given_up, now, fvv::format("no frame came for %g s", options.idle)};
    changed.wait_for(lock, pause);
  }
}

} // namespace fvv::mux
