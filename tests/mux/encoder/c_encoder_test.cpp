// The encoder in C: the bytes of the encoder in C++, errors for wrong arguments, and no crash where memory or
// a callback fails.
#include "fvv_catch.h"

#include "fvv/encoder.h"
#include "fvv_mux/encoder.h"

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <new>
#include <unistd.h>

using namespace fvv;

namespace {

// Allocations until one fails; below 0: none does.
std::atomic<long> until_failure{-1};

void *allocate(size_t size) {
  if (until_failure >= 0 && until_failure-- == 0) throw std::bad_alloc();
  if (void *memory = std::malloc(size ? size : 1)) return memory;
  throw std::bad_alloc();
}

} // namespace

void *operator new(size_t size) {
  return allocate(size);
}
void *operator new[](size_t size) {
  return allocate(size);
}
// The standard library's own would not be freed by those below.
void *operator new(size_t size, const std::nothrow_t &) noexcept {
  return until_failure >= 0 && until_failure-- == 0 ? nullptr : std::malloc(size ? size : 1);
}
void *operator new[](size_t size, const std::nothrow_t &tag) noexcept {
  return operator new(size, tag);
}
void operator delete(void *memory) noexcept {
  std::free(memory);
}
void operator delete[](void *memory) noexcept {
  std::free(memory);
}
void operator delete(void *memory, size_t) noexcept {
  std::free(memory);
}
void operator delete[](void *memory, size_t) noexcept {
  std::free(memory);
}

namespace {

constexpr uint32_t width = 64, height = 48;

fvv_camera calibration_of(uint16_t id) {
  fvv_camera camera = {};
  camera.id = id;
  camera.width = width;
  camera.height = height;
  camera.fx = camera.fy = 60;
  camera.cx = 32;
  camera.cy = 24;
  for (int i = 0; i < 9; i += 4) camera.rotation[i] = 1;
  camera.translation[0] = 0.1 * id;
  camera.translation[2] = 3;
  camera.r_max = fvv_camera_r_max(&camera);
  return camera;
}

struct Folder {
  const std::filesystem::path root =
      std::filesystem::temp_directory_path() / ("fvv_c_encoder_" + std::to_string(getpid()));
  Folder() { std::filesystem::create_directory(root); }
  ~Folder() { std::filesystem::remove_all(root); }
  std::string path(const char *name) const { return (root / name).string(); }
};

// What frame i shows, as plain arrays.
struct Moment {
  std::vector<double> positions, texture;
  std::vector<uint32_t> faces = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
  std::vector<uint8_t> pixels, mask;

  explicit Moment(int i) : pixels(size_t(width) * height * 3), mask(size_t(width) * height, 255) {
    const double x = 0.01 * i;
    positions = {x, 0, 0, x + 0.5, 0, 0, x, 0.5, 0, x, 0, 0.5};
    texture = {0, 0, 1, 0, 0, 1, 1, 1};
    for (size_t k = 0; k < pixels.size(); k++) pixels[k] = uint8_t(k / 5 + size_t(i));
    for (size_t k = 0; k < mask.size(); k += 3) mask[k] = 0;
  }
};

const fvv_encoder_option jpeg[] = {{"codec", "jpeg"}, {"quality", "90"}};

fvv_encoder_options options_of() {
  fvv_encoder_options options = {};
  options.struct_size = sizeof options;
  options.name = "pushed";
  options.group = 2;
  options.threads = 1;
  options.named = jpeg;
  options.named_count = 2;
  return options;
}

fvv_status append(void *user, const void *bytes, size_t size) {
  static_cast<std::string *>(user)->append(static_cast<const char *>(bytes), size);
  return FVV_OK;
}

// An encoder with everything that a call of it needs, all of it right.
struct Subject {
  fvv_encoder_options options = options_of();
  std::string bytes;
  fvv_output output = {append, &bytes};
  fvv_encoder *encoder = nullptr;
  fvv_diagnostic diagnostic = {};
  fvv_camera calibration = calibration_of(3);
  std::string name = "front";
  fvv_encoder_camera camera = {};
  Moment moment{0};
  fvv_encoder_picture picture = {}, mask = {};
  fvv_encoder_frame frame = {};

