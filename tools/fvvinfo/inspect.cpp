#include "fvvinfo/report.h"

#include "fvv_cxx/error.h"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace fvv::info {

namespace {

void take_event(void *user, const fvv_event *event) {
  auto &report = *static_cast<Report *>(user);
  const bool whole = event->kind == FVV_EVENT_CHUNK;
  if (whole && event->chunk.type == FVV_CHUNK_INDEX) report.has_index = true;
  if (!report.options.chunks || !(whole || (event->kind == FVV_EVENT_DAMAGE && event->has_chunk))) return;
  report.chunks.push_back({event->offset, event->chunk, whole && event->group_intact});
}

// A descriptor that is closed when reading ends in any way.
class Source {
public:
  explicit Source(const std::string &path) : name(path == "-" ? "standard input" : path) {
    descriptor = path == "-" ? STDIN_FILENO : open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) throw Error(name + ": cannot open: " + std::strerror(errno));
  }
  ~Source() {
    if (descriptor != STDIN_FILENO) close(descriptor);
  }
  Source(const Source &) = delete;
  Source &operator=(const Source &) = delete;

  uint64_t size() const { // 0 when it is not known
    struct stat status;
    return fstat(descriptor, &status) == 0 && S_ISREG(status.st_mode) ? uint64_t(status.st_size) : 0;
  }
  size_t read(uint8_t *out, size_t size) {
    for (;;) {
      const ssize_t n = ::read(descriptor, out, size);
      if (n >= 0) return size_t(n);
      if (errno != EINTR) throw Error(name + ": cannot read: " + std::strerror(errno));
    }
  }

private:
  std::string name;
  int descriptor;
};

} // namespace

Report inspect(const std::string &path, const Options &options) {
  if (path == "-" && isatty(STDIN_FILENO))
    throw Error("standard input is a terminal: name a file or pipe a stream into it", Error::usage);
  Source source(path);
  Report report;
  report.name = path == "-" ? "standard input" : path;
  report.options = options;
  fvv_check_options check;
  fvv_check_options_default(&check);
  check.decode = options.check;
  check.event = take_event;
  check.user = &report;
  fvv_checker *checker = nullptr;
  if (fvv_checker_create(&check, nullptr, nullptr, &checker) != FVV_OK) throw std::bad_alloc();
  report.checker.reset(checker);
  constexpr size_t block = 1 << 20;
  cli::Progress progress("reading " + report.name, source.size() / block);
  std::vector<uint8_t> bytes(block);
  while (const size_t n = source.read(bytes.data(), block)) {
    report.status = fvv_checker_push(checker, bytes.data(), n);
    if (report.status < 0) break;
    if (n == block) progress.step();
  }
  if (report.status >= 0) report.status = fvv_checker_finish(checker);
  // The callback's address is that of this local report: nothing is pushed any more.
  return report;
}

const char *Report::integrity() const {
  if (status < 0) return "unreadable";
  const auto &s = summary();
  for (size_t i = 0; i < fvv_checker_problem_count(checker.get()); i++)
    if (fvv_checker_problem(checker.get(), i)->status != FVV_ERROR_TRUNCATED) return "damaged";
  return s.truncated || s.problems ? "truncated" : "complete";
}

cli::Exit Report::exit() const {
  const std::string state = integrity();
  return state == "complete" ? cli::done : state == "truncated" ? cli::loss : cli::failed;
}

double pixel_share(const Report &report, const fvv_video_layout &video) {
  double pixels = 0;
  for (size_t i = 0; i < video.tile_count; i++)
    if (const fvv_camera *camera = fvv_configuration_camera(report.configuration(), video.tiles[i].camera_id))
      pixels += double(camera->width) * camera->height;
  return pixels > 0 ? double(video.config.width) * video.config.height / pixels : 0;
}

std::string type_name(uint32_t code) {
  std::string out;
  for (int i = 0; i < 4; i++) {
    const char c = char(code >> (8 * i) & 255);
    out += c >= 0x20 && c <= 0x7e ? c : '?';
  }
  return out;
}

std::string codec_name(uint32_t codec) {
  switch (codec) {
  case FVV_CODEC_JPEG:
    return "JPEG";
  case FVV_CODEC_AVC1:
    return "H.264";
  case FVV_CODEC_HVC1:
    return "HEVC";
  case FVV_CODEC_VP09:
    return "VP9";
  case FVV_CODEC_AV01:
    return "AV1";
  case FVV_CODEC_OEXR:
    return "OpenEXR";
  default:
    return type_name(codec);
  }
}

const char *kind_name(uint8_t kind) {
  switch (kind) {
  case FVV_TRACK_MESH:
    return "mesh";
  case FVV_TRACK_VIDEO:
    return "video";
  case FVV_TRACK_CALIBRATION:
    return "calibration";
  case FVV_TRACK_VISIBILITY:
    return "visibility";
  case FVV_TRACK_BACKGROUND:
    return "background";
  case FVV_TRACK_METADATA:
    return "metadata";
  case FVV_TRACK_AUDIO:
    return "audio";
  default:
    return "unknown";
  }
}

const char *lens_name(uint8_t lens) {
  return lens == FVV_LENS_RADTAN ? "radtan" : lens == FVV_LENS_FISHEYE ? "fisheye" : "none";
}

const char *up_name(uint8_t up) {
  static const char *const names[] = {"unknown", "+x", "+y", "+z", "-x", "-y", "-z"};
  return up <= FVV_UP_MINUS_Z ? names[up] : names[0];
}

} // namespace fvv::info
