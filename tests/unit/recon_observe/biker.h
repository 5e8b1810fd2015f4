// SPDX-License-Identifier: Apache-2.0
// The real man of the shared data, seen by the shared networks.
#pragma once

#include <optional>

#include "reconstruction/input/observe/observations.h"
#include "tests/unit/shared_data.h"

#include <gtest/gtest.h>

namespace dpl {

inline constexpr const char* kNoBiker = "shared data (models, real-orbit-biker) is not on this machine";

struct Biker {
    Observer observer;
    Scan scan;

    struct View {
        ImageRgb8 image;
        ImageGrey8 truth;
    };
    /** A picture of him, with his own matte. */
    View view(size_t frame) const {
        auto image = readFrameImage(scan.frames.at(frame));
        auto truth = readFrameMask(scan.frames.at(frame));
        EXPECT_TRUE(image && truth);
        return {*image, *truth};
    }
    Observation observe(const ImageRgb8& image, bool closeup = false) {
        auto seen = observer.observe(image, nullptr, nullptr, closeup);
        EXPECT_TRUE(seen) << seen.error().message;
        return *seen;
    }
};

/** Nothing when the shared data are not on this machine. */
inline std::optional<Biker> loadBiker() {
    const auto models = sharedData("models"), pictures = sharedData("real-orbit-biker");
    if (!models || !pictures) return std::nullopt;
    auto scan = readScan(*pictures);
    auto observer = Observer::load(*models);
    EXPECT_TRUE(scan && observer);
    return Biker{std::move(*observer), std::move(*scan)};
}

}  // namespace dpl