  Subject() {
    calibration.name = name.data();
    calibration.name_size = name.size();
    camera.struct_size = sizeof camera;
    camera.calibration = &calibration;
    camera.has_masks = 1;
    show(0);
  }
  ~Subject() { fvv_encoder_destroy(encoder); }

  void show(int i) {
    moment = Moment(i);
    picture = {moment.pixels.data(), width, height, 3, 8, 0};
    mask = {moment.mask.data(), width, height, 1, 8, 0};
    frame = {};
    frame.struct_size = sizeof frame;
    frame.positions = moment.positions.data();
    frame.vertex_count = moment.positions.size() / 3;
    frame.faces = moment.faces.data();
    frame.face_count = moment.faces.size() / 3;
    frame.texture = moment.texture.data();
    frame.camera_count = 1;
    frame.pictures = &picture;
    frame.masks = &mask;
  }
  fvv_status create() { return fvv_encoder_create(&options, &output, &encoder, &diagnostic); }
  fvv_status add_camera() { return fvv_encoder_add_camera(encoder, &camera, &diagnostic); }
  fvv_status add_frame() { return fvv_encoder_add_frame(encoder, &frame, &diagnostic); }
  fvv_status finish() { return fvv_encoder_finish(encoder, nullptr, &diagnostic); }
  std::string message() const { return diagnostic.message; }

  // Until the first call that fails.
  fvv_status run(int frames) {
    fvv_status status = create();
    if (status == FVV_OK) status = add_camera();
    for (int i = 0; i < frames && status == FVV_OK; i++) {
      show(i);
      status = add_frame();
    }
    return status == FVV_OK ? finish() : status;
  }
};

std::string bytes_in_cxx(int frames, const mux::SoundInput *sound = nullptr) {
  mux::Configuration configuration;
  configuration.name = "pushed";
  mux::CameraInput camera;
  camera.calibration = calibration_of(3);
  camera.name = "front";
  camera.masks = true;
  configuration.cameras = {camera};
  if (sound) configuration.sounds = {*sound};
  mux::Options options;
  options.codec = FVV_CODEC_JPEG;
  options.quality = {false, 90};
  options.group = 2;
  std::string bytes;
  mux::Encoder encoder(configuration, options,
                       [&](const void *part, size_t size) { append(&bytes, part, size); });
  for (int i = 0; i < frames; i++) {
    const Moment moment(i);
    mux::Frame frame;
    frame.mesh = {moment.positions, moment.faces, moment.texture};
    frame.pictures = {media::Image{width, height, 3, moment.pixels}};
    frame.masks = {media::Image{width, height, 1, moment.mask}};
    encoder.add(std::move(frame));
  }
  encoder.finish();
  return bytes;
}

} // namespace

TEST_CASE("the encoder in C writes the bytes of the one in C++") {
  Subject subject;
  REQUIRE(subject.run(5) == FVV_OK);
  CHECK(subject.message().empty());
  const std::string expected = bytes_in_cxx(5);
  REQUIRE(expected.size() > 1000);
  CHECK((subject.bytes == expected));
}

TEST_CASE("rows of pictures may have a gap, and threads change nothing") {
  Subject subject;
  subject.options.threads = 0;
  REQUIRE(subject.create() == FVV_OK);
  REQUIRE(subject.add_camera() == FVV_OK);
  for (int i = 0; i < 5; i++) {
    subject.show(i);
    const size_t row = 3 * width, stride = row + 13;
    std::vector<uint8_t> wide(stride * height, 77);
    for (size_t y = 0; y < height; y++) std::copy_n(&subject.moment.pixels[y * row], row, &wide[y * stride]);
    subject.picture.pixels = wide.data();
    subject.picture.stride = stride;
    REQUIRE(subject.add_frame() == FVV_OK);
  }
  REQUIRE(subject.finish() == FVV_OK);
  CHECK((subject.bytes == bytes_in_cxx(5)));
}

