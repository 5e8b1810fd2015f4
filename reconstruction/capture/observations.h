// SPDX-License-Identifier: Apache-2.0
// Finds keypoints, clothing labels and masks with neural networks, for scans that lack them.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "reconstruction/capture/scan.h"
#include "sdk/core/jobs.h"

namespace dpl {

/** The 24 keypoint names in the order of Observation::keypoints: "nose" … "head_top". */
std::span<const std::string_view> observedKeypointNames();

/** Converts 33 pose landmarks (BlazePose order, pixels, confidence 0 … 1) to the 24 keypoints. Neck, pelvis, knuckles, toes and head top
 *  are derived from other landmarks. `mask` may be null; otherwise the head top is placed on its outline. */
std::vector<Keypoint> keypointsFromLandmarks(std::span<const Vec2d> landmarks33, std::span<const double> confidence33,
                                             const ImageGrey8* mask);

/** What the networks found in one picture. Positions in its pixels, planes of its size. */
struct Observation {
    std::vector<Keypoint> keypoints;  // observedKeypointNames() order
    ImageGrey8 labels;                // default label values: background 0, body 1, top 2, bottom 3, hair 4, shoes 5
    ImageGrey8 mask;                  // the given mask, else the segmentation of the pose network
    double personScore = 0;           // 0 … 1
};

/** The networks of one folder: blazepose_full.onnx (or _lite) and, if present, skin_clothes_hair_pan.onnx. Each thread needs its own. */
class Observer {
public:
    static Result<Observer> load(const std::filesystem::path& models);
    Observer(Observer&&) noexcept;
    Observer& operator=(Observer&&) noexcept;
    ~Observer();
    bool hasLabels() const;

    /** `mask` may be null. When no person is found, personScore is below 0.5 and every confidence is 0. */
    Result<Observation> observe(const ImageRgb8& image, const ImageGrey8* mask);

private:
    struct State;
    explicit Observer(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

struct ObserveOptions {
    std::filesystem::path models;                             // folder of the networks
    std::filesystem::path output;                             // receives keypoints/, labels/ and masks/ (docs/formats/scan.md)
    std::function<void(size_t done, size_t count)> progress;  // called from worker threads, one at a time; may be empty
};

/** Writes what the scan lacks: keypoints when it has no keypoint names, and labels and masks of frames without them. A frame in which no
 *  person is found gets no labels. Each frame is processed alone, so a held-out picture affects only its own files. Every thread of `jobs`
 *  loads the networks. The files do not depend on the number of threads and are written atomically. */
Status observeScan(const Scan& scan, const ObserveOptions& options, Jobs& jobs);

/** Adds the paths of files that observeScan() wrote to `folder` to the scan, where it lacks them. Reads no file. */
Scan withObservations(Scan scan, const std::filesystem::path& folder);

}  // namespace dpl
