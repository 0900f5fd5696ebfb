// Speaks the protocol of conformance/PROTOCOL.md for fvv_view, which draws: by how much each camera colours a
// place. It draws one pixel, whose middle is the place, from where the viewer is.
#include "../serve.h"
#include "fvv_view/draw.h"

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using fvv::render::Vec3;
using nlohmann::json;

Vec3 vector_of(const json &numbers) {
  return {numbers.at(0), numbers.at(1), numbers.at(2)};
}

Vec3 place_of(const fvv::view::Frame &frame, const json &place) {
  const uint32_t *corners = &frame.faces.at(3 * size_t(place.at("face")));
  Vec3 sum;
  for (size_t i = 0; i < 3; i++) {
    const float *p = &frame.positions.at(3 * size_t(corners[i]));
    sum += Vec3{p[0], p[1], p[2]} * double(place.at("barycentric").at(i));
  }
  return sum + frame.origin;
}

// A direction at a right angle to one, for the upper side of the picture.
Vec3 across(const Vec3 &direction) {
  const Vec3 axis = std::abs(direction.z) < 0.9 * length(direction) ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
  return cross(direction, axis);
}

json weights_at(fvv::view::Frame &frame, const json &place) {
  const Vec3 eye = vector_of(place.at("eye")), at = place_of(frame, place), up = across(at - eye);
  frame.normals.assign(frame.positions.size() / 3, vector_of(place.at("normal")));
  fvv::view::Options options;
  options.target.pose = {eye.x, eye.y, eye.z, at.x, at.y, at.z, up.x, up.y, up.z};
  options.target.size = fvv::view::Size{1, 1};
  fvv::view::Result result;
  const fvv::render::ViewPicture picture = fvv::view::draw(frame, options, result);
  if (picture.face.at(0) != place.at("face").get<uint32_t>())
    throw std::runtime_error("the viewer sees another face than " + place.at("face").dump());
  json out = json::object();
  for (const fvv::render::Contribution &one : picture.contributions)
    if (one.source != fvv::render::no_source && one.weight > 0)
      out[std::to_string(result.sources.at(one.source))] = one.weight;
  return out;
}

json weigh(const json &request) {
  const fvv::InputFile file(request.at("path").get<std::string>());
  fvv::view::Frame frame = fvv::view::load_frame(file, request.at("frame"));
  json weights = json::array();
  for (const json &place : request.at("places")) weights.push_back(weights_at(frame, place));
  return {{"weights", weights}};
}

json answer(const json &request) {
  const std::string op = request.at("op");
  if (op == "hello") return fvv::conformance::hello("fvvrender", {"weigh"});
  if (op == "weigh") return weigh(request);
  throw std::runtime_error(op + ": no such operation");
}

} // namespace

int main() {
  fvv::conformance::serve(answer);
  return 0;
}