TEST_CASE("sound of samples is that of the encoder in C++") {
  std::vector<float> samples(9600);
  for (size_t i = 0; i < samples.size(); i++) samples[i] = float(0.5 * std::sin(double(i) * 0.05));
  mux::SoundInput expected = mux::sound_of_samples(samples, 2, 0.04);
  expected.title = "tone";
  expected.language = "en";
  expected.position = {{1, 2, 3}};
  const double position[] = {1, 2, 3};
  fvv_encoder_sound sound = {};
  sound.struct_size = sizeof sound;
  sound.samples = samples.data();
  sound.sample_count = samples.size() / 2;
  sound.channels = 2;
  sound.start = 0.04;
  sound.title = "tone";
  sound.language = "en";
  sound.positions = position;
  sound.position_count = 1;
  Subject subject;
  REQUIRE(subject.create() == FVV_OK);
  REQUIRE(subject.add_camera() == FVV_OK);
  sound.channels = 9;
  CHECK(fvv_encoder_add_sound(subject.encoder, &sound, &subject.diagnostic) == FVV_ERROR_ARGUMENT);
  CHECK(subject.message() == "sound: channels: expected 1 to 8, found 9");
  sound.channels = 2;
  REQUIRE(fvv_encoder_add_sound(subject.encoder, &sound, &subject.diagnostic) == FVV_OK);
  for (int i = 0; i < 5; i++) {
    subject.show(i);
    REQUIRE(subject.add_frame() == FVV_OK);
  }
  REQUIRE(subject.finish() == FVV_OK);
  CHECK((subject.bytes == bytes_in_cxx(5, &expected)));
}

TEST_CASE("the report has what was written") {
  Subject subject;
  REQUIRE(subject.create() == FVV_OK);
  REQUIRE(subject.add_camera() == FVV_OK);
  for (int i = 0; i < 5; i++) {
    subject.show(i);
    REQUIRE(subject.add_frame() == FVV_OK);
  }
  fvv_encoder_report report = {};
  CHECK(fvv_encoder_finish(subject.encoder, &report, &subject.diagnostic) == FVV_ERROR_ARGUMENT);
  CHECK(subject.message().find("report: struct_size") == 0);
  report.struct_size = offsetof(fvv_encoder_report, bytes);
  report.bytes = 42; // beyond the size that the caller knows
  REQUIRE(fvv_encoder_finish(subject.encoder, &report, &subject.diagnostic) == FVV_OK);
  CHECK(report.frames == 5);
  CHECK(report.groups == 3);
  CHECK(report.rungs == 1);
  CHECK(report.bytes == 42);
  CHECK(subject.finish() == FVV_ERROR_STATE);
  CHECK(subject.add_frame() == FVV_ERROR_STATE);
  CHECK(fvv_encoder_broken(subject.encoder) == 0);

  Subject whole;
  REQUIRE(whole.create() == FVV_OK);
  REQUIRE(whole.add_camera() == FVV_OK);
  REQUIRE(whole.add_frame() == FVV_OK);
  report = {};
  report.struct_size = sizeof report;
  REQUIRE(fvv_encoder_finish(whole.encoder, &report, nullptr) == FVV_OK);
  CHECK(report.bytes == whole.bytes.size());
  CHECK(report.mesh_bytes + report.video_bytes < report.bytes);
  CHECK(report.mesh_bytes > 0);
  CHECK(report.video_bytes > 0);
  CHECK(report.faces == 4);
  CHECK(report.step > 0);
}

TEST_CASE("wrong options are refused with their name") {
  const auto refused = [](const std::function<void(fvv_encoder_options &)> &spoil) {
    Subject subject;
    spoil(subject.options);
    subject.encoder = reinterpret_cast<fvv_encoder *>(&subject);
    CHECK(subject.create() == FVV_ERROR_ARGUMENT);
    CHECK(subject.encoder == nullptr);
    CHECK(subject.diagnostic.status == FVV_ERROR_ARGUMENT);
    return subject.message();
  };
  using O = fvv_encoder_options;
  CHECK(refused([](O &o) { o.struct_size = 0; }).find("options: struct_size: expected") == 0);
  CHECK(refused([](O &o) { o.struct_size--; }).find("options: struct_size: expected") == 0);
  CHECK(refused([](O &o) { o.struct_size = SIZE_MAX; }).find("options: struct_size: expected") == 0);
  CHECK(refused([](O &o) { o.codec = 1; }) == "options: codec: unknown: 1");
  CHECK(refused([](O &o) { o.up = 7; }) == "options: up: unknown: 7");
  CHECK(refused([](O &o) { o.named = nullptr; }) == "options: named: is NULL");
  CHECK(refused([](O &o) { o.frame_duration = {0, 25}; }).find("frame duration") != std::string::npos);
  CHECK(refused([](O &o) { o.bit_depth = 9; }).find("bit-depth") != std::string::npos);
  CHECK(refused([](O &o) { o.psnr = NAN, o.named_count = 0; }).find("quality") != std::string::npos);
  CHECK(refused([](O &o) { o.max_error = -1; }).find("max-error") != std::string::npos);
  CHECK(refused([](O &o) { o.threads = 257; }).find("threads") != std::string::npos);
  static const fvv_encoder_option unknown[] = {{"qualty", "42dB"}}, wrong[] = {{"quality", "good"}},
                                  missing[] = {{"quality", nullptr}};
  CHECK(refused([](O &o) { o.named = unknown, o.named_count = 1; }).find("qualty") != std::string::npos);
  CHECK(refused([](O &o) { o.named = wrong, o.named_count = 1; }).find("good") != std::string::npos);
  CHECK(refused([](O &o) { o.named = missing, o.named_count = 1; }) == "options: named option 0: is NULL");
}

