// The objects of a scene for META: its meshes' pieces, followed over all frames, with names from a file.
#include "fvv_geometry/objects.h"
#include "fvv_cxx/parallel.h"
#include "fvv_scene/file_io.h"
#include "mux/src/choose/choices.h"
#include "mux/src/meshes/meshes.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace fvv::mux {

namespace {

using Json = nlohmann::ordered_json;
using render::Vec3;

constexpr size_t most_bytes = 48 << 10;   // of the text: every reader supports 64 KiB of META
constexpr uint64_t names_limit = 1 << 20; // bytes of a file of names
constexpr double places_in_radius = 60;   // of the smallest object: how finely its path is given

// Of each place of time; without a mesh nothing.
std::vector<std::vector<objects::Piece>> pieces_over_time(const Plan &plan) {
  std::vector<std::vector<objects::Piece>> all(size_t(plan.end()));
  fvv::parallel(plan.options.threads, plan.frame_count(), [&](size_t i) {
    plan.observer.check_cancelled();
    if (!plan.has_mesh(i)) return;
    all[size_t(plan.tick_of(i))] =
        objects::pieces_of(frame_mesh(plan.capture, plan.capture.frames.number(int64_t(i))));
  });
  return all;
}

[[noreturn]] void refuse(const std::string &file, const std::string &name, const std::string &what) {
  throw Error(file + ": /" + name + ": " + what, Error::usage);
}

std::string list_of(const objects::Following &found) {
  std::string out;
  for (size_t i = 0; i < found.objects.size(); i++) {
    const auto &path = found.objects[i].path;
    const auto first =
        std::find_if(path.begin(), path.end(), [](const auto &centre) { return centre.has_value(); });
    out += (i ? ", " : "") + std::to_string(i + 1) + " at";
    for (const double x : {(*first)->x, (*first)->y, (*first)->z}) {
      out += ' ';
      scene::append_double(out, std::round(100 * x) / 100);
    }
  }
  return out.empty() ? "none" : out;
}

// The object that a file names: {"object": 2}, or {"frame": 7, "at": [x, y, z]}.
size_t named_object(const Plan &plan, const objects::Following &found, const std::string &name,
                    const Json &entry) {
  const std::string &file = plan.options.objects;
  const char *const expected = R"(expected {"object": 2} or {"frame": 7, "at": [x, y, z]})";
  if (!entry.is_object()) refuse(file, name, expected);
  if (entry.contains("object")) {
    const Json &number = entry["object"];
    if (!number.is_number_integer() || number.get<int64_t>() < 1 ||
        number.get<int64_t>() > int64_t(found.objects.size()))
      refuse(file, name, "expected one of these objects: " + list_of(found));
    return size_t(number.get<int64_t>()) - 1;
  }
  const Json at = entry.value("at", Json()), number = entry.value("frame", Json());
  const auto is_number = [](const Json &x) { return x.is_number(); };
  if (!number.is_number_integer() || !at.is_array() || at.size() != 3 ||
      !std::all_of(at.begin(), at.end(), is_number))
    refuse(file, name, expected);
  for (size_t i = 0; i < plan.frame_count(); i++) {
    if (plan.capture.frames.number(int64_t(i)) != number.get<int64_t>()) continue;
    const Vec3 place{at[0].get<double>(), at[1].get<double>(), at[2].get<double>()};
    double nearest = INFINITY;
    size_t best = SIZE_MAX;
    for (size_t k = 0; k < found.objects.size(); k++)
      if (const auto &centre = found.objects[k].path[size_t(plan.tick_of(i))])
        if (const double away = length(*centre - place); away <= found.objects[k].radius && away < nearest) {
          nearest = away;
          best = k;
        }
    if (best == SIZE_MAX)
      refuse(file, name, "no object is there in that frame; these are: " + list_of(found));
    return best;
  }
  refuse(file, name, "the stream has no frame " + number.dump());
}

// What a file says of an object.
struct Named {
  std::string name;         // empty: none
  std::optional<size_t> of; // the object that it is a part of
};

// Of each object.
std::vector<Named> names_of(const Plan &plan, const objects::Following &found) {
  std::vector<Named> names(found.objects.size());
  const std::string &file = plan.options.objects;
  if (file == "auto") return names;
  Json given;
  try {
    given = Json::parse(scene::read_file(file, names_limit));
  } catch (const Json::parse_error &error) {
    throw Error(file + ": byte " + std::to_string(error.byte) + ": is no JSON", Error::usage);
  }
  if (!given.is_object()) throw Error(file + ": expected an object: names, and what has them", Error::usage);
  for (const auto &[name, entry] : given.items()) {
    const Json parts = entry.is_array() ? entry : Json::array({entry});
    if (name.empty() || parts.empty()) refuse(file, name, "expected a name, and what has it");
    std::optional<size_t> first;
    for (const Json &part : parts) {
      const size_t object = named_object(plan, found, name, part);
      if (!names[object].name.empty()) refuse(file, name, "is the same object as " + names[object].name);
      names[object] = {name, first};
      if (!first) first = object;
    }
  }
  return names;
}

// The runs of a path: where each begins, then places in units from the origin, each as the difference to the
// one before. Only every stride-th place of time is given.
Json path_of(const objects::Object &object, Vec3 origin, double unit, size_t stride) {
  Json runs = Json::array();
  int64_t former[3] = {};
  bool goes_on = false;
  for (size_t i = 0; i * stride < object.path.size(); i++) {
    const auto &centre = object.path[i * stride];
    if (!centre) {
      goes_on = false;
      continue;
    }
    const Vec3 from = *centre - origin;
    const int64_t now[3] = {std::llround(from.x / unit), std::llround(from.y / unit),
                            std::llround(from.z / unit)};
    if (!goes_on) runs.push_back(Json::array({i}));
    for (size_t k = 0; k < 3; k++) runs.back().push_back(goes_on ? now[k] - former[k] : now[k]);
    std::copy(now, now + 3, former);
    goes_on = true;
  }
  return runs;
}

// Rounded up, to the unit.
double rounded_up(double radius, double unit) {
  return std::ceil(radius / unit) * unit;
}

} // namespace

