/* Fails unless the library that was packaged is the one that these headers describe. */
#include "fvv/types.h"

#include <stdio.h>

int main(void) {
  printf("fvv %s\n", fvv_version());
  return fvv_crc32c(0, "123456789", 9) == 0xe3069283u ? 0 : 1;
}
