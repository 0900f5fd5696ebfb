// The encoder in C: arguments are checked and copied, exceptions become statuses.
#include "fvv/encoder.h"

#include "fvv_cxx/stream_error.h"
#include "fvv_media/image.h"
#include "fvv_media/video.h"
#include "fvv_mux/encoder.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

namespace {

using namespace fvv;

// A call that is refused for its arguments, or ended by a callback.
struct Refusal {
  fvv_status status;
  std::string text;
};

[[noreturn]] void refuse(const std::string &text) {
  throw Refusal{FVV_ERROR_ARGUMENT, text};
}

// One line, cut where a character of UTF-8 begins.
void describe(fvv_diagnostic *diagnostic, fvv_status status, const char *text) noexcept {
  if (!diagnostic) return;
  *diagnostic = {};
  diagnostic->status = status;
  const char more[] = "...";
  const size_t room = sizeof diagnostic->message - 1, length = std::strlen(text);
  size_t size = length;
  if (length > room) {
    size = room - (sizeof more - 1);
    while (size && (static_cast<unsigned char>(text[size]) & 0xc0) == 0x80) size--;
  }
  std::memcpy(diagnostic->message, text, size);
  if (length > room) std::memcpy(diagnostic->message + size, more, sizeof more - 1);
  std::replace(diagnostic->message, diagnostic->message + size, '\n', ' ');
}

// unusable: the status for what the encoder refuses.
template <class Work>
fvv_status guarded(fvv_diagnostic *diagnostic, fvv_status unusable, const Work &work) noexcept {
  if (diagnostic) *diagnostic = {};
  fvv_status status = FVV_ERROR_BUG;
  const char *text = "unknown exception";
  try {
    try {
      work();
      return FVV_OK;
    } catch (const Refusal &refusal) {
      status = refusal.status;
      describe(diagnostic, status, refusal.text.c_str());
    } catch (const StreamError &error) {
      const fvv_status found = error.diagnostic.status;
      status = found == FVV_ERROR_MEMORY || found == FVV_ERROR_BUG ? found : unusable;
      describe(diagnostic, status, error.what());
      if (diagnostic) diagnostic->issue = error.diagnostic.issue;
    } catch (const Error &error) {
      status = unusable;
      describe(diagnostic, status, error.what());
    } catch (const std::bad_alloc &) {
      status = FVV_ERROR_MEMORY;
      describe(diagnostic, status, "out of memory");
    } catch (const std::length_error &) {
      status = FVV_ERROR_MEMORY;
      describe(diagnostic, status, "out of memory");
    } catch (const std::exception &error) {
      describe(diagnostic, status, error.what());
    }
  } catch (...) {
    describe(diagnostic, status, text);
  }
  return status;
}

// The size of a struct of the caller. Larger than ours is one of a later version, which we can serve if it
// uses no field that we lack.
constexpr size_t largest_struct = 4096;
template <class Struct> size_t checked_size(const Struct *given, size_t least, const char *name) {
  size_t size = 0;
  std::memcpy(&size, given, sizeof size);
  if (size < least || size > largest_struct)
    refuse(std::string(name) + ": struct_size: expected " + std::to_string(sizeof(Struct)) + ", found " +
           std::to_string(size));
  return size;
}

// A copy of a struct of the caller.
template <class Struct> Struct taken(const Struct *given, const char *name) {
  if (!given) refuse(std::string(name) + ": is NULL");
  // All fields are of the first version.
  const size_t size = checked_size(given, sizeof(Struct), name);
  const auto *bytes = reinterpret_cast<const unsigned char *>(given);
  if (!std::all_of(bytes + sizeof(Struct), bytes + size, [](unsigned char byte) { return byte == 0; }))
    refuse(std::string(name) + ": has fields that this version of the library does not know");
  Struct out;
  std::memcpy(&out, given, sizeof out);
  return out;
}

std::string text_of(const char *text) {
  return text ? text : "";
}

// Without the locale of the program.
std::string text_of(double value) {
  char out[32];
  return {out, std::to_chars(out, out + sizeof out, value).ptr};
}

mux::Options options_of(const fvv_encoder_options &given) {
  mux::Options options;
  const auto set = [&](bool is_set, const char *name, const std::string &value) {
    if (is_set) mux::set_option(options, name, value);
  };
  if (given.codec) {
    const media::VideoCodec *codec = media::find_video_codec(given.codec);
    if (!codec) refuse("options: codec: unknown: " + std::to_string(given.codec));
    set(true, "codec", codec->option);
  }
  set(given.bit_depth, "bit-depth", std::to_string(given.bit_depth));
  set(given.psnr != 0, "quality", text_of(given.psnr) + "dB");
  set(given.bit_rate, "bitrate", std::to_string(given.bit_rate));
  set(given.max_error != 0, "max-error", text_of(given.max_error));
  set(given.group, "group", std::to_string(given.group));
  const unsigned processors = std::clamp(std::thread::hardware_concurrency(), 1u, 256u);
  set(true, "threads", std::to_string(given.threads ? given.threads : processors));
  set(given.without_meshes, "no-meshes", "on");
  if (given.named_count && !given.named) refuse("options: named: is NULL");
  for (size_t i = 0; i < given.named_count; i++) {
    const fvv_encoder_option &one = given.named[i];
    if (!one.name || !one.value) refuse("options: named option " + std::to_string(i) + ": is NULL");
    set(true, one.name, one.value);
  }
  return options;
}

// A file that appears whole or not at all.
class File {
public:
  explicit File(const char *the_path)
      : path(the_path), part(path + ".part"), file(std::fopen(part.c_str(), "wb")) {
    if (!file) fail();
  }
  ~File() {
    if (!file) return;
    std::fclose(file);
    std::remove(part.c_str());
  }
  File(const File &) = delete;
  File &operator=(const File &) = delete;

