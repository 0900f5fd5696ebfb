// libx265 3.5 loses about a kilobyte with every encoder. Compiled into programs that LeakSanitizer watches,
// so that it reports only our own leaks.
extern "C" const char *__lsan_default_suppressions();
extern "C" const char *__lsan_default_suppressions() {
  return "leak:libx265.so\n";
}
