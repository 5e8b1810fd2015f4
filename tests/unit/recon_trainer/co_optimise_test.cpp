// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/training/trainer/co_optimise.h"

#include <gtest/gtest.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include <cstring>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>

#include "reconstruction/training/trainer/pose_fitter.h"
#include "sdk/core/files.h"
#include "sdk/math/sh.h"
#include "tests/unit/heard_task.h"
#include "tests/unit/must.h"
#include "tests/unit/recon_trainer/toy_scene.h"

namespace dpl::test {
namespace {

/** All bytes of a result that go into the avatar, by part. */
std::map<std::string, std::vector<uint8_t>> bytesOf(const CoOptimiseResult& r) {
    std::map<std::string, std::vector<uint8_t>> out;
    const auto add = [&](const char* name, const auto& v) {
        const auto* p = reinterpret_cast<const uint8_t*>(v.data());
        out[name].insert(out[name].end(), p, p + v.size() * sizeof(v[0]));
    };
    add("triangles", r.splats.triangleStart), add("uv", r.splats.uv), add("phi", r.splats.phi), add("scale", r.splats.scaleM);
    add("opacity", r.splats.opacity), add("flags", r.splats.flags), add("sh", r.splats.sh), add("rest", r.restPositions);
    for (const Pose& p : r.poses) add("rotations", p.localRotations), add("translations", std::vector<Vec3f>{p.rootTranslation});
    add("curve", r.curve), add("nodes", r.correctives.nodes);
    return out;
}

void expectSame(const CoOptimiseResult& a, const CoOptimiseResult& b) {
    const auto x = bytesOf(a), y = bytesOf(b);
    for (const auto& [name, bytes] : x) EXPECT_TRUE(bytes == y.at(name)) << name << " differ";
}

std::unique_ptr<CoOptimiser> make(Jobs& jobs, const CoOptimiseSettings& settings, float sway = 0.004f) {
    CoOptimiseInput input = toyScene(jobs, 8, sway, 0.03f);
    input.correctives = toyCorrectives(input.mesh);
    auto t = CoOptimiser::create(std::move(input), settings, jobs);
    EXPECT_TRUE(t) << t.error().message;
    return t ? std::move(*t) : nullptr;
}

std::filesystem::path scratch(const char* name) {
    return std::filesystem::path(::testing::TempDir()) / name;
}

TEST(CoOptimise, lossFallsAndPictureGetsClose) {
    Jobs jobs(2);
    auto t = make(jobs, toySettings(240), 0);
    ASSERT_TRUE(t->run());
    const CoOptimiseResult r = t->result();
    ASSERT_GE(r.curve.size(), 4u);
    // The level rises during the run, so the later PSNR is of a harder picture.
    EXPECT_GT(r.curve.back().psnr, r.curve.front().psnr + 2);
    EXPECT_GT(r.curve.back().psnr, 26);
    EXPECT_GT(r.splats.count(), 1500u) << "density control added splats";
    EXPECT_LE(r.splats.count(), 2200u);
    EXPECT_EQ(r.splats.triangleStart.back(), r.splats.count());
    EXPECT_GT(r.profile.pairs, 0);
}

TEST(CoOptimise, sameBytesOnOneTwoThreeThreads) {
    std::optional<CoOptimiseResult> first;
    for (uint32_t threads : {1u, 2u, 3u}) {
        SCOPED_TRACE(threads);
        Jobs jobs(threads);
        auto t = make(jobs, toySettings(48));
        ASSERT_TRUE(t->run());
        if (!first) first = t->result();
        expectSame(t->result(), *first);
    }
}

TEST(CoOptimise, anotherSeedGivesAnotherResult) {
    Jobs jobs(2);
    CoOptimiseSettings s = toySettings(16);
    auto a = make(jobs, s);
    s.seed = 43;
    auto b = make(jobs, s);
    ASSERT_TRUE(a->run() && b->run());
    EXPECT_TRUE(bytesOf(a->result()) != bytesOf(b->result()));
}

TEST(CoOptimise, restoredRunEndsInTheSameBytes) {
    Jobs jobs(2);
    const CoOptimiseSettings s = toySettings(48);
    const auto makeKnown = [&] {  // registration knows every other frame, of which fewer joints turn then
        CoOptimiseInput input = toyScene(jobs, 8, 0.004f, 0.03f);
        input.correctives = toyCorrectives(input.mesh);
        auto known = std::make_shared<PosePrecision>();
        known->joints = {0};
        known->matrix.assign(36, 0.0);
        for (size_t i = 0; i < 6; ++i) known->matrix[7 * i] = 1e4;
        for (size_t f = 0; f < input.frames.size(); f += 2) input.frames[f].precision = known;
        return std::move(*CoOptimiser::create(std::move(input), s, jobs));
    };
    auto whole = makeKnown();
    ASSERT_TRUE(whole->run());
    const auto path = scratch("trainer.checkpoint");
    auto killed = makeKnown();
    ASSERT_TRUE(killed->run(29));  // inside an epoch, a geometry interval and a curve interval
    ASSERT_TRUE(killed->checkpoint(path));
    killed.reset();
    auto rerun = makeKnown();
    const Status restored = rerun->restore(path);
    ASSERT_TRUE(restored) << restored.error().message;
    EXPECT_EQ(rerun->step(), 29u);
    ASSERT_TRUE(rerun->run());
    expectSame(rerun->result(), whole->result());
}

TEST(CoOptimise, damagedOrForeignCheckpointIsRefusedAndChangesNothing) {
    Jobs jobs(1);
    CoOptimiseSettings s = toySettings(16);
    auto t = make(jobs, s);
    ASSERT_TRUE(t->run(8));
    const auto path = scratch("trainer_damaged.checkpoint");
    ASSERT_TRUE(t->checkpoint(path));
    auto bytes = readFile(path);
    ASSERT_TRUE(bytes);
    const auto before = bytesOf(t->result());
    for (size_t cut : {size_t(0), size_t(3), size_t(20), bytes->size() / 2, bytes->size() - 1}) {
        ASSERT_TRUE(writeFileAtomically(path, std::span(bytes->data(), cut)));
        EXPECT_FALSE(t->restore(path)) << "cut to " << cut;
    }
    auto flipped = *bytes;
    flipped[flipped.size() / 3] ^= 4;
    ASSERT_TRUE(writeFileAtomically(path, flipped));
    EXPECT_FALSE(t->restore(path));
    ASSERT_TRUE(writeFileAtomically(path, *bytes));
    s.seed = 7;
    auto other = make(jobs, s);
    const Status refused = other->restore(path);
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find(path.string()), std::string::npos) << "the sentence names the file";
    EXPECT_TRUE(bytesOf(t->result()) == before);
    EXPECT_TRUE(t->restore(path));
}

TEST(CoOptimise, aBranchGoesOnWithOtherSettingsAndSaysWhatChanged) {
    Jobs jobs(2);
    const CoOptimiseSettings before = toySettings(32);
    auto t = make(jobs, before);
    ASSERT_TRUE(t->run(20));
    const auto path = scratch("trainer_branch.checkpoint");
    ASSERT_TRUE(t->checkpoint(path));

    CoOptimiseSettings now = before;
    now.steps = 40, now.rateDc = 1e-3f, now.loss.ssim = 0, now.levelStarts.back() = 0.5f;
    auto other = make(jobs, now);
    EXPECT_FALSE(other->restore(path)) << "another run's checkpoint is no place to resume from";
    EXPECT_EQ(must(other->branch(path)), "steps 32 to 40, loss.ssim 0.2 to 0, rateDc 0.005 to 0.001, levelStarts 0 0.3 to 0 0.5");
    EXPECT_EQ(other->step(), 20u);
    ASSERT_TRUE(other->run());
    EXPECT_EQ(other->step(), 40u);
    ASSERT_TRUE(t->run());
    EXPECT_TRUE(bytesOf(other->result()).at("sh") != bytesOf(t->result()).at("sh"));

    auto same = make(jobs, before);
    EXPECT_EQ(must(same->branch(path)), "");
    ASSERT_TRUE(same->run());
    expectSame(same->result(), t->result());
}

TEST(CoOptimise, aBranchThatCannotGoOnSaysWhy) {
    Jobs jobs(1);
    auto t = make(jobs, toySettings(16));
    ASSERT_TRUE(t->run(8));
    const auto path = scratch("trainer_no_branch.checkpoint");
    ASSERT_TRUE(t->checkpoint(path));
    const auto refused = [&](const CoOptimiseSettings& settings, float sway, const std::string& words) {
        auto other = make(jobs, settings, sway);
        const auto before = bytesOf(other->result());
        const auto branched = other->branch(path);
        ASSERT_FALSE(branched) << words;
        EXPECT_NE(branched.error().message.find(words), std::string::npos) << branched.error().message;
        EXPECT_NE(branched.error().message.find(path.string()), std::string::npos) << branched.error().message;
        EXPECT_TRUE(bytesOf(other->result()) == before) << words;
        EXPECT_EQ(other->step(), 0u);
    };
    refused(toySettings(8), 0.004f, "has taken 8 steps, and this training has 8");
    CoOptimiseSettings other = toySettings(16);
    other.init.shDegree = toySettings(16).init.shDegree + 1;
    refused(other, 0.004f, "keep init.shDegree");
    other = toySettings(16), other.smoothingLengthM *= 2;
    refused(other, 0.004f, "keep smoothingLengthM");
    refused(toySettings(16), 0.003f, "other pictures, poses, clothes or light");
    ASSERT_TRUE(writeFileAtomically(path, std::string("no checkpoint")));
    refused(toySettings(16), 0.004f, "not a checkpoint");
}

/** A checkpoint with another payload, with the length and hash that match it. */
std::vector<uint8_t> withPayload(std::span<const uint8_t> checkpoint, std::span<const uint8_t> payload) {
    constexpr size_t kSizeAt = 16, kHashAt = 24, kPayloadAt = 32;
    std::vector<uint8_t> out(checkpoint.begin(), checkpoint.begin() + kPayloadAt);
    const uint64_t size = payload.size(), hash = XXH3_64bits(payload.data(), payload.size());
    std::memcpy(out.data() + kSizeAt, &size, 8), std::memcpy(out.data() + kHashAt, &hash, 8);
    out.insert(out.end(), payload.begin(), payload.end());
    return out;
}

TEST(CoOptimise, aCheckpointWhoseFieldsDoNotFitIsRefusedAndChangesNothing) {
    Jobs jobs(1);
    auto t = make(jobs, toySettings(16));
    ASSERT_TRUE(t->run(8));
    const auto path = scratch("trainer_hostile.checkpoint");
    ASSERT_TRUE(t->checkpoint(path));
    const auto bytes = readFile(path);
    ASSERT_TRUE(bytes);
    const std::vector<uint8_t> payload(bytes->begin() + 32, bytes->end());
    const auto before = bytesOf(t->result());
    const auto refuses = [&](const std::vector<uint8_t>& bad, const char* word) {
        ASSERT_TRUE(writeFileAtomically(path, withPayload(*bytes, bad)));
        const Status restored = t->restore(path);
        ASSERT_FALSE(restored) << word;
        EXPECT_NE(restored.error().message.find(word), std::string::npos) << restored.error().message;
        EXPECT_NE(restored.error().message.find(path.string()), std::string::npos) << restored.error().message;
        EXPECT_TRUE(bytesOf(t->result()) == before) << word;
    };
    for (size_t cut = 0; cut < payload.size(); cut += payload.size() / 61 + 1)
        refuses({payload.begin(), payload.begin() + long(cut)}, "damaged");

    // step u32, SH degree u32, count u64 and triangles u32, count u64 and flags u8, count u64 and rows f32
    uint64_t splats = 0;
    std::memcpy(&splats, payload.data() + 8, 8);
    ASSERT_GT(splats, 1000u);
    const auto changed = [&](size_t at, auto value) {
        std::vector<uint8_t> out = payload;
        std::memcpy(out.data() + at, &value, sizeof value);
        return out;
    };
    refuses(changed(0, 17u), "more steps");
    refuses(changed(4, 9u), "SH degree");
    refuses(changed(16, 70000u), "triangle order");
    refuses(changed(8, ~uint64_t(0)), "does not fit");
    refuses(changed(8, splats - 1), "damaged");
    refuses(changed(16 + splats * 4, splats - 1), "flags");
    refuses(changed(16 + splats * 4 + 8 + splats + 8, NAN), "rows: numbers that are not finite");

    ASSERT_TRUE(writeFileAtomically(path, withPayload(*bytes, payload)));
    EXPECT_TRUE(t->restore(path)) << "the header that this test writes is a good one";
}

TEST(CoOptimise, hugeGradientsLeaveTheStateFinite) {
    // The loss stays finite at this weight; squares of gradients and the lengths of those on the screen do not.
    Jobs jobs(2);
    CoOptimiseSettings s = toySettings(16);
    s.loss.l1 = 1e32f;
    s.learnGeometry = s.learnCorrectives = s.densify = false;
    auto t = make(jobs, s);
    ASSERT_TRUE(t->run(8));
    const auto path = scratch("trainer_huge.checkpoint");
    ASSERT_TRUE(t->checkpoint(path));
    const Status restored = make(jobs, s)->restore(path);
    EXPECT_TRUE(restored) << restored.error().message;
}

TEST(CoOptimise, theProfileHoldsAllPartsOfTheStepsThatItCounts) {
    Jobs jobs(1);
    CoOptimiseInput input = toyScene(jobs, 8);
    input.frames.resize(1);  // so the last epoch is one step
    auto t = CoOptimiser::create(std::move(input), toySettings(2), jobs);
    ASSERT_TRUE(t && (*t)->run());
    const StepProfile p = (*t)->result().profile;
    EXPECT_EQ(p.steps, 1u);
    const auto wallMs = [&p](StepPart part) { return p.parts[size_t(part)].wall; };
    for (const StepPart part : {StepPart::Pose, StepPart::Project, StepPart::Blend, StepPart::Loss, StepPart::Pixels, StepPart::Adam})
        EXPECT_GT(wallMs(part), 0) << nameOf(part);
    double sum = 0;
    for (const PartTime& part : p.parts) sum += part.wall;
    EXPECT_LE(sum, p.stepMs);
    EXPECT_GT(p.visible, 0);
    EXPECT_GE(p.entries, p.visible);
    EXPECT_GT(p.pixels, 0);
    EXPECT_GT(p.forwardNsPerPair, 0);
}

TEST(CoOptimise, posesAreFoundAgain) {
    // In every frame the subject is 8 mm and 3 degrees off the given pose. Learning the poses must improve the picture.
    Jobs jobs(2);
    CoOptimiseSettings s = toySettings(400);
    s.learnGeometry = false;
    const auto run = [&](bool learn) {
        s.learnPoses = learn;
        auto t = CoOptimiser::create(toyScene(jobs, 8, 0.008f, 0.05f), s, jobs);
        EXPECT_TRUE(t && (*t)->run());
        return (*t)->result().curve.back().psnr;
    };
    const float fixed = run(false), learned = run(true);
    EXPECT_GT(learned, fixed + 1.0f);
}

TEST(CoOptimise, correctivesAreFoundAgain) {
    Jobs jobs(2);
    PoseCorrectiveData truth = toyCorrectives(ballMesh());
    truth.nodes = {Vec4f(0, 0.02f, 0.01f, 0.4f), Vec4f(0.015f, 0, 0, -0.3f)};
    double psnr[2] = {};
    for (const bool learn : {false, true}) {
        CoOptimiseInput input = toyScene(jobs, 12, 0, 0, 72, truth);
        if (learn) input.correctives = toyCorrectives(input.mesh);
        CoOptimiseSettings settings = toySettings(480);
        settings.learnPoses = false;  // learned poses could take the place of offsets
        settings.rateNodeOffset = 2e-3f;
        auto t = CoOptimiser::create(std::move(input), settings, jobs);
        ASSERT_TRUE(t) << t.error().message;
        ASSERT_TRUE((*t)->run());
        const CoOptimiseResult r = (*t)->result();
        psnr[learn] = double(r.curve.back().psnr);
        if (!learn) continue;
        for (int n = 0; n < 2; ++n) {
            EXPECT_NEAR(r.correctives.nodes[size_t(n)].w, truth.nodes[size_t(n)].w, 0.1) << "light of node " << n;
            for (int a = 0; a < 3; ++a)
                EXPECT_NEAR(r.correctives.nodes[size_t(n)][a], truth.nodes[size_t(n)][a], 0.006) << "offset of node " << n;
        }
    }
    std::printf("without %.2f dB, with %.2f dB\n", psnr[0], psnr[1]);
    EXPECT_GT(psnr[1], psnr[0] + 3) << "the pictures cannot be explained without them";
}

TEST(CoOptimise, splatsThatNoPictureShowsStayAsTheyStarted) {
    Jobs jobs(2);
    // The lower half of the ball is drawn, but the pictures show something else there by their labels.
    CoOptimiseInput in = toyScene(jobs);
    constexpr uint8_t kLeg = 1, kSkirt = 2;
    for (const Triangle& t : in.mesh.triangles) {
        const auto& at = in.mesh.restPositions;
        in.triangleLabel.push_back(at[t.x].y + at[t.y].y + at[t.z].y < 0 ? kLeg : kSkirt);
    }
    in.frames = labelled(in.frames, kSkirt);
    const TriangleSight sight = *triangleSight({in.joints, in.mesh, in.triangleLabel, in.frames}, jobs);
    CoOptimiseSettings settings = toySettings(60);
    settings.densify = false;
    auto trainer = CoOptimiser::create(in, settings, jobs);
    ASSERT_TRUE(trainer);
    const SplatData before = (*trainer)->result().splats;
    ASSERT_TRUE((*trainer)->run());
    const SplatData after = (*trainer)->result().splats;
    ASSERT_EQ(after.triangleStart, before.triangleStart);
    const uint32_t stride = shCoefficientCount(before.shDegree) * 3;
    size_t unseen = 0, seen = 0, learned = 0;
    for (size_t t = 0; t < sight.seen.size(); ++t)
        for (uint32_t i = before.triangleStart[t]; i < before.triangleStart[t + 1]; ++i) {
            const bool same = after.opacity[i] == before.opacity[i] && after.uv[i] == before.uv[i] &&
                              std::equal(&after.sh[i * stride], &after.sh[(i + 1) * stride - 1] + 1, &before.sh[i * stride]);
            ++(sight.seen[t] ? seen : unseen);
            if (sight.seen[t])
                learned += !same;
            else
                ASSERT_TRUE(same) << "splat " << i << " of unseen triangle " << t;
        }
    EXPECT_GT(unseen, 100u);
    EXPECT_GT(learned, seen / 2);
}

TEST(CoOptimise, aCloseupMovesSplatsFurtherInOneStep) {
    // Adam's first step has the length of the rate, whatever the gradient, so a factor on gradients would not show.
    Jobs jobs(2);
    auto start = make(jobs, toySettings(20), 0);
    ASSERT_TRUE(start->run());
    const CoOptimiseResult given = start->result();
    const auto changes = [&](FrameKind kind) {
        CoOptimiseInput input = toyScene(jobs, 8, 0, 0.03f);
        input.mesh.restPositions = given.restPositions;
        input.frames.resize(1);
        input.frames[0].kind = kind;
        CoOptimiseSettings settings = toySettings(1);
        settings.learnGeometry = settings.learnPoses = settings.densify = false;
        settings.closeupStepScale = 4;
        auto trainer = CoOptimiser::createFrom(std::move(input), given.splats, settings, jobs);
        EXPECT_TRUE(trainer && (*trainer)->run());
        std::vector<double> out;
        const SplatData after = (*trainer)->result().splats;
        for (size_t i = 0; i < after.sh.size(); ++i) out.push_back(double(after.sh[i]) - double(given.splats.sh[i]));
        return out;
    };
    const std::vector<double> full = changes(FrameKind::StaticFull), close = changes(FrameKind::StaticCloseup);
    size_t moved = 0;
    for (size_t i = 0; i < full.size(); ++i) {
        EXPECT_NEAR(close[i], 4 * full[i], 1e-5);
        moved += full[i] != 0;
    }
    EXPECT_GT(moved, 100u);
}

TEST(CoOptimise, cancelStopsAndCanGoOn) {
    Jobs jobs(1);
    auto t = make(jobs, toySettings(8));
    HeardTask task(3);
    {
        const TaskScope scope(&task);
        const Status stopped = t->run();
        ASSERT_FALSE(stopped);
        EXPECT_EQ(stopped.error().code, Code::Cancelled);
    }
    EXPECT_EQ(t->step(), 3u);
    ASSERT_EQ(task.heard.size(), 3u);
    EXPECT_DOUBLE_EQ(task.heard[2].first, 2.0 / 8);
    EXPECT_TRUE(task.heard[2].second.starts_with("step 2 of 8, ")) << task.heard[2].second;
    EXPECT_TRUE(t->run());
    EXPECT_TRUE(t->finished());
}

TEST(CoOptimise, badInputIsRefusedByName) {
    Jobs jobs(1);
    const CoOptimiseSettings s = toySettings(8);
    const auto refuse = [&](auto&& spoil, const char* word) {
        CoOptimiseInput in = toyScene(jobs, 4);
        spoil(in);
        auto t = CoOptimiser::create(std::move(in), s, jobs);
        ASSERT_FALSE(t);
        EXPECT_NE(t.error().message.find(word), std::string::npos) << t.error().message;
    };
    const auto change = [](TrainFrame& frame, auto&& how) {
        FramePicture picture = **frame.picture.get();
        how(picture);
        frame.picture = std::make_shared<const FramePicture>(std::move(picture));
    };
    refuse([&](auto& in) { change(in.frames[2], [](FramePicture& p) { p.image.pixels.pop_back(); }); }, "toy_2");
    refuse([](auto& in) { in.frames[3].picture = {}; }, "toy_3");
    refuse([](auto& in) { in.frames[1].pose.localRotations[1].x = NAN; }, "toy_1");
    refuse([](auto& in) { in.mesh.restPositions[3].y = INFINITY; }, "vertex 3");
    refuse([](auto& in) { in.mesh.jointIndices[0].x = 9; }, "joint 9");
    refuse([](auto& in) { in.triangleLabel.assign(3, 1); }, "labels");
    refuse(
        [&](auto& in) {
            for (auto& f : in.frames) change(f, [](FramePicture& p) { std::fill(p.mask.pixels.begin(), p.mask.pixels.end(), uint8_t(0)); });
        },
        "none of the 4");
}

TEST(PoseFit, bringsADisplacedFrameBack) {
    Jobs jobs(2);
    CoOptimiseSettings s = toySettings(160);
    auto t = CoOptimiser::create(toyScene(jobs, 8), s, jobs);
    ASSERT_TRUE(t && (*t)->run());
    CoOptimiseResult r = (*t)->result();
    AvatarData avatar;
    avatar.joints = twoJoints(), avatar.mesh = ballMesh(), avatar.mesh.restPositions = r.restPositions, avatar.splats = r.splats;
    TrainFrame f = toyScene(jobs, 8).frames[0];
    f.pose.rootTranslation = {0.015f, -0.01f, 0};
    auto fit = fitPose(avatar, f, {}, jobs);
    ASSERT_TRUE(fit) << fit.error().message;
    EXPECT_LT(fit->lossAfter, 0.7 * fit->lossBefore);
    // There is one camera, and a pixel is 10 mm at this distance. Across the view the error is about a third of a pixel.
    EXPECT_LT(std::hypot(fit->pose.rootTranslation.x, fit->pose.rootTranslation.y), 0.007f);
}

TEST(PoseFit, framesAtOnceEqualFramesOneByOne) {
    Jobs jobs(3), one(1);
    CoOptimiseInput in = toyScene(jobs, 8);
    auto t = CoOptimiser::create(in, toySettings(40), jobs);
    ASSERT_TRUE(t && (*t)->run());
    CoOptimiseResult r = (*t)->result();
    AvatarData avatar;
    avatar.joints = twoJoints(), avatar.mesh = ballMesh(), avatar.mesh.restPositions = r.restPositions, avatar.splats = r.splats;
    std::vector<TrainFrame> frames = in.frames;
    for (TrainFrame& f : frames) f.pose.rootTranslation = {0.01f, -0.005f, 0};
    frames[2].picture = {};  // cannot be used
    const PoseFitSettings settings{.iterations = 12};
    const PoseFitter fitter(avatar, jobs);
    const auto together = fitter.fitAll(frames, settings, jobs), alone = fitter.fitAll(frames, settings, one);
    ASSERT_TRUE(together && alone);
    ASSERT_EQ(together->size(), frames.size());
    for (size_t f = 0; f < frames.size(); ++f) {
        const auto single = fitPose(avatar, frames[f], settings, jobs);
        ASSERT_EQ((*together)[f].has_value(), f != 2) << f;
        ASSERT_EQ((*alone)[f].has_value(), f != 2) << f;
        ASSERT_EQ(bool(single), f != 2) << f;
        if (f == 2) continue;
        EXPECT_EQ((*together)[f]->lossAfter, single->lossAfter) << f;
        EXPECT_TRUE(samePose((*together)[f]->pose, single->pose)) << f;
        EXPECT_TRUE(samePose((*alone)[f]->pose, single->pose)) << f;
        EXPECT_FALSE(samePose(single->pose, frames[f].pose)) << f;
    }
    const auto again = fitter.fitAll(frames, settings, jobs, *together);
    ASSERT_TRUE(again);
    for (size_t f = 0; f < frames.size(); ++f) {
        ASSERT_EQ((*again)[f].has_value(), f != 2) << f;
        if (f == 2) continue;
        EXPECT_LE((*again)[f]->lossAfter, (*together)[f]->lossAfter) << f;
        EXPECT_EQ((*again)[f]->lossBefore, (*together)[f]->lossBefore) << f;
        EXPECT_TRUE(samePose((*again)[f]->pose, fitter.fit(frames[f], settings, jobs, &(*together)[f]->pose)->pose)) << f;
    }
    const Pose noPose;
    EXPECT_EQ(fitter.fit(frames[0], settings, jobs, &noPose).error().code, Code::InvalidArgument);

    Task task;
    task.cancel();
    const TaskScope scope(&task);
    const auto stopped = fitter.fitAll(frames, settings, jobs);
    ASSERT_FALSE(stopped);
    EXPECT_EQ(stopped.error().code, Code::Cancelled);
}

TEST(Polish, keepsMeshAndOrderAndLowersTheLoss) {
    Jobs jobs(2);
    CoOptimiseInput in = toyScene(jobs, 8);
    auto t = CoOptimiser::create(in, toySettings(80), jobs);
    ASSERT_TRUE(t && (*t)->run());
    const CoOptimiseResult trained = (*t)->result();
    AvatarData avatar;
    avatar.joints = in.joints, avatar.mesh = in.mesh, avatar.mesh.restPositions = trained.restPositions, avatar.splats = trained.splats;
    for (float& c : avatar.splats.sh) c *= 0.5f;  // dulls every colour
    const SplatData before = avatar.splats;
    const auto lossOf = [&] { return fitPose(avatar, in.frames[0], {.iterations = 0}, jobs)->lossBefore; };
    const double dull = lossOf();
    auto polished = polish(avatar, {}, in.frames, 120, 5, jobs);
    ASSERT_TRUE(polished) << polished.error().message;
    avatar = std::move(*polished);
    EXPECT_EQ(avatar.splats.uv, before.uv);
    EXPECT_EQ(avatar.splats.phi, before.phi);
    EXPECT_EQ(avatar.splats.triangleStart, before.triangleStart);
    const size_t stride = shCoefficientCount(before.shDegree) * 3;
    size_t moved = 0;
    for (size_t k = 0; k < before.sh.size(); ++k) {
        moved += avatar.splats.sh[k] != before.sh[k];
        if (k % stride >= 3) {
            ASSERT_EQ(avatar.splats.sh[k], before.sh[k]) << "splats share the rows of a palette";
        }
    }
    EXPECT_GT(moved, before.count());
    EXPECT_LT(lossOf(), 0.96 * dull);  // small gain: 120 small steps correct rounding, not whole colours
}

TEST(CoOptimise, picturesLiveWithinABoundAndTheResultIsTheSame) {
    Jobs jobs(2);
    const CoOptimiseInput kept = toyScene(jobs);
    CoOptimiseInput bounded = kept;
    PictureCounts counts;
    bounded.frames = decodedOnDemand(bounded.frames, counts);
    bounded.levelBoundBytes = 0;
    const auto trained = [&](const CoOptimiseInput& input) {
        auto trainer = must(CoOptimiser::create(input, toySettings(60), jobs));
        const Status ran = trainer->run();
        EXPECT_TRUE(ran);
        return trainer->result();
    };
    const CoOptimiseResult a = trained(kept), b = trained(bounded);
    EXPECT_EQ(a.splats.uv, b.splats.uv);
    EXPECT_EQ(a.splats.sh, b.splats.sh);
    EXPECT_EQ(a.restPositions, b.restPositions);
    EXPECT_GT(counts.decoded, 60) << "one a step";
    EXPECT_LE(counts.mostAlive, int(jobs.threadCount())) << "of " << kept.frames.size() << " pictures";
    EXPECT_EQ(counts.alive, 0);
}

}  // namespace
}  // namespace dpl::test
