// SPDX-License-Identifier: Apache-2.0
// Recorded CMU clips, and joint positions of clips on rigs, for the tests of retargeting.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "sdk/avatar/rig.h"
#include "sdk/motion/clip.h"
#include "sdk/motion/motion.h"
#include "tests/unit/shared_data.h"

namespace dpl::test {

inline const char* const kClips[] = {"02_01", "02_03",         "02_05",    "05_01",    "05_09",         "07_01",
                                     "09_01", "scaled_131_01", "mh_tpose", "mh_walk1", "mh_zombieWalk1"};

inline std::optional<Motion> mocap(const std::string& name) {
    const auto shared = sharedData();
    if (!shared) return std::nullopt;
    std::ifstream in(*shared / "mocap-cmu" / (name + ".bvh"), std::ios::binary);
    if (!in) return std::nullopt;
    const std::string text((std::istreambuf_iterator<char>(in)), {});
    auto motion = readBvh(text, name);
    EXPECT_TRUE(motion) << motion.error().message;
    return motion ? std::optional(std::move(*motion)) : std::nullopt;
}

inline std::vector<Vec3f> positionsAt(const ClipData& clip, const std::vector<JointData>& rig, double timeS) {
    std::vector<Mat3x4f> g;
    const Pose pose = samplePose(clip, rig, timeS);
    EXPECT_TRUE(checkPose(rig, pose));
    jointTransforms(rig, pose, g);
    std::vector<Vec3f> p;
    for (size_t j = 0; j < rig.size(); ++j) p.push_back(Mat3f(g[j]) * rig[j].restPosition + g[j][3]);
    return p;
}

}  // namespace dpl::test

#define NEED_MOCAP(motion, name)                  \
    const auto motion = ::dpl::test::mocap(name); \
    if (!motion) GTEST_SKIP() << "shared/data/mocap-cmu is not at hand (set DOPPEL_SHARED_DATA)"
