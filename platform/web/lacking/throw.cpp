// SPDX-License-Identifier: Apache-2.0
// Debian's libc++abi for wasm32 cannot unwind, so a `throw` ends the module: JavaScript gets the name of the type, throws, and makes no
// more calls (doppel.js). libdoppel's own errors are values; what remains is memory that the browser refuses.
#include <cstdlib>
#include <typeinfo>

extern "C" {

[[noreturn]] __attribute__((import_module("doppel"), import_name("thrown"))) void doppelThrown(const char* typeName);

void* __cxa_allocate_exception(size_t bytes) noexcept {
    static char room[256];  // there may be no memory
    return bytes <= sizeof room ? room : std::malloc(bytes);
}
void __cxa_free_exception(void*) noexcept {}
[[noreturn]] void __cxa_throw(void*, std::type_info* type, void (*)(void*)) {
    doppelThrown(type->name());
}
[[noreturn]] void __cxa_rethrow() {
    doppelThrown("again");
}
void* __cxa_begin_catch(void* exception) noexcept {
    return exception;
}
void __cxa_end_catch() {}
int __cxa_thread_atexit(void (*)(void*), void*, void*) {
    return 0;  // the thread never ends
}

}  // extern "C"
