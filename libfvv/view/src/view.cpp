#include "fvv_view/view.h"

#include "fvv_view/draw.h"

#include <utility>

namespace fvv::view {

struct Viewer::State {
  Frame frame;
};

Viewer::Viewer(const std::string &path, int64_t number, size_t rung) {
  LoadOptions options;
  options.rung = rung;
  state = std::make_unique<State>(State{load_frame(InputFile(path), number, options)});
}

Viewer::~Viewer() = default;
Viewer::Viewer(Viewer &&) noexcept = default;

View Viewer::draw(const ViewSettings &settings) const {
  Options options;
  options.target = settings.target;
  std::string excluded;
  for (const uint16_t camera : settings.excluded)
    excluded += (excluded.empty() ? "" : ",") + std::to_string(camera);
  if (!excluded.empty()) options.excluded = demux::Selection::parse("excluded", excluded);
  options.view.samples = settings.samples;
  options.view.background = {settings.background[0], settings.background[1], settings.background[2]};
  options.threads = settings.threads;
  options.pictures = settings.pictures;
  options.environment = settings.environment;
  Result result;
  render::ViewPicture drawn = view::draw(state->frame, options, result);
  View out;
  out.picture = {drawn.width, drawn.height, 3, eight_bits(drawn)};
  out.depth = std::move(drawn.depth);
  out.surface = result.surface;
  out.sources = std::move(result.sources);
  out.warnings = std::move(result.warnings);
  out.losses = std::move(result.losses);
  return out;
}

} // namespace fvv::view
