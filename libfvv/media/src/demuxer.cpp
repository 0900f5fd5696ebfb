#include "demuxer.h"

#include "fvv_cxx/input_file.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <new>

namespace fvv::media {

struct Demuxer::Source {
  FILE *file;
  AVIOContext *io = nullptr;

  explicit Source(const std::string &path) : file(fdopen(open_to_read(path), "rb")) {
    constexpr int buffer_size = 65536;
    auto *buffer = static_cast<uint8_t *>(av_malloc(buffer_size));
    if (buffer) io = avio_alloc_context(buffer, buffer_size, 0, this, read, nullptr, seek);
    if (io) return;
    av_free(buffer);
    fclose(file);
    throw std::bad_alloc();
  }
  Source(const Source &) = delete;
  ~Source() {
    av_free(io->buffer);
    avio_context_free(&io);
    fclose(file);
  }

  // Of a WAV file from a program that could not go back to write its length: 0, or (nearly) the greatest
  // number of 31 or 32 bits in its place. Such a file ends where it ends.
  bool is_endless_wav() const {
    const off_t here = ftello(file);
    uint8_t head[12];
    const bool has_head = fseeko(file, 0, SEEK_SET) == 0 && fread(head, 1, sizeof head, file) == sizeof head;
    const bool back = fseeko(file, here, SEEK_SET) == 0;
    if (!has_head || !back || memcmp(head, "RIFF", 4) || memcmp(head + 8, "WAVE", 4)) return false;
    const uint32_t size =
        uint32_t(head[4]) | uint32_t(head[5]) << 8 | uint32_t(head[6]) << 16 | uint32_t(head[7]) << 24;
    return size == 0 || (size >= 0x7ffff000 && size <= 0x80000100) || size >= 0xfffff000;
  }

  static int read(void *source, uint8_t *bytes, int size) {
    FILE *from = static_cast<Source *>(source)->file;
    const size_t got = fread(bytes, 1, size_t(size), from);
    if (got) return int(got);
    return ferror(from) ? AVERROR(EIO) : AVERROR_EOF;
  }
  static int64_t seek(void *source, int64_t offset, int whence) {
    FILE *in = static_cast<Source *>(source)->file;
    whence &= ~AVSEEK_FORCE;
    if (whence != AVSEEK_SIZE) return fseeko(in, offset, whence) ? AVERROR(errno) : int64_t(ftello(in));
    const off_t here = ftello(in);
    if (fseeko(in, 0, SEEK_END)) return AVERROR(errno);
    const off_t size = ftello(in);
    return fseeko(in, here, SEEK_SET) ? AVERROR(errno) : int64_t(size);
  }
};

namespace {

int refuse_open(AVFormatContext *, AVIOContext **, const char *, int, AVDictionary **) {
  return AVERROR(EPERM);
}

// Formats that only list other files.
bool is_list(const char *format) {
  for (const char *list : {"concat", "dash", "hls", "imf", "sdp", "webm_dash_manifest"})
    if (!strcmp(format, list)) return true;
  return false;
}

} // namespace

Demuxer::Demuxer(const std::string &path, Kind kind, std::optional<uint32_t> stream)
    : path_(path), kind_(kind), source_(std::make_unique<Source>(path)),
      is_endless_(source_->is_endless_wav()) {
  quiet_log();
  clear_log();
  try {
    open();
    choose(stream);
  } catch (...) {
    avformat_close_input(&context_);
    throw;
  }
}

Demuxer::~Demuxer() {
  avformat_close_input(&context_);
}

void Demuxer::open() {
  context_ = avformat_alloc_context();
  if (!context_) throw std::bad_alloc();
  context_->pb = source_->io;
  context_->flags |= AVFMT_FLAG_CUSTOM_IO; // its owner is source_
  context_->io_open = refuse_open;
  context_->error_recognition = AV_EF_CRCCHECK | AV_EF_BITSTREAM | AV_EF_BUFFER | AV_EF_EXPLODE;
  const AVInputFormat *format = nullptr;
  int code = av_probe_input_buffer2(source_->io, &format, "", context_, 0, 0);
  if (code < 0) fail(path_ + no_such_file(), code);
  if (is_list(format->name))
    throw Error(path_, std::string("is a list of other files (") + format->name + "), which are not read");
  code = avformat_open_input(&context_, "", format, nullptr); // frees the context when it fails
  if (code < 0) fail(path_ + no_such_file(), code);
  code = avformat_find_stream_info(context_, nullptr);
  // It decodes as well, and errors of the decoder in a file that begins within a group do not count here.
  if (code < 0 || log_has_demuxer_error()) fail(path_ + ": is cut or damaged", code);
}

void Demuxer::choose(std::optional<uint32_t> wanted) {
  const auto fits = [this](const AVStream &stream) {
    return stream.codecpar->codec_type == (kind_ == video ? AVMEDIA_TYPE_VIDEO : AVMEDIA_TYPE_AUDIO) &&
           !(stream.disposition & AV_DISPOSITION_ATTACHED_PIC);
  };
  const std::string what = kind_ == video ? "video" : "sound";
  for (unsigned i = 0; i < context_->nb_streams; i++) {
    AVStream &stream = *context_->streams[i];
    stream.discard = AVDISCARD_ALL;
    if (!stream_ && (wanted ? i == *wanted : fits(stream))) stream_ = &stream;
  }
  if (!stream_)
    throw Error(path_, wanted ? "has " + std::to_string(context_->nb_streams) + " streams, stream " +
                                    std::to_string(*wanted) + " is not among them"
                              : "has no " + what + " stream");
  if (!fits(*stream_)) throw Error(path_, "stream " + std::to_string(*wanted) + " is no " + what);
  stream_->discard = AVDISCARD_DEFAULT;
}

std::string Demuxer::no_such_file() const {
  return std::string(": is no ") + (kind_ == video ? "video" : "sound") + " file, or is cut or damaged";
}

std::string Demuxer::tag(const char *name) const {
  for (const AVDictionary *tags : {stream_->metadata, context_->metadata})
    if (const AVDictionaryEntry *entry = av_dict_get(tags, name, nullptr, 0)) return entry->value;
  return {};
}

std::optional<int64_t> Demuxer::first_picture() const {
  for (unsigned i = 0; i < context_->nb_streams; i++) {
    const AVStream &stream = *context_->streams[i];
    if (stream.codecpar->codec_type != AVMEDIA_TYPE_VIDEO ||
        (stream.disposition & AV_DISPOSITION_ATTACHED_PIC) || stream.start_time == AV_NOPTS_VALUE)
      continue;
    return av_rescale_q(stream.start_time, stream.time_base, stream_->time_base);
  }
  return std::nullopt;
}

bool Demuxer::read(AVPacket *packet) {
  clear_log();
  for (;;) {
    av_packet_unref(packet);
    const int code = av_read_frame(context_, packet);
    // Demuxers log a message for a file that ends too early, and then report a regular end.
    if (log_has_error() || (code < 0 && code != AVERROR_EOF)) fail(path_ + ": is cut or damaged", code);
    if (code == AVERROR_EOF) return false;
    if (packet->stream_index != stream_->index || packet->size == 0) continue;
    if (packet->flags & AV_PKT_FLAG_CORRUPT && !is_endless_) throw Error(path_, "is cut or damaged");
    return true;
  }
}

bool Demuxer::seek(int64_t dts) {
  const bool found = av_seek_frame(context_, stream_->index, dts, AVSEEK_FLAG_BACKWARD) >= 0;
  clear_log();
  return found;
}

} // namespace fvv::media
