#include "cli/output.h"

#include "cli/cli.h"
#include "cli/temporary.h"
#include "fvv_cxx/format.h"
#include "fvv_cxx/input_file.h"

#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>

namespace fs = std::filesystem;

namespace fvv::cli {

namespace {

constexpr const char *list_name = ".fvv-output", *list_head = "fvv output folder 1", *tool_key = "tool ",
                     *file_key = "file ";

std::string system_reason() {
  return std::strerror(errno);
}

bool exists(const std::string &path) {
  struct stat status;
  return lstat(path.c_str(), &status) == 0;
}

std::string without_slash(std::string path) {
  while (path.size() > 1 && path.back() == '/') path.pop_back();
  return path;
}

// Where a chain of symbolic links leads; the end need not exist.
std::string end_of_links(const std::string &path) {
  constexpr int most = 40; // as in Linux
  fs::path here = path;
  for (int i = 0; i < most; i++) {
    std::error_code error;
    if (!fs::is_symlink(fs::symlink_status(here, error))) return here.string();
    const fs::path next = fs::read_symlink(here, error);
    if (error) throw Error(path + ": cannot follow the symbolic link: " + error.message());
    here = here.parent_path() / next; // an absolute link replaces the folder
  }
  throw Error(path + ": too many symbolic links");
}

// The name in the real folder around it, which need not exist: two paths to one place have the same.
std::string place_of(const std::string &path) {
  const std::string end = without_slash(end_of_links(path));
  std::error_code error;
  const fs::path whole = fs::absolute(end, error);
  if (error) throw Error(path + ": cannot create: " + error.message());
  const fs::path parent = fs::weakly_canonical(whole.parent_path(), error);
  if (error) throw Error(path + ": cannot create: " + error.message());
  return (parent / whole.filename()).string();
}

bool is_inside(const std::string &path, const std::string &folder) {
  return path.size() > folder.size() && path[folder.size()] == '/' &&
         path.compare(0, folder.size(), folder) == 0;
}

// The outputs that are open, for claim().
std::mutex open_lock;
std::vector<std::pair<const Output *, std::string>> open_outputs;

int rename_without_replacing(const std::string &from, const std::string &to) {
#ifdef RENAME_NOREPLACE
  if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return 0;
  if (errno != EINVAL && errno != ENOSYS) return -1;
#endif
  if (exists(to)) {
    errno = EEXIST;
    return -1;
  }
  return std::rename(from.c_str(), to.c_str());
}

// What had a name before another file took it.
struct Replaced {
  std::string former; // where that is now; after a failure empty, unless it has lost its name
  int error = 0;      // errno; 0: the name has changed hands
};

// Gives fresh the name. The name holds something whole at every moment where the system can exchange two
// names in one step; elsewhere (NFS, FUSE) it is free for a moment.
Replaced replace(const std::string &fresh, const std::string &name) {
#ifdef RENAME_EXCHANGE
  if (renameat2(AT_FDCWD, fresh.c_str(), AT_FDCWD, name.c_str(), RENAME_EXCHANGE) == 0) return {fresh};
  if (errno != EINVAL && errno != ENOSYS) return {"", errno};
#endif
  const std::string aside = temporary_name(name);
  if (std::rename(name.c_str(), aside.c_str()) != 0) return {"", errno};
  if (std::rename(fresh.c_str(), name.c_str()) == 0) return {aside};
  const int reason = errno;
  return {std::rename(aside.c_str(), name.c_str()) == 0 ? "" : aside, reason};
}

std::string former_is_at(const std::string &path) {
  return "; what was there before is now " + path;
}

// So that a name is on the disk as well as what it names. Some file systems do not take it for folders.
void flush_folder(const std::string &folder) {
  const int descriptor = open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  fsync(descriptor);
  ::close(descriptor);
}

// No signal ends the run between the first and the last of the files that appear together.
class WithoutSignals {
public:
  WithoutSignals() {
    sigset_t signals;
    sigemptyset(&signals);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, signal);
    pthread_sigmask(SIG_BLOCK, &signals, &former);
  }
  ~WithoutSignals() { pthread_sigmask(SIG_SETMASK, &former, nullptr); }

private:
  sigset_t former;
};

} // namespace

