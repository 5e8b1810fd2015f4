// SPDX-License-Identifier: Apache-2.0
// Every call into the runtime fails in turn, at each of its times. Whatever happens then, the program reaches a clean state: no rule of the
// specification is broken, nothing stays behind, and a new session draws again.
#include <set>

#include "tests/xr/xr_fixture.h"

namespace dpl::test {
namespace {

constexpr XrVector3f kHead{0, 1, 2.9f};

/** Calls of a session's life that do not have a session, and so cannot say that it is lost. */
const std::set<std::string> kOfInstance{"xrCreateAction",
                                        "xrCreateActionSet",
                                        "xrCreateSession",
                                        "xrDestroyAction",
                                        "xrDestroyActionSet",
                                        "xrEnumerateEnvironmentBlendModes",
                                        "xrEnumerateViewConfigurations",
                                        "xrEnumerateViewConfigurationViews",
                                        "xrGetSystem",
                                        "xrGetSystemProperties",
                                        "xrGetVulkanGraphicsDevice2KHR",
                                        "xrGetVulkanGraphicsRequirements2KHR",
                                        "xrPathToString",
                                        "xrPollEvent",
                                        "xrResultToString",
                                        "xrStringToPath",
                                        "xrSuggestInteractionProfileBindings"};

uint64_t waitsInVain = 0;  // of all vkWaitForFences so far: they reached their limit

class XrLoss : public XrTest {
protected:
    static mockxr::Settings small() {
        mockxr::Settings settings = userAt(kHead);
        settings.capture = false;
        settings.widthPx = 32, settings.heightPx = 24;
        return settings;
    }

    /** A session from its first event to its end: three pictures, then the user is asked to leave. True: it ended without an error. */
    bool wholeLife() {
        int drew = 0;
        for (int i = 0; i < 60; ++i) {
            const auto did = session_->frame(*scene_);
            if (!did) {
                EXPECT_FALSE(did.error().message.empty());
                return false;
            }
            if (*did == xr::Step::Ended) return true;
            if (*did == xr::Step::Drew && ++drew == 3) session_->requestExit();
        }
        ADD_FAILURE() << "the session did not end in 60 calls";
        return false;
    }

    /** Names of calls and how often a whole life makes each. */
    std::map<std::string, uint64_t> callsOfALife() {
        const auto before = mockxr::calls();
        EXPECT_TRUE(wholeLife());
        closeSession();
        std::map<std::string, uint64_t> made;
        for (const auto& [name, count] : mockxr::calls())
            if (const auto old = before.find(name); old == before.end() || old->second < count)
                made[name] = count - (old == before.end() ? 0 : old->second);
        return made;
    }

    /** Fails the k-th call of that name in a session's life, then wants a second session to draw. */
    void lifeWithFailure(const std::string& name, uint64_t k, XrResult result) {
        SCOPED_TRACE(name + ", time " + std::to_string(k) + ", result " + std::to_string(result));
        mockxr::fail({name, mockxr::calls()[name] + k, 1, result});
        openSession(opaque());
        wholeLife();
        closeSession();
        EXPECT_EQ(mockxr::liveHandles(), handlesBetweenSessions_);
        openSession(opaque());
        EXPECT_TRUE(run(xr::Step::Drew));
        closeSession();
        EXPECT_EQ(mockxr::violations().size() + mockxr::vulkanMessages().size(), complaints_);
        complaints_ = mockxr::violations().size() + mockxr::vulkanMessages().size();
    }

    /** Once with each result: all calls of a life, each time that it is made, the middle ones of many left out. */
    void sweep(XrResult result) {
        open(small(), opaque());
        if (HasFatalFailure()) return;
        const auto made = callsOfALife();
        EXPECT_GT(made.size(), 25u) << "a life makes many calls";
        handlesBetweenSessions_ = mockxr::liveHandles();
        complaints_ = mockxr::violations().size() + mockxr::vulkanMessages().size();
        for (const auto& [name, count] : made)
            for (uint64_t k = 1; k <= count; ++k) {
                const bool ofSession = result != XR_ERROR_SESSION_LOST || !kOfInstance.count(name);
                if (ofSession && (k <= 2 || k == count)) lifeWithFailure(name, k, result);
            }
    }

    void TearDown() override {
        XrTest::TearDown();
        EXPECT_EQ(waitsInVain, waitsInVainBefore_) << "a frame waited for commands that were not submitted";
    }

    size_t handlesBetweenSessions_ = 0, complaints_ = 0;
    const uint64_t waitsInVainBefore_ = waitsInVain;
};

TEST_F(XrLoss, theSessionIsLostAtEachCall) {
    sweep(XR_ERROR_SESSION_LOST);
}

TEST_F(XrLoss, eachCallFails) {
    sweep(XR_ERROR_RUNTIME_FAILURE);
}

TEST_F(XrLoss, theInstanceIsLost) {
    for (const char* name : {"xrCreateSession", "xrPollEvent", "xrWaitFrame", "xrEndFrame"}) {
        SCOPED_TRACE(name);
        open(small(), opaque());
        if (HasFatalFailure()) return;
        mockxr::fail({name, mockxr::calls()[name] + 1, 1, XR_ERROR_INSTANCE_LOST});
        EXPECT_FALSE(wholeLife());
        close();
        EXPECT_EQ(mockxr::liveHandles(), 0u);
        for (const std::string& sentence : mockxr::violations()) ADD_FAILURE() << sentence;
    }
    open(small(), opaque());
    EXPECT_TRUE(run(xr::Step::Drew));
}

TEST_F(XrLoss, aRuntimeThatCannotBeOpened) {
    mockxr::reset(small());
    ASSERT_TRUE(xr::Runtime::create({}));
    const auto made = mockxr::calls();
    for (const auto& [name, count] : made)
        for (uint64_t k = 1; k <= count; ++k) {
            SCOPED_TRACE(name + ", time " + std::to_string(k));
            mockxr::reset(small());
            mockxr::fail({name, k, 1, XR_ERROR_RUNTIME_FAILURE});
            {
                const auto runtime = xr::Runtime::create({});
                EXPECT_TRUE(runtime || !runtime.error().message.empty());
            }
            EXPECT_EQ(mockxr::liveHandles(), 0u);
            for (const std::string& sentence : mockxr::violations()) ADD_FAILURE() << sentence;
        }
}

TEST_F(XrLoss, aSessionThatIsLostAgainAndAgain) {
    open(small(), opaque());
    if (HasFatalFailure()) return;
    mockxr::fail({"xrWaitFrame", 1, 1000, XR_ERROR_SESSION_LOST});
    int lost = 0;
    for (int i = 0; i < 100; ++i) {
        const auto did = session_->frame(*scene_);
        if (!did) {
            EXPECT_NE(did.error().message.find("loses every session"), std::string::npos) << did.error().message;
            EXPECT_GE(lost, 1);
            return;
        }
        lost += *did == xr::Step::Lost;
    }
    ADD_FAILURE() << "it tries for ever";
}

}  // namespace
}  // namespace dpl::test

/** Stands before the function of the loader, for the library under test is linked into this program. */
extern "C" VKAPI_ATTR VkResult VKAPI_CALL vkWaitForFences(VkDevice device, uint32_t count, const VkFence* fences, VkBool32 all,
                                                          uint64_t limitNs) {
    const auto next = reinterpret_cast<PFN_vkWaitForFences>(vkGetDeviceProcAddr(device, "vkWaitForFences"));
    const VkResult result = next(device, count, fences, all, limitNs);
    dpl::test::waitsInVain += result == VK_TIMEOUT;
    return result;
}
