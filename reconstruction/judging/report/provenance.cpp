// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/judging/report/provenance.h"

#include <algorithm>
#include <array>

namespace dpl {
namespace {

// The development set. scan-tiny has the subject of scan-a, and scan-c-motion that of scan-c.
constexpr std::array<std::string_view, 8> kDevelopmentScans = {"scan-a",           "scan-tiny",    "scan-c",       "scan-c-motion",
                                                               "real-orbit-biker", "procedural-1", "procedural-2", "procedural-3"};

}  // namespace

bool isDevelopmentScan(std::string_view scanName) {
    return std::find(kDevelopmentScans.begin(), kDevelopmentScans.end(), scanName) != kDevelopmentScans.end();
}

std::vector<std::string> provenanceOf(std::string_view scanName, bool sameBody) {
    std::vector<std::string> sentences;
    sentences.emplace_back(isDevelopmentScan(scanName)
                               ? "Development set: constants of the reconstruction were chosen on this scan, so its figures are optimistic."
                               : "Not of the development set, by its name. If its pictures come from one of the scans on which constants "
                                 "of the reconstruction were chosen, its figures are optimistic all the same.");
    if (sameBody)
        sentences.emplace_back(
            "The subject was made from the same body model that is fitted here. Real people differ from it, so expect less for them.");
    return sentences;
}

}  // namespace dpl