Inputs inputs(const std::vector<std::string> &paths) {
  return [paths](const std::function<void(const std::string &)> &visit) {
    for (const std::string &path : paths) visit(path);
  };
}

FileWriter::FileWriter(const std::string &path, const std::string &shown)
    : name(shown), descriptor(open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666)) {
  if (descriptor < 0) throw Error(name + ": cannot create: " + system_reason());
}

FileWriter::~FileWriter() {
  if (descriptor >= 0 && descriptor != STDOUT_FILENO) ::close(descriptor);
}

void FileWriter::fail() const {
  throw Error(name + ": cannot write: " + system_reason());
}

void FileWriter::write(const void *bytes, size_t size) {
  const auto *p = static_cast<const uint8_t *>(bytes);
  while (size) {
    if (time_out >= 0) await_reader();
    // A pipe that is ready takes that many without a wait.
    const ssize_t n = ::write(descriptor, p, time_out < 0 ? size : std::min<size_t>(size, PIPE_BUF));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) fail();
    p += n, size -= static_cast<size_t>(n);
  }
}

void FileWriter::await_reader() const {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point end = Clock::now() + std::chrono::milliseconds(time_out);
  pollfd waited = {descriptor, POLLOUT, 0};
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
    const int ready = poll(&waited, 1, int(std::max<long long>(0, left)));
    if (ready > 0) return; // an error is that of the write
    if (ready < 0 && errno != EINTR) fail();
    if (ready == 0)
      throw Error(name + ": its reader took nothing for " + fvv::format("%g", time_out / 1000.0) + " s");
  }
}

void FileWriter::close(bool to_disk) {
  if (descriptor < 0 || descriptor == STDOUT_FILENO) return;
  const bool flushed = !to_disk || fsync(descriptor) == 0 || errno == EINVAL;
  const int reason = errno, closing = descriptor;
  descriptor = -1;
  const bool closed = ::close(closing) == 0;
  if (!flushed) errno = reason;
  if (!flushed || !closed) fail();
}

Output::Output(const std::string &path, bool may_replace, const Inputs &read, bool folder)
    : given(path), force(may_replace), read_by_run(read), is_folder(folder) {}

Output::~Output() {
  {
    const std::lock_guard<std::mutex> lock(open_lock);
    open_outputs.erase(std::remove_if(open_outputs.begin(), open_outputs.end(),
                                      [&](const auto &other) { return other.first == this; }),
                       open_outputs.end());
  }
  remove_temporary();
  while (!parents.empty()) {
    rmdir(parents.back().c_str());
    forget_temporary(parents.back());
    parents.pop_back();
  }
}

void Output::claim(const std::string &target) {
  const std::lock_guard<std::mutex> lock(open_lock);
  for (const auto &[other, path] : open_outputs) {
    if (path == target) throw Error(given + ": two outputs have this name", Error::usage);
    if (is_inside(path, target) || is_inside(target, path))
      throw Error(given + ": is inside another output, or has one inside: " + other->given, Error::usage);
  }
  open_outputs.emplace_back(this, target);
  name = target;
}

void Output::make_parents() {
  std::vector<std::string> missing;
  for (fs::path folder = fs::path(name).parent_path(); !exists(folder.string()) && folder.has_relative_path();
       folder = folder.parent_path())
    missing.push_back(folder.string());
  for (; !missing.empty(); missing.pop_back()) {
    if (mkdir(missing.back().c_str(), 0777) != 0) throw Error(given + ": cannot create: " + system_reason());
    parents.push_back(missing.back());
    remember_temporary(missing.back(), Removal::empty_folder);
  }
}

std::string Output::temporary_for(const std::string &target) {
  const std::string path = temporary_name(target);
  remember_temporary(path);
  return path;
}

