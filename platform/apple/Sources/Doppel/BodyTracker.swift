// SPDX-License-Identifier: Apache-2.0
import CDoppel

/// Turns what a platform tells of a person into poses of one avatar: see "driving from trackers" in doppel.h. `track` may be called on a
/// camera's thread; it never waits for drawing.
public final class BodyTracker: Sendable {
    public enum Format: UInt32, Sendable {
        case vrm = 0
        case unity, arkitBody, fbBody, openXRHands, mediaPipePose

        var raw: DplTrackFormat { DplTrackFormat(rawValue: .init(rawValue)) }

        /// The joints in the platform's own words, in the order in which a frame has them.
        public var jointNames: [String] {
            var names: [String] = []
            var name: UnsafePointer<CChar>?
            while dplGetTrackJointName(raw, UInt32(names.count), &name) == DPL_OK, let name { names.append(String(cString: name)) }
            return names
        }
    }

    public struct Options: OptionSet, Sendable {
        public let rawValue: UInt32
        public init(rawValue: UInt32) { self.rawValue = rawValue }
        public static let raw = Options(rawValue: UInt32(DPL_TRACKER_RAW.rawValue))
        public static let keepPlace = Options(rawValue: UInt32(DPL_TRACKER_KEEP_PLACE.rawValue))
        public static let inPlace = Options(rawValue: UInt32(DPL_TRACKER_IN_PLACE.rawValue))
        public static let overPose = Options(rawValue: UInt32(DPL_TRACKER_OVER_POSE.rawValue))
    }

    public enum State: UInt32, Sendable {
        case waiting = 0
        case tracking, lost
    }

    public struct Status: Sendable, Equatable {
        public let state: State
        public let drivenJoints, framesTaken, framesDropped: Int
        /// By how much the pose was extrapolated, seconds.
        public let predictedS: Float
    }

    public let avatar: Avatar
    private let handle: Handle

    /// rest: the platform's neutral pose, one for each joint of the format; empty where the format needs none.
    public init(driving avatar: Avatar, format: Format, rest: [RigidPose] = [], options: Options = []) throws(DoppelError) {
        self.avatar = avatar
        let flat = FlatPoses(rest)
        var info = DplTrackerInfo.sized
        info.format = format.raw
        info.flags = options.rawValue
        info.restCount = UInt32(rest.count)
        var raw: DplTracker?
        let result = flat.use { rotations, positions in
            info.restRotations = rest.isEmpty ? nil : rotations
            info.restPositions = rest.isEmpty ? nil : positions
            return dplCreateTracker(avatar.handle.raw, &info, &raw)
        }
        try check(result)
        handle = Handle(raw: raw!)
    }

    deinit { dplDestroyTracker(handle.raw) }

    /// Gives the tracker a frame: a pose for each joint of the format, in one space. confidence: 0 to 1 for each joint; empty: all are
    /// tracked. A frame of another skeleton, or with left and right swapped, is dropped and throws `.corruptData`.
    public func track(_ joints: [RigidPose], confidence: [Float] = [], timeNs: Int64) throws(DoppelError) {
        if !confidence.isEmpty && confidence.count != joints.count {
            throw DoppelError(.invalidArgument, "\(joints.count) joints need as many values of confidence, not \(confidence.count)")
        }
        var frame = DplTrackFrame.sized
        frame.jointCount = UInt32(joints.count)
        frame.timeNs = timeNs
        let result = FlatPoses(joints).use { rotations, positions in
            confidence.withUnsafeBufferPointer { trusted in
                frame.rotations = rotations
                frame.positions = positions
                frame.confidence = confidence.isEmpty ? nil : trusted.baseAddress
                return dplTrackFrame(handle.raw, &frame)
            }
        }
        try check(result)
    }

    /// Poses the avatar for a picture that is shown at displayTimeNs, on the clock of the frames.
    @discardableResult
    public func pose(displayTimeNs: Int64) throws(DoppelError) -> Status {
        let c = try filled(DplTrackerStatus.sized) { dplSetPoseFromTracker(handle.raw, displayTimeNs, $0) }
        return Status(
            state: State(rawValue: UInt32(c.state.rawValue)) ?? .lost, drivenJoints: Int(c.drivenJoints), framesTaken: Int(c.framesTaken),
            framesDropped: Int(c.framesDropped), predictedS: c.predictedS)
    }
}

extension DplTrackerInfo: Sized {}
extension DplTrackFrame: Sized {}
extension DplTrackerStatus: Sized {}

/// Poses as the C interface takes them.
private struct FlatPoses {
    let rotations, positions: [Float]

    init(_ poses: [RigidPose]) {
        rotations = poses.flatMap(\.quaternion)
        positions = poses.flatMap(\.translation)
    }

    func use<R>(_ body: (UnsafePointer<Float>?, UnsafePointer<Float>?) -> R) -> R {
        rotations.withUnsafeBufferPointer { r in positions.withUnsafeBufferPointer { p in body(r.baseAddress, p.baseAddress) } }
    }
}
