// SPDX-License-Identifier: Apache-2.0
import CDoppel

/// Places, poses and clips.
extension Avatar {
    /// Where it stands in the world, until it is changed: see `dplSetTransform`. scale: metres of the world that one of its metres takes.
    public func setTransform(_ worldFromAvatar: RigidPose, scale: Float = 1) throws(DoppelError) {
        try check(dplSetTransform(handle.raw, worldFromAvatar.rows(scale: scale)))
    }

    /// The transform as a 3×4 matrix, row by row, of twelve numbers.
    public func transform() throws(DoppelError) -> [Float] {
        var worldFromAvatar = [Float](repeating: 0, count: 12)
        try check(dplGetTransform(handle.raw, &worldFromAvatar))
        return worldFromAvatar
    }

    /// One local rotation for each joint, quaternions x, y, z, w, and where the root stands, metres. Identity everywhere is the rest pose.
    public struct Pose: Sendable, Equatable {
        public var rotations: [SIMD4<Float>]
        public var root: SIMD3<Float>

        public init(rotations: [SIMD4<Float>], root: SIMD3<Float> = .zero) {
            self.rotations = rotations
            self.root = root
        }
    }

    public func setPose(_ pose: Pose) throws(DoppelError) {
        let root = [pose.root.x, pose.root.y, pose.root.z]
        let count = try c(pose.rotations.count)
        try check(
            pose.rotations.withUnsafeBytes {
                dplSetPose(handle.raw, $0.bindMemory(to: Float.self).baseAddress, count, root)
            })
    }

    /// The same for a picture that is shown at timeNs, nanoseconds of any one clock: clothes then remember. See `dplSetPoseAtTime`.
    public func setPose(_ pose: Pose, timeNs: Int64) throws(DoppelError) {
        let root = [pose.root.x, pose.root.y, pose.root.z]
        let count = try c(pose.rotations.count)
        try check(
            pose.rotations.withUnsafeBytes {
                dplSetPoseAtTime(handle.raw, $0.bindMemory(to: Float.self).baseAddress, count, root, timeNs)
            })
    }

    /// Clothes forget: they are those of the current pose alone.
    public func settle() throws(DoppelError) { try check(dplSettle(handle.raw)) }

    /// What the clothes remember in the current pose, and its time, for a save or another device.
    public func motionState() throws(DoppelError) -> [UInt8] {
        var size = 0
        try check(dplGetMotionState(handle.raw, nil, 0, &size))
        var state = [UInt8](repeating: 0, count: size)
        try check(dplGetMotionState(handle.raw, &state, state.count, &size))
        return state
    }

    /// Restores `motionState()` of an avatar of the same file.
    public func setMotionState(_ state: [UInt8]) throws(DoppelError) {
        try check(dplSetMotionState(handle.raw, state, state.count))
    }

    /// How stiff the clothes are, until changed: 0 to 100, 1 as learned; stiffer ones swing and lag less. See `dplSetClothStiffness`.
    public func setClothStiffness(_ stiffness: Float) throws(DoppelError) { try check(dplSetClothStiffness(handle.raw, stiffness)) }

    public func pose() throws(DoppelError) -> Pose {
        let count = try info().jointCount
        var rotations = [SIMD4<Float>](repeating: .zero, count: count)
        var root: [Float] = [0, 0, 0]
        try check(
            rotations.withUnsafeMutableBytes {
                dplGetPose(handle.raw, $0.bindMemory(to: Float.self).baseAddress, UInt32(count), &root)
            })
        return Pose(rotations: rotations, root: SIMD3(root[0], root[1], root[2]))
    }

    /// World positions of all joints in the current pose, metres.
    public func jointPositions() throws(DoppelError) -> [SIMD3<Float>] {
        let count = try info().jointCount
        var flat = [Float](repeating: 0, count: 3 * count)
        try check(dplGetJointPositions(handle.raw, &flat, UInt32(count)))
        return (0..<count).map { SIMD3(flat[3 * $0], flat[3 * $0 + 1], flat[3 * $0 + 2]) }
    }

    public struct Clip: Sendable, Equatable {
        public let name: String
        public let durationS: Double
    }

    public func clip(_ index: Int) throws(DoppelError) -> Clip {
        let number = try c(index)
        let c = try filled(DplClipInfo.sized) { dplGetClipInfo(handle.raw, number, $0) }
        return Clip(name: String(cString: c.name), durationS: c.durationS)
    }

    /// Poses the avatar as a clip does, timeS seconds from its start. loop: the time wraps around; otherwise it is clamped.
    public func setPose(clip: Int, timeS: Double, loop: Bool = true) throws(DoppelError) {
        try check(dplSetPoseFromClip(handle.raw, try c(clip), timeS, loop ? DPL_TRUE : DPL_FALSE))
    }

    /// A clip within a mix; see `DplClipLayer`.
    public struct ClipLayer: Sendable, Equatable {
        public var clip: Int
        public var timeS: Double
        public var weight: Float
        /// The layer moves this joint and all below it; 0: the whole body.
        public var joint: Int
        /// The time wraps around. With travel, each round starts where the round before ended.
        public var loop, travel: Bool
        /// Move the whole clip: about the vertical, then along x and z, metres. `join` finds them.
        public var headingRad: Float = 0
        public var shiftM: SIMD2<Float> = .zero