  void write(const void *bytes, size_t size) {
    if (std::fwrite(bytes, 1, size, file) != size) fail();
  }
  void commit() {
    if (std::fclose(std::exchange(file, nullptr)) == 0 && std::rename(part.c_str(), path.c_str()) == 0)
      return;
    const int reason = errno;
    std::remove(part.c_str());
    errno = reason;
    fail();
  }

private:
  [[noreturn]] void fail() const { throw Refusal{FVV_ERROR_IO, path + ": " + std::strerror(errno)}; }

  const std::string path, part;
  std::FILE *file;
};

template <class Sample>
media::BasicImage<Sample> image_of(const fvv_encoder_picture &given, const fvv_camera &camera,
                                   const std::string &where) {
  media::BasicImage<Sample> out;
  out.width = given.width;
  out.height = given.height;
  out.channels = int(given.channels);
  // A picture of another size is refused by it; nothing of it is read.
  if (out.width != camera.width || out.height != camera.height) return out;
  const size_t row = size_t(out.width) * given.channels;
  const size_t stride = given.stride ? given.stride : row * sizeof(Sample);
  if (stride < row * sizeof(Sample))
    refuse(where + ": stride: expected at least " + std::to_string(row * sizeof(Sample)) + ", found " +
           std::to_string(stride));
  out.pixels.resize(row * out.height);
  for (size_t y = 0; y < out.height; y++)
    std::memcpy(&out.pixels[y * row], static_cast<const char *>(given.pixels) + y * stride,
                row * sizeof(Sample));
  return out;
}

void check_picture(const fvv_encoder_picture &given, uint32_t channels, const std::string &where) {
  if (!given.pixels) refuse(where + ": pixels: is NULL");
  if (given.channels != channels)
    refuse(where + ": channels: expected " + std::to_string(channels) + ", found " +
           std::to_string(given.channels));
}

media::AnyImage picture_of(const fvv_encoder_picture &given, const fvv_camera &camera,
                           const std::string &where) {
  check_picture(given, 3, where);
  if (given.bits == 8) return image_of<uint8_t>(given, camera, where);
  if (given.bits == 16) return image_of<uint16_t>(given, camera, where);
  if (given.bits == 32) return image_of<float>(given, camera, where);
  refuse(where + ": bits: expected 8, 16 or 32, found " + std::to_string(given.bits));
}

media::Image mask_of(const fvv_encoder_picture &given, const fvv_camera &camera, const std::string &where) {
  check_picture(given, 1, where);
  if (given.bits != 8) refuse(where + ": bits: expected 8, found " + std::to_string(given.bits));
  return image_of<uint8_t>(given, camera, where);
}

} // namespace

