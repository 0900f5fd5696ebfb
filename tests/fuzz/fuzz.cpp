#include "fuzz.h"

namespace fuzz {

// Registration runs before main, in any order of files: the list is made by its first use.
static std::vector<Target> &list() {
  static std::vector<Target> all;
  return all;
}

const std::vector<Target> &targets() {
  return list();
}

const Target *find_target(const std::string &name) {
  for (const Target &target : list())
    if (name == target.name) return &target;
  return nullptr;
}

Register::Register(const char *name, Form form, void (*run)(const uint8_t *data, size_t size)) {
  list().push_back({name, form, run});
}

} // namespace fuzz
