// Entry points of libFuzzer. One program contains all targets; which one runs is the program's name (links
// are made by the build), or the environment variable FVV_FUZZ_TARGET.
#include "mutate/mutate.h"

#include <algorithm>

extern "C" {
int LLVMFuzzerInitialize(int *count, char ***parameters);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t capacity);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t capacity, unsigned seed);
size_t LLVMFuzzerCustomCrossOver(const uint8_t *first, size_t first_size, const uint8_t *second,
                                 size_t second_size, uint8_t *out, size_t capacity, unsigned seed);
}

static const fuzz::Target *target;

int LLVMFuzzerInitialize(int *, char ***parameters) {
  const char *named = std::getenv("FVV_FUZZ_TARGET");
  std::string name = named ? named : (*parameters)[0];
  name = name.substr(name.rfind('/') + 1);
  target = fuzz::find_target(name);
  if (!target) {
    std::fprintf(stderr, "%s is not the name of a target; these are:", name.c_str());
    for (const fuzz::Target &other : fuzz::targets()) std::fprintf(stderr, " %s", other.name);
    std::fprintf(stderr, "\n");
    std::exit(2);
  }
  return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  target->run(data, size);
  return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t capacity, unsigned seed) {
  if (target->form == fuzz::Form::bytes) return LLVMFuzzerMutate(data, size, capacity);
  fuzz::Random random(seed);
  const fuzz::Bytes out =
      fuzz::mutate(target->form, fuzz::Bytes(data, data + size), capacity, random, LLVMFuzzerMutate);
  std::copy(out.begin(), out.end(), data);
  return out.size();
}

size_t LLVMFuzzerCustomCrossOver(const uint8_t *first, size_t first_size, const uint8_t *second,
                                 size_t second_size, uint8_t *out, size_t capacity, unsigned seed) {
  fuzz::Random random(seed);
  const fuzz::Bytes a(first, first + first_size), b(second, second + second_size);
  fuzz::Bytes crossed;
  if (target->form == fuzz::Form::stream) {
    crossed = fuzz::cross_streams(a, b, random);
  } else {
    crossed.assign(a.begin(), a.begin() + random.below(uint32_t(a.size()) + 1));
    crossed.insert(crossed.end(), b.begin() + random.below(uint32_t(b.size()) + 1), b.end());
  }
  if (crossed.size() > capacity) crossed.resize(capacity);
  std::copy(crossed.begin(), crossed.end(), out);
  return crossed.size();
}
