// A plan as bytes. What fvvmux does with plans is in tests/tools/mux/test_parts.py.
#include "mux/src/parts/plan_data.h"
#include "mux_fixture.h"

TEST_CASE("a plan that was saved is saved again with the same bytes") {
  const Folder folder;
  Shape shape = with_masks();
  shape.count = 6;
  const scene::Capture capture = make_capture(folder, shape);
  mux::PlanData data;
  data.capture = read_bytes(capture.path);
  data.warnings = {"one", "two\n\xff"};
  data.decisions.nominal.rates[7] = 1e300;
  data.decisions.nominal.sizes[3] = -0.0;
  FileOptions options = options_for(folder);
  std::vector<std::string> all;
  const auto check = [&] {
    data.plan = mux::make_plan(options, {});
    data.plan.lattice.pixels = INFINITY;
    data.plan.error.nearest.distance = 0.1;
    const std::string bytes = mux::save_plan(data);
    const mux::PlanData loaded = mux::load_plan(bytes, "plan.cbor", capture.path);
    CHECK(mux::save_plan(loaded) == bytes);
    CHECK(loaded.warnings == data.warnings);
    CHECK(std::isinf(loaded.plan.lattice.pixels));
    CHECK(loaded.plan.error.nearest.distance == 0.1);
    CHECK(std::signbit(loaded.decisions.nominal.sizes.at(3)));
    CHECK(loaded.plan.groups.size() == data.plan.groups.size());
    CHECK(loaded.plan.capture.cameras.size() == data.plan.capture.cameras.size());
    all.push_back(bytes);
  };
  check();
  options.visibility = mux::Visibility::weights;
  options.crop = mux::Crop::automatic;
  options.keep_geometry = false;
  options.max_error = mux::MaxError{2, mux::MaxError::pixels};
  check();
  options.ladder = {{1, 0}, {0.5, 0}};
  options.mesh_ladder = mux::MeshLadder::on;
  options.texture_unseen = {1, 2, 3};
  options.frames = fvv::Range{1, 4};
  options.cameras = {"3", "13"};
  check();
  options.step = mux::Length{0.01, true};
  options.max_error.reset();
  options.match_colours = mux::MatchColours::automatic;
  check();
  for (size_t i = 0; i < all.size(); i++)
    for (size_t k = 0; k < i; k++) CHECK(all[i] != all[k]);
}
