// Names that must vanish when a run is interrupted. A fixed table, because a signal handler may not allocate.
#pragma once

#include <string>

namespace fvv::cli {

// A name beside path that no other file has: ".NAME.PID.N.partial". What a killed run left is passed over.
std::string temporary_name(const std::string &path);

// tree: removed with all that is in it; empty_folder: removed if nothing is in it by then.
enum class Removal { tree = 1, empty_folder };

// Registers a file or folder for removal. Error when too many are registered at once.
void remember_temporary(const std::string &path, Removal removal = Removal::tree);
void forget_temporary(const std::string &path);

// Trees first, then empty folders, the last one first. Trees are left to a child process, since walking one
// is not async-signal-safe.
void remove_temporaries_in_handler();

// Removes a file or a folder with all that is in it, in a handler too. Other threads may still write into the
// folder, and a handler in another thread may remove it as well: it takes another round until all is gone.
void remove_tree(const char *path);

} // namespace fvv::cli
