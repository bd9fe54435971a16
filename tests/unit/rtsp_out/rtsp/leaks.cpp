// For the leak sanitizer; other builds do not call these.

extern "C" {

// The whole stack of an allocation, not only down to the first library without frame pointers.
const char* __asan_default_options() {
    return "fast_unwind_on_malloc=0";
}

// GLib makes the table of its quarks when it is loaded, and drops it for a larger one at the 2048th, on purpose: its
// lookups take no lock (glib/gquark.c). Nothing of ours is allocated below the dynamic loader.
const char* __lsan_default_suppressions() {
    return "leak:ld-linux\n";
}
}
