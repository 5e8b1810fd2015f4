// SPDX-License-Identifier: Apache-2.0
// Keypoints, clothing labels and masks found by neural networks, for scans that bring none.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "reconstruction/capture/scan.h"
#include "sdk/core/jobs.h"

namespace dpl {

/** The 24 names of our scans, in their order: "nose" … "head_top". */
std::span<const std::string_view> observedKeypointNames();

/** 33 pose landmarks (BlazePose order, pixels) to the 24 names. Neck, pelvis, knuckles, toes and head top are derived from others; the
 *  head top follows the mask when one is given. confidence33: 0 … 1. */
std::vector<Keypoint> keypointsFromLandmarks(std::span<const Vec2d> landmarks33, std::span<const double> confidence33,
                                             const ImageGrey8* mask);

/** What the networks found in one picture, in its pixels. */
struct Observation {
    std::vector<Keypoint> keypoints;  // observedKeypointNames() order
    ImageGrey8 labels;                // default label values: background 0, body 1, top 2, bottom 3, hair 4, shoes 5
    ImageGrey8 mask;                  // the given mask; without one, the pose network's segmentation
    double personScore = 0;           // 0 … 1
};

/** The networks of one folder: blazepose_full.onnx (or _lite) and, if present, skin_clothes_hair_pan.onnx. Use one per thread. */
class Observer {
public:
    static Result<Observer> load(const std::filesystem::path& models);
    Observer(Observer&&) noexcept;
    Observer& operator=(Observer&&) noexcept;
    ~Observer();
    bool hasLabels() const;

    /** `mask` may be null. Without a person personScore is below 0.5 and every confidence 0. */
    Result<Observation> observe(const ImageRgb8& image, const ImageGrey8* mask);

private:
    struct State;
    explicit Observer(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

struct ObserveOptions {
    std::filesystem::path models;                             // folder of the networks
    std::filesystem::path output;                             // gets keypoints/, labels/ and masks/, in the layout of docs/formats/scan.md
    std::function<void(size_t done, size_t count)> progress;  // called from worker threads, one at a time; may be empty
};

/** Writes what the scan lacks: keypoints when it has no keypoint names, labels and masks of frames without one. Labels are written only
 *  where a person was found. Each frame is observed alone, so a held-out picture affects only its own files. Every thread of `jobs` loads
 *  the networks; the files do not depend on the number of threads. Each file appears whole. */
Status observeScan(const Scan& scan, const ObserveOptions& options, Jobs& jobs);

/** The scan with the files of a finished observeScan() in place of what it lacks. `folder` is that call's output. Reads no file. */
Scan withObservations(Scan scan, const std::filesystem::path& folder);

}  // namespace dpl
