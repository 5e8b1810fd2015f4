// SPDX-License-Identifier: Apache-2.0
#if canImport(ARKit) && canImport(UIKit) && !os(visionOS)
    import ARKit
    import Doppel
    import simd

    /// Drives an avatar by ARKit's body tracking (ARBodyTrackingConfiguration). Call `update` with the anchors of a session's delegate, and
    /// `pose` once a picture.
    public final class BodyDrive: Sendable {
        public let tracker: BodyTracker

        /// Throws `.unsupported` where ARKit's skeleton is not the one that the library knows: then nothing is driven.
        public init(driving avatar: Avatar, options: BodyTracker.Options = []) throws(DoppelError) {
            let definition = ARSkeletonDefinition.defaultBody3D
            guard definition.jointNames == BodyTracker.Format.arkitBody.jointNames else {
                throw DoppelError(.unsupported,
                    "this version of ARKit names the \(definition.jointCount) joints of a body unlike the library's table")
            }
            guard let neutral = definition.neutralBodySkeleton3D else { throw DoppelError(.unsupported, "ARKit gives no neutral body") }
            tracker = try BodyTracker(
                driving: avatar, format: .arkitBody, rest: neutral.jointModelTransforms.map { RigidPose($0) }, options: options)
        }

        /// timestampS: of the ARFrame. Throws `.corruptData` for a frame that was dropped because left and right are swapped.
        public func update(_ body: ARBodyAnchor, timestampS: Double) throws(DoppelError) {
            let skeleton = body.skeleton
            let worldFromBody = RigidPose(body.transform)
            let joints = skeleton.jointModelTransforms.map { worldFromBody * RigidPose($0) }
            let confidence = joints.indices.map { body.isTracked && skeleton.isJointTracked($0) ? Float(1) : 0 }
            try tracker.track(joints, confidence: confidence, timeNs: Int64(timestampS * 1e9))
        }

        /// displayTimeS: on the clock of CACurrentMediaTime, which is that of ARFrame.timestamp.
        @discardableResult
        public func pose(displayTimeS: Double) throws(DoppelError) -> BodyTracker.Status {
            try tracker.pose(displayTimeNs: Int64(displayTimeS * 1e9))
        }
    }
#endif
