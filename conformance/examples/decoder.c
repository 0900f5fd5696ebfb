/* A decoder under test in C, over libfvv: cameras of whole frames. */
#include <cjson/cJSON.h>
#include <openssl/evp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fvv/stream.h"

typedef struct content {
  uint8_t *bytes;
  size_t size;
} content;

static content load(const cJSON *request) {
  content out = {calloc(1, 1 << 22), 0}; /* enough for every case */
  const cJSON *data = cJSON_GetObjectItem(request, "data"), *path = cJSON_GetObjectItem(request, "path");
  if (data) {
    const char *text = data->valuestring;
    const int size = EVP_DecodeBlock(out.bytes, (const unsigned char *)text, (int)strlen(text));
    const char *pad = strchr(text, '=');
    out.size = size < 0 ? 0 : (size_t)size - (pad ? strlen(pad) : 0);
  } else {
    FILE *file = fopen(path->valuestring, "rb");
    if (file) out.size = fread(out.bytes, 1, 1 << 22, file);
    if (file) fclose(file);
  }
  return out;
}

static void add_camera(cJSON *arrays, const fvv_camera *c) {
  double n[26] = {c->fx, c->fy, c->cx, c->cy, c->skew};
  memcpy(n + 5, c->distortion, sizeof c->distortion);
  n[13] = c->r_max;
  memcpy(n + 14, c->rotation, sizeof c->rotation);
  memcpy(n + 23, c->translation, sizeof c->translation);
  uint8_t digest[32];
  char name[16], hex[65];
  EVP_Digest(n, sizeof n, digest, NULL, EVP_sha256(), NULL);
  for (int i = 0; i < 32; i++) snprintf(hex + 2 * i, 3, "%02x", digest[i]);
  snprintf(name, sizeof name, "camera/%u", c->id);
  cJSON_AddStringToObject(arrays, name, hex);
}

/* Whether the checker calls the frame of a time whole. */
static int is_whole(const fvv_checker *checker, int64_t time) {
  for (size_t i = 0; i < fvv_checker_run_count(checker); i++) {
    const fvv_frame_run *run = fvv_checker_run(checker, i);
    if (time >= run->first_time && time <= run->last_time) return 1;
  }
  return 0;
}

static void add_frames(cJSON *frames, content *stream_content, const fvv_checker *checker) {
  int64_t last = 0; /* a group of a wrong time may repeat those of an earlier one */
  const fvv_input input = fvv_input_memory(stream_content->bytes, stream_content->size);
  fvv_stream *stream;
  if (fvv_stream_open(&input, NULL, NULL, &stream, NULL) != FVV_OK) return;
  for (size_t f = 0; f < fvv_stream_frame_count(stream); f++) {
    fvv_frame frame;
    fvv_camera camera;
    const fvv_configuration *configuration;
    if (fvv_stream_frame(stream, f, &frame, NULL) != FVV_OK ||
        fvv_stream_configuration(stream, frame.group, &configuration, NULL) != FVV_OK ||
        !is_whole(checker, frame.time) || (cJSON_GetArraySize(frames) && frame.time <= last))
      continue;
    last = frame.time;
    cJSON *one = cJSON_CreateObject();
    char time[24]; /* a string: cJSON's numbers are doubles */
    snprintf(time, sizeof time, "%lld", (long long)frame.time);
    cJSON_AddStringToObject(one, "time", time);
    cJSON *arrays = cJSON_AddObjectToObject(one, "arrays");
    for (size_t i = 0; i < configuration->camera_count; i++)
      if (fvv_stream_camera(stream, f, configuration->cameras[i].id, &camera, NULL) == FVV_OK)
        add_camera(arrays, &camera);
    cJSON_AddItemToArray(frames, one);
  }
  fvv_stream_close(stream);
}

static cJSON *decode(const cJSON *request) {
  content bytes = load(request);
  fvv_check_options options;
  fvv_check_options_default(&options);
  options.decode = 1;
  fvv_checker *checker;
  if (fvv_checker_create(&options, NULL, NULL, &checker) != FVV_OK) exit(1);
  fvv_checker_push(checker, bytes.bytes, bytes.size);
  const int whole = fvv_checker_finish(checker) >= 0 && !fvv_checker_summary(checker)->problems;
  cJSON *report = cJSON_CreateObject();
  cJSON_AddItemToObject(report, "id", cJSON_Duplicate(cJSON_GetObjectItem(request, "id"), 1));
  cJSON_AddStringToObject(report, "status", whole ? "whole" : "damaged");
  cJSON *frames = cJSON_AddArrayToObject(report, "frames");
  add_frames(frames, &bytes, checker);
  fvv_checker_destroy(checker);
  free(bytes.bytes);
  return report;
}

int main(void) {
  char *line = NULL;
  size_t capacity = 0;
  while (getline(&line, &capacity, stdin) > 0) {
    cJSON *request = cJSON_Parse(line);
    const char *op = cJSON_GetObjectItem(request, "op")->valuestring;
    if (!strcmp(op, "quit")) break;
    cJSON *answer = strcmp(op, "hello")
                        ? decode(request)
                        : cJSON_Parse("{\"protocol\": 1, \"name\": \"example.c\", \"version\": \"1\","
                                      " \"format\": \"0.2\", \"parts\": [\"camera\"]}");
    char *text = cJSON_PrintUnformatted(answer);
    puts(text);
    fflush(stdout);
    cJSON_free(text);
    cJSON_Delete(answer);
    cJSON_Delete(request);
  }
  free(line);
  return 0;
}
