// SPDX-License-Identifier: Apache-2.0
#include "reconstruction/run/training_shown.h"

#include <chrono>

namespace dpl {

TrainingShown::TrainingShown(RunNews* news, const CoOptimiseInput& input) : news_(news) {
    if (!news_) return;
    avatar_.generator = "doppel reconstruct, unfinished";
    avatar_.joints = input.joints;
    avatar_.mesh = input.mesh;
    avatar_.mesh.colours.assign(input.mesh.restPositions.size(), glm::u8vec4(200, 200, 200, 255));  // the splats have the colours
    avatar_.kappaPx2 = kTrainedKappaPx2;
}

void TrainingShown::heldBack(const FrameTable& table) {
    if (!news_) return;
    std::vector<size_t> rows;
    const auto take = [&](bool closeups) {
        for (size_t row = 0; row < table.rows(); ++row)
            if (table.scan.frames[row].split == Split::Validation && (table.scan.frames[row].kind == FrameKind::StaticCloseup) == closeups)
                rows.push_back(row);
    };
    take(false);
    if (rows.empty()) take(true);
    if (rows.empty()) return;
    const size_t row = rows[rows.size() / 2];
    const auto picture = table.picture(row);
    if (!picture) return;
    const ImageRgb8& image = (*picture)->image;
    news_->heldBack(table.scan.frames[row].name, {image.widthPx, image.heightPx, 3, image.pixels});
}

void TrainingShown::after(const CoOptimiser& optimiser, uint32_t steps) {
    if (!news_) return;
    std::vector<RunNews::FitPoint> points;
    for (const CurvePoint& point : optimiser.curve()) points.push_back({point.step, point.psnr, point.loss});
    news_->curve(points, steps);
    if (!news_->wantsAvatar()) return;
    const auto start = std::chrono::steady_clock::now();
    CoOptimiseResult trained = optimiser.result();
    AvatarData avatar = avatar_;
    avatar.mesh.restPositions = std::move(trained.restPositions);
    avatar.splats = std::move(trained.splats);
    news_->avatar(std::move(avatar), optimiser.step(), std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
}

}  // namespace dpl