void Output::check_inputs(const std::set<Identity> &found, const char *relation) const {
  if (!read_by_run || found.empty()) return;
  read_by_run([&](const std::string &path) {
    struct stat status;
    if (stat(path.c_str(), &status) == 0 && found.count({status.st_dev, status.st_ino}))
      throw Error(given + ": " + relation + " " + path + ", which this run reads; choose another name");
  });
}

void Output::keep_former(const std::string &path) {
  if (!temporary.empty()) forget_temporary(temporary);
  temporary = path;
}

void Output::place() {
  if (temporary.empty()) return;
  struct stat status;
  if (replaces && lstat(name.c_str(), &status) == 0) {
    const Replaced replaced = replace(temporary, name);
    if (replaced.error)
      throw Error(given + ": cannot replace: " + std::strerror(replaced.error) +
                  (replaced.former.empty() ? "" : former_is_at(replaced.former)));
    placed = exchanged = true;
    keep_former(replaced.former);
    // Another program may have given the name to something else while the run went on.
    check_former(temporary);
    return;
  }
  if (rename_without_replacing(temporary, name) != 0)
    throw Error(given + ": " +
                (errno == EEXIST ? "was created by another program" : "cannot write: " + system_reason()));
  placed = true;
}

std::string Output::take_back() {
  if (!placed) return "";
  placed = false;
  if (!exchanged)
    return std::rename(name.c_str(), temporary.c_str()) == 0
               ? ""
               : "; " + given + " is already there, and cannot be removed again: " + system_reason();
  exchanged = false;
  const Replaced replaced = replace(temporary, name);
  if (!replaced.error) {
    keep_former(replaced.former);
    return "";
  }
  // The new output keeps the name, or nothing has it. What was there before stays, whatever happens.
  const std::string former = temporary;
  keep_former(replaced.former);
  return "; " + given + " cannot be put back: " + std::strerror(replaced.error) + former_is_at(former);
}

void Output::remove_temporary() {
  if (temporary.empty()) return;
  // A file output never removes a folder: another program may have given the name to one.
  if (is_folder) {
    std::error_code ignored;
    fs::remove_all(temporary, ignored);
    remove_tree(temporary.c_str());
  } else {
    unlink(temporary.c_str());
  }
  forget_temporary(temporary);
  temporary.clear();
}

void Output::commit() {
  cli::commit({this});
}

void commit(const std::vector<Output *> &outputs) {
  for (Output *output : outputs) output->finish_writing();
  const WithoutSignals together;
  try {
    for (Output *output : outputs) output->place();
  } catch (const Error &error) {
    std::string left;
    for (auto output = outputs.rbegin(); output != outputs.rend(); ++output) left += (*output)->take_back();
    if (left.empty()) throw;
    throw Error(error.line() + left, error.kind);
  }
  for (Output *output : outputs) {
    if (output->placed) flush_folder(fs::path(output->name).parent_path().string());
    for (const std::string &folder : output->parents) forget_temporary(folder);
    output->parents.clear();
    output->remove_temporary(); // what was there before, if anything
  }
}

OutputFile::OutputFile(const std::string &path, bool may_replace, const Inputs &read)
    : Output(path, may_replace, read, false) {
  if (path == "-") {
    if (isatty(STDOUT_FILENO))
      throw Error("standard output is a terminal: not writing a binary file to it", Error::usage);
    file = std::make_unique<FileWriter>(STDOUT_FILENO, "standard output");
    return;
  }
  struct stat former, standard;
  const bool there = stat(path.c_str(), &former) == 0;
  if (!there && errno != ENOENT) throw Error(path + ": cannot create: " + system_reason());
  if (path.empty() || path.back() == '/' || (there && S_ISDIR(former.st_mode)))
    throw Error(path + ": is a folder, expected the name of a file");
  if (there && (S_ISCHR(former.st_mode) || S_ISFIFO(former.st_mode))) {
    open_special();
    return;
  }
  if (there && !S_ISREG(former.st_mode))
    throw Error(path + ": is " + file_kind(former.st_mode) +
                ", expected a file, a pipe or a character device");
  if (there) {
    check_inputs({{former.st_dev, former.st_ino}}, "is");
    if (fstat(STDOUT_FILENO, &standard) == 0 && standard.st_dev == former.st_dev &&
        standard.st_ino == former.st_ino)
      throw Error(path + ": is standard output; -o - writes to it");
    if (!force) throw Error(path + ": already exists; --force overwrites it");
    replaces = true;
  }
  claim(place_of(path));
  temporary = temporary_for(name);
  try {
    file = std::make_unique<FileWriter>(temporary, path);
  } catch (...) {
    forget_temporary(temporary);
    temporary.clear();
    throw;
  }
  if (!there) return;
  former_identity = {former.st_dev, former.st_ino};
  keep_owner(former);
  if (chmod(temporary.c_str(), former.st_mode & 0777) != 0)
    throw Error(path + ": cannot create: " + system_reason());
}