struct fvv_encoder {
  fvv_encoder_options given = {};
  fvv_output output = {};
  std::unique_ptr<File> file; // else output
  mux::Configuration configuration;
  mux::Options options;
  std::unique_ptr<mux::Encoder> encoder;
  size_t frames = 0;
  uint32_t warnings = 0;
  fvv_status ended = FVV_OK; // by progress
  enum { open, broken, finished } state = open;

  fvv_encoder(const fvv_encoder_options &chosen) : given(chosen), options(options_of(chosen)) {
    configuration.name = text_of(chosen.name);
    if (chosen.frame_duration.numerator || chosen.frame_duration.denominator)
      configuration.frame_duration = chosen.frame_duration;
    configuration.meshes = options.meshes;
    configuration.up = chosen.up;
    configuration.scale_unknown = chosen.scale_unknown;
    if (chosen.up > FVV_UP_MINUS_Z) refuse("options: up: unknown: " + std::to_string(chosen.up));
  }

  // An encoder for the configuration, which refuses what is wrong with it.
  std::unique_ptr<mux::Encoder> encoder_of(const mux::Configuration &chosen) {
    mux::Observer observer;
    observer.on_warning = [this](const std::string &text) {
      warnings++;
      if (given.warning) given.warning(given.user, text.c_str());
    };
    observer.on_progress = [this](size_t count) {
      if (given.progress && ended == FVV_OK)
        ended = std::min<fvv_status>(given.progress(given.user, count), FVV_OK);
    };
    observer.is_cancelled = [this] { return ended != FVV_OK; };
    const auto sink = [this](const void *bytes, size_t size) {
      if (file) return file->write(bytes, size);
      const fvv_status status = output.write(output.user, bytes, size);
      if (status != FVV_OK)
        throw Refusal{status < 0 ? status : FVV_ERROR_IO,
                      "writing failed: " + text_of(fvv_status_text(status))};
    };
    return std::make_unique<mux::Encoder>(chosen, options, sink, observer);
  }

  void require(bool before_frames) const {
    const char *why = state == broken           ? "the encoder failed before"
                      : state == finished       ? "the stream is finished"
                      : before_frames && frames ? "cameras and sound are added before the first frame"
                                                : nullptr;
    if (why) throw Refusal{FVV_ERROR_STATE, why};
  }

  // What writes to the stream: a failure leaves it incomplete.
  template <class Work> void writing(const Work &work) {
    state = broken;
    try {
      work();
    } catch (const Error &error) {
      if (error.kind == Error::cancelled) throw Refusal{ended, "ended by progress"};
      throw;
    }
    if (ended != FVV_OK) throw Refusal{ended, "ended by progress"};
    state = open;
  }

  mux::Frame frame_of(const fvv_encoder_frame &frame) const;
};

