// SPDX-License-Identifier: Apache-2.0
// structSize: what docs/reference/abi.md promises, for every struct of doppel.h that a CPU context takes or fills.
#include <cstddef>
#include <cstring>
#include <functional>

#include "sdk/include/doppel/doppel_convert.h"
#include "tests/unit/api/api_fixture.h"
#include "tests/unit/avatar/rigs.h"
#include "tests/unit/format/sample_correctives.h"

namespace dpl {
namespace {

/** A struct in a buffer that a newer program would pass: 64 bytes more, full of ones. */
template <class T>
struct Longer {
    T value{};
    unsigned char behind[64];
    Longer() { std::memset(behind, 0xff, sizeof behind); }
    bool untouched() const {
        for (const unsigned char byte : behind)
            if (byte != 0xff) return false;
        return true;
    }
};

class StructSize : public test::ApiTest {
protected:
    void SetUp() override {
        test::ApiTest::SetUp();
        AvatarData person = test::tinyAvatar();
        person.joints = test::personRig(0.8f);
        sortSplats(person);
        const auto bytes = writeAvatar(test::withCorrectives(std::move(person), 1));
        ASSERT_TRUE(bytes) << bytes.error().message;
        ASSERT_EQ(dplLoadAvatar(context_, bytes->data(), bytes->size(), &person_), DPL_OK) << dplGetLastError();
    }
    void TearDown() override {
        EXPECT_EQ(dplDestroyAvatar(person_), DPL_OK);
        test::ApiTest::TearDown();
    }

    /** first: size of the struct in its first version. fill: makes a valid struct of the current size. */
    template <class T>
    void check(const char* name, size_t first, const std::function<void(T&)>& fill, const std::function<DplResult(T*)>& call) {
        SCOPED_TRACE(name);
        const auto with = [&](size_t size) {
            Longer<T> longer;
            fill(longer.value);
            const uint32_t given = uint32_t(size);
            std::memcpy(&longer.value, &given, sizeof given);
            const DplResult result = call(&longer.value);
            uint32_t after;
            std::memcpy(&after, &longer.value, sizeof after);
            EXPECT_EQ(after, given) << "structSize is the caller's";
            EXPECT_TRUE(longer.untouched()) << "bytes behind the struct were written at size " << size;
            return result;
        };
        EXPECT_EQ(with(sizeof(T)), DPL_OK) << dplGetLastError();
        EXPECT_EQ(with(sizeof(T) + 64), DPL_OK) << "of a newer program: " << dplGetLastError();
        EXPECT_EQ(with(first), DPL_OK) << "of the oldest program: " << dplGetLastError();
        for (const size_t wrong : {size_t(0), size_t(4), first - 1, size_t(4097), size_t(0xffffffff)}) {
            EXPECT_EQ(with(wrong), DPL_ERROR_INVALID_ARGUMENT) << wrong;
            EXPECT_TRUE(errorSays("structSize")) << dplGetLastError();
        }
        EXPECT_EQ(call(nullptr), DPL_ERROR_INVALID_ARGUMENT);
    }
    template <class T>
    void check(const char* name, const std::function<void(T&)>& fill, const std::function<DplResult(T*)>& call) {
        check<T>(name, sizeof(T), fill, call);
    }
    template <class T>
    static void nothing(T&) {}

