// SPDX-License-Identifier: Apache-2.0
// Observations by neural front-ends: keypoints, clothing labels and masks for scans that bring none. Never required.
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

/** 33 pose landmarks (BlazePose order, pixels) -> the 24 names. Neck, pelvis, knuckles, toes and head top are derived; the head top follows
 * the mask when there is one. confidence33: 0 … 1. */
std::vector<Keypoint> keypointsFromLandmarks(std::span<const Vec2d> landmarks33, std::span<const double> confidence33,
                                             const ImageGrey8* mask);

/** What one picture gave; pixels are those of the image handed in. */
struct Observation {
    std::vector<Keypoint> keypoints;  // observedKeypointNames() order
    ImageGrey8 labels;                // default label values: background 0, body 1, top 2, bottom 3, hair 4, shoes 5
    ImageGrey8 mask;                  // the given mask, else the pose network's segmentation
    double personScore = 0;           // 0 … 1
};

/** Networks of one folder: blazepose_full.onnx (or _lite) and, when there, skin_clothes_hair_pan.onnx. Not thread-safe: one per thread. */
class Observer {
public:
    static Result<Observer> load(const std::filesystem::path& models);
    Observer(Observer&&) noexcept;
    Observer& operator=(Observer&&) noexcept;
    ~Observer();
    bool hasLabels() const;

    /** mask may be null. No person: personScore < 0.5, all confidences 0. */
    Result<Observation> observe(const ImageRgb8& image, const ImageGrey8* mask);

private:
    struct State;
    explicit Observer(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

struct ObserveOptions {
    std::filesystem::path models;  // folder of the networks
    std::filesystem::path output;  // keypoints/, labels/ and masks/ are written here, in the layout of docs/formats/scan.md
    std::function<void(size_t done, size_t count)> progress;  // called from worker threads, one at a time; may be empty
};

/** Fills in what the scan lacks, frame by frame: keypoints when the scan has no keypoint names, labels (where a person was found) and masks
 *  where a frame has none. Files
 *  are written to a temporary name and renamed; scan's paths, names and labels are set. Pictures are looked at one at a time, so a held-out
 * one changes nothing but its own files. One network set per thread of `jobs`; the files do not depend on the number of threads. */
Status observeScan(Scan& scan, const ObserveOptions& options, Jobs& jobs);

}  // namespace dpl
