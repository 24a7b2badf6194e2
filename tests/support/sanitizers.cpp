// What the leak sanitizer is not to report: libraries that we cannot mend. The sanitizer looks the function up by name,
// so it must be visible.

extern "C" __attribute__((visibility("default"))) const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libOSMesa\nleak:libLLVM\nleak:libgallium\n";
}

// And the thread sanitizer: civetweb writes the date of its answers by localtime, whose buffer all threads share.
extern "C" __attribute__((visibility("default"))) const char* __tsan_default_suppressions();
extern "C" const char* __tsan_default_suppressions() {
  return "race:tzset_internal\nrace:localtime\n";
}
