// SPDX-License-Identifier: Apache-2.0
// Writes pages for layout_test.py: `report_page tall|wide|bare|live FILE`. The page `live` has the stage of a living person, but no module.
#include <cstdio>
#include <string_view>

#include "sdk/core/files.h"
#include "tests/unit/recon_report/sample_report.h"

int main(int argc, char** argv) {
    using namespace dpl;
    if (argc != 3) return std::fprintf(stderr, "usage: report_page tall|wide|bare|live FILE\n"), 2;
    const std::string_view which = argv[1];
    ReportData data = which == "bare" ? test::bareReport() : which == "wide" ? test::fullReport(960, 800) : test::fullReport();
    if (which == "live") data.live = test::someLife();
    const Status written = writeFileAtomically(argv[2], reportHtml(data));
    if (!written) return std::fprintf(stderr, "%s\n", written.error().message.c_str()), 1;
    return 0;
}
