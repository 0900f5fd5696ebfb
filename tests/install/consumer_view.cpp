/* Draws the first frame of a file in the colours of its vertices, and measures how far its meshes are from
 * themselves. */
#include <fvv_compare/compare.h>
#include <fvv_cxx/error.h>
#include <fvv_view/view.h>

#include <cstdio>

int main(int argc, char **argv) {
  if (argc != 2) return 2;
  try {
    fvv::view::ViewSettings settings;
    settings.target.pose = {3, 2, 4, 0, 0, 0};
    settings.target.size = fvv::view::Size{40, 30};
    settings.pictures = false;
    const fvv::view::View drawn = fvv::view::Viewer(argv[1], 0).draw(settings);
    const fvv::compare::Sequence sequence(argv[1]);
    fvv::compare::Result compared;
    fvv::compare::compare(sequence, sequence, {}, compared);
    const double apart = compared.errors.distance[fvv::compare::symmetric].max;
    std::printf("%s, %s\n", drawn.surface ? "a mesh" : "no mesh", apart < 1e-9 ? "equal" : "apart");
  } catch (const fvv::Error &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
