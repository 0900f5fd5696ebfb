#include "fvvrecover/report.h"

#include "fvv_cxx/format.h"

namespace fvv::recover {

using Json = nlohmann::ordered_json;

namespace {

const char *name_of(State state) {
  switch (state) {
  case State::whole:
    return "whole";
  case State::unfinished:
    return "unfinished";
  default:
    return "damaged";
  }
}

std::string type_name(uint32_t code) {
  std::string out;
  for (int i = 0; i < 4; i++) out += static_cast<char>(code >> (8 * i) & 255);
  return out;
}

Json json(const fvv_diagnostic &problem) {
  Json out = {{"offset", std::to_string(problem.offset)}, {"message", problem.message}};
  if (problem.chunk_type) out["chunk"] = type_name(problem.chunk_type);
  if (problem.issue) out["issue"] = fvv::format("FVV-%u", problem.issue);
  return out;
}

Json json(const Loss &loss) {
  Json out = {{"offset", std::to_string(loss.offset)}};
  if (loss.sequence) out["sequence"] = *loss.sequence;
  if (loss.end > loss.start) {
    out["start"] = std::to_string(loss.start);
    out["end"] = std::to_string(loss.end);
  }
  out["groups_lost"] = loss.groups;
  out["frames_kept"] = loss.frames_kept;
  out["frames_lost"] = loss.frames_lost ? Json(*loss.frames_lost) : Json(nullptr);
  out["chunks_lost"] = loss.chunks_lost;
  out["why"] = json(loss.why);
  return out;
}

std::string count(uint64_t number, const char *unit) {
  return fvv::format("%llu %s%s", static_cast<unsigned long long>(number), unit, number == 1 ? "" : "s");
}

std::string sequence_text(const Loss &loss) {
  if (!loss.sequence) return "a group without its beginning";
  if (loss.groups > 1)
    return fvv::format("groups %u to %llu", *loss.sequence,
                       static_cast<unsigned long long>(*loss.sequence + loss.groups - 1));
  return fvv::format("group %u", *loss.sequence);
}

} // namespace

Json json(const std::string &input, const std::string &output, const Result &r) {
  Json losses = Json::array(), problems = Json::array();
  for (const Loss &loss : r.losses) losses.push_back(json(loss));
  for (const fvv_diagnostic &problem : r.problems) problems.push_back(json(problem));
  return {{"fvvrecover", 1},
          {"file", input},
          {"output", output.empty() ? Json(nullptr) : Json(output)},
          {"state", name_of(r.state)},
          {"bytes_read", r.bytes_read},
          {"bytes_written", r.bytes_written},
          {"groups",
           {{"copied", r.groups_copied},
            {"renumbered", r.groups_renumbered},
            {"reduced", r.groups_reduced},
            {"lost", r.groups_lost}}},
          {"frames", {{"kept", r.frames_kept}, {"lost", r.frames_lost}, {"exact", r.frames_lost_is_exact}}},
          {"losses", losses},
          {"problem_count", r.problem_count},
          {"problems", problems}};
}

std::string text(const std::string &input, const Loss &loss) {
  std::string what = sequence_text(loss) + ": ";
  if (loss.groups > 1 || (loss.groups && !loss.frames_lost && !loss.chunks_lost))
    what += "lost";
  else if (!loss.frames_lost)
    what += count(loss.frames_kept, "frame") + " kept, the others lost";
  else if (*loss.frames_lost)
    what += count(loss.frames_kept, "frame") + " kept, " + std::to_string(*loss.frames_lost) + " lost";
  else if (loss.chunks_lost)
    what += "all " + count(loss.frames_kept, "frame") + " kept, " + count(loss.chunks_lost, "other chunk") +
            " lost";
  else
    what += "all " + count(loss.frames_kept, "frame") + " kept, and a new end";
  fvv_diagnostic line = loss.why;
  what += ": " + std::string(loss.why.message);
  std::snprintf(line.message, sizeof line.message, "%s", what.c_str());
  char out[1024];
  fvv_diagnostic_format(&line, input.c_str(), out, sizeof out);
  return out;
}

std::string text(const std::string &input, const Result &r) {
  const auto number = [](uint64_t n) { return static_cast<unsigned long long>(n); };
  std::string out = fvv::format("%s: %s, %llu bytes read, %llu written\n", input.c_str(), name_of(r.state),
                                number(r.bytes_read), number(r.bytes_written));
  out += "              kept      lost\n";
  const char *more = r.frames_lost_is_exact ? "" : " or more";
  out += fvv::format("  groups  %8llu  %8llu%s\n",
                     number(r.groups_copied + r.groups_renumbered + r.groups_reduced), number(r.groups_lost),
                     more);
  out += fvv::format("  frames  %8llu  %8llu%s\n", number(r.frames_kept), number(r.frames_lost), more);
  if (r.groups_renumbered)
    out += "  " + count(r.groups_renumbered, "group") + " renumbered: groups before are lost\n";
  if (r.groups_reduced)
    out += "  " + count(r.groups_reduced, "group") + " rebuilt from what is whole in them\n";
  return out;
}

} // namespace fvv::recover
