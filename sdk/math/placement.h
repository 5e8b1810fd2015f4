// SPDX-License-Identifier: Apache-2.0
// Where a subject stands in the world, and the views of a frame as it sees them.
//
// A subject is posed, thinned out, culled and lit in its own space and its own metres, wherever it stands: the views are moved there
// instead. So a placement cannot change a pose or a bound of stretch. What is measured along a view (near plane and fade, depth, size on
// the screen) is in metres of the world: `scale` times the subject's. Code that poses or draws one subject means its own space by "world".
#pragma once

#include <array>
#include <span>

#include "sdk/math/camera.h"

namespace dpl {

/** X_world = scale · rotation · X_subject + translation. */
struct Placement {
    Mat3d rotation{1};
    double scale = 1;      // > 0: metres of the world that a metre of the subject takes
    Vec3d translation{0};  // metres, world

    bool operator==(const Placement&) const = default;
    Vec3d toWorld(const Vec3d& own) const { return rotation * (scale * own) + translation; }
    Vec3d toOwn(const Vec3d& world) const { return directionToOwn(world - translation) / scale; }
    /** Turns a direction, whose length stays. */
    Vec3d directionToOwn(const Vec3d& world) const { return glm::transpose(rotation) * world; }
    /** The camera in the subject's space and metres. */
    Cameraf toOwn(const Cameraf& view) const {
        if (*this == Placement()) return view;  // the same bits, so the same picture as without a placement
        Cameraf own = view;
        const Mat3d turn(view.viewFromWorldRotation);
        own.viewFromWorldRotation = Mat3f(turn * rotation);
        own.viewFromWorldTranslation = Vec3f((turn * translation + Vec3d(view.viewFromWorldTranslation)) / scale);
        return own;
    }
};

/** A camera in the space and metres of the subject that it sees. A length of the subject is `scale` times as long in the view. */
struct SubjectView {
    Cameraf camera;
    float scale = 1;
    SubjectView(const Cameraf& c, float s = 1) : camera(c), scale(s) {}

    Mat3f viewFromSubject() const { return scale * camera.viewFromWorldRotation; }
    /** Metres of the world. */
    Vec3f toView(const Vec3f& own) const { return scale * camera.toView(own); }
};

/** The views of a draw as one subject sees them. */
class SubjectViews {
public:
    SubjectViews() = default;
    /** views: at most two. */
    SubjectViews(const Placement& placement, std::span<const Cameraf> views) : count_(views.size()), scale_(float(placement.scale)) {
        for (size_t v = 0; v < count_; ++v) cameras_[v] = placement.toOwn(views[v]);
    }
    std::span<const Cameraf> cameras() const { return {cameras_.data(), count_}; }
    float scale() const { return scale_; }
    SubjectView operator[](size_t v) const { return {cameras_[v], scale_}; }

private:
    std::array<Cameraf, 2> cameras_;
    size_t count_ = 0;
    float scale_ = 1;
};

}  // namespace dpl