TEST_CASE("a longer struct of a later version is taken if what is unknown in it is 0") {
  struct Later {
    fvv_encoder_options known = options_of();
    uint64_t more = 0;
  } later;
  later.known.struct_size = sizeof later;
  Subject subject;
  REQUIRE(fvv_encoder_create(&later.known, &subject.output, &subject.encoder, &subject.diagnostic) == FVV_OK);
  fvv_encoder_destroy(subject.encoder);
  later.more = 1;
  CHECK(fvv_encoder_create(&later.known, &subject.output, &subject.encoder, &subject.diagnostic) ==
        FVV_ERROR_ARGUMENT);
  CHECK(subject.message() == "options: has fields that this version of the library does not know");
}

TEST_CASE("what is NULL is refused, and NULL diagnostics are not written") {
  Subject subject;
  CHECK(fvv_encoder_create(&subject.options, nullptr, &subject.encoder, nullptr) == FVV_ERROR_ARGUMENT);
  CHECK(fvv_encoder_create(&subject.options, &subject.output, nullptr, nullptr) == FVV_ERROR_ARGUMENT);
  CHECK(fvv_encoder_create_file(nullptr, &subject.options, &subject.encoder, nullptr) == FVV_ERROR_ARGUMENT);
  CHECK(fvv_encoder_add_camera(nullptr, &subject.camera, nullptr) == FVV_ERROR_ARGUMENT);
  CHECK(fvv_encoder_add_sound(nullptr, nullptr, nullptr) == FVV_ERROR_ARGUMENT);
  CHECK(fvv_encoder_add_frame(nullptr, &subject.frame, nullptr) == FVV_ERROR_ARGUMENT);
  CHECK(fvv_encoder_finish(nullptr, nullptr, nullptr) == FVV_ERROR_ARGUMENT);
  CHECK(fvv_encoder_broken(nullptr) == 0);
  fvv_encoder_destroy(nullptr);
  REQUIRE(fvv_encoder_create(nullptr, &subject.output, &subject.encoder, nullptr) == FVV_OK);
  CHECK(fvv_encoder_add_camera(subject.encoder, nullptr, nullptr) == FVV_ERROR_ARGUMENT);
  CHECK(fvv_encoder_add_sound(subject.encoder, nullptr, nullptr) == FVV_ERROR_ARGUMENT);
  CHECK(fvv_encoder_add_frame(subject.encoder, nullptr, nullptr) == FVV_ERROR_ARGUMENT);
  CHECK(fvv_encoder_finish(subject.encoder, nullptr, nullptr) == FVV_ERROR_STATE);
}

TEST_CASE("a camera that is refused is not added") {
  Subject subject;
  REQUIRE(subject.create() == FVV_OK);
  subject.calibration.fx = NAN;
  CHECK(subject.add_camera() == FVV_ERROR_ARGUMENT);
  CHECK(subject.message().find("camera 0") != std::string::npos);
  subject.calibration = calibration_of(3);
  REQUIRE(subject.add_camera() == FVV_OK);
  CHECK(subject.add_camera() == FVV_ERROR_ARGUMENT);
  CHECK(subject.message() == "encoder: two cameras have the identifier 3");
  REQUIRE(subject.add_frame() == FVV_OK);
  subject.calibration.id = 4;
  CHECK(subject.add_camera() == FVV_ERROR_STATE);
  CHECK(subject.finish() == FVV_OK);
}

