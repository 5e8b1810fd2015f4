// SPDX-License-Identifier: Apache-2.0
// A program for headsets, where there is none: it says why it cannot start.
#include <platform/openxr/puppet.h>
#include <platform/openxr/session.h>

#include <cstdio>

int main() {
    const auto runtime = dpl::xr::Runtime::create({});
    if (runtime) return std::printf("a headset, on a machine whose runtime was taken away?\n"), 1;
    std::printf("%s\n", runtime.error().message.c_str());
    return runtime.error().code == DPL_ERROR_UNSUPPORTED && !dpl::xr::Puppet().drives() ? 0 : 1;
}
