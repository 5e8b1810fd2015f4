// SPDX-License-Identifier: Apache-2.0
#include "platform/openxr/session_self.h"

namespace dpl::xr {
namespace {

constexpr int kMaxEventsAFrame = 256;  // a broken runtime might never stop
constexpr int kMaxLossesInARow = 5;

}  // namespace

Session::Session(Runtime& runtime, const SessionOptions& options) : self_(std::make_unique<Self>(runtime, options)) {}

Session::~Session() {
    static_cast<void>(self_->close());
}

Result<Step> Session::frame(Scene& scene) {
    Self& self = *self_;
    if (self.failed_) return *self.failed_;
    if (self.ended_) return Step::Ended;
    Result<Step> step = self.step(scene);
    if (self.calls_.sessionLost) {
        self.calls_.sessionLost = false;
        step = Step::Lost;
        if (Status closed = self.close(); !closed)
            step = closed.error();
        else if (++self.lossesInARow_ >= kMaxLossesInARow)
            step = Error{DPL_ERROR_DEVICE, "the runtime loses every session before it shows a picture; start the runtime again"};
    }
    if (!step) {
        self.failed_ = step.error();
        static_cast<void>(self.close());  // the first error is the one to tell
    } else if (*step == Step::Drew) {
        self.lossesInARow_ = 0;
    }
    return step;
}

/** One call of frame(). Who sees calls_.sessionLost afterwards need not read the result. */
Result<Step> Session::Self::step(Scene& scene) {
    if (!live_ && !wantsExit_) {
        const auto opened = open(scene);
        if (!opened) return opened.error();
        if (!*opened) return Step::Idle;
    }
    if (live_) DPL_XR_OK(pollEvents());
    if (calls_.sessionLost) return Step::Lost;
    if (exiting_ || (wantsExit_ && !running_)) {
        DPL_XR_OK(close());
        ended_ = true;
        return Step::Ended;
    }
    if (!running_) return Step::Idle;
    if (wantsExit_ && !askedForExit_) {
        DPL_XR(xrRequestExitSession, live_->session.handle);
        askedForExit_ = true;
    }
    return runFrame(scene);
}

/** Makes a session. False: there is no headset at present. */
Result<bool> Session::Self::open(Scene& scene) {
    const auto system = runtime_.findSystem();
    if (!system && system.error().code == DPL_ERROR_NOT_FOUND) return false;
    if (!system) return system.error();
    if (!ready_) {
        DPL_XR_OK(commands_.make());
        const Status made = actions_.create(calls_);
        if (!made) complaint_ = "no controllers: " + made.error().message;
        hasActions_ = bool(made);
        ready_ = true;
    }
    auto display = chooseDisplay(runtime_, calls_, *system, options_);
    if (!display) return display.error();
    auto live = std::make_unique<Live>(runtime_);
    live->display = *display;
    XrGraphicsBindingVulkan2KHR binding{XR_TYPE_GRAPHICS_BINDING_VULKAN2_KHR};
    binding.instance = runtime_.vulkan(), binding.physicalDevice = runtime_.physicalDevice(), binding.device = runtime_.device();
    binding.queueFamilyIndex = runtime_.queueFamily(), binding.queueIndex = 0;
    XrSessionCreateInfo info{XR_TYPE_SESSION_CREATE_INFO};
    info.next = &binding;
    info.systemId = *system;
    DPL_XR(xrCreateSession, runtime_.instance(), &info, &live->session.handle);
    DPL_XR_OK(live->world.create(runtime_, calls_, live->session.handle));
    DPL_XR_OK(live->images.make(calls_, live->session.handle, live->display, options_));
    DPL_XR_OK(startPassthrough(*live));
    if (live->display.tracksHands) {
        if (Status started = live->hands.start(calls_, live->session.handle); !started) complaint_ = "no hands: " + started.error().message;
    }
    if (live->display.tracksBodies) {
        if (Status started = live->body.start(calls_, live->session.handle); !started) complaint_ = "no body: " + started.error().message;
    }
    if (hasActions_) {
        if (Status attached = actions_.attach(calls_, live->session.handle); !attached) {
            complaint_ = "no controllers: " + attached.error().message;
            actions_.detach();
        }
    }
    refreshHz_ = chooseRefreshRate(runtime_, calls_, live->session.handle, options_.refreshHz);
    if (calls_.sessionLost) {
        actions_.detach();
        return false;
    }
    live_ = std::move(live);
    scene_ = &scene;
    DPL_XR_OK(scene.begin(live_->images.shown()));
    return true;
}

/** Decides how the picture meets the surroundings. */
Status Session::Self::startPassthrough(Live& live) {
    Blend& blend = live.images.shown().blend;
    blend = live.display.blendMode == XR_ENVIRONMENT_BLEND_MODE_ADDITIVE      ? Blend::Additive
            : live.display.blendMode == XR_ENVIRONMENT_BLEND_MODE_ALPHA_BLEND ? Blend::Alpha
                                                                              : Blend::Opaque;
    if (options_.blend == Blend::Opaque || blend != Blend::Opaque) return {};
    if (!live.display.canPassThrough) {
        complain("the headset cannot show the surroundings, so the picture is opaque");
        return {};
    }
    DPL_XR_OK(live.passthrough.start(calls_, live.session.handle));
    live.passesThrough = true;
    blend = Blend::Alpha;
    return {};
}

Status Session::Self::pollEvents() {
    for (int n = 0; n < kMaxEventsAFrame && !calls_.sessionLost; ++n) {
        XrEventDataBuffer event{XR_TYPE_EVENT_DATA_BUFFER};
        const XrResult result = xrPollEvent(runtime_.instance(), &event);
        if (result == XR_EVENT_UNAVAILABLE) return {};
        DPL_XR_OK(calls_.check(result, "xrPollEvent"));
        switch (event.type) {
            case XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING:
                return Error{DPL_ERROR_DEVICE, "the OpenXR runtime is about to go away; start it and this program again"};
            case XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED: {
                const auto& changed = reinterpret_cast<const XrEventDataSessionStateChanged&>(event);
                if (changed.session == live_->session.handle) DPL_XR_OK(stateChanged(changed.state));
                break;
            }
            case XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING: {
                const auto& changed = reinterpret_cast<const XrEventDataReferenceSpaceChangePending&>(event);
                if (changed.session == live_->session.handle) live_->world.changePending(changed);
                break;
            }
            case XR_TYPE_EVENT_DATA_DISPLAY_REFRESH_RATE_CHANGED_FB:
                refreshHz_ = reinterpret_cast<const XrEventDataDisplayRefreshRateChangedFB&>(event).toDisplayRefreshRate;
                break;
            default:
                break;
        }
    }
    return {};
}

/** States may come in any order from a broken runtime: a session is begun only if it is not running, and ended only if it is. */
Status Session::Self::stateChanged(XrSessionState state) {
    state_ = state;
    switch (state) {
        case XR_SESSION_STATE_READY: {
            if (running_) break;
            XrSessionBeginInfo info{XR_TYPE_SESSION_BEGIN_INFO};
            info.primaryViewConfigurationType = live_->display.views;
            DPL_XR(xrBeginSession, live_->session.handle, &info);
            running_ = true;
            break;
        }
        case XR_SESSION_STATE_STOPPING:
            if (!running_) break;
            running_ = false;
            DPL_XR(xrEndSession, live_->session.handle);
            break;
        case XR_SESSION_STATE_LOSS_PENDING:
            calls_.sessionLost = true;
            break;
        case XR_SESSION_STATE_EXITING:
            exiting_ = true;
            break;
        default:
            break;
    }
    return {};
}

Status Session::Self::close() {
    const Status finished = commands_.waitForAll();
    if (scene_) scene_->end();
    scene_ = nullptr;
    actions_.detach();
    live_.reset();
    state_ = XR_SESSION_STATE_UNKNOWN;
    running_ = askedForExit_ = false;
    moved_.reset();
    return finished;
}

void Session::requestExit() {
    self_->wantsExit_ = true;
}
void Session::captureNextFrame() {
    self_->wantsCapture_ = true;
}
std::span<const CapturedView> Session::captured() const {
    return self_->captured_;
}
std::span<const DplCamera> Session::cameras() const {
    return {self_->cameras_, self_->cameraCount_};
}
const Frame& Session::lastFrame() const {
    return self_->frame_;
}
const std::string& Session::lastComplaint() const {
    return self_->complaint_;
}
XrSessionState Session::state() const {
    return self_->state_;
}
const Controllers& Session::controllers() const {
    return self_->controllers_;
}
const std::optional<XrPosef>& Session::originMoved() const {
    return self_->moved_;
}
float Session::refreshHz() const {
    return self_->refreshHz_;
}

}  // namespace dpl::xr
