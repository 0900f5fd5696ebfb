/* Draws the first frame of a file in the colours of its vertices, and measures how far its meshes are from
 * themselves. */
#include <fvv_compare/compare.h>
#include <fvv_view/draw.h>

#include <cstdio>

int main(int argc, char **argv) {
  if (argc != 2) return 2;
  try {
    const fvv::InputFile file(argv[1]);
    fvv::view::Options options;
    options.target.pose = {3, 2, 4, 0, 0, 0};
    options.target.size = fvv::view::Size{40, 30};
    options.pictures = false;
    fvv::view::Result drawn;
    fvv::view::draw(fvv::view::load_frame(file, 0), options, drawn);
    const fvv::compare::Sequence sequence(file);
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