    DplAvatar person_ = nullptr;
};

TEST_F(StructSize, outputs) {
    check<DplAvatarInfo>("DplAvatarInfo", offsetof(DplAvatarInfo, fileSplatCount), nothing<DplAvatarInfo>,
                         [&](DplAvatarInfo* s) { return dplGetAvatarInfo(person_, s); });
    check<DplFileAxes>("DplFileAxes", nothing<DplFileAxes>, [&](DplFileAxes* s) { return dplGetFileAxes(person_, s); });
    check<DplJointInfo>("DplJointInfo", nothing<DplJointInfo>, [&](DplJointInfo* s) { return dplGetJointInfo(person_, 0, s); });
    check<DplExpressionInfo>("DplExpressionInfo", nothing<DplExpressionInfo>,
                             [&](DplExpressionInfo* s) { return dplGetExpressionInfo(person_, 0, s); });
    check<DplClipInfo>("DplClipInfo", nothing<DplClipInfo>, [&](DplClipInfo* s) { return dplGetClipInfo(person_, 0, s); });
    check<DplPoseTrust>("DplPoseTrust", nothing<DplPoseTrust>, [&](DplPoseTrust* s) { return dplGetPoseTrust(person_, s, nullptr, 0); });
    check<DplCaptureDetail>("DplCaptureDetail", nothing<DplCaptureDetail>,
                            [&](DplCaptureDetail* s) { return dplGetCaptureDetail(person_, 0, s); });
    check<DplFrameStats>("DplFrameStats", offsetof(DplFrameStats, avatarBytes), nothing<DplFrameStats>,
                         [&](DplFrameStats* s) { return dplGetFrameStats(person_, s); });
    std::vector<uint8_t> alpha(DPL_CONTACT_SHADOW_PX * DPL_CONTACT_SHADOW_PX);
    check<DplContactShadow>("DplContactShadow", nothing<DplContactShadow>,
                            [&](DplContactShadow* s) { return dplGetContactShadow(person_, nullptr, alpha.data(), alpha.size(), s); });
    check<DplLayerInfo>("DplLayerInfo", nothing<DplLayerInfo>, [&](DplLayerInfo* s) { return dplGetLayerInfo(person_, 0, s); });
    const float origin[3] = {0, 1, 3}, direction[3] = {0, 0, -1};
    check<DplWritten>("DplWritten", nothing<DplWritten>, [&](DplWritten* s) { return dplWriteSplats(person_, nullptr, nullptr, s); });
    check<DplPick>("DplPick", nothing<DplPick>, [&](DplPick* s) { return dplPick(&person_, 1, origin, direction, s); });
    DplTrackerInfo info{};
    info.structSize = sizeof info;
    DplTracker tracker = nullptr;
    ASSERT_EQ(dplCreateTracker(person_, &info, &tracker), DPL_OK) << dplGetLastError();
    check<DplTrackerStatus>("DplTrackerStatus", nothing<DplTrackerStatus>,
                            [&](DplTrackerStatus* s) { return s ? dplSetPoseFromTracker(tracker, 0, s) : DPL_ERROR_INVALID_ARGUMENT; });
    const float numbers[4 * 55] = {0, 0, 0, 1};
    check<DplTrackFrame>(
        "DplTrackFrame", [&](DplTrackFrame& f) { f.jointCount = 55, f.rotations = f.positions = numbers; },
        [&](DplTrackFrame* s) { return dplTrackFrame(tracker, s); });
    EXPECT_EQ(dplDestroyTracker(tracker), DPL_OK);
}

TEST_F(StructSize, inputs) {
    check<DplContextInfo>(
        "DplContextInfo", offsetof(DplContextInfo, flags), [](DplContextInfo& i) { i.renderer = DPL_RENDERER_SOFTWARE, i.threadCount = 1; },
        [&](DplContextInfo* s) {
            if (!s) return DPL_ERROR_INVALID_ARGUMENT;  // NULL means all defaults
            DplContext made = nullptr;
            const DplResult r = dplCreateContext(s, &made);
            if (r == DPL_OK) dplDestroyContext(made);
            return r;
        });
    check<DplTrackerInfo>("DplTrackerInfo", nothing<DplTrackerInfo>, [&](DplTrackerInfo* s) {
        DplTracker made = nullptr;
        const DplResult r = dplCreateTracker(person_, s, &made);
        if (r == DPL_OK) dplDestroyTracker(made);
        return r;
    });
    const DplClipLayer layer{sizeof(DplClipLayer), 0, 0.5, 1, 0, DPL_LAYER_LOOP, 0, {0, 0}};
    check<DplClipLayer>(
        "DplClipLayer", [&](DplClipLayer& l) { l = layer; }, [&](DplClipLayer* s) { return dplSetPoseFromClips(person_, s, 1, 0); });
    check<DplClipLayer>(
        "DplClipLayer of dplJoinClipLayer", [&](DplClipLayer& l) { l = layer; },
        [&](DplClipLayer* s) { return dplJoinClipLayer(person_, &layer, s); });
    check<DplFaceMotion>(
        "DplFaceMotion", [](DplFaceMotion& m) { m.blinks = m.glances = 1; },
        [&](DplFaceMotion* s) { return dplSetFaceMotion(person_, s, 5); });
    check<DplGaze>(
        "DplGaze", [](DplGaze& g) { g.target[2] = 3, g.headWeight = 1; }, [&](DplGaze* s) { return dplLookAtPoint(person_, s); });
    std::vector<float> numbers(1 << 16);
    const DplBufferElement place{sizeof(DplBufferElement), DPL_SPLAT_POSITION, DPL_NUMBER_FLOAT, 0, 0, 0};
    DplWritten written{sizeof(DplWritten)};
    const DplBuffer buffer{sizeof(DplBuffer), 1, &place, numbers.data(), numbers.size() * 4};
    check<DplSplatOptions>("DplSplatOptions", nothing<DplSplatOptions>, [&](DplSplatOptions* s) {
        return s ? dplWriteSplats(person_, s, nullptr, &written) : DPL_ERROR_INVALID_ARGUMENT;  // NULL means zeros
    });
    check<DplBuffer>(
        "DplBuffer", [&](DplBuffer& b) { b = buffer; },
        [&](DplBuffer* s) { return s ? dplWriteSplats(person_, nullptr, s, &written) : DPL_ERROR_INVALID_ARGUMENT; });
    check<DplBufferElement>(
        "DplBufferElement", [&](DplBufferElement& e) { e = place; },
        [&](DplBufferElement* s) {
            DplBuffer one = buffer;
            one.elements = s;
            return dplWriteMesh(person_, &one, &written);
        });
    check<DplDetail>("DplDetail", nothing<DplDetail>,
                     [&](DplDetail* s) { return s ? dplSetDetail(context_, s) : DPL_ERROR_INVALID_ARGUMENT; });
    std::vector<uint8_t> pixels(16 * 16 * 4);
    const DplCamera camera = test::frontCamera(16, 16);
    check<DplCamera>(
        "DplCamera", offsetof(DplCamera, viewFromWorld) + sizeof DplCamera::viewFromWorld, [&](DplCamera& c) { c = camera; },
        [&](DplCamera* s) { return dplDraw(context_, person_, s, 1, 0); });
    check<DplImage>(
        "DplImage", offsetof(DplImage, format), [&](DplImage& i) { i.rgba = pixels.data(), i.rgbaBytes = pixels.size(); },
        [&](DplImage* s) { return dplRender(context_, person_, &camera, 1, s); });
    check<DplCamera>("DplCamera of dplCameraFromAngles", nothing<DplCamera>, [](DplCamera* s) {
        const float turn[] = {0, 0, 0, 1}, place[] = {0, 0, 0}, angles[] = {-0.5f, 0.5f, 0.5f, -0.5f};
        return dplCameraFromAngles(turn, place, angles, 10, 10, s);
    });
    check<DplCamera>("DplCamera of dplCameraLookAt", nothing<DplCamera>, [](DplCamera* s) {
        const float eye[] = {0, 1, 3}, target[] = {0, 1, 0}, up[] = {0, 1, 0};
        return dplCameraLookAt(eye, target, up, 0.8f, 10, 10, s);
    });
}

}  // namespace
}  // namespace dpl
