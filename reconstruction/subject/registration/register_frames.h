// SPDX-License-Identifier: Apache-2.0
// Registers frames: changes their poses until the clothed surface, painted with the contrast that the still pictures show, fits their
// pictures. Root and joint rotations move, nothing else. docs/reference/registration.md
//
//   min Σ_frames [ Σ ρ((C(π(X)) − c)/σ) + Σ ρ(d(π(X))/σ) + keypoints ] + priors
//   priors  moving frames: pose, smoothness in time, resting feet; still frames: spread of the sway
//   C, c  local contrast of the frame, and of the point in the still pictures
//   d     distance of a drawn outline from that of the mask or of a label
#pragma once

#include <string_view>

#include "reconstruction/input/capture/pose_precision.h"
#include "reconstruction/input/capture/train_frame.h"
#include "reconstruction/subject/body/fit_body.h"
#include "sdk/core/jobs.h"

namespace dpl {

struct RegisterFrame {
    FrameKind kind = FrameKind::Dynamic;
    double timeS = 0;
    Camerad camera;                       // metric
    Pose pose;                            // start
    LazyPicture picture;                  // none: the frame is posed by its keypoints alone
    std::span<const Keypoint> keypoints;  // in the order of keypointNames; empty: none
    Split split = Split::Train;           // others than training frames must bring no picture; no frame of an earlier split depends on them
};

struct RegisterInput {
    const BodyModel* body = nullptr;         // shaped: joints, keypoints and its own mesh; morphs are ignored
    const MeshData* surface = nullptr;       // clothed, at rest, on the joints of `body`
    std::span<const uint8_t> triangleLabel;  // F label values, or empty: unknown
    std::span<const uint8_t> rigidTriangle;  // F; 1: moves with its joints (skin, hair, shoes), 0: cloth
    std::span<const uint8_t> outlineLabels;  // label values whose outline in the picture is that of something rigid
    std::span<const std::string> keypointNames;
    std::span<const LandmarkOffset> landmarks;  // one per name, or empty
    double keypointSigma = 0;                   // of a coordinate at full confidence, fraction of the image diagonal
    double pictureWeight = 1;                   // > 0; of pictures beside keypoints (priors::kFoundPictureWeight)
    bool searchLimbs = false;                   // try other depths of limbs whose keypoints fit badly: for found keypoints
    Pose stillPose;                             // mean of the pose priors
    std::vector<RegisterFrame> frames;          // still and moving, of one scan
};

struct RegisterSettings {
    uint32_t surfacePoints = 2000;
    std::vector<double> blursPx{4, 2, 1};  // coarse to fine; pixels after pictures above 640 px a side are reduced to that
    int roundsPerBlur = 2;                 // a round finds anew what each picture shows
    int stepsPerRound = 4;
};

struct Registration {
    std::vector<Pose> poses;                // one per frame; a still frame without picture keeps its start
    std::vector<PosePrecision> precisions;  // of `poses`, where pictures count once; a still frame without picture: of its sway
    std::vector<SolveEnd> solves;
};

/** Registers all training frames together. Validation frames are solved afterwards by their keypoints, between their neighbours, and test
 *  frames after them. A moving frame without keypoints and without picture is placed by its neighbours. Without any picture the result is
 * that of keypoints alone. Deterministic, on any number of threads. Errors: InvalidArgument for sizes that do not match;
 *  a picture cannot be read; Cancelled. */
Result<Registration> registerFrames(const RegisterInput& input, const RegisterSettings& settings, Jobs& jobs);

}  // namespace dpl
