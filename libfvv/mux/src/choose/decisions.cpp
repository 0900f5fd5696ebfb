#include "mux/src/choose/decisions.h"
#include "mux/src/choose/choices.h"
#include "mux/src/ladder/mesh_rungs.h"

#include <algorithm>
#include <cstdio>

namespace fvv::mux {

// Of the pictures' bytes. A player without bits loses no picture, only time for depth maps.
constexpr double most_fraction = 0.1;
// Where bytes have to be seen: weights gain 0.01 to 0.02 dB over depth maps between cameras all round, and
// 0.07 dB between four that are far apart, for 3 % of all bytes (docs/encoding/view-loss.md).
constexpr double most_fraction_by_views = 0.02;
constexpr double most_fraction_of_few = 0.15;

VisibilityDecision decide_visibility(const VisibilityChoice &choice, uint64_t bytes, uint64_t pictures) {
  if (!choice.open) return {choice.on, choice.reason};
  const double most = !choice.by_views                            ? most_fraction
                      : choice.cameras.size() < cameras_all_round ? most_fraction_of_few
                                                                  : most_fraction_by_views;
  const bool on = double(bytes) <= most * double(pictures);
  char text[160];
  std::snprintf(text, sizeof text, "%.2g %% of the pictures' bytes in the first group, %s %g %%",
                pictures ? 100 * double(bytes) / double(pictures) : 100.0, on ? "at most" : "more than",
                100 * most);
  return {on, text};
}

namespace {

// Of a ladder, so that a reader can tell what a rung takes: what pictures were to take, or took when their
// quality was chosen, and what all else takes in the first group.
NominalRates nominal_rates(const Plan &plan, const Decisions &decisions, const FirstGroup &first) {
  NominalRates nominal;
  if (plan.options.ladder.empty()) return nominal;
  const fvv_rational &duration = plan.capture.frame_duration;
  const double per_second = double(duration.denominator) / duration.numerator / double(plan.groups[0].end);
  const auto add = [&](uint16_t track, uint64_t bytes) {
    if (bytes) nominal.rates[track] = 8 * double(bytes) * per_second;
  };
  for (size_t k = 0; k < plan.meshes.size(); k++) {
    const MeshTrack &track = plan.meshes[k];
    const FirstGroup::Meshes &group = first.meshes[k];
    add(track.id, group.mesh);
    if (group.frames) nominal.sizes[track.id] = group.faces / double(group.frames);
    if (decisions.visibility.on) add(track.visibility, group.visibility);
    if (plan.colours.on) add(track.colours, group.colours);
  }
  for (size_t k = 0; k < plan.tracks.size(); k++) {
    const VideoDecision &video = decisions.videos[k];
    if (plan.tracks[k].encoded)
      add(plan.tracks[k].id, first.videos[k]);
    else
      nominal.rates[plan.tracks[k].id] =
          video.settings.bit_rate ? double(video.settings.bit_rate) : video.sample_rate;
  }
  return nominal;
}

} // namespace

size_t Decisions::mesh_of(const Plan &plan, size_t rung) const {
  size_t k = plan.meshes.size() - 1;
  while (!meshes[k].sent || plan.meshes[k].rung > rung) k--; // the first one is sent
  return k;
}

bool Decisions::has_mesh_rungs(const Plan &plan) const {
  return !plan.meshes.empty() && mesh_of(plan, plan.rung_count()) > 0;
}

Decisions decide(const Plan &plan, std::vector<VideoDecision> videos, const FirstGroup &first) {
  Decisions decisions;
  decisions.videos = std::move(videos);
  uint64_t pictures = 0;
  std::vector<uint64_t> rungs(plan.rung_count()), meshes;
  for (size_t k = 0; k < plan.tracks.size(); k++) {
    const VideoTrack &track = plan.tracks[k];
    if (!track.is_atlas() && !track.rung) pictures += first.videos[k];
    for (size_t rung = 0; rung < rungs.size(); rung++)
      if (track.is_in(rung)) rungs[rung] += first.videos[k];
  }
  decisions.visibility =
      decide_visibility(plan.visibility, plan.has_meshes() ? first.meshes[0].visibility : 0, pictures);
  for (const FirstGroup::Meshes &group : first.meshes)
    meshes.push_back(group.mesh + (decisions.visibility.on ? group.visibility : 0) + group.colours);
  decisions.meshes = decide_mesh_rungs(plan, meshes, rungs);
  decisions.nominal = nominal_rates(plan, decisions, first);
  return decisions;
}

} // namespace fvv::mux
