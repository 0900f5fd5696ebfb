// Shared by the parts of fvvbench: a file in memory, times, and errors that end the run.
#pragma once

#include "fvv/stream.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <functional>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

using Bytes = std::vector<uint8_t>;
constexpr int runs = 5; // of which the median counts

inline void require(fvv_status status, const fvv_diagnostic &d) {
  if (status < 0) throw std::runtime_error(d.message[0] ? d.message : fvv_status_text(status));
}

inline double seconds(const std::function<void()> &body) {
  const auto begin = std::chrono::steady_clock::now();
  body();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

inline double median(const std::function<void()> &body) {
  std::vector<double> all;
  for (int i = 0; i < runs; i++) all.push_back(seconds(body));
  std::sort(all.begin(), all.end());
  return all[all.size() / 2];
}

inline Bytes read_file(const char *path) {
  FILE *file = std::fopen(path, "rb");
  if (!file) throw std::runtime_error(std::string(path) + ": cannot open");
  Bytes out;
  uint8_t block[1 << 16];
  while (const size_t n = std::fread(block, 1, sizeof block, file)) out.insert(out.end(), block, block + n);
  std::fclose(file);
  return out;
}

inline fvv_input input_of(const Bytes &bytes) {
  return fvv_input_memory(bytes.data(), bytes.size());
}

// Figures of a file; see fvvbench.cpp.
nlohmann::ordered_json visibility(const char *path);
nlohmann::ordered_json depth_maps(const char *path);
