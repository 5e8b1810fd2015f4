// SPDX-License-Identifier: Apache-2.0
// Which frame of a scan is compared, and which is to be drawn for it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace dpl {

class Comparison {
public:
    enum class Way : uint8_t { Wipe, Beside, Error };

    Way way = Way::Wipe;
    float wipe = 0.5f;  // share of the width that shows the photograph

    /** names: of the frames, for people. Keeps the chosen frame, where there is one. */
    void setFrames(std::vector<std::string> names);
    const std::vector<std::string>& frames() const { return names_; }

    size_t frame() const { return chosen_; }
    /** Beyond the ends: the frame at the end. */
    void choose(size_t frame);
    void step(int by);

    /** The frame that is to be drawn now. Nothing while one is on its way, so that a fast hand skips frames, and when the chosen one is
     * there or cannot be drawn. Counts as on its way from then on. */
    std::optional<size_t> next();
    /** A frame has been drawn, or could not be. */
    void arrived(size_t frame);
    /** Whether the pictures are those of the chosen frame. */
    bool isShown() const { return arrived_ == chosen_; }

private:
    std::vector<std::string> names_;
    size_t chosen_ = 0;
    std::optional<size_t> onItsWay_, arrived_;
};

}  // namespace dpl
