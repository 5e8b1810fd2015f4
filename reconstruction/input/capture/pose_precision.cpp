// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/input/capture/pose_precision.h"

#include <algorithm>
#include <iterator>

namespace dpl {

PosePrecision together(const PosePrecision& a, const PosePrecision& b) {
    PosePrecision out;
    std::set_union(a.joints.begin(), a.joints.end(), b.joints.begin(), b.joints.end(), std::back_inserter(out.joints));
    const size_t n = out.size();
    out.matrix.assign(n * n, 0.0);
    for (const PosePrecision* part : {&a, &b}) {
        std::vector<size_t> place(part->size());  // of a row of the part
        for (size_t k = 0; k < part->joints.size(); ++k) {
            const auto at = std::lower_bound(out.joints.begin(), out.joints.end(), part->joints[k]);
            for (size_t c = 0; c < 3; ++c) place[3 * k + c] = 3 * size_t(at - out.joints.begin()) + c;
        }
        for (size_t c = 0; c < 3; ++c) place[3 * part->joints.size() + c] = n - 3 + c;
        for (size_t r = 0; r < part->size(); ++r)
            for (size_t c = 0; c < part->size(); ++c) out.matrix[place[r] * n + place[c]] += part->matrix[r * part->size() + c];
    }
    return out;
}

}  // namespace dpl
