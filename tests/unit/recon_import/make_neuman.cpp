// SPDX-License-Identifier: Apache-2.0
// make_neuman SCAN FOLDER: writes the moving frames of a scan as a subject of the NeuMan layout, for tools/prove-neuman.
#include <cstdio>

#include "tests/unit/recon_import/made_neuman.h"

int main(int argc, char** argv) {
    if (argc != 3) return std::fprintf(stderr, "usage: make_neuman SCAN FOLDER\n"), 2;
    const auto scan = dpl::readScan(argv[1]);
    if (!scan) return std::fprintf(stderr, "%s\n", scan.error().message.c_str()), 1;
    dpl::writeNeuman(*scan, argv[2]);
    return 0;
}
