// SPDX-License-Identifier: Apache-2.0
// skinned_example FOLDER [KEPT]: writes the example of DPL_skinned_gaussian_splatting, as docs/formats/skinned-splats holds it, and
// compares its pictures with those of another folder.
#include <cstdio>

#include "tests/conformance/skinned_example.h"

int main(int argc, char** argv) {
    if (argc < 2 || argc > 3) return std::fprintf(stderr, "usage: %s FOLDER [KEPT]\n", argv[0]), 2;
    std::error_code ignored;
    std::filesystem::create_directories(argv[1], ignored);
    dpl::Status done = dpl::writeSkinnedExample(argv[1]);
    if (done && argc == 3) done = dpl::compareSkinnedPictures(argv[1], argv[2]);
    return done ? 0 : (std::fprintf(stderr, "%s\n", done.error().message.c_str()), 1);
}
