#include "questions.h"

#include "stream_pointer.h"

#include <array>
#include <map>
#include <stdexcept>

namespace fvv::conformance {

using nlohmann::json;

namespace {

json project(const fvv_camera &camera, const json &request) {
  json pixels = json::array();
  for (const json &row : request.at("points")) {
    const auto point = row.get<std::array<double, 3>>();
    std::array<double, 2> pixel;
    const bool seen = fvv_camera_project(&camera, point.data(), pixel.data(), nullptr);
    pixels.push_back(seen ? json(pixel) : json());
  }
  return {{"pixels", pixels}};
}

json unproject(const fvv_camera &camera, const json &request) {
  json rays = json::array();
  for (const json &row : request.at("pixels")) {
    const auto pixel = row.get<std::array<double, 2>>();
    std::array<double, 3> ray;
    const bool found = fvv_camera_unproject(&camera, pixel.data(), ray.data());
    rays.push_back(found ? json(ray) : json());
  }
  return {{"rays", rays}};
}

using Answer = json (*)(const fvv_camera &, const json &);
const std::map<std::string, Answer> answers = {{"project", project}, {"unproject", unproject}};

} // namespace

std::vector<std::string> questions() {
  std::vector<std::string> out;
  for (const auto &[op, answer] : answers) out.push_back(op);
  return out;
}

json answer_question(const std::vector<uint8_t> &bytes, const json &request) {
  const fvv_input input = fvv_input_memory(bytes.data(), bytes.size());
  fvv_stream *opened = nullptr;
  if (fvv_stream_open(&input, nullptr, nullptr, &opened, nullptr) != FVV_OK)
    throw std::runtime_error("the stream cannot be opened");
  const StreamPointer stream(opened);
  fvv_camera camera;
  if (fvv_stream_camera(opened, request.at("frame"), request.at("camera"), &camera, nullptr) != FVV_OK)
    throw std::runtime_error("camera " + request.at("camera").dump() + ": not calibrated in frame " +
                             request.at("frame").dump());
  return answers.at(request.at("op"))(camera, request);
}

} // namespace fvv::conformance
