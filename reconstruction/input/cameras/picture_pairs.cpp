// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/cameras/picture_pairs.h"

#include <algorithm>
#include <set>

namespace dpl {
namespace {

constexpr size_t kNeighbours = 3, kAnchorsOfStill = 9, kAnchorsOfCloseup = 20;

}  // namespace

std::vector<std::pair<size_t, size_t>> pairsToMatch(size_t stills, size_t closeups) {
    std::set<std::pair<size_t, size_t>> pairs;
    const auto add = [&](size_t a, size_t b) {
        if (a != b) pairs.emplace(std::min(a, b), std::max(a, b));
    };
    const auto addAnchors = [&](size_t picture, size_t most) {
        const size_t count = std::min(most, stills);
        for (size_t k = 0; k < count; ++k) add(picture, k * stills / count);
    };
    for (size_t i = 0; i < stills; ++i) {
        for (size_t k = 1; k <= kNeighbours; ++k) add(i, (i + k) % stills);
        addAnchors(i, kAnchorsOfStill);
    }
    for (size_t i = 0; i < closeups; ++i) {
        for (size_t k = 1; k <= kNeighbours && i + k < closeups; ++k) add(stills + i, stills + i + k);
        addAnchors(stills + i, kAnchorsOfCloseup);
    }
    return {pairs.begin(), pairs.end()};
}

}  // namespace dpl
