// Speaks the protocol of conformance/PROTOCOL.md for libfvv: requests on standard input, answers on standard
// output.
#include "../serve.h"
#include "questions.h"
#include "report.h"

#include <openssl/evp.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

namespace {

using nlohmann::json;

std::vector<uint8_t> from_base64(const std::string &text) {
  if (text.size() % 4) throw std::runtime_error("data: expected base64 with padding");
  std::vector<uint8_t> out(text.size() / 4 * 3);
  if (EVP_DecodeBlock(out.data(), reinterpret_cast<const unsigned char *>(text.data()), int(text.size())) < 0)
    throw std::runtime_error("data: expected base64");
  for (size_t i = 0; i < 2 && i < text.size() && text[text.size() - 1 - i] == '='; i++) out.pop_back();
  return out;
}

std::vector<uint8_t> content_of(const json &request) {
  if (request.contains("data")) return from_base64(request.at("data"));
  const std::string path = request.at("path");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(path + ": cannot be opened");
  return {std::istreambuf_iterator<char>(file), {}};
}

json hello() {
  std::vector<std::string> parts = {"check", "mesh",  "camera",      "visibility", "colours", "texturing",
                                    "video", "sound", "environment", "data",       "join"};
  for (const std::string &op : fvv::conformance::questions()) parts.push_back(op);
  return fvv::conformance::hello("libfvv", parts);
}

json answer(const json &request) {
  const std::string op = request.at("op");
  const std::vector<std::string> asked = fvv::conformance::questions();
  if (op == "hello") return hello();
  if (op == "decode" && request.value("joined", false))
    return fvv::conformance::joined_report(content_of(request));
  if (op == "decode") return fvv::conformance::report(content_of(request), request.value("live", false));
  if (std::find(asked.begin(), asked.end(), op) != asked.end())
    return fvv::conformance::answer_question(content_of(request), request);
  throw std::runtime_error(op + ": no such operation");
}

} // namespace

int main() {
  fvv::conformance::serve(answer);
  return 0;
}
