// Delta frames that follow a hostile key mesh: any connectivity, any motion.
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
    if (status == FVV_OK) fuzz::expect_valid(*fvv_mesh_sequence_mesh(sequence));
  }
  fvv_mesh_sequence_close(sequence);
}
