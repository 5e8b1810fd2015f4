// SPDX-License-Identifier: Apache-2.0
// ARKit of visionOS: what this package uses of it. Declarations only, checked against the public documentation; see README.md.
import Foundation
@_exported import simd

public protocol DataProvider: AnyObject, Sendable {}

public final class DeviceAnchor: Sendable {
    public var originFromAnchorTransform: simd_float4x4 { fatalError() }
}

public final class WorldTrackingProvider: DataProvider {
    public init() {}
    public func queryDeviceAnchor(atTimestamp timestamp: TimeInterval) -> DeviceAnchor? { fatalError() }
}

public final class ARKitSession: Sendable {
    public init() {}
    public func run(_ dataProviders: [any DataProvider]) async throws {}
}
