// Outputs of a run: whole under their names, or absent. docs/tools/outputs.md has the rules that users read.
#pragma once

#include "fvv_cxx/error.h"

#include <sys/stat.h>
#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace fvv::cli {

// Calls its argument with the path of every file that a run reads. Called only when an output replaces
// something, so that it may take time.
using Inputs = std::function<void(const std::function<void(const std::string &)> &)>;
Inputs inputs(const std::vector<std::string> &paths);

// Writes to a descriptor; errors name the file as the user knows it.
class FileWriter {
public:
  // Makes the file, which must not exist yet.
  FileWriter(const std::string &path, const std::string &shown);
  // Owns the descriptor unless it is that of standard output.
  FileWriter(int owned, const std::string &shown) : name(shown), descriptor(owned) {}
  ~FileWriter();
  FileWriter(const FileWriter &) = delete;
  FileWriter &operator=(const FileWriter &) = delete;
  void write(const void *bytes, size_t size);
  // Of a pipe: a write fails when its reader takes nothing for that long.
  void set_time_out(double seconds) { time_out = int(1000 * seconds); }
  // to_disk: not before the bytes are there. May be called twice.
  void close(bool to_disk = false);

private:
  [[noreturn]] void fail() const;
  void await_reader() const;
  std::string name;
  int descriptor;
  int time_out = -1; // milliseconds; below 0: none
};

// A file or a folder under a temporary name beside its own, until it is committed. Without commit nothing
// stays of it.
class Output {
public:
  virtual ~Output();
  Output(const Output &) = delete;
  Output &operator=(const Output &) = delete;
  void commit();

protected:
  Output(const std::string &path, bool may_replace, const Inputs &read, bool folder);
  // Two outputs of a run must not be the same, nor one inside the other. target: what given means, resolved.
  void claim(const std::string &target);
  // Makes the folders around the target that are missing.
  void make_parents();
  std::string temporary_for(const std::string &target);
  // Error when a run reads the file with this device and inode.
  using Identity = std::pair<dev_t, ino_t>;
  void check_inputs(const std::set<Identity> &found, const char *relation) const;

  virtual void finish_writing() = 0; // all errors of a full disk come here, before anything is replaced
  // Error unless what had the name, and is now at path, may be removed.
  virtual void check_former(const std::string &path) const = 0;

  void remove_temporary();

  const std::string given; // as the user wrote it
  const bool force;
  const Inputs read_by_run;
  const bool is_folder;
  bool replaces = false; // whether anything has the name, and may lose it
  std::string name;      // without symbolic links; empty: there is nothing to rename
  std::string temporary;

private:
  friend void commit(const std::vector<Output *> &outputs);
  void place();
  // What it could not restore, for the message of the error; empty: all is as before.
  std::string take_back();
  void keep_former(const std::string &path);

  std::vector<std::string> parents; // that this run made
  bool placed = false, exchanged = false;
};

// All outputs of a run at once: each appears under its name, or, after an Error, none, and what was there
// before is there again.
void commit(const std::vector<Output *> &outputs);

// Written to a temporary file, renamed by commit(). Character devices and pipes are written to directly; "-"
// is standard output, refused when that is a terminal. Refuses folders, sockets, block devices, files that
// the run reads, and without force what exists.
class OutputFile : public Output {
public:
  OutputFile(const std::string &path, bool may_replace, const Inputs &read = {});
  void write(const void *bytes, size_t size) { file->write(bytes, size); }
  void set_time_out(double seconds) { file->set_time_out(seconds); }
  // Whether it can be read back before it is committed: not for pipes and devices.
  bool is_regular() const { return !temporary.empty(); }
  // Where the bytes are until then; nothing can be written any more.
  const std::string &written();

private:
  void open_special();
  void keep_owner(const struct stat &former) const;
  void finish_writing() override;
  void check_former(const std::string &path) const override;
  Identity former_identity;
  std::unique_ptr<FileWriter> file;
};

// A folder that holds the file .fvv-output, which lists what this run wrote. Refuses an existing path unless
// it is an empty folder, or, with force, one whose list names this tool and all files in it.
class OutputFolder : public Output {
public:
  OutputFolder(const std::string &path, bool may_replace, const Inputs &read = {});
  // A new file "a/b.png" of the folder. Refuses absolute names and "..": nothing leaves the folder. Several
  // threads may call these.
  std::unique_ptr<FileWriter> create(const std::string &relative);
  void write(const std::string &relative, std::string_view bytes);
  // A later run of this tool will add that file, which then counts as written by this one.
  void expect(const std::string &relative);
  // Where a file that was written is until commit(), to read it back.
  std::string path(const std::string &relative) const { return temporary + "/" + relative; }
  // The name of a file for messages.
  std::string shown(const std::string &relative) const;

private:
  void finish_writing() override;
  void flush() const;
  void check_former(const std::string &path) const override;
  void check_own(const std::string &folder) const;
  std::mutex mutex; // of files
  std::set<std::string> files;
};

} // namespace fvv::cli
