// What a run tells of its work, for people and as JSON.
#pragma once

#include "fvv_scene/import.h"

namespace fvv::fvvimport {

struct Result {
  std::string format, output; // output: empty when none was asked for
  const scene::Capture *capture = nullptr;
  std::optional<import::Diagnosis> diagnosis;
};

std::string text_summary(const Result &result); // lines, each with its end
std::string json_summary(const Result &result);

} // namespace fvv::fvvimport