TEST_CASE("a frame that is refused changes nothing") {
  const auto refused = [](const std::function<void(Subject &)> &spoil, fvv_status status) {
    Subject subject;
    REQUIRE(subject.create() == FVV_OK);
    REQUIRE(subject.add_camera() == FVV_OK);
    for (int i = 0; i < 5; i++) {
      subject.show(i);
      if (i == 1) {
        spoil(subject);
        CHECK(subject.add_frame() == status);
        CHECK(subject.diagnostic.status == status);
        CHECK(subject.message().find("frame") == 0);
        CHECK(fvv_encoder_broken(subject.encoder) == 0);
        subject.show(i);
      }
      REQUIRE(subject.add_frame() == FVV_OK);
    }
    REQUIRE(subject.finish() == FVV_OK);
    CHECK((subject.bytes == bytes_in_cxx(5)));
  };
  using S = Subject;
  const fvv_status input = FVV_ERROR_INPUT, argument = FVV_ERROR_ARGUMENT;
  refused([](S &s) { s.moment.positions[4] = NAN; }, input);
  refused([](S &s) { s.moment.positions[4] = INFINITY; }, input);
  refused([](S &s) { s.moment.faces[4] = 4; }, input);
  refused([](S &s) { s.moment.texture[1] = NAN; }, input);
  refused([](S &s) { s.frame.face_count = 0; }, input);
  refused([](S &s) { s.frame.vertex_count = SIZE_MAX; }, input);
  refused([](S &s) { s.frame.face_count = SIZE_MAX / 2; }, input);
  refused([](S &s) { s.frame.positions = nullptr; }, argument);
  refused([](S &s) { s.frame.faces = nullptr; }, argument);
  refused([](S &s) { s.frame.struct_size = 8; }, argument);
  refused([](S &s) { s.frame.camera_count = 2; }, argument);
  refused([](S &s) { s.frame.camera_count = 0; }, input);
  refused([](S &s) { s.frame.pictures = nullptr; }, input);
  refused([](S &s) { s.frame.masks = nullptr; }, input);
  refused([](S &s) { s.picture.pixels = nullptr; }, argument);
  refused([](S &s) { s.picture.width = 63; }, input);
  refused([](S &s) { s.picture.height = UINT32_MAX; }, input);
  refused([](S &s) { s.picture.channels = 4; }, argument);
  refused([](S &s) { s.picture.bits = 12; }, argument);
  refused([](S &s) { s.picture.stride = 3 * width - 1; }, argument);
  refused([](S &s) { s.mask.channels = 3; }, argument);
  refused([](S &s) { s.mask.bits = 16; }, argument);
}

TEST_CASE("a picture whose samples are not the codec's is refused before anything is encoded") {
  Subject subject;
  REQUIRE(subject.create() == FVV_OK);
  REQUIRE(subject.add_camera() == FVV_OK);
  const std::vector<uint16_t> deep(size_t(width) * height * 3);
  subject.picture.pixels = deep.data();
  subject.picture.bits = 16;
  CHECK(subject.add_frame() == FVV_ERROR_INPUT);
  CHECK(subject.message() ==
        "frame 0: camera 3: expected a picture with samples of 8 bits for the codec and its bit "
        "depth, found 16 bits");
  CHECK(fvv_encoder_broken(subject.encoder) == 0);
}

TEST_CASE("a failing output breaks the encoder with its status") {
  for (const fvv_status given : {FVV_ERROR_IO, FVV_ERROR_MEMORY, FVV_END}) {
    static fvv_status returned;
    returned = given;
    Subject subject;
    subject.output.write = [](void *, const void *, size_t) { return returned; };
    REQUIRE(subject.create() == FVV_OK);
    REQUIRE(subject.add_camera() == FVV_OK);
    REQUIRE(subject.add_frame() == FVV_OK); // the group has two
    CHECK(subject.add_frame() == (given < 0 ? given : FVV_ERROR_IO));
    CHECK(subject.message().find("writing failed") == 0);
    CHECK(fvv_encoder_broken(subject.encoder) == 1);
    CHECK(subject.add_frame() == FVV_ERROR_STATE);
    CHECK(subject.finish() == FVV_ERROR_STATE);
  }
}