std::string find_objects(const Plan &plan) {
  if (plan.options.objects.empty()) return {};
  if (!plan.has_meshes())
    throw Error(option_name("objects", plan.options.objects) + ": there are no meshes", Error::usage);
  const fvv_rational &duration = plan.capture.frame_duration;
  const objects::Following found =
      objects::follow(pieces_over_time(plan), double(duration.numerator) / double(duration.denominator));
  const std::vector<Named> names = names_of(plan, found);
  double smallest = INFINITY;
  for (const objects::Object &object : found.objects) smallest = std::min(smallest, object.radius);
  const double unit = found.objects.empty() ? 1 : geometry::round_down_125(smallest / places_in_radius);
  const double *o = plan.lattice.lattice.origin;
  const auto tidy = [](double value) {
    return std::stod([&] {
      char text[32];
      std::snprintf(text, sizeof text, "%.9g", value);
      return std::string(text);
    }());
  };
  for (size_t stride = 1;; stride *= 2) {
    Json list = Json::array(), touching = Json::array(), splits = Json::array();
    for (size_t i = 0; i < found.objects.size(); i++) {
      Json one = {{"id", i + 1}};
      if (names[i].of)
        one["of"] = *names[i].of + 1;
      else if (!names[i].name.empty())
        one["name"] = names[i].name;
      one["radius"] = tidy(rounded_up(found.objects[i].radius, unit));
      one["path"] = path_of(found.objects[i], {o[0], o[1], o[2]}, unit, stride);
      list.push_back(std::move(one));
    }
    for (const objects::Touch &touch : found.touches) {
      Json which = Json::array();
      for (const size_t object : touch.objects) which.push_back(object + 1);
      Json one = {{"objects", which}, {"from", touch.first}, {"to", touch.last}};
      if (!touch.is_sure) one["sure"] = false;
      touching.push_back(std::move(one));
    }
    for (const objects::Split &split : found.splits)
      splits.push_back({{"from", split.from + 1}, {"object", split.object + 1}, {"time", split.frame}});
    const Json objects = {{"step", stride}, {"origin", {o[0], o[1], o[2]}}, {"unit", tidy(unit)},
                          {"list", list},   {"touching", touching},         {"splits", splits}};
    std::string text = Json{{"objects", objects}}.dump();
    if (text.size() <= most_bytes || stride > found.objects.size() + size_t(plan.end())) return text;
  }
}

} // namespace fvv::mux
