// SPDX-License-Identifier: Apache-2.0
// All pictures at one blur, held against the surface in its current poses. Private to reconstruction/subject/registration.
#pragma once

#include "reconstruction/subject/registration/appearance.h"
#include "reconstruction/subject/registration/frame_poses.h"
#include "reconstruction/subject/registration/picture_cost.h"

namespace dpl {

class PictureRounds {
public:
    /** Keeps references. */
    PictureRounds(const RegisterInput& input, const RegisterSettings& settings, Jobs& jobs);

    /** Frames with a picture, as indices of RegisterInput::frames. */
    const std::vector<size_t>& shown() const { return shown_; }
    /** A round at a blur: draws all frames anew, and finds what each shows and how points look in the still pictures. */
    void start(const FramePoses& poses, double blurPx);
    /** Draws some frames anew, with everything else as the round has it. Frames without a picture are passed over, here and below. */
    void look(const FramePoses& poses, std::span<const size_t> frames);
    /** Adds the costs of the pictures of some frames. */
    void addTerms(ceres::Problem& problem, FramePoses& poses, std::span<const size_t> frames) const;
    /** Cost of the pictures of some frames, σ², that does not depend on what start() or look() found: over all pixels that picture or
     * drawing show as person, the cost of an outlier where only one does, and the robust difference of contrast where both do. Pixels
     * within one blur count as one. It can compare poses that differ by far. */
    double misfit(const FramePoses& poses, std::span<const size_t> frames);

private:
    /** The points and outlines of one frame for its pose of the last look. */
    struct FrameView {
        std::vector<SeenPoint> seen;
        std::vector<OutlineTerm> outline;
    };
    std::vector<size_t> withPicture(std::span<const size_t> frames) const;  // indices of shown_
    std::vector<DrawnMesh> draw(const FramePoses& poses, std::span<const size_t> which) const;
    FrameView viewOf(size_t i, const DrawnMesh& drawn) const;
    void addOutline(size_t i, const DrawnMesh& drawn, const std::vector<uint8_t>& inside, const MaskDistance& outline, bool silhouette,
                    std::vector<OutlineTerm>& terms) const;
    std::vector<ContrastTerm> contrastTerms(size_t i) const;
    void findTriangleContrast();
    double misfit(size_t i, const DrawnMesh& drawn) const;

    const RegisterInput& input_;
    Jobs& jobs_;
    std::vector<MeshPoint> points_;
    std::vector<CarriedPoint> carried_;
    std::vector<size_t> shown_, stills_;   // frames; indices of shown_ that tell the contrast of points
    std::vector<FrameOutlines> outlines_;  // of shown_, as all below
    // Of the round:
    std::vector<double> pxPerM_, blurPx_;
    std::vector<FrameView> views_;
    std::vector<ContrastImage> images_;
    std::vector<PointContrast> contrast_;    // of points_
    std::vector<PointContrast> ofTriangle_;  // empty: not found yet
};

}  // namespace dpl
