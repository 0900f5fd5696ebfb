// Requests on standard input, answers on standard output: the protocol of conformance/PROTOCOL.md, for the
// adapters in C++.
#pragma once

#include "fvv/format.h"
#include "fvv/types.h"

#include <nlohmann/json.hpp>

#include <exception>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

namespace fvv::conformance {

// The answer to "hello". parts: what the decoder has.
inline nlohmann::json hello(const std::string &name, const std::vector<std::string> &parts) {
  const std::string format = std::to_string(FVV_FORMAT_MAJOR) + "." + std::to_string(FVV_FORMAT_MINOR);
  return {{"protocol", 1}, {"name", name}, {"version", fvv_version()}, {"format", format}, {"parts", parts}};
}

// Until "quit" or the end of the input. What answer throws becomes an answer with "error".
inline void serve(const std::function<nlohmann::json(const nlohmann::json &request)> &answer) {
  using nlohmann::json;
  std::ios::sync_with_stdio(false);
  for (std::string line; std::getline(std::cin, line);) {
    json id, out;
    try {
      const json request = json::parse(line);
      if (request.contains("id")) id = request.at("id");
      if (request.at("op") == "quit") return;
      out = answer(request);
    } catch (const std::exception &error) {
      out = {{"error", error.what()}};
    }
    if (!id.is_null()) out["id"] = id;
    // Codes of codecs may be any bytes.
    std::cout << out.dump(-1, ' ', false, json::error_handler_t::replace) << std::endl;
  }
}

} // namespace fvv::conformance
