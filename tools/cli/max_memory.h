// The option --max-memory of tools that decode files of strangers; that of fvvmux is in the table of fvv_mux.
#pragma once

#include "fvv_media/memory_limit.h"

#include <CLI/CLI.hpp>

#include <cstdint>
#include <string>

namespace fvv::cli {

constexpr const char *max_memory_option = "--max-memory";
constexpr uint64_t max_memory_default = media::default_memory_limit;

// A number of bytes with a unit; CLI11's own validator takes -1 as well.
inline std::string parse_bytes(std::string &text) {
  if (text.empty() || text[0] < '0' || text[0] > '9')
    return "expected bytes, or a number with K, M or G, found \"" + text + "\"";
  return CLI::AsSizeValue(false)(text);
}

// what: that is counted.
inline CLI::Option *add_max_memory(CLI::App &app, uint64_t &bytes,
                                   const std::string &what = "that decoding pictures may take at once") {
  return app.add_option(max_memory_option, bytes, what + ": bytes, or with K, M or G (512M); default 4G")
      ->transform(CLI::Validator(parse_bytes, ""))
      ->type_name("SIZE");
}

} // namespace fvv::cli
