// SPDX-License-Identifier: Apache-2.0
#include "apps/reference/reference_file.h"

#include <algorithm>

#include "apps/reference/flip.h"
#include "apps/reference/reference_renderer.h"
#include "sdk/avatar/cloth_bounds.h"
#include "sdk/format/avatar_file.h"
#include "sdk/format/splat_file.h"

namespace dpl {
namespace {

double decibels(double squares, uint64_t values) {
    return squares > 0 ? -10 * std::log10(squares / double(values)) : std::numeric_limits<double>::infinity();
}

template <class T>
PictureError compare(const ReferencePicture& reference, std::span<const T> rgba) {
    constexpr double kPeak = std::numeric_limits<T>::max();
    PictureError e;
    if (rgba.size() != reference.alpha.size() * 4) return {1, 1, 1, 1, 255};  // sizes differ: report the largest error
    for (size_t p = 0; p < reference.alpha.size(); ++p) {
        const bool covered = reference.alpha[p] > 0 || rgba[p * 4 + 3] > 0;
        for (size_t c = 0; c < 3; ++c) {
            const double actual = rgba[p * 4 + c] / kPeak + 0.5 * (1 - rgba[p * 4 + 3] / kPeak),
                         want = reference.rgb[p * 3 + c] + 0.5 * (1 - reference.alpha[p]);
            const double square = (actual - want) * (actual - want);
            e.squares += square;
            e.coveredSquares += covered ? square : 0;
            e.maxLevels = std::max(e.maxLevels, std::abs(actual - want) * 255);
        }
        e.values += 3;
        e.coveredValues += covered ? 3 : 0;
    }
    return e;
}

Pose poseOf(std::span<const float> rotations) {
    Pose pose;
    for (size_t j = 0; j + 4 <= rotations.size(); j += 4)
        pose.localRotations.emplace_back(rotations[j + 3], rotations[j], rotations[j + 1], rotations[j + 2]);
    return pose;
}

}  // namespace

Result<ReferenceFile> ReferenceFile::read(std::span<const uint8_t> bytes) {
    ReferenceFile file;
    if (splatFormatOf(bytes) != SplatFormat::None) {
        DPL_TRY(SplatFile general, readSplats(bytes));
        file.splats_ = std::make_shared<const StaticSplatData>(std::move(general.splats));
    } else {
        DPL_TRY(AvatarData avatar, readAvatar(bytes));
        boundGarments(avatar.joints, avatar.mesh);  // the file as renderers load it
        file.avatar_ = std::make_shared<const AvatarData>(std::move(avatar));
    }
    return file;
}

ReferencePicture ReferenceFile::draw(std::span<const float> rotations, const Vec3f& rootTranslation, const Cameraf& camera,
                                     std::span<const EarlierRotations> earlier) const {
    Pose pose = poseOf(rotations);
    pose.rootTranslation = rootTranslation;
    if (avatar_ && !earlier.empty()) {
        std::vector<ReferenceEarlierPose> poses;
        for (const EarlierRotations& e : earlier) poses.push_back({poseOf(e.rotations), e.secondsToNext});
        pose.before = referenceMemory(avatar_->correctives.motion, poses);
    }
    ReferenceImage image =
        avatar_ ? renderReference(*avatar_, pose, referenceCamera(camera)) : renderReference(*splats_, referenceCamera(camera));
    return {image.widthPx, image.heightPx, std::move(image.rgb), std::move(image.alpha)};
}

bool ReferenceFile::hasPoseCorrectives() const {
    return avatar_ && avatar_->correctives.followsPose();
}

bool ReferenceFile::hasLight() const {
    return avatar_ && !avatar_->light.empty();
}

uint32_t ReferenceFile::samples(const Vec3f& rootTranslation, const Cameraf& camera) const {
    Pose pose;
    pose.rootTranslation = rootTranslation;
    return avatar_ && referenceFourSamples(*avatar_, pose, referenceCamera(camera)) ? 4 : 1;
}

double PictureError::psnrDb() const {
    return decibels(squares, values);
}
double PictureError::coveredPsnrDb() const {
    return decibels(coveredSquares, coveredValues);
}

PictureError& PictureError::operator+=(const PictureError& other) {
    squares += other.squares, coveredSquares += other.coveredSquares;
    values += other.values, coveredValues += other.coveredValues;
    maxLevels = std::max(maxLevels, other.maxLevels);
    return *this;
}

PictureError compareWith(const ReferencePicture& reference, std::span<const uint8_t> rgba) {
    return compare(reference, rgba);
}
PictureError compareWith(const ReferencePicture& reference, std::span<const uint16_t> rgba) {
    return compare(reference, rgba);
}

double coveredFlip(const ReferencePicture& reference, std::span<const uint8_t> rgba) {
    if (rgba.size() != reference.alpha.size() * 4) return 1;
    constexpr uint32_t kMarginPx = 16;  // larger than the radius of FLIP's filters
    const uint32_t width = reference.widthPx, height = reference.heightPx;
    const auto covered = [&](size_t p) { return reference.alpha[p] > 0 || rgba[p * 4 + 3] > 0; };
    uint32_t x0 = width, x1 = 0, y0 = height, y1 = 0;
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x)
            if (covered(size_t(y) * width + x))
                x0 = std::min(x0, x), x1 = std::max(x1, x + 1), y0 = std::min(y0, y), y1 = std::max(y1, y + 1);
    if (x1 == 0) return 0;
    x0 -= std::min(x0, kMarginPx), y0 -= std::min(y0, kMarginPx), x1 = std::min(width, x1 + kMarginPx),
                                                                  y1 = std::min(height, y1 + kMarginPx);
    std::vector<double> want, have;
    std::vector<size_t> at;
    for (uint32_t y = y0; y < y1; ++y)
        for (uint32_t x = x0; x < x1; ++x) {
            const size_t p = size_t(y) * width + x;
            for (size_t c = 0; c < 3; ++c) {
                want.push_back(reference.rgb[p * 3 + c] + 0.5 * (1 - reference.alpha[p]));
                have.push_back(rgba[p * 4 + c] / 255.0 + 0.5 * (1 - rgba[p * 4 + 3] / 255.0));
            }
            at.push_back(p);
        }
    const std::vector<double> map = flipMap(want, have, x1 - x0, y1 - y0);
    double sum = 0;
    size_t count = 0;
    for (size_t i = 0; i < map.size(); ++i)
        if (covered(at[i])) sum += map[i], ++count;
    return sum / double(count);
}

}  // namespace dpl