mux::Frame fvv_encoder::frame_of(const fvv_encoder_frame &frame) const {
  const std::string where = "frame " + std::to_string(frames);
  fvv_limits limits;
  fvv_limits_default(&limits);
  const auto check_count = [&](size_t count, size_t most, const void *array, const char *name) {
    if (count && !array) refuse(where + ": " + name + ": is NULL");
    if (count > most)
      throw Refusal{FVV_ERROR_INPUT, where + ": " + name + ": expected at most " + std::to_string(most) +
                                         ", found " + std::to_string(count)};
  };
  check_count(frame.vertex_count, limits.max_vertices, frame.positions, "positions");
  check_count(frame.face_count, limits.max_faces, frame.faces, "faces");
  const std::vector<mux::CameraInput> &cameras = configuration.cameras;
  if (frame.camera_count && frame.camera_count != cameras.size())
    refuse(where + ": camera_count: expected " + std::to_string(cameras.size()) + ", found " +
           std::to_string(frame.camera_count));
  mux::Frame out;
  const auto copy = [&](auto &to, const auto *from, size_t count) {
    if (from) to.assign(from, from + count);
  };
  copy(out.mesh.positions, frame.positions, 3 * frame.vertex_count);
  copy(out.mesh.faces, frame.faces, 3 * frame.face_count);
  copy(out.mesh.texture, frame.texture, 2 * frame.vertex_count);
  copy(out.mesh.normals, frame.normals, 3 * frame.vertex_count);
  if (!frame.camera_count) return out;
  if (frame.pictures) out.pictures.resize(cameras.size());
  if (frame.masks) out.masks.resize(cameras.size());
  if (frame.visibility) out.visibility.resize(cameras.size());
  if (frame.calibrations) out.calibrations.resize(cameras.size());
  for (size_t i = 0; i < cameras.size(); i++) {
    const mux::CameraInput &camera = cameras[i];
    const std::string which = where + ": camera " + std::to_string(camera.calibration.id);
    if (camera.pictures && frame.pictures)
      out.pictures[i] = picture_of(frame.pictures[i], camera.calibration, which + ": picture");
    if (camera.pictures && camera.masks && frame.masks)
      out.masks[i] = mask_of(frame.masks[i], camera.calibration, which + ": mask");
    if (camera.visibility && frame.visibility)
      copy(out.visibility[i], frame.visibility[i], frame.vertex_count);
    if (!camera.moves || !frame.calibrations) continue;
    out.calibrations[i] = frame.calibrations[i];
    out.calibrations[i].flags &= uint8_t(~FVV_CAMERA_MOVES);
    out.calibrations[i].name = nullptr;
    out.calibrations[i].name_size = 0;
  }
  return out;
}

namespace {

template <class Open>
fvv_status create(const fvv_encoder_options *options, fvv_encoder **encoder, fvv_diagnostic *diagnostic,
                  const Open &open) noexcept {
  if (encoder) *encoder = nullptr;
  return guarded(diagnostic, FVV_ERROR_ARGUMENT, [&] {
    if (!encoder) refuse("encoder: is NULL");
    auto made = std::make_unique<fvv_encoder>(options ? taken(options, "options") : fvv_encoder_options{});
    open(*made);
    made->encoder = made->encoder_of(made->configuration);
    *encoder = made.release();
  });
}

// Runs add, which changes a configuration.
template <class Add>
fvv_status configure(fvv_encoder *encoder, fvv_diagnostic *diagnostic, const Add &add) noexcept {
  return guarded(diagnostic, FVV_ERROR_ARGUMENT, [&] {
    if (!encoder) refuse("encoder: is NULL");
    encoder->require(true);
    mux::Configuration changed = encoder->configuration;
    add(changed);
    std::unique_ptr<mux::Encoder> made = encoder->encoder_of(changed);
    encoder->configuration = std::move(changed);
    encoder->encoder = std::move(made);
  });
}

fvv_encoder_report values_of(const mux::Report &found, uint32_t warnings, size_t size) {
  fvv_encoder_report out = {};
  out.struct_size = size;
  out.frames = found.frames;
  out.groups = found.groups;
  out.rungs = found.rung_count();
  out.bytes = found.bytes;
  for (size_t i = 0; i <= found.lower_meshes.size(); i++) {
    const mux::MeshSums &meshes = found.meshes(i);
    out.mesh_bytes += meshes.mesh.payload;
    out.visibility_bytes += meshes.visibility.bytes;
    out.colour_bytes += meshes.colours.track.payload;
  }
  for (const mux::VideoTrackReport &video : found.videos) out.video_bytes += video.payload;
  for (const mux::SoundReport &sound : found.sounds) out.sound_bytes += sound.payload;
  out.calibration_bytes = found.calibration.payload;
  out.faces = found.faces;
  out.step = found.has_meshes ? found.lattice.step : 0;
  out.seconds = found.seconds;
  out.warnings = warnings;
  return out;
}

} // namespace

fvv_status fvv_encoder_create(const fvv_encoder_options *options, const fvv_output *output,
                              fvv_encoder **encoder, fvv_diagnostic *diagnostic) {
  return create(options, encoder, diagnostic, [&](fvv_encoder &made) {
    if (!output || !output->write) refuse("output: is NULL");
    made.output = *output;
  });
}

fvv_status fvv_encoder_create_file(const char *path, const fvv_encoder_options *options,
                                   fvv_encoder **encoder, fvv_diagnostic *diagnostic) {
  return create(options, encoder, diagnostic, [&](fvv_encoder &made) {
    if (!path) refuse("path: is NULL");
    made.file = std::make_unique<File>(path);
  });
}

