// SPDX-License-Identifier: Apache-2.0
#include "platform/openxr/session.h"

#include <doppel/doppel_convert.h>

#include <algorithm>
#include <limits>

#include "platform/openxr/actions.h"
#include "platform/openxr/capture.h"
#include "platform/openxr/frame_commands.h"
#include "platform/openxr/images.h"
#include "platform/openxr/passthrough.h"
#include "platform/openxr/views.h"
#include "platform/openxr/world.h"

namespace dpl::xr {
namespace {

constexpr int kMaxEventsAFrame = 256;  // a broken runtime might never stop
constexpr int kMaxLossesInARow = 5, kMaxTimeoutsInARow = 8;

}  // namespace

struct SessionHandle {
    XrSession handle = XR_NULL_HANDLE;
    ~SessionHandle() {
        if (handle) xrDestroySession(handle);
    }
};

/** One session and what dies with it, from last to first. */
struct Live {
    explicit Live(const Runtime& runtime) : images(runtime), passthrough(runtime) {}
    SessionHandle session;
    World world;
    Images images;
    Passthrough passthrough;
    Display display;
    bool passesThrough = false;
};

struct Session::Self {
    Self(Runtime& runtime, const SessionOptions& options)
        : runtime_(runtime), options_(options), calls_(runtime), commands_(runtime), actions_(runtime), capture_(runtime) {}

    Result<Step> step(Scene& scene);
    Result<bool> open(Scene& scene);
    Status startPassthrough(Live& live);
    Status pollEvents();
    Status stateChanged(XrSessionState state);
    Result<Step> runFrame(Scene& scene);
    Result<bool> draw(Scene& scene, const XrFrameState& state);
    Status describe(const XrFrameState& state);
    Status endFrame(const XrFrameState& state, bool withPicture);
    void fillLayer();
    Status close();
    void complain(const char* text) {
        if (complaint_ != text) complaint_ = text;
    }

    Runtime& runtime_;
    SessionOptions options_;
    Calls calls_;
    FrameCommands commands_;
    bool ready_ = false, hasActions_ = false;  // commands and actions were made; the runtime takes the actions
    Actions actions_;
    Capture capture_;
    std::unique_ptr<Live> live_;
    Scene* scene_ = nullptr;  // has heard begin() and not yet end()

    XrSessionState state_ = XR_SESSION_STATE_UNKNOWN;
    bool running_ = false, exiting_ = false, wantsExit_ = false, askedForExit_ = false, ended_ = false, wantsCapture_ = false;
    std::optional<Error> failed_;
    int lossesInARow_ = 0, timeoutsInARow_ = 0;
    std::string complaint_;
    float refreshHz_ = 0;