        public init(clip: Int, timeS: Double, weight: Float = 1, joint: Int = 0, loop: Bool = true, travel: Bool = false) {
            self.clip = clip
            self.timeS = timeS
            self.weight = weight
            self.joint = joint
            self.loop = loop
            self.travel = travel
        }

        func raw() throws(DoppelError) -> DplClipLayer {
            var layer = DplClipLayer.sized
            layer.clip = try c(clip)
            layer.timeS = timeS
            layer.weight = weight
            layer.joint = try c(joint)
            layer.flags = (loop ? UInt32(DPL_LAYER_LOOP.rawValue) : 0) | (travel ? UInt32(DPL_LAYER_TRAVEL.rawValue) : 0)
            layer.headingRad = headingRad
            layer.shiftM = (shiftM.x, shiftM.y)
            return layer
        }
    }

    /// Mixes clips for a picture that is shown at timeNs, nanoseconds of any one clock: cross-fades, and layers over a part of the body.
    /// See `dplSetPoseFromClips`.
    public func setPose(layers: [ClipLayer], timeNs: Int64) throws(DoppelError) {
        var raw: [DplClipLayer] = []
        for layer in layers { raw.append(try layer.raw()) }
        try check(dplSetPoseFromClips(handle.raw, raw, try c(raw.count), timeNs))
    }

    /// Moves `layer` so that it goes on from where `before` stands, for a cross-fade of two recorded walks; see `dplJoinClipLayer`.
    public func join(_ before: ClipLayer, _ layer: inout ClipLayer) throws(DoppelError) {
        var from = try before.raw()
        var to = try layer.raw()
        try check(dplJoinClipLayer(handle.raw, &from, &to))
        layer.headingRad = to.headingRad
        layer.shiftM = SIMD2(to.shiftM.0, to.shiftM.1)
    }

    /// Turns neck, head and eyes of the current pose towards a point, metres in the space of the pose. Once after each pose, before
    /// drawing. Weights are 0 to 1; limits are left or right, and up or down, radians, zero: the usual ones. See `dplLookAtPoint`.
    public func look(
        at target: SIMD3<Float>, headWeight: Float = 0.7, eyeWeight: Float = 1, headLimitRad: SIMD2<Float> = .zero,
        eyeLimitRad: SIMD2<Float> = .zero
    ) throws(DoppelError) {
        var gaze = DplGaze.sized
        gaze.target = (target.x, target.y, target.z)
        gaze.headWeight = headWeight
        gaze.eyeWeight = eyeWeight
        gaze.headLimitRad = (headLimitRad.x, headLimitRad.y)
        gaze.eyeLimitRad = (eyeLimitRad.x, eyeLimitRad.y)
        try check(dplLookAtPoint(handle.raw, &gaze))
    }

    /// How `loadClip` keeps or changes what was recorded; see `DplClipFlag`.
    public struct ClipOptions: OptionSet, Sendable {
        public let rawValue: UInt32
        public init(rawValue: UInt32) { self.rawValue = rawValue }
        public static let keepLeadIn = ClipOptions(rawValue: UInt32(DPL_CLIP_KEEP_LEAD_IN.rawValue))
        public static let keepPlace = ClipOptions(rawValue: UInt32(DPL_CLIP_KEEP_PLACE.rawValue))
        public static let inPlace = ClipOptions(rawValue: UInt32(DPL_CLIP_IN_PLACE.rawValue))
        public static let asRecorded = ClipOptions(rawValue: UInt32(DPL_CLIP_AS_RECORDED.rawValue))
    }

    /// Reads a motion (BVH or glTF) and retargets it onto this avatar. Returns the index of the new clip.
    public func loadClip(_ bytes: [UInt8], options: ClipOptions = [], name: String? = nil) throws(DoppelError) -> Int {
        var settings = DplClipOptions.sized
        settings.flags = options.rawValue
        var index: UInt32 = 0
        let result = withOptionalCString(name) { text in
            settings.name = text
            return bytes.withUnsafeBufferPointer { dplLoadClip(handle.raw, $0.baseAddress, $0.count, &settings, &index) }
        }
        try check(result)
        return Int(index)
    }

    public struct Trust: Sendable, Equatable {
        /// Share of the pose-dependent offsets that is drawn. Below 1 the pose lies outside the trained ones.
        public let offsets: Float
        public let farthestJoint: Int
        /// In standard deviations of training; above 4 was hardly seen.
        public let farthestDistance: Float
    }

    /// How far the current pose lies from the poses that the avatar was trained on; see `dplGetPoseTrust`.
    public func poseTrust() throws(DoppelError) -> Trust {
        let c = try filled(DplPoseTrust.sized) { dplGetPoseTrust(handle.raw, $0, nil, 0) }
        return Trust(offsets: c.offsets, farthestJoint: Int(c.farthestJoint), farthestDistance: c.farthestDistance)
    }

    /// Turns joints back until none is farther from its training than `limit` standard deviations.
    public func holdPose(limit: Float) throws(DoppelError) { try check(dplHoldPose(handle.raw, limit)) }
}
