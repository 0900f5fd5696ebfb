// The option --max-memory of tools that decode video and pictures of strangers.
#pragma once

#include <CLI/CLI.hpp>

#include <cstdint>
#include <string>

namespace fvv::cli {

constexpr const char *max_memory_option = "--max-memory";
// HEVC of 8192 x 4320 with 10 bits takes 2.1 GiB at most.
constexpr uint64_t max_memory_default = uint64_t(4) << 30;

// A number of bytes with a unit; CLI11's own validator takes -1 as well.
inline std::string parse_bytes(std::string &text) {
  if (text.empty() || text[0] < '0' || text[0] > '9')
    return "expected bytes, or a number with K, M or G, found \"" + text + "\"";
  return CLI::AsSizeValue(false)(text);
}

inline void add_max_memory(CLI::App &app, uint64_t &bytes) {
  app.add_option(max_memory_option, bytes,
                 "that decoding pictures may take at once: bytes, or with K, M or G (512M); default 4G")
      ->transform(CLI::Validator(parse_bytes, ""))
      ->type_name("SIZE");
}

} // namespace fvv::cli