    Frame frame_;
    uint64_t drawnFrames_ = 0;
    std::optional<XrTime> firstTime_;
    XrView views_[kMaxViews]{};
    DplCamera cameras_[kMaxViews]{};
    uint32_t cameraCount_ = 0;
    XrCompositionLayerProjectionView layerViews_[kMaxViews]{};
    XrCompositionLayerDepthInfoKHR layerDepths_[kMaxViews]{};
    std::vector<CapturedView> captured_;
    Controllers controllers_;
    std::optional<XrPosef> moved_;
};

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

Result<Step> Session::Self::runFrame(Scene& scene) {
    XrFrameWaitInfo wait{XR_TYPE_FRAME_WAIT_INFO};
    XrFrameState state{XR_TYPE_FRAME_STATE};
    DPL_XR(xrWaitFrame, live_->session.handle, &wait, &state);
    XrFrameBeginInfo begin{XR_TYPE_FRAME_BEGIN_INFO};
    DPL_XR(xrBeginFrame, live_->session.handle, &begin);
    const Result<bool> drawn = state.shouldRender ? draw(scene, state) : Result<bool>(false);
    if (calls_.sessionLost) return Step::Lost;
    // A frame that was begun is ended, also when drawing failed.
    const Status ended = endFrame(state, drawn && *drawn);
    if (!drawn) return drawn.error();
    if (!ended) return ended.error();
    return *drawn ? Step::Drew : Step::Hidden;
}

/** False: nothing can be shown this time. */
Result<bool> Session::Self::draw(Scene& scene, const XrFrameState& state) {
    const Display& display = live_->display;
    if (Status synced = actions_.sync(calls_, live_->world.space(), state.predictedDisplayTime, controllers_); !synced)
        complain("the runtime does not tell where the controllers are");
    moved_ = live_->world.takeMove(state.predictedDisplayTime);
    const auto hindrance = locateViews(calls_, live_->session.handle, display, live_->world.space(), state.predictedDisplayTime, views_);
    if (!hindrance) return hindrance.error();
    if (*hindrance) {
        complain(*hindrance);
        return false;
    }
    const auto acquired = live_->images.acquire(calls_);
    if (!acquired) return acquired.error();
    if (!*acquired) {
        complain("the runtime did not give an image back within 1 s");
        if (++timeoutsInARow_ >= kMaxTimeoutsInARow)
            return Error{DPL_ERROR_DEVICE, "the runtime has given no image back for several seconds; start it again"};
        return false;
    }
    timeoutsInARow_ = 0;
    DPL_XR_OK(describe(state));
    if (wantsCapture_ && options_.capture) DPL_XR_OK(capture_.begin(live_->images.shown()));
    DPL_XR_OK(commands_.begin(frame_));
    DPL_XR_OK(scene.draw(frame_));
    const bool capturing = wantsCapture_ && options_.capture;
    if (capturing) capture_.record(frame_.commands, live_->images);
    live_->images.giveDepthBack(frame_.commands);
    DPL_XR_OK(commands_.submit());
    ++drawnFrames_;
    if (capturing) {
        DPL_XR_OK(commands_.waitForAll());
        DPL_XR_OK(capture_.read(live_->images.shown(), options_.nearM, captured_));
        for (size_t i = 0; i < captured_.size(); ++i)
            captured_[i].camera = cameras_[i], captured_[i].pose = views_[i].pose, captured_[i].fov = views_[i].fov;
        wantsCapture_ = false;
    }
    fillLayer();
    return true;
}

/** Times, cameras and images of the frame. */
Status Session::Self::describe(const XrFrameState& state) {
    const Display& display = live_->display;
    if (!firstTime_) firstTime_ = state.predictedDisplayTime;
    frame_.timeS = std::max(frame_.timeS, dplSecondsBetween(*firstTime_, state.predictedDisplayTime));
    frame_.periodS = state.predictedDisplayPeriod > 0 ? double(state.predictedDisplayPeriod) * 1e-9 : 0;
    frame_.number = drawnFrames_;
    frame_.groupCount = display.groupCount;
    cameraCount_ = 0;
    for (uint32_t g = 0; g < display.groupCount; ++g) {
        GroupFrame& group = frame_.groups[g];
        DPL_XR_OK(camerasOf(views_ + cameraCount_, live_->images.shown().groups[g], group));
        live_->images.describe(g, options_.nearM, group);
        for (uint32_t v = 0; v < group.views; ++v) cameras_[cameraCount_++] = group.cameras[v];
    }
    return {};
}

void Session::Self::fillLayer() {
    const bool depth = live_->images.hasDepthLayer();
    uint32_t i = 0;
    for (uint32_t g = 0; g < live_->display.groupCount; ++g)
        for (uint32_t v = 0; v < live_->display.viewsOf(g); ++v, ++i) {
            XrCompositionLayerProjectionView& view = layerViews_[i];
            view = {XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW};
            view.pose = views_[i].pose, view.fov = views_[i].fov;
            view.subImage = live_->images.colourLayer(g, v);
            if (!depth) continue;
            XrCompositionLayerDepthInfoKHR& info = layerDepths_[i];
            info = {XR_TYPE_COMPOSITION_LAYER_DEPTH_INFO_KHR};
            info.subImage = live_->images.depthLayer(g, v);
            info.minDepth = 0, info.maxDepth = 1;
            info.nearZ = std::numeric_limits<float>::infinity(), info.farZ = options_.nearM;  // reversed: where 0 and 1 are stored
            view.next = &info;
        }
}

Status Session::Self::endFrame(const XrFrameState& state, bool withPicture) {
    if (withPicture) DPL_XR_OK(live_->images.release(calls_));
    XrCompositionLayerProjection projection{XR_TYPE_COMPOSITION_LAYER_PROJECTION};
    projection.layerFlags = live_->images.shown().blend == Blend::Alpha ? XR_COMPOSITION_LAYER_BLEND_TEXTURE_SOURCE_ALPHA_BIT : 0;
    projection.space = live_->world.space();
    projection.viewCount = live_->display.viewCount;
    projection.views = layerViews_;
    const XrCompositionLayerBaseHeader* layers[2];
    uint32_t layerCount = 0;
    if (live_->passesThrough) layers[layerCount++] = reinterpret_cast<const XrCompositionLayerBaseHeader*>(&live_->passthrough.layer());
    if (withPicture) layers[layerCount++] = reinterpret_cast<const XrCompositionLayerBaseHeader*>(&projection);
    XrFrameEndInfo info{XR_TYPE_FRAME_END_INFO};
    info.displayTime = state.predictedDisplayTime;
    info.environmentBlendMode = live_->display.blendMode;
    info.layerCount = layerCount;
    info.layers = layers;
    DPL_XR(xrEndFrame, live_->session.handle, &info);
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
