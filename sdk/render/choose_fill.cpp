// SPDX-License-Identifier: Apache-2.0
#include "sdk/render/choose_fill.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace dpl {
namespace {

constexpr int kTimedFrames = 2;
/** Size of the timed picture over that of the compared one. In a small picture the passes of tiles that do not depend on pixels decide. */
constexpr float kTimedScale = 4;
/** 8-bit blending keeps 46 dB on harder pictures. One wrong tile of 8 x 8 px in a picture of this size gives less than 35 dB. */
constexpr double kMinPsnrDb = 42;
constexpr int kMaxErrorLevels = 24;  // of one channel; a splat at the 1/255 cut-off may flip, and layers of equal depth may swap

const char* nameOf(Fill fill) {
    return fill == Fill::Tiles ? "tiles" : "quads";
}

struct Trial {
    double milliseconds = 0;
    std::string fault;  // empty: the pixels are right
};

std::string faultOf(std::span<const uint8_t> got, std::span<const uint8_t> want) {
    if (got.size() != want.size()) return formatText("{} bytes of pixels instead of {}", got.size(), want.size());
    double squares = 0;
    int worst = 0;
    for (size_t i = 0; i < got.size(); ++i) {
        const int error = std::abs(int(got[i]) - int(want[i]));
        squares += double(error) * error;
        worst = std::max(worst, error);
    }
    const double psnrDb = 10 * std::log10(255.0 * 255.0 * double(got.size()) / std::max(squares, 1e-9));
    if (psnrDb >= kMinPsnrDb && worst <= kMaxErrorLevels) return {};
    return formatText("wrong pixels ({} dB, up to {} levels)", std::round(psnrDb * 10) / 10, worst);
}

/** Time of the last frame by the device's clock. 0 on a device without timestamps. */
double deviceMilliseconds(Renderer& renderer, RenderAvatarId id) {
    const auto stats = renderer.stats(id);
    double sum = 0;
    if (stats)
        for (const PassTime& pass : stats->passes)
            if (pass.label != "readback") sum += pass.milliseconds;
    return sum;
}

/** An error says nothing about the fill: there was not enough memory, or the device was lost. */
Result<Trial> trialOf(Renderer& renderer, RenderAvatarId id, const FillScene& scene, std::span<const uint8_t> want) {
    Trial trial;
    const Cameraf timed = scene.camera.scaled(kTimedScale);
    for (int frame = -1; frame <= kTimedFrames; ++frame) {  // one to compare, one to warm up
        const auto start = std::chrono::steady_clock::now();
        const Status drawn = renderer.draw(id, {}, {frame < 0 ? &scene.camera : &timed, 1}, false);
        const auto pixels = drawn ? renderer.read(id) : Result<std::span<const PixelView>>(drawn.error());
        if (!pixels && (pixels.error().code == Code::OutOfMemory || renderer.lost())) return pixels.error();
        if (!pixels) return Trial{0, pixels.error().message};
        const double wall = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count(),
                     device = deviceMilliseconds(renderer, id);
        if (frame < 0 && !(trial.fault = faultOf((*pixels)[0].rgba, want)).empty()) return trial;
        const double took = device > 0 ? device : wall;
        if (frame > 0) trial.milliseconds = frame == 1 ? took : std::min(trial.milliseconds, took);
    }
    return trial;
}

/** Pseudo-random numbers in [0, 1), the same on every machine. */
struct Random {
    uint32_t state = 1;
    float operator()() { return float((state = state * 1664525u + 1013904223u) >> 8) / 16777216.0f; }
};

}  // namespace

FillScene fillTestScene() {
    FillScene scene;
    Random random;
    constexpr uint32_t kCount = 3000;
    StaticSplatData& s = scene.splats;
    s.shDegree = 0;
    for (uint32_t i = 0; i < kCount; ++i) {
        const float angle = 6.2831853f * random(), height = 2 * random() - 1, large = i % 50 == 0 ? 6.0f : 1.0f;
        s.position.push_back({0.3f * std::sin(angle), 0.8f * height, 0.3f * std::cos(angle)});
        const Quatf turn(0.2f + random(), random() - 0.5f, random() - 0.5f, random() - 0.5f);
        s.rotation.push_back(glm::normalize(turn));
        s.scaleM.push_back(large * Vec3f(0.004f + 0.02f * random(), 0.004f + 0.01f * random(), 0.002f));
        s.opacity.push_back(0.3f + 0.6f * random());
        for (int c = 0; c < 3; ++c)
            s.sh.push_back(0.8f * (height * float(c - 1) + 0.5f * (random() - 0.5f)));  // neighbours are alike, as on a person
    }
    Cameraf& c = scene.camera;
    c.widthPx = 157, c.heightPx = 219;  // no multiple of a tile
    c.fx = c.fy = 260, c.cx = 78.5f, c.cy = 109.5f;
    c.viewFromWorldRotation = Mat3f(1, 0, 0, 0, -1, 0, 0, 0, -1);
    c.viewFromWorldTranslation = Vec3f(0, 0, 2.2f);
    return scene;
}

Result<Fill> chooseFill(Renderer& renderer, const FillScene& scene, std::span<const uint8_t> wantRgba, std::string& reason) {
    DPL_TRY(const RenderAvatarId id, renderer.addSplats(scene.splats));
    Trial trials[2];
    Status status;
    for (const Fill fill : {Fill::Quads, Fill::Tiles}) {
        renderer.setFill(fill);
        const auto trial = status ? trialOf(renderer, id, scene, wantRgba) : Result<Trial>(status.error());
        if (trial)
            trials[size_t(fill)] = *trial;
        else
            status = trial.error();
    }
    renderer.removeAvatar(id);
    DPL_RETURN_IF_ERROR(status);
    const auto text = [&](Fill fill) {
        const Trial& t = trials[size_t(fill)];
        return formatText("{}: {}", nameOf(fill), t.fault.empty() ? formatText("{} ms", std::round(t.milliseconds * 100) / 100) : t.fault);
    };
    reason = text(Fill::Quads) + "; " + text(Fill::Tiles);
    const bool quads = trials[0].fault.empty(), tiles = trials[1].fault.empty();
    if (!quads && !tiles) return fail(Code::Device, "the self-test failed on {}: {}", renderer.name(), reason);
    const Fill choice = tiles && (!quads || trials[1].milliseconds < trials[0].milliseconds) ? Fill::Tiles : Fill::Quads;
    renderer.setFill(choice);
    return choice;
}

}  // namespace dpl
