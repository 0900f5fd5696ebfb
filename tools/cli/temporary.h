// Names that must vanish when a run is interrupted. A fixed table, because a signal handler may not allocate.
#pragma once

#include <string>

namespace fvv::cli {

// A name beside path that no other run uses: ".NAME.PID.N.partial".
std::string temporary_name(const std::string &path);

// Registers a file or folder for removal. Failure when 16 are open at once.
void remember_temporary(const std::string &path);
void forget_temporary(const std::string &path);

// Unlinks registered files; folders are left to a child process, since walking a tree is not
// async-signal-safe.
void remove_temporaries_in_handler();

} // namespace fvv::cli
