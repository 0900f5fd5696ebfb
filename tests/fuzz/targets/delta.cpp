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
    const uint8_t *absent = fvv_mesh_sequence_absent(sequence);
    fuzz::expect(!patch || absent, "only a patched frame has a patch");
    uint32_t faces = patch ? patch->face_count : 0;
    for (uint32_t f = 0; f < key.mesh.face_count; f++) faces += !(absent && absent[f]);
    fuzz::expect(mesh.face_count == faces, "the faces are those that are left and those of the patch");
    fuzz::expect(mesh.vertex_count == key.mesh.vertex_count + (patch ? patch->vertex_count : 0),
                 "the vertices are those of the key mesh and of the patch");
  }
  fvv_mesh_sequence_close(sequence);
}
