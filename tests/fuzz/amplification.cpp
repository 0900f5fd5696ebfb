// How much memory and time a small input can cost: the largest of many inputs, each at most 4 KiB, by every
// way to read it. All memory of the process counts, also what Draco and meshoptimizer take by operator new.
#include "mutate/mutate.h"

#include "fvv/frames.h"
#include "fvv/stream.h"

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <malloc.h>
#include <string>

// The allocator of the process, counted. glibc allows these names to be replaced, and keeps its own under
// others.
extern "C" {
void *__libc_malloc(size_t size);
void *__libc_calloc(size_t count, size_t size);
void *__libc_realloc(void *pointer, size_t size);
void *__libc_memalign(size_t alignment, size_t size);
void __libc_free(void *pointer);
}

namespace {
size_t live, peak;

void *count(void *pointer) {
  if (pointer) peak = std::max(peak, live += malloc_usable_size(pointer));
  return pointer;
}
void discount(void *pointer) {
  if (pointer) live -= malloc_usable_size(pointer);
}
} // namespace

extern "C" {
void *malloc(size_t size) {
  return count(__libc_malloc(size));
}
void *calloc(size_t number, size_t size) {
  return count(__libc_calloc(number, size));
}
void *realloc(void *pointer, size_t size) {
  discount(pointer);
  return count(__libc_realloc(pointer, size));
}
void *aligned_alloc(size_t alignment, size_t size) {
  return count(__libc_memalign(alignment, size));
}
int posix_memalign(void **out, size_t alignment, size_t size) {
  *out = count(__libc_memalign(alignment, size));
  return *out || !size ? 0 : ENOMEM;
}
void free(void *pointer) {
  discount(pointer);
  __libc_free(pointer);
}
}