// Who replaces the file of another user must be the administrator to keep its owner; its group is kept by
// members of it too. For others the system refuses it, and then the file belongs to who wrote it, as with
// other programs.
void OutputFile::keep_owner(const struct stat &former) const {
  struct stat now;
  if (lstat(temporary.c_str(), &now) != 0 || (now.st_uid == former.st_uid && now.st_gid == former.st_gid))
    return;
  if (lchown(temporary.c_str(), former.st_uid, former.st_gid) != 0 &&
      lchown(temporary.c_str(), static_cast<uid_t>(-1), former.st_gid) != 0)
    return;
}

void OutputFile::open_special() {
  // Opening a pipe waits until somebody reads it.
  const int descriptor = open(given.c_str(), O_WRONLY | O_CLOEXEC | O_NOCTTY);
  if (descriptor < 0) throw Error(given + ": cannot open: " + system_reason());
  file = std::make_unique<FileWriter>(descriptor, given);
  if (isatty(descriptor))
    throw Error(given + ": is a terminal: not writing a binary file to it", Error::usage);
}

void OutputFile::check_former(const std::string &path) const {
  struct stat status;
  if (lstat(path.c_str(), &status) != 0) return;
  if (!S_ISREG(status.st_mode))
    throw Error(given + ": has become " + file_kind(status.st_mode) + " while this run went on; it stays");
  if (Identity(status.st_dev, status.st_ino) != former_identity)
    check_inputs({{status.st_dev, status.st_ino}}, "has become");
}

const std::string &OutputFile::written() {
  file->close(true);
  return temporary;
}

void OutputFile::finish_writing() {
  file->close(is_regular());
}

OutputFolder::OutputFolder(const std::string &path, bool may_replace, const Inputs &read)
    : Output(path, may_replace, read, true) {
  const std::string place = place_of(path);
  claim(place);
  struct stat former;
  const bool there = lstat(place.c_str(), &former) == 0;
  if (there && !S_ISDIR(former.st_mode))
    throw Error(path + ": is " + file_kind(former.st_mode) + ", expected the name of a folder");
  std::error_code error;
  const fs::path current = fs::current_path(error);
  if (there && !error && (current == place || is_inside(current.string(), place)))
    throw Error(path + ": is the current folder, or around it; name another one");
  if (there) {
    const bool empty = fs::is_empty(place, error);
    if (error) throw Error(path + ": cannot read the folder: " + error.message());
    if (!empty && !force) throw Error(path + ": already exists; --force replaces it");
    if (!empty) check_own(place);
    replaces = true;
  }
  make_parents();
  temporary = temporary_for(name);
  if (mkdir(temporary.c_str(), 0777) == 0) return;
  const std::string reason = system_reason();
  forget_temporary(temporary);
  temporary.clear();
  throw Error(path + ": cannot create: " + reason);
}

std::string OutputFolder::shown(const std::string &relative) const {
  return (fs::path(given) / relative).string();
}

