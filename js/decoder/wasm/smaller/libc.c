/* Functions of the C library, smaller than its own. */
#include <malloc.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

/* What the C library does in loops, by the instructions that engines have for it. */

void *memcpy(void *restrict to, const void *restrict from, size_t size) {
  return __builtin_memcpy(to, from, size);
}
void *memmove(void *to, const void *from, size_t size) {
  return __builtin_memmove(to, from, size);
}
void *memset(void *to, int value, size_t size) {
  return __builtin_memset(to, value, size);
}

/* In place of the allocator's own, which can grow a block in place and is five times as large:
 * lists double when they grow, and are kept from frame to frame. */
void *realloc(void *pointer, size_t size) {
  void *larger = malloc(size);
  if (larger && pointer) {
    const size_t had = malloc_usable_size(pointer);
    memcpy(larger, pointer, had < size ? had : size);
    free(pointer);
  }
  return larger;
}

/* snprintf and vsnprintf with what messages and codec strings of libfvv use, in place of the C library's,
 * which are five times as large: flag 0, width, precision, l, ll, z and d u x X c s g. Floating point is
 * formatted by JavaScript. */

/* Writes a number with that many significant digits to out, at most size bytes; returns how many it wrote. */
__attribute__((import_module("fvv"), import_name("number"))) extern int
fvvjs_import_number(double value, int digits, char *out, int size);

typedef struct text {
  char *out;
  size_t capacity, length;
} text;

static void put(text *t, char c) {
  if (t->length + 1 < t->capacity) t->out[t->length] = c;
  t->length++;
}

static void put_integer(text *t, uint64_t value, int negative, unsigned base, char ten, int width,
                        int zeros) {
  char digits[24];
  int count = 0;
  do {
    const unsigned digit = (unsigned)(value % base);
    digits[count++] = (char)(digit < 10 ? '0' + digit : (unsigned)ten + digit - 10);
    value /= base;
  } while (value);
  if (negative && zeros) put(t, '-');
  for (int pad = width - count - negative; pad > 0; pad--) put(t, zeros ? '0' : ' ');
  if (negative && !zeros) put(t, '-');
  while (count) put(t, digits[--count]);
}

static void put_number(text *t, double value, int digits) {
  char out[32];
  const int count = fvvjs_import_number(value, digits < 0 ? 6 : digits, out, sizeof out);
  for (int i = 0; i < count; i++) put(t, out[i]);
}

static void put_text(text *t, const char *s, int most) {
  for (int i = 0; s[i] && (most < 0 || i < most); i++) put(t, s[i]);
}

static int read_number(const char **f) {
  int value = 0;
  for (; **f >= '0' && **f <= '9'; (*f)++) value = 10 * value + (**f - '0');
  return value;
}

int vsnprintf(char *out, size_t capacity, const char *f, va_list arguments) {
  text t = {out, capacity, 0};
  for (; *f; f++) {
    if (*f != '%') {
      put(&t, *f);
      continue;
    }
    f++;
    const int zeros = *f == '0';
    const int width = read_number(&f);
    int precision = -1, longs = 0;
    if (*f == '.') {
      f++;
      precision = read_number(&f);
    }
    for (; *f == 'l'; f++) longs++;
    if (*f == 'z') f++; /* 32 bits, as long */
    if (*f == 'd') {
      const int64_t value = longs == 2 ? va_arg(arguments, int64_t) : va_arg(arguments, int32_t);
      put_integer(&t, value < 0 ? 0 - (uint64_t)value : (uint64_t)value, value < 0, 10, 'a', width, zeros);
    } else if (*f == 'u' || *f == 'x' || *f == 'X') {
      const uint64_t value = longs == 2 ? va_arg(arguments, uint64_t) : va_arg(arguments, uint32_t);
      put_integer(&t, value, 0, *f == 'u' ? 10 : 16, *f == 'X' ? 'A' : 'a', width, zeros);
    } else if (*f == 'c') {
      put(&t, (char)va_arg(arguments, int));
    } else if (*f == 's') {
      put_text(&t, va_arg(arguments, const char *), precision);
    } else if (*f == 'g') {
      put_number(&t, va_arg(arguments, double), precision);
    } else {
      put(&t, *f);
    }
  }
  if (capacity) out[t.length < capacity ? t.length : capacity - 1] = 0;
  return (int)t.length;
}

int snprintf(char *out, size_t capacity, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  const int length = vsnprintf(out, capacity, format, arguments);
  va_end(arguments);
  return length;
}
