// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/train_frames.h"

#include <gtest/gtest.h>

#include "tests/unit/recon_run/toy_reconstruction.h"

namespace dpl {
namespace {

TEST(FramesOf, aHeldOutFrameWithoutAMaskIsNotScored) {
    test::ToyReconstruction toy;
    IngestedScan ingested = toy.ingested;
    for (const size_t f : {5, 6, 7}) ingested.scan.frames[f].maskPath.clear();
    Pictures pictures(ingested.scan);
    const std::vector<Camerad> cameras(ingested.scan.frames.size(), ingested.scan.frames[0].camera);
    const std::vector<Pose> poses(ingested.scan.frames.size(), Pose::rest(2));
    const auto set = framesOf(ingested, Split::Test, cameras, poses, pictures);
    ASSERT_TRUE(set) << set.error().message;
    EXPECT_TRUE(set->frames.empty());
}

}  // namespace
}  // namespace dpl