std::unique_ptr<FileWriter> OutputFolder::create(const std::string &relative) {
  const fs::path part(relative);
  bool outside = part.is_absolute() || relative.empty();
  for (const auto &step : part) outside = outside || step == "..";
  if (outside) throw Error(given + ": '" + relative + "' would lie outside the output folder");
  fs::path folder = temporary;
  for (const auto &step : part.parent_path()) {
    folder /= step;
    if (mkdir(folder.c_str(), 0777) != 0 && errno != EEXIST)
      throw Error(shown(relative) + ": cannot create: " + system_reason());
  }
  auto out = std::make_unique<FileWriter>((fs::path(temporary) / part).string(), shown(relative));
  const std::lock_guard<std::mutex> lock(mutex);
  files.insert(part.generic_string());
  return out;
}

void OutputFolder::write(const std::string &relative, std::string_view bytes) {
  const auto out = create(relative);
  out->write(bytes.data(), bytes.size());
  out->close();
}

void OutputFolder::expect(const std::string &relative) {
  const std::lock_guard<std::mutex> lock(mutex);
  files.insert(relative);
}

void OutputFolder::finish_writing() {
  std::string list = std::string(list_head) + "\n" + tool_key + tool() + "\n";
  for (const std::string &file : files) list += file_key + file + "\n";
  write(list_name, list);
  flush();
}

// Each file and each folder of it, before the folder gets its name.
void OutputFolder::flush() const {
  std::set<std::string> folders = {temporary};
  for (const std::string &file : files) {
    const fs::path whole = fs::path(temporary) / file;
    const int descriptor = open(whole.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) continue; // expected of a later run
    const bool flushed = fsync(descriptor) == 0 || errno == EINVAL;
    const int reason = errno;
    ::close(descriptor);
    if (!flushed) throw Error(shown(file) + ": cannot write: " + std::strerror(reason));
    for (fs::path p = fs::path(file).parent_path(); !p.empty(); p = p.parent_path())
      folders.insert((fs::path(temporary) / p).string());
  }
  for (const std::string &folder : folders) flush_folder(folder);
}

void OutputFolder::check_former(const std::string &path) const {
  struct stat status;
  if (lstat(path.c_str(), &status) == 0 && !S_ISDIR(status.st_mode))
    throw Error(given + ": has become " + file_kind(status.st_mode) + " while this run went on; it stays");
  // Files may have been added.
  check_own(path);
}

// Error unless a run of this tool wrote the folder and all that is in it, and this run reads none of it.
void OutputFolder::check_own(const std::string &folder) const {
  std::error_code error;
  if (fs::is_empty(folder, error)) return;
  const std::string refusal = given + ": --force replaces only what this tool wrote: ";
  std::ifstream list(fs::path(folder) / list_name);
  std::string line, writer;
  if (!std::getline(list, line) || line != list_head || !std::getline(list, writer))
    throw Error(refusal + "the folder has no list of its files (" + list_name + "); remove it first");
  if (writer != tool_key + tool())
    throw Error(refusal + "the folder is from " +
                writer.substr(std::min(writer.size(), std::strlen(tool_key))));
  std::set<std::string> own = {list_name}, around;
  while (std::getline(list, line))
    if (line.compare(0, std::strlen(file_key), file_key) == 0) own.insert(line.substr(std::strlen(file_key)));
  for (const std::string &file : own)
    for (fs::path p = fs::path(file).parent_path(); !p.empty(); p = p.parent_path())
      around.insert(p.generic_string());
  std::set<Identity> found;
  fs::recursive_directory_iterator entry(folder, error), end;
  for (; !error && entry != end; entry.increment(error)) {
    const std::string part = entry->path().lexically_relative(folder).generic_string();
    struct stat status;
    if (lstat(entry->path().c_str(), &status) != 0) continue;
    if (S_ISREG(status.st_mode) && own.count(part))
      found.insert({status.st_dev, status.st_ino});
    else if (!S_ISDIR(status.st_mode) || !around.count(part))
      throw Error(refusal + "it did not write " + shown(part));
  }
  if (error) throw Error(given + ": cannot read the folder: " + error.message());
  check_inputs(found, "has in it");
}

} // namespace fvv::cli
