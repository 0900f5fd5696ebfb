#include "cli/temporary.h"

#include "fvv_cxx/error.h"

#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <climits>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <mutex>

namespace fvv::cli {

namespace {

constexpr int slots = 48;
constexpr size_t longest = 4096;
struct Slot {
  Removal removal;
  char path[longest];
};
Slot remembered[slots];
std::mutex remembered_lock;

bool exists(const char *path) {
  struct stat status;
  return lstat(path, &status) == 0;
}

// fork() would wait for the locks of malloc, which the interrupted thread may hold. vfork() shares the stack
// with the child: its caller has no variables that change.
[[gnu::noinline]] void run_rm(const char *path) {
  const pid_t child = vfork();
  if (child == 0) {
    execl("/bin/rm", "rm", "-rf", "--", path, static_cast<char *>(nullptr));
    _exit(127);
  }
  if (child > 0) waitpid(child, nullptr, 0);
}

} // namespace

void remove_tree(const char *path) {
  constexpr int rounds = 50;
  for (int i = 0; i < rounds && unlink(path) != 0 && exists(path); i++) {
    run_rm(path);
    if (!exists(path)) return;
    const timespec pause = {0, 10000000};
    nanosleep(&pause, nullptr);
  }
}

std::string temporary_name(const std::string &path) {
  static int counter = 0;
  const std::filesystem::path whole(path);
  for (;;) {
    const std::string end = "." + std::to_string(getpid()) + "." + std::to_string(counter++) + ".partial";
    // A name as long as the file system takes leaves no room for more.
    const std::string leaf = "." + whole.filename().string().substr(0, NAME_MAX - 1 - end.size()) + end;
    const std::string name = (whole.parent_path() / leaf).string();
    if (!exists(name.c_str())) return name;
  }
}

void remember_temporary(const std::string &path, Removal removal) {
  const std::lock_guard<std::mutex> lock(remembered_lock);
  if (path.size() + 1 > longest) throw Error(path + ": the name is too long");
  for (Slot &slot : remembered)
    if (!slot.path[0]) {
      // The first character goes in last: a signal sees the whole name or none.
      slot.removal = removal;
      std::memcpy(slot.path + 1, path.c_str() + 1, path.size());
      slot.path[0] = path[0];
      return;
    }
  throw Error(path + ": too many outputs are open at once");
}

void forget_temporary(const std::string &path) {
  const std::lock_guard<std::mutex> lock(remembered_lock);
  for (Slot &slot : remembered)
    if (path == slot.path) slot.path[0] = 0;
}

void remove_temporaries_in_handler() {
  for (const Slot &slot : remembered)
    if (slot.path[0] && slot.removal == Removal::tree) remove_tree(slot.path);
  for (int i = slots; i-- > 0;)
    if (remembered[i].path[0] && remembered[i].removal == Removal::empty_folder) rmdir(remembered[i].path);
}

} // namespace fvv::cli
