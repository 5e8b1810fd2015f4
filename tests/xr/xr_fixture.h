// SPDX-License-Identifier: Apache-2.0
// A test that runs platform/openxr in this process on the mock runtime.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "platform/openxr/session.h"
#include "tests/xr/mock_runtime/control.h"
#include "tests/xr/room_scene.h"

namespace dpl::test {

class XrTest : public testing::Test {
protected:
    /** Skips the test where there is no Vulkan device. */
    void SetUp() override;
    /** Nothing is left behind: no handle, no broken rule, no message of the validation layer. */
    void TearDown() override;

    /** A program with the tiny avatar on the mock: runtime, avatar, scene, session. */
    void open(const mockxr::Settings& settings, xr::SessionOptions options = {});
    void openSession(const xr::SessionOptions& options);
    void closeSession();
    void close();

    /** Calls frame() until it gives `wanted`. Fails the test at an error or after too many calls. */
    bool run(xr::Step wanted, int atMost = 12);
    /** One frame, which must not be an error. */
    xr::Step step();

    /** The user at that place, looking along -z. */
    static mockxr::Settings userAt(XrVector3f head);
    static xr::SessionOptions opaque();

    std::unique_ptr<xr::Runtime> runtime_;
    DplAvatar avatar_ = nullptr;
    std::optional<RoomScene> scene_;
    std::optional<xr::Session> session_;
};

/** The camera of a view, from the formulas of the specification. */
DplCamera cameraOf(const XrPosef& worldFromView, const XrFovf& fov, uint32_t widthPx, uint32_t heightPx);

/** What the software renderer draws of the tiny avatar: behind the wall, over the plain colour; RGBA8 sRGB codes. */
std::vector<uint8_t> expectedPicture(DplCamera camera, bool withAvatar = true);

/** Submitted pixels as RGBA8 sRGB codes. */
std::vector<uint8_t> asRgba8Srgb(const mockxr::SubmittedView& view);

/** Pixels that differ by more than 8 codes in a colour. */
size_t differingPixels(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b);

}  // namespace dpl::test
