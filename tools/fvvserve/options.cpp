#include "fvvserve/options.h"

#include "cli/cli.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <thread>

extern char **environ;

namespace fvv::serve {

LiveInput parse_live(const std::string &text) {
  const size_t equals = text.find('=');
  const std::string name = text.substr(0, equals);
  const bool good = !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '-' || c == '_';
  });
  if (equals == std::string::npos || !good || equals + 1 == text.size())
    throw Error("--live: expected NAME=FILE with up to 64 letters, digits, - and _ in NAME, found '" + text +
                    "'",
                Error::usage);
  return {name, text.substr(equals + 1)};
}

std::string parse_origin(const std::string &text) {
  if (text == "*") return text;
  const size_t scheme = text.find("://");
  const std::string host = scheme == std::string::npos ? "" : text.substr(scheme + 3);
  const std::string before = text.substr(0, scheme == std::string::npos ? 0 : scheme);
  if ((before != "http" && before != "https") || host.empty() ||
      host.find_first_of("/?#@* ") != std::string::npos)
    throw Error("--allow-origin: expected http://HOST[:PORT], https://HOST[:PORT] or *, found '" + text + "'",
                Error::usage);
  std::string out = text;
  // A browser sends scheme and host in lower case.
  std::transform(out.begin(), out.end(), out.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return out;
}

std::string find_site() {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path tool = fs::read_symlink("/proc/self/exe", error).parent_path();
  for (const char *place : {"../share/fvv/site", "../../../demo/site"}) {
    const fs::path folder = (tool / place).lexically_normal();
    if (fs::exists(folder / "index.html", error)) return folder.string();
  }
  throw Error("--open: the site whose page plays the file is not built: ./run demo builds it; or name the "
              "folder of a site with --root");
}

void check_stream(const std::string &file) {
  constexpr unsigned char signature[] = {0x89, 'F', 'V', 'V', '\r', '\n', 0x1a, '\n'};
  struct stat status;
  if (stat(file.c_str(), &status) != 0) throw Error(file + ": cannot open: " + std::strerror(errno));
  if (!S_ISREG(status.st_mode)) throw Error(file + ": expected a file");
  std::array<unsigned char, sizeof signature> found{};
  std::FILE *stream = std::fopen(file.c_str(), "rb");
  if (!stream) throw Error(file + ": cannot open: " + std::strerror(errno));
  const size_t size = std::fread(found.data(), 1, found.size(), stream);
  std::fclose(stream);
  if (size != found.size() || std::memcmp(found.data(), signature, size) != 0)
    throw Error(file + ": expected an fvv stream, found another file");
}

std::string page_of(const std::string &address, const std::string &file) {
  std::string url = "http://" + address + "/?open=";
  for (const unsigned char c : std::filesystem::path(file).filename().string()) {
    char text[4];
    const bool plain = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') ||
                       std::strchr("-._~", c) != nullptr;
    std::snprintf(text, sizeof text, plain ? "%c" : "%%%02X", c);
    url += text;
  }
  return url;
}

void show_page(const std::string &url) {
  if (!std::getenv("DISPLAY") && !std::getenv("WAYLAND_DISPLAY")) return;
  posix_spawn_file_actions_t actions;
  if (posix_spawn_file_actions_init(&actions) != 0) return;
  // What the browser prints is not the server's.
  for (const int descriptor : {STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&actions, descriptor, "/dev/null", O_WRONLY, 0);
  std::string program = "xdg-open", address = url;
  char *arguments[] = {program.data(), address.data(), nullptr};
  pid_t child;
  if (posix_spawnp(&child, program.c_str(), &actions, nullptr, arguments, environ) == 0)
    std::thread([child] { waitpid(child, nullptr, 0); }).detach();
  posix_spawn_file_actions_destroy(&actions);
}

} // namespace fvv::serve
