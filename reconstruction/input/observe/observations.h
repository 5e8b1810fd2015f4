// SPDX-License-Identifier: Apache-2.0
// Finds keypoints, clothing labels and masks with neural networks, for scans that lack them.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "reconstruction/input/capture/glance.h"
#include "reconstruction/input/capture/scan.h"
#include "sdk/core/jobs.h"

namespace dpl {

/** The 24 keypoint names in the order of Observation::keypoints: "nose" … "head_top". */
std::span<const std::string_view> observedKeypointNames();

/** Converts 33 pose landmarks (BlazePose order, pixels, confidence 0 … 1) to the 24 keypoints. Neck, pelvis, knuckles, toes and head top
 *  are derived from other landmarks; hips, knees and shoulders move from where the network marks them to the joints. `mask` may be null;
 * otherwise the head top is placed on its outline. */
std::vector<Keypoint> keypointsFromLandmarks(std::span<const Vec2d> landmarks33, std::span<const double> confidence33,
                                             const ImageGrey8* mask);

/** What the networks found in one picture. Positions in its pixels, planes of its size. */
struct Observation {
    std::vector<Keypoint> keypoints;  // observedKeypointNames() order
    std::vector<Keypoint> hands;      // handKeypointNames() order; empty when no hand is found, or without the network of hands
    ImageGrey8 labels;                // default label values: background 0, body 1, top 2, bottom 3, hair 4, shoes 5
    ImageGrey8 mask;                  // the given mask, else the segmentation of the pose network with its edge refined (refine_matte.h)
    double personScore = 0;           // 0 … 1
};

/** A rotated square of a picture, pixels. */
struct PersonCrop {
    Vec2d centrePx{0};
    double sidePx = 1, angleRad = 0;  // the crop's up direction is the picture's, rotated clockwise by angleRad
};

struct PersonBox {
    Vec2d low{0}, high{0};  // pixels
};

/** A person that the pose network confirms. */
struct SeenPerson {
    PersonBox box;    // round the landmarks, with room for head, hands and feet
    PersonCrop crop;  // what the pose network should get
    double score = 0;
};

/** The networks of one folder (models_folder.h). Each thread needs its own. */
class Observer {
public:
    static Result<Observer> load(const std::filesystem::path& models);
    Observer(Observer&&) noexcept;
    Observer& operator=(Observer&&) noexcept;
    ~Observer();
    bool hasLabels() const;
    bool hasDetector() const;
    bool hasHands() const;

    /** The people in a picture, best first. Without a detector only the one that the pose network finds in the whole picture. */
    Result<std::vector<SeenPerson>> people(const ImageRgb8& image);

    /** A look with one network, some tenths of a second. */
    Result<Glance> glance(const ImageRgb8& image);

    /** `mask` may be null. `start`: where the person is; null: the mask's box, or the whole picture. When no person is found, personScore
     *  is below 0.5 and every confidence is 0. `closeup`: the picture shows a part of the person, whom the network of close-ups finds
     *  where the pose network does not. */
    Result<Observation> observe(const ImageRgb8& image, const ImageGrey8* mask, const PersonCrop* start = nullptr, bool closeup = false);

private:
    struct State;
    explicit Observer(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

/** Whether the scan lacks keypoints, or a frame a mask: what an avatar cannot be made without. */
bool lacksObservations(const Scan& scan);

/** "FRAME:X,Y", pixels of the stored picture. */
struct PersonPoint {
    std::string frame;
    Vec2d px{0};
};
Result<PersonPoint> parsePersonPoint(const std::string& text);

struct ObserveOptions {
    std::filesystem::path models;                  // folder of the networks
    std::filesystem::path output;                  // receives keypoints/, labels/ and masks/ (docs/formats/scan.md)
    std::vector<PersonPoint> persons;              // where the user says that the person is
    std::function<void(const std::string&)> note;  // gets a sentence on what was chosen; may be empty
};

/** Writes what the scan lacks: keypoints when it has no keypoint names, those of hands included where the folder has the network of hands,
 *  and labels and masks of frames without them. A frame in which no person is found gets no labels. Where several people are in view,
 * choosePerson() decides over the training frames of each kind; frames in which nobody is found are tried again where the neighbours see
 * the person. A held-out picture affects only its own files. Every thread of `jobs` loads the networks. The files do not depend on the
 * number of threads and are written atomically. Also writes people.json: the boxes of all people, and which was chosen. Errors: a file;
 * Cancelled, between two frames. */
Status observeScan(const Scan& scan, const ObserveOptions& options, Jobs& jobs);

/** Adds the paths of files that observeScan() wrote to `folder` to the scan, where it lacks them. Reads no file. */
Scan withObservations(Scan scan, const std::filesystem::path& folder);

}  // namespace dpl
