// The report of a run as text and as JSON.
#pragma once

#include "fvv_scene/import.h"

namespace fvv::fvvimport {

struct Result {
  std::string format, output; // output: empty if none was requested
  const scene::Capture *capture = nullptr;
  std::optional<import::Diagnosis> diagnosis;
};

std::string text_summary(const Result &result); // lines, each with its end
std::string json_summary(const Result &result);

} // namespace fvv::fvvimport
