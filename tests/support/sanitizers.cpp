// What the leak sanitizer is not to report: libraries that we cannot mend.

extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libOSMesa\nleak:libLLVM\nleak:libgallium\n";
}
