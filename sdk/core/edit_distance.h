// SPDX-License-Identifier: Apache-2.0
// How alike two words are, for errors that guess what was meant.
#pragma once

#include <algorithm>
#include <numeric>
#include <string>
#include <string_view>
#include <vector>

namespace dpl {

/** Levenshtein distance: the fewest letters inserted, removed or replaced that turn one word into the other. */
inline size_t editDistance(std::string_view a, std::string_view b) {
    std::vector<size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), size_t(0));
    for (size_t i = 0; i < a.size(); ++i) {
        size_t diagonal = row[0]++;
        for (size_t j = 0; j < b.size(); ++j) {
            const size_t replaced = diagonal + (a[i] != b[j]);
            diagonal = row[j + 1];
            row[j + 1] = std::min({replaced, row[j] + 1, row[j + 1] + 1});
        }
    }
    return row.back();
}

/** " (did you mean 'steps'?)" with the first of the names that are most like the word; empty where none is. */
inline std::string didYouMean(std::string_view word, const std::vector<std::string>& names) {
    constexpr size_t kMostEdits = 2;
    const auto nearest = std::min_element(names.begin(), names.end(), [&](const std::string& a, const std::string& b) {
        return editDistance(word, a) < editDistance(word, b);
    });
    if (nearest == names.end() || editDistance(word, *nearest) > kMostEdits) return {};
    return " (did you mean '" + *nearest + "'?)";
}

}  // namespace dpl