namespace {

namespace fs = std::filesystem;

constexpr size_t longest = 4096;
constexpr double most_mebibytes = 64, most_milliseconds = 50;

const char usage[] =
    "usage: amplification [--mutate N] [--target NAME] FOLDER...\n"
    "Reads every file of at most 4 KiB in the folders and N mutations of each, as a stream or as the input\n"
    "of a target, and prints the most memory and processor time that one took. Exit code 1: more than\n"
    "64 MiB or 50 ms.\n";

// ---- what is measured: reading a stream in all ways.

void check(const uint8_t *data, size_t size) {
  fvv_check_options options;
  fvv_check_options_default(&options);
  options.decode = 1;
  fvv_checker *checker = nullptr;
  if (fvv_checker_create(&options, nullptr, nullptr, &checker) != FVV_OK) return;
  (void)fvv_checker_push(checker, data, size);
  (void)fvv_checker_finish(checker);
  fvv_checker_destroy(checker);
}

void push_frames(const uint8_t *data, size_t size) {
  fvv_frames *frames = nullptr;
  if (fvv_frames_create(nullptr, nullptr, nullptr, &frames) != FVV_OK) return;
  if (fvv_frames_push(frames, data, size) == FVV_OK) fvv_frames_finish(frames);
  fvv_frames_event event;
  while (fvv_frames_next(frames, &event, nullptr) == FVV_OK) {}
  fvv_frames_destroy(frames);
}

// Every frame once, in order, with all that belongs to it. Who asks for frames in another order pays for each
// request, but that is no property of the input.
void seek(const uint8_t *data, size_t size) {
  fuzz::Memory memory = {data, size};
  const fvv_input input = memory.input();
  fvv_stream *stream = nullptr;
  if (fvv_stream_open(&input, nullptr, nullptr, &stream, nullptr) != FVV_OK) return;
  for (size_t number = 0; number < fvv_stream_frame_count(stream); number++) {
    fvv_frame frame;
    const fvv_configuration *configuration = nullptr;
    if (fvv_stream_frame(stream, number, &frame, nullptr) != FVV_OK ||
        fvv_stream_configuration(stream, frame.group, &configuration, nullptr) != FVV_OK)
      continue;
    for (size_t i = 0; i < configuration->track_count; i++) {
      const uint16_t track = configuration->tracks[i].id;
      fvv_mesh mesh;
      const fvv_visibility *visibility;
      const fvv_environment *environment;
      const uint8_t *bytes;
      uint32_t vertices;
      if (fvv_stream_mesh(stream, number, track, &mesh, nullptr) == FVV_OK) fvv_mesh_free(&mesh);
      (void)!fvv_stream_visibility(stream, number, track, &visibility, nullptr);
      (void)!fvv_stream_colours(stream, number, track, &bytes, &vertices, nullptr);
      (void)!fvv_stream_environment(stream, frame.group, track, &environment, nullptr);
    }
    for (size_t i = 0; i < configuration->camera_count; i++) {
      fvv_camera camera;
      (void)!fvv_stream_camera(stream, number, configuration->cameras[i].id, &camera, nullptr);
    }
  }
  fvv_stream_close(stream);
}

// ---- measuring

struct Worst {
  double mebibytes = 0, milliseconds = 0;
  std::string by_memory, by_time;
  size_t inputs = 0;
};

double processor_ms() {
  timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * double(now.tv_sec) + 1e-6 * double(now.tv_nsec);
}

void measure(Worst &worst, void (*run)(const uint8_t *, size_t), const fuzz::Bytes &input,
             const std::string &name) {
  double least = 1e9;
  // The first run may touch new pages; the least of three is what the input costs.
  for (int i = 0; i < 3; i++) {
    const size_t before = peak = live;
    const double start = processor_ms();
    run(input.data(), input.size());
    least = std::min(least, processor_ms() - start);
    const double mebibytes = double(peak - before) / (1 << 20);
    if (mebibytes > worst.mebibytes) worst.mebibytes = mebibytes, worst.by_memory = name;
    if (least < worst.milliseconds) break;
  }
  if (least > worst.milliseconds) worst.milliseconds = least, worst.by_time = name;
}

void measure_input(Worst &worst, const fuzz::Target *target, const fuzz::Bytes &input,
                   const std::string &name) {
  worst.inputs++;
  if (target) return measure(worst, target->run, input, name);
  measure(worst, check, input, name + " (checker)");
  measure(worst, push_frames, input, name + " (frames)");
  measure(worst, seek, input, name + " (random access)");
}

void measure_folder(Worst &worst, const fuzz::Target *target, const fs::path &folder, uint32_t mutations) {
  std::vector<fs::path> files;
  for (const fs::directory_entry &entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && entry.file_size() <= longest && entry.path().extension() != ".json")
      files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const fs::path &path : files) {
    std::ifstream file(path, std::ios::binary);
    const fuzz::Bytes input(std::istreambuf_iterator<char>(file), {});
    measure_input(worst, target, input, path.string());
    const uint32_t seed = fuzz::digest(input.data(), input.size());
    fuzz::Random random(seed);
    fuzz::seed_mutations(seed);
    const fuzz::Form form = target ? target->form : fuzz::Form::stream;
    for (uint32_t i = 0; i < mutations; i++) {
      const fuzz::Bytes changed = fuzz::mutate(form, input, longest, random, fuzz::mutate_bytes);
      measure_input(worst, target, changed, path.string() + ", mutation " + std::to_string(i));
    }
  }
}

} // namespace

int main(int count, char **given) {
  std::vector<std::string> words(given + 1, given + count);
  uint32_t mutations = 0;
  const fuzz::Target *target = nullptr;
  while (words.size() > 1 && (words[0] == "--mutate" || words[0] == "--target")) {
    if (words[0] == "--mutate")
      mutations = uint32_t(std::strtoul(words[1].c_str(), nullptr, 10));
    else if (!(target = fuzz::find_target(words[1])))
      words.resize(2);
    words.erase(words.begin(), words.begin() + 2);
  }
  if (words.empty()) {
    std::fputs(usage, stderr);
    return 2;
  }
  Worst worst;
  for (const std::string &folder : words) measure_folder(worst, target, folder, mutations);
  std::printf("inputs %zu\namplification.max_mib %.2f (%s)\namplification.max_ms %.2f (%s)\n", worst.inputs,
              worst.mebibytes, worst.by_memory.c_str(), worst.milliseconds, worst.by_time.c_str());
  return worst.mebibytes > most_mebibytes || worst.milliseconds > most_milliseconds;
}
