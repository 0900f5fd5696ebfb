// Delta and patched frames that follow a hostile key mesh: any connectivity, any motion.
#include "meshes.h"

FVV_FUZZ_TARGET(delta, fuzz::Form::bytes) {
  fuzz::Input input(data, size);
  const fuzz::Mesh key(input.part());
  if (!key.there) return;
  fvv_mesh_sequence *sequence = nullptr;
  const fvv_status opened = fvv_mesh_sequence_open(&key.mesh, nullptr, &sequence, nullptr);
  fuzz::expect_status(opened);
  if (opened != FVV_OK) {
    fuzz::expect(!sequence, "a sequence that was not opened is NULL");
    return;
  }
  bool failed = false;
  uint32_t vertices = key.mesh.vertex_count;
  for (int frame = 0; frame < 8 && input.left(); frame++) {
    const fuzz::Bytes payload = input.part();
    const fvv_status status = fvv_mesh_sequence_decode(sequence, payload.data(), payload.size(), nullptr);
    fuzz::expect_status(status);
    fuzz::expect(!failed || status == FVV_ERROR_STATE, "nothing decodes after an error");
    failed |= status != FVV_OK;
    if (status != FVV_OK) continue;
    const fvv_mesh &mesh = *fvv_mesh_sequence_mesh(sequence);
    fuzz::expect_valid(mesh);
    const fvv_mesh *patch = fvv_mesh_sequence_patch(sequence);
    uint32_t count = 0;
    const uint32_t *kept = fvv_mesh_sequence_kept(sequence, &count);
    fuzz::expect(!patch || kept, "only a patched frame has a patch");
    fuzz::expect(mesh.vertex_count == count + (patch ? patch->vertex_count : 0),
                 "the vertices are those that are kept and those of the patch");
    fuzz::expect(kept || count == vertices, "a delta frame keeps all vertices");
    for (uint32_t v = 0; kept && v < count; v++)
      fuzz::expect(kept[v] < vertices && (!v || kept[v] > kept[v - 1]), "kept vertices rise");
    vertices = mesh.vertex_count;
  }
  fvv_mesh_sequence_close(sequence);
}
