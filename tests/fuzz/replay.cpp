// Runs targets on files, without libFuzzer: crashing inputs that were kept, seeds, and mutations of them.
#include "mutate/mutate.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace {

namespace fs = std::filesystem;

const char usage[] =
    "usage: fuzz_replay [--mutate N] [--keep FILE] TARGET PATH...\n"
    "       fuzz_replay [--mutate N] [--keep FILE] --all FOLDER...\n"
    "       fuzz_replay --list\n"
    "Runs a target on files, or on all files of folders. --all: FOLDER/TARGET/ has the inputs of each\n"
    "target. --mutate: also N mutations of each file, the same in every run. --keep: each input is\n"
    "written there before it runs, so that one that ends the process can be found.\n";

struct Options {
  uint32_t mutations = 0;
  std::string keep;
};

fuzz::Bytes read(const fs::path &path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    std::fprintf(stderr, "%s: cannot be read\n", path.c_str());
    std::exit(1);
  }
  return fuzz::Bytes(std::istreambuf_iterator<char>(file), {});
}

void run_one(const fuzz::Target &target, const fuzz::Bytes &input, const Options &options) {
  if (!options.keep.empty())
    std::ofstream(options.keep, std::ios::binary)
        .write(reinterpret_cast<const char *>(input.data()), std::streamsize(input.size()));
  // A block of exactly this size lets a sanitizer see what is read beyond it.
  const fuzz::Bytes copy = input;
  target.run(copy.data(), copy.size());
}

size_t run_file(const fuzz::Target &target, const fs::path &path, const Options &options) {
  const fuzz::Bytes input = read(path);
  run_one(target, input, options);
  const uint32_t seed = fuzz::digest(input.data(), input.size());
  fuzz::Random random(seed);
  fuzz::seed_mutations(seed);
  fuzz::Bytes changed = input;
  for (uint32_t i = 0; i < options.mutations; i++) {
    // A few mutations on top of each other, then from the file again.
    if (i % 4 == 0) changed = input;
    changed = fuzz::mutate(target.form, changed, input.size() + 256, random, fuzz::mutate_bytes);
    run_one(target, changed, options);
  }
  return 1 + options.mutations;
}

size_t run_path(const fuzz::Target &target, const fs::path &path, const Options &options) {
  if (!fs::is_directory(path)) return run_file(target, path, options);
  std::vector<fs::path> files;
  for (const fs::directory_entry &entry : fs::directory_iterator(path))
    if (entry.is_regular_file()) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  size_t runs = 0;
  for (const fs::path &file : files) runs += run_file(target, file, options);
  return runs;
}

int fail(const std::string &text) {
  std::fprintf(stderr, "%s\n%s", text.c_str(), usage);
  return 2;
}

} // namespace

int main(int count, char **given) {
  Options options;
  std::vector<std::string> words(given + 1, given + count);
  while (words.size() > 1 && (words[0] == "--mutate" || words[0] == "--keep")) {
    if (words[0] == "--keep")
      options.keep = words[1];
    else
      options.mutations = uint32_t(std::strtoul(words[1].c_str(), nullptr, 10));
    words.erase(words.begin(), words.begin() + 2);
  }
  if (words == std::vector<std::string>{"--list"}) {
    for (const fuzz::Target &target : fuzz::targets()) std::printf("%s\n", target.name);
    return 0;
  }
  if (words.size() < 2) return fail("a target and a path are missing");
  const bool all = words[0] == "--all";
  if (!all && !fuzz::find_target(words[0])) return fail(words[0] + " is not a target");
  size_t runs = 0;
  for (const fuzz::Target &target : fuzz::targets()) {
    if (!all && target.name != words[0]) continue;
    for (size_t i = 1; i < words.size(); i++) {
      const fs::path path = all ? fs::path(words[i]) / target.name : fs::path(words[i]);
      if (!fs::exists(path)) {
        if (all) continue; // not every target has crashed
        return fail(path.string() + " does not exist");
      }
      runs += run_path(target, path, options);
    }
  }
  std::printf("%zu inputs\n", runs);
  return 0;
}
