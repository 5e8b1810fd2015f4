// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/comparison.h"

#include <algorithm>

namespace dpl {

void Comparison::setFrames(std::vector<std::string> names) {
    names_ = std::move(names);
    choose(chosen_);
}

void Comparison::choose(size_t frame) {
    chosen_ = names_.empty() ? frame : std::min(frame, names_.size() - 1);
}

void Comparison::step(int by) {
    const auto to = ptrdiff_t(chosen_) + by;
    choose(size_t(std::max<ptrdiff_t>(0, to)));
}

std::optional<size_t> Comparison::next() {
    if (onItsWay_ || arrived_ == chosen_) return std::nullopt;
    onItsWay_ = chosen_;
    return onItsWay_;
}

void Comparison::arrived(size_t frame) {
    onItsWay_.reset();
    arrived_ = frame;
}

}  // namespace dpl