void fvv_encoder_destroy(fvv_encoder *encoder) {
  delete encoder;
}

fvv_status fvv_encoder_add_camera(fvv_encoder *encoder, const fvv_encoder_camera *camera,
                                  fvv_diagnostic *diagnostic) {
  return configure(encoder, diagnostic, [&](mux::Configuration &configuration) {
    const fvv_encoder_camera given = taken(camera, "camera");
    if (!given.calibration) refuse("camera: calibration: is NULL");
    mux::CameraInput input;
    input.calibration = *given.calibration;
    if (input.calibration.name_size && !input.calibration.name) refuse("camera: name: is NULL");
    if (input.calibration.name) input.name.assign(input.calibration.name, input.calibration.name_size);
    input.calibration.name = nullptr;
    input.calibration.name_size = 0;
    input.calibration.flags &= uint8_t(~FVV_CAMERA_MOVES);
    input.pictures = !given.without_pictures;
    input.masks = given.has_masks;
    input.moves = given.moves;
    input.visibility = given.has_visibility;
    configuration.cameras.push_back(std::move(input));
  });
}

fvv_status fvv_encoder_add_sound(fvv_encoder *encoder, const fvv_encoder_sound *sound,
                                 fvv_diagnostic *diagnostic) {
  return configure(encoder, diagnostic, [&](mux::Configuration &configuration) {
    const fvv_encoder_sound given = taken(sound, "sound");
    if (!given.samples || !given.sample_count) refuse("sound: samples: expected some, found none");
    if (given.channels < 1 || given.channels > 8)
      refuse("sound: channels: expected 1 to 8, found " + std::to_string(given.channels));
    if (given.position_count && !given.positions) refuse("sound: positions: is NULL");
    if (given.sample_count > std::vector<float>().max_size() / given.channels) throw std::bad_alloc();
    const std::vector<float> samples(given.samples, given.samples + given.sample_count * given.channels);
    mux::SoundInput input = mux::sound_of_samples(samples, given.channels, given.start, given.bit_rate);
    input.title = text_of(given.title);
    input.language = text_of(given.language);
    const auto position = [&](size_t i) {
      const double *place = given.positions + 3 * i;
      return std::array<double, 3>{place[0], place[1], place[2]};
    };
    if (given.position_count == 1) input.position = position(0);
    for (size_t i = 0; given.position_count > 1 && i < given.position_count; i++)
      input.per_frame.push_back(position(i));
    configuration.sounds.push_back(std::move(input));
  });
}

fvv_status fvv_encoder_add_frame(fvv_encoder *encoder, const fvv_encoder_frame *frame,
                                 fvv_diagnostic *diagnostic) {
  return guarded(diagnostic, FVV_ERROR_INPUT, [&] {
    if (!encoder) refuse("encoder: is NULL");
    encoder->require(false);
    mux::Frame copy = encoder->frame_of(taken(frame, "frame"));
    encoder->encoder->check_next(copy);
    encoder->writing([&] { encoder->encoder->add(std::move(copy)); });
    encoder->frames++;
  });
}

fvv_status fvv_encoder_finish(fvv_encoder *encoder, fvv_encoder_report *report, fvv_diagnostic *diagnostic) {
  return guarded(diagnostic, FVV_ERROR_INPUT, [&] {
    if (!encoder) refuse("encoder: is NULL");
    const size_t size = report ? checked_size(report, sizeof(size_t), "report") : 0;
    encoder->require(false);
    if (!encoder->frames) throw Refusal{FVV_ERROR_STATE, "expected at least one frame, found none"};
    mux::Report found;
    encoder->writing([&] {
      found = encoder->encoder->finish();
      if (encoder->file) encoder->file->commit();
    });
    encoder->state = fvv_encoder::finished;
    if (!report) return;
    const fvv_encoder_report out = values_of(found, encoder->warnings, size);
    std::memcpy(report, &out, std::min(size, sizeof out));
  });
}

int fvv_encoder_broken(const fvv_encoder *encoder) {
  return encoder && encoder->state == fvv_encoder::broken;
}
