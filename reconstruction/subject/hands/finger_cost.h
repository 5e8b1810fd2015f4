// SPDX-License-Identifier: Apache-2.0
// The residuals of the finger fit. Private to reconstruction/subject/hands, so that no public header includes Ceres.
#pragma once

#include <ceres/autodiff_cost_function.h>
#include <ceres/rotation.h>

#include <cmath>
#include <span>
#include <vector>

#include "reconstruction/subject/hands/hand_rig.h"
#include "reconstruction/subject/hands/priors.h"
#include "sdk/math/camera.h"

namespace dpl {

constexpr int kWristSize = 6;  // of a hand against the body fit: rotation vector in the wrist's frame, shift in the world, metres

/** What one frame shows of one hand. */
struct HandView {
    Camerad camera;                              // metric
    Mat3d wristRotation{1};                      // of the body fit, world
    Vec3d wrist{0};                              // of the body fit, world, metres
    std::array<Keypoint, kHandPoints> points{};  // in the order of the fingers
    double sigmaPx = 1;                          // at full confidence
};

/** Two residuals per seen point. Blocks: turns (kHandTurns), wrist (kWristSize). The Geman–McClure loss is applied inside, as in the body
 *  fit's ReprojectionCost. */
class HandCost {
public:
    /** `rig`, `view` and `outlierSigmas` must outlive it. */
    HandCost(const HandRig& rig, const HandView& view, const double& outlierSigmas)
        : rig_(rig), view_(view), outlierSigmas_(outlierSigmas) {
        for (size_t k = 0; k < view.points.size(); ++k)
            if (view.points[k].confidence > 0) seen_.push_back(k);
    }
    int residuals() const { return int(2 * seen_.size()); }

    template <class T>
    bool operator()(const T* turns, const T* wrist, T* residuals) const {
        using std::sqrt;
        const double c2 = outlierSigmas_ * outlierSigmas_;
        std::array<std::array<std::array<T, 3>, kFingerPoints>, kHandFingers> points;
        for (size_t f = 0; f < kHandFingers; ++f) points[f] = fingerPoints(rig_.fingers[f], turns + f * kFingerTurns);
        for (size_t i = 0; i < seen_.size(); ++i) {
            const Keypoint& seen = view_.points[seen_[i]];
            std::array<T, 2> px;
            T* r = residuals + 2 * i;
            if (!pixel(points[seen_[i] / kFingerPoints][seen_[i] % kFingerPoints], wrist, px)) {
                r[0] = r[1] = T(outlierSigmas_);
                continue;
            }
            const double weight = seen.confidence / view_.sigmaPx;
            for (size_t a = 0; a < 2; ++a) r[a] = weight * (px[a] - seen.px[int(a)]);
            const T scale = sqrt(c2 / (r[0] * r[0] + r[1] * r[1] + c2));
            r[0] *= scale, r[1] *= scale;
        }
        return true;
    }

private:
    /** Where a point of the rest frame of the wrist, metres from it, is seen; false: behind the camera. */
    template <class T>
    bool pixel(const std::array<T, 3>& rest, const T* wrist, std::array<T, 2>& px) const {
        constexpr double kMinDepthM = 0.05;
        T own[3];  // turned by the hand's own rotation
        ceres::AngleAxisRotatePoint(wrist, rest.data(), own);
        T world[3], seen[3];
        for (int r = 0; r < 3; ++r)
            world[r] = view_.wrist[r] + wrist[3 + r] + view_.wristRotation[0][r] * own[0] + view_.wristRotation[1][r] * own[1] +
                       view_.wristRotation[2][r] * own[2];
        const Mat3d& turn = view_.camera.viewFromWorldRotation;
        for (int r = 0; r < 3; ++r)
            seen[r] = turn[0][r] * world[0] + turn[1][r] * world[1] + turn[2][r] * world[2] + view_.camera.viewFromWorldTranslation[r];
        if (!(seen[2] > kMinDepthM)) return false;
        px = {view_.camera.fx * seen[0] / seen[2] + view_.camera.cx, view_.camera.fy * seen[1] / seen[2] + view_.camera.cy};
        return true;
    }

    const HandRig& rig_;
    const HandView& view_;
    const double& outlierSigmas_;
    std::vector<size_t> seen_;
};

/** Standard deviation of a turn against the pose that it is drawn to, radians. turn: an index of HandTurns. */
inline double spreadOfTurn(size_t turn) {
    if (turn < kFingerTurns) return priors::kThumbTurnRad;
    return turn % kFingerTurns == kBaseSide ? priors::kFingerSpreadRad : priors::kFingerBendRad;
}

/** Distance from `mean` in standard deviations, and from what the middle joint's tendon makes of the last one. Block: turns. */
struct FingerPriorCost {
    static constexpr int kResiduals = int(kHandTurns + kHandFingers - 1);
    HandTurns mean{};

    template <class T>
    bool operator()(const T* turns, T* residuals) const {
        for (size_t i = 0; i < kHandTurns; ++i) residuals[i] = (turns[i] - mean[i]) / spreadOfTurn(i);
        for (size_t f = 1; f < kHandFingers; ++f)
            residuals[kHandTurns + f - 1] =
                (turns[f * kFingerTurns + kEndBend] - priors::kEndBendShare * turns[f * kFingerTurns + kMiddleBend]) / priors::kEndBendRad;
        return true;
    }
};

/** Block: wrist. */
struct WristPriorCost {
    template <class T>
    bool operator()(const T* wrist, T* residuals) const {
        for (int i = 0; i < kWristSize; ++i) residuals[i] = wrist[i] / (i < 3 ? priors::kWristTurnRad : priors::kWristShiftM);
        return true;
    }
};

/** Angular acceleration of every hinge over frames at times t0 < t1 < t2, seconds. Blocks: turns of each. */
struct FingerSmoothness {
    double beforeS = 1, afterS = 1;

    template <class T>
    bool operator()(const T* a, const T* b, const T* c, T* residuals) const {
        const double mean = 0.5 * (beforeS + afterS);
        for (size_t i = 0; i < kHandTurns; ++i)
            residuals[i] = ((c[i] - b[i]) / afterS - (b[i] - a[i]) / beforeS) / (mean * priors::kFingerAccelerationRadS2);
        return true;
    }
};

}  // namespace dpl
