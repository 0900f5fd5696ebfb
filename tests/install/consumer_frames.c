/* A program as a user of the installed library writes it: pushes a file in small pieces, as a network
 * delivers it, and prints the meshes of each whole frame. */
#include <fvv/frames.h>

#include <stdio.h>

static int report(fvv_status status, const fvv_diagnostic *diagnostic, const char *name) {
  char line[512];
  fvv_diagnostic_format(diagnostic, name, line, sizeof line);
  fprintf(stderr, "%s (%s)\n", line, fvv_status_text(status));
  return 1;
}

static void print_frame(const fvv_frames_event *event) {
  size_t i;
  for (i = 0; i < event->chunk_count; i++) {
    const fvv_frame_chunk *chunk = &event->chunks[i];
    fvv_mesh_header mesh;
    if (chunk->header.type != FVV_CHUNK_MESH) continue;
    if (fvv_mesh_peek(chunk->payload, (size_t)chunk->header.size, NULL, &mesh, NULL) < 0) continue;
    printf("time %ld, track %u: %lu vertices, %lu faces\n", (long)event->time, chunk->header.track,
           (unsigned long)mesh.vertex_count, (unsigned long)mesh.face_count);
  }
}

int main(int argc, char **argv) {
  FILE *file = argc == 2 ? fopen(argv[1], "rb") : NULL;
  fvv_frames *frames = NULL;
  fvv_frames_event event;
  fvv_diagnostic diagnostic = {0};
  fvv_status status;
  int lost = 0;
  if (!file) return 2;
  status = fvv_frames_create(NULL, NULL, NULL, &frames);
  while (status >= 0 && status != FVV_END) {
    unsigned char piece[97];
    const size_t size = fread(piece, 1, sizeof piece, file);
    if (size)
      status = fvv_frames_push(frames, piece, size);
    else
      fvv_frames_finish(frames);
    while (status >= 0 && (status = fvv_frames_next(frames, &event, &diagnostic)) == FVV_OK) {
      if (event.kind == FVV_FRAMES_FRAME) print_frame(&event);
      if (event.kind == FVV_FRAMES_DAMAGE) lost = report(event.diagnostic.status, &event.diagnostic, argv[1]);
    }
  }
  fvv_frames_destroy(frames);
  fclose(file);
  return status < 0 ? report(status, &diagnostic, argv[1]) : lost;
}
