// SPDX-License-Identifier: Apache-2.0
import CDoppel

/// Owns an avatar, or a set of general splats. It may be used from any thread.
public final class Avatar: Sendable {
    /// The context it was loaded with.
    public let context: DoppelContext
    let handle: Handle

    /// Takes ownership of `raw`, which was loaded with `context`.
    public init(owning raw: DplAvatar, of context: DoppelContext) {
        handle = Handle(raw: raw)
        self.context = context
    }

    deinit { dplDestroyAvatar(handle.raw) }

    /// For calls of the C interface. Valid as long as this object.
    public var raw: DplAvatar { handle.raw }

    public struct Info: Sendable, Equatable {
        public let name: String
        /// 0: general splats, which cannot be posed.
        public let jointCount: Int
        public let splatCount, vertexCount, triangleCount, layerCount, clipCount, shDegree: Int
        /// Bounding box at rest, metres.
        public let restMin, restMax: SIMD3<Float>
        /// What the file holds. More than was loaded if memory was short.
        public let fileSplatCount, fileShDegree: Int
        /// False: general splats of a file that does not say which way is up. `dplGetFileAxes` with `raw` tells more.
        public let axesStated: Bool
    }

    public func info() throws(DoppelError) -> Info {
        let c = try filled(DplAvatarInfo.sized) { dplGetAvatarInfo(handle.raw, $0) }
        let axes = try filled(DplFileAxes.sized) { dplGetFileAxes(handle.raw, $0) }
        return Info(
            name: String(cString: c.name), jointCount: Int(c.jointCount), splatCount: Int(c.splatCount), vertexCount: Int(c.vertexCount),
            triangleCount: Int(c.triangleCount), layerCount: Int(c.layerCount), clipCount: Int(c.clipCount), shDegree: Int(c.shDegree),
            restMin: SIMD3(c.restMin.0, c.restMin.1, c.restMin.2), restMax: SIMD3(c.restMax.0, c.restMax.1, c.restMax.2),
            fileSplatCount: Int(c.fileSplatCount), fileShDegree: Int(c.fileShDegree), axesStated: axes.stated != 0)
    }

    public struct Joint: Sendable, Equatable {
        public let name: String
        /// VRM humanoid name, such as "leftUpperArm", or "".
        public let humanoidBone: String
        public let parent: Int?
        /// Metres, avatar space at rest.
        public let restPosition: SIMD3<Float>
    }

    public func joint(_ index: Int) throws(DoppelError) -> Joint {
        let number = try c(index)
        let c = try filled(DplJointInfo.sized) { dplGetJointInfo(handle.raw, number, $0) }
        return Joint(
            name: String(cString: c.name), humanoidBone: String(cString: c.humanoidBone), parent: c.parent < 0 ? nil : Int(c.parent),
            restPosition: SIMD3(c.restPosition.0, c.restPosition.1, c.restPosition.2))
    }

    /// Finds a joint by its name, or else by its humanoid bone.
    public func findJoint(_ name: String) throws(DoppelError) -> Int {
        Int(try filled(UInt32(0)) { dplFindJoint(handle.raw, name, $0) })
    }

    public struct FrameStats: Sendable, Equatable {
        public let splatsDrawn: Int
        /// Memory that the renderer holds for all avatars and frames of the context.
        public let residentBytes: UInt64
        /// Memory of this avatar alone.
        public let avatarBytes: UInt64
        /// Time of the last finished frame; 0 where it is not measured.
        public let frameMs: Double
        /// Share of the splats that level of detail kept, 0 to 1.
        public let detailShare: Float
    }

    /// What the last finished frame drew and cost. `dplGetFrameStats` with `raw` tells more.
    public func frameStats() throws(DoppelError) -> FrameStats {
        let c = try filled(DplFrameStats.sized) { dplGetFrameStats(handle.raw, $0) }
        return FrameStats(
            splatsDrawn: Int(c.splatsDrawn), residentBytes: c.residentBytes, avatarBytes: c.avatarBytes, frameMs: c.frameMs,
            detailShare: c.detailShare)
    }
}

/// An index or count for the C interface.
func c(_ number: Int) throws(DoppelError) -> UInt32 {
    guard let out = UInt32(exactly: number) else { throw DoppelError(.notFound, "there is no number \(number)") }
    return out
}
