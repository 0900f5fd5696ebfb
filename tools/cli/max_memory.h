// The option --max-memory of tools that decode files of strangers; that of fvvmux is in the table of fvv_mux.
#pragma once

#include "fvv_media/memory_limit.h"

#include <CLI/CLI.hpp>

#include <cstdint>
#include <optional>
#include <string>

namespace fvv::cli {

constexpr const char *max_memory_option = "--max-memory";
constexpr uint64_t max_memory_default = media::default_memory_limit;

// Replaces the text by its number of bytes, which CLI11 reads; returns what is wrong with it.
inline std::string number_of_bytes(std::string &text) {
  const std::optional<uint64_t> bytes = media::parse_memory(text);
  if (!bytes) return std::string("expected ") + media::memory_words + ", found \"" + text + "\"";
  text = std::to_string(*bytes);
  return {};
}

// what: that is counted.
inline CLI::Option *add_max_memory(CLI::App &app, uint64_t &bytes,
                                   const std::string &what = "that decoding pictures may take at once") {
  return app.add_option(max_memory_option, bytes, what + ": bytes, or with K, M or G (512M); default 4G")
      ->transform(CLI::Validator(number_of_bytes, ""))
      ->type_name("SIZE");
}

} // namespace fvv::cli
