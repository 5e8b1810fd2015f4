// SPDX-License-Identifier: Apache-2.0

/// What to do after `DPL_ERROR_DEVICE`. The first may have lost one frame only, as when an app went to the background; the next one in a
/// row means that the device is gone.
public struct DeviceLoss: Sendable {
    public enum Step: Sendable, Equatable {
        case leaveFrameOut
        case rebuild
    }

    /// Between attempts to rebuild.
    static let pauseS = 1.0
    private var failures = 0
    private var quietUntilS = -Double.infinity

    public init() {}

    /// Whether to draw at all; false for a while after a rebuild failed.
    public func mayDraw(nowS: Double) -> Bool { nowS >= quietUntilS }

    /// A frame failed with DPL_ERROR_DEVICE.
    public mutating func failed() -> Step {
        failures += 1
        return failures == 1 ? .leaveFrameOut : .rebuild
    }

    public mutating func rebuildFailed(nowS: Double) { quietUntilS = nowS + DeviceLoss.pauseS }

    /// A frame was prepared.
    public mutating func drew() { self = DeviceLoss() }
}
