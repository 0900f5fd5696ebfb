// The options of the command line.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace fvv::serve {

// --live NAME=FILE. file "-": standard input.
struct LiveInput {
  std::string name, file;
};

struct Options {
  std::string root; // folder to serve; empty: none
  std::string open; // a file that the site's page plays, served as /open/clip.fvv; empty: none
  std::vector<LiveInput> live;
  std::string bind = "127.0.0.1";
  uint16_t port = 8035;                     // 0: the system chooses
  std::vector<std::string> allow_origin;    // "https://host:port" or "*", besides the same origin
  std::vector<std::string> allow_host;      // names, besides localhost and addresses
  bool loop = false;                        // files restart while there are clients
  bool follow = false;                      // files are still being written
  bool pace = false;                        // pipes by their time stamps too
  size_t queue_bytes = size_t(8) << 20;     // waiting for one live client
  size_t connections = 1024;                // at once
  std::chrono::milliseconds request{10000}; // from the first to the last byte of a request, and between two
  std::chrono::milliseconds idle{60000};    // without any message
  bool verbose = false;
};

// "players=-": throws Error (usage) when NAME is not 1 to 64 of A-Z a-z 0-9 - _ or FILE is empty.
LiveInput parse_live(const std::string &text);
// The folder of the demo site: beside an installed fvvserve, or where ./run demo builds it. Error when there
// is none.
std::string find_site();
// Error unless FILE can be read and begins as an fvv stream does.
void check_stream(const std::string &file);
// The address of the page that plays a file: "http://127.0.0.1:8035/?open=clip.fvv".
std::string page_of(const std::string &address, const std::string &file);
// Shows the address in a browser where there is a screen and xdg-open.
void show_page(const std::string &url);
// "https://example.org:8443" or "*": throws Error (usage) for anything else, a path above all.
std::string parse_origin(const std::string &text);

} // namespace fvv::serve