TEST_CASE("progress counts frames, and ends the encoding with its status") {
  static uint64_t done;
  done = 0;
  Subject subject;
  subject.options.progress = [](void *, uint64_t frames) -> fvv_status {
    done += frames;
    return FVV_OK;
  };
  REQUIRE(subject.run(5) == FVV_OK);
  CHECK(done == 5);
  Subject ended;
  ended.options.progress = [](void *, uint64_t) -> fvv_status { return FVV_ERROR_STATE; };
  CHECK(ended.run(5) == FVV_ERROR_STATE);
  CHECK(ended.message() == "ended by progress");
  CHECK(fvv_encoder_broken(ended.encoder) == 1);
}

TEST_CASE("a file appears when the stream is finished, and not before") {
  const Folder folder;
  const std::string path = folder.path("out.fvv"), part = path + ".part";
  Subject subject;
  REQUIRE(fvv_encoder_create_file(path.c_str(), &subject.options, &subject.encoder, nullptr) == FVV_OK);
  REQUIRE(subject.add_camera() == FVV_OK);
  for (int i = 0; i < 5; i++) {
    subject.show(i);
    REQUIRE(subject.add_frame() == FVV_OK);
  }
  CHECK(!std::filesystem::exists(path));
  CHECK(std::filesystem::exists(part));
  REQUIRE(subject.finish() == FVV_OK);
  CHECK(!std::filesystem::exists(part));
  std::ifstream file(path, std::ios::binary);
  const std::string found((std::istreambuf_iterator<char>(file)), {});
  CHECK((found == bytes_in_cxx(5)));

  Subject given_up;
  const std::string other = folder.path("other.fvv");
  REQUIRE(fvv_encoder_create_file(other.c_str(), &given_up.options, &given_up.encoder, nullptr) == FVV_OK);
  fvv_encoder_destroy(given_up.encoder);
  given_up.encoder = nullptr;
  CHECK(!std::filesystem::exists(other));
  CHECK(!std::filesystem::exists(other + ".part"));
  CHECK(fvv_encoder_create_file((folder.path("none") + "/out.fvv").c_str(), &given_up.options,
                                &given_up.encoder, &given_up.diagnostic) == FVV_ERROR_IO);
  CHECK(given_up.message().find("No such file") != std::string::npos);
}

TEST_CASE("a long reason is cut where a character begins") {
  Subject subject;
  std::string name;
  for (int i = 0; i < 300; i++) name += "\xc3\xa4";
  const fvv_encoder_option long_name[] = {{name.c_str(), "on"}};
  subject.options.named = long_name;
  subject.options.named_count = 1;
  CHECK(subject.create() == FVV_ERROR_ARGUMENT);
  const std::string message = subject.message();
  REQUIRE(message.size() > 150);
  CHECK(message.substr(message.size() - 3) == "...");
  CHECK((message[message.size() - 4] & 0xc0) == 0x80); // the end of a character
  CHECK(message.size() < sizeof subject.diagnostic.message);
}

// Each of the allocations.
TEST_CASE("an allocation that fails is an error, wherever it is") {
  size_t failed = 0;
  bool is_whole = false;
  for (long n = 0; !is_whole; n++) {
    Subject subject;
    subject.output = {[](void *, const void *, size_t) -> fvv_status { return FVV_OK; }, nullptr};
    long left = n;
    // Memory is short inside of the call alone.
    const auto call = [&](fvv_status (Subject::*method)()) {
      until_failure = left;
      const fvv_status status = (subject.*method)();
      left = until_failure.exchange(-1);
      return status;
    };
    fvv_status status = call(&Subject::create);
    if (status == FVV_OK) status = call(&Subject::add_camera);
    for (int i = 0; i < 2 && status == FVV_OK; i++) {
      subject.show(i);
      status = call(&Subject::add_frame);
    }
    if (status == FVV_OK) status = call(&Subject::finish);
    is_whole = left >= 0;
    INFO("allocation " << n << ": " << subject.message());
    if (is_whole) CHECK(status == FVV_OK);
    if (status == FVV_OK) continue;
    failed++;
    CHECK((status == FVV_ERROR_MEMORY || status == FVV_ERROR_INPUT || status == FVV_ERROR_ARGUMENT));
    CHECK(!subject.message().empty());
  }
  CHECK(failed > 50);
}
