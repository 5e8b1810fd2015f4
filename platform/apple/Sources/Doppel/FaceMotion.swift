// SPDX-License-Identifier: Apache-2.0
import CDoppel

/// What a face does by itself, beside the expression that is set. All zeros: nothing. See `DplFaceMotion`.
public struct FaceMotion: Sendable, Equatable {
    /// Of the times of blinks and glances: people of one seed blink together.
    public var seed: UInt32
    /// 0 to 1; 1 as people at rest do.
    public var blinks: Float
    public var glances: Float
    /// A stream that is silent for so many seconds has stopped; 0: what was set stays.
    public var holdS: Float = 0
    /// When the stream spoke last, nanoseconds of the clock of the pictures.
    public var heardNs: Int64 = 0

    public init(seed: UInt32, blinks: Float = 1, glances: Float = 1) {
        self.seed = seed
        self.blinks = blinks
        self.glances = glances
    }
}

extension Avatar {
    /// Blinks, glances and the end of a stream, for a picture at a time: for each picture. See `dplSetFaceMotion`.
    public func setFaceMotion(_ motion: FaceMotion, timeNs: Int64) throws(DoppelError) {
        var given = DplFaceMotion.sized
        given.seed = motion.seed
        given.blinks = motion.blinks
        given.glances = motion.glances
        given.holdS = motion.holdS
        given.heardNs = motion.heardNs
        try check(dplSetFaceMotion(handle.raw, &given, timeNs))
    }
}
