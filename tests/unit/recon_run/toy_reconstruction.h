// SPDX-License-Identifier: Apache-2.0
// A finished training of a random ball with two joints, as the stages after it receive it, with a scan on disk that shows it.
#pragma once

#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <tuple>

#include "reconstruction/base/image_codec.h"
#include "reconstruction/judging/report/draw_view.h"
#include "reconstruction/run/run_request.h"
#include "reconstruction/run/stage_body_fit.h"
#include "reconstruction/run/stage_co_optimise.h"
#include "reconstruction/run/stage_garments.h"
#include "reconstruction/run/stage_ingest.h"
#include "reconstruction/run/stage_package.h"
#include "reconstruction/run/stage_register.h"
#include "sdk/core/files.h"
#include "sdk/format/avatar_file.h"
#include "tests/reference/random_avatar.h"
#include "tests/unit/must.h"

namespace dpl::test {

/** Correctives with one mode, the bend of joint 1 about X, and two nodes: the bottom and the top of the ball. */
inline PoseCorrectiveData ballCorrectives(const MeshData& mesh, const Vec4f& bottom, const Vec4f& top) {
    PoseCorrectiveData c;
    c.modeCount = 1, c.nodeCount = 2, c.joints = {1}, c.reach = 2;
    c.mean.assign(6, 0.0f);
    c.modes = {0, 0, 0, 0, 0, 2};  // 2·sin(bend)
    for (const Vec3f& p : mesh.restPositions) {
        const int up = int(255 * glm::clamp(p.y - 0.5f, 0.0f, 1.0f));
        c.nodeIndices.push_back({0, 1, 0, 0});
        c.nodeWeights.push_back({uint8_t(255 - up), uint8_t(up), 0, 0});
    }
    c.nodes = {bottom, top};
    return c;
}

inline std::vector<uint8_t> bytesOf(const AvatarData& avatar) {
    return must(writeAvatar(avatar, {.shPalette = true}));
}

/** Frames 0 to 2 still, 3 and 4 moving, all for training; held out: 5 and 6 still, 7 moving. The avatar is trained, so its poses of the
 *  training frames are the true ones. */
class ToyReconstruction {
public:
    static constexpr size_t kFrames = 8, kTrained = 5;
    static constexpr uint32_t kSizePx = 96;

    ToyReconstruction() {
        std::filesystem::create_directories(folder / "scan");
        AvatarData ball = randomAvatar(3, 16, 8, 1);
        // Opaque, with a sharp outline: scores compare alpha with a mask of 0 and 255.
        ball.splats.opacity.assign(ball.splats.count(), 0.97f);
        ball.splats.scaleM.assign(ball.splats.count(), Vec2f(0.012f));
        avatar = must(readAvatar(bytesOf(ball)));
        Scan& scan = table.scan;
        scan.root = folder / "scan", scan.name = "toy";
        for (size_t f = 0; f < kFrames; ++f) {
            const bool moving = f == 3 || f == 4 || f == 7;
            ScanFrame frame;
            frame.name = "frame_" + std::to_string(f);
            frame.kind = moving ? FrameKind::Dynamic : FrameKind::StaticFull;
            frame.split = f < kTrained ? Split::Train : Split::Test;
            frame.imagePath = scan.root / (frame.name + ".png"), frame.maskPath = scan.root / (frame.name + ".mask.png");
            const float turn = 0.7f * float(f);
            frame.camera = lookAt({1.6f * std::sin(turn), 1.1f, 1.6f * std::cos(turn)}, {0, 1, 0}, kSizePx, kSizePx, 110).cast<double>();
            Pose pose = Pose::rest(2);
            if (moving) pose.localRotations[1] = glm::angleAxis(f == 3 ? 0.5f : f == 4 ? -0.4f : 0.3f, Vec3f(1, 0, 0));
            truth.push_back(pose);
            metric.cameras.push_back(frame.camera);
            scan.frames.push_back(frame);
        }
        table.usable.assign(kFrames, true);
        table.hashes.assign(kFrames, FrameHashes{"none", "none", "none", "none"});
        body.shaped.name = "ball", body.shaped.joints = avatar.joints, body.shaped.mesh = avatar.mesh;
        body.fit.poses = body.poses.poses = registered.poses.poses = truth;
        registered.precisions.resize(kFrames);
        training.result.poses.assign(truth.begin(), truth.begin() + kTrained);
        package.bytes = bytesOf(avatar);
    }
    ToyReconstruction(const ToyReconstruction&) = delete;
    ~ToyReconstruction() { std::filesystem::remove_all(folder); }

    /** Writes the pictures of the frames from `first` on: `shown` in the true poses, over grey. */
    void takePictures(const AvatarData& shown, size_t first = 0) {
        AvatarView view = must(AvatarView::open(bytesOf(shown), 2));
        for (size_t f = first; f < kFrames; ++f) {
            const ScanFrame& frame = table.scan.frames[f];
            const std::vector<uint8_t> rgba = must(view.draw(truth[f], frame.camera));
            std::vector<uint8_t> rgb, mask;
            for (size_t i = 0; i < rgba.size(); i += 4) {
                for (size_t c = 0; c < 3; ++c) rgb.push_back(uint8_t((rgba[i + c] * rgba[i + 3] + 90 * (255 - rgba[i + 3]) + 127) / 255));
                mask.push_back(rgba[i + 3] >= 128 ? 255 : 0);
            }
            for (const auto& [path, pixels, channels] : {std::tuple(frame.imagePath, rgb, 3u), std::tuple(frame.maskPath, mask, 1u)})
                if (const Status written = writeFileAtomically(path, must(encodePng(pixels, kSizePx, kSizePx, channels))); !written)
                    throw std::runtime_error(written.error().message);
        }
    }

    const std::filesystem::path folder = newFolder();
    AvatarData avatar;        // decoded
    std::vector<Pose> truth;  // of all frames
    FrameTable table;
    MetricCameras metric;
    ChosenBody chosen;
    FittedBody body;
    GarmentLayers layers;
    RegisteredPoses registered;
    Training training;
    Package package;
    RunSettings settings = settingsOf({});
    std::string trainingKey = "trained";
    Progress progress{Progress::Style::Quiet};
    Jobs jobs{2};
    StageChain chain{folder / "out", progress};

    /** Gives a run everything that the toy holds, as it is now. */
    void give(Run& run) const {
        FrameTable fresh = table;
        fresh.pictures = std::make_shared<PictureCache>();
        run.put(fresh, "table");
        run.put(metric, "cameras");
        run.put(body, "body");
        run.put(layers, "layers");
        run.put(registered, "register");
        run.put(package, "package");
        run.put(settings, "settings");
    }
    /** The same, with a finished training. */
    void giveTrained(Run& run) const {
        give(run);
        run.put(training, trainingKey);
        run.put(SettingsAfterTraining{settings}, "settings");
    }

private:
    static std::filesystem::path newFolder() {
        static int made = 0;
        return std::filesystem::temp_directory_path() / ("doppel_toy_" + std::to_string(::getpid()) + "_" + std::to_string(made++));
    }
};

}  // namespace dpl::test
