// SPDX-License-Identifier: Apache-2.0
// ARKit of iOS: what this package uses of it. Declarations only, checked against the public documentation; see README.md.
import Foundation
import UIKit
@_exported import simd

open class ARAnchor: NSObject {
    public var transform: simd_float4x4 { fatalError() }
}

public final class ARPlaneAnchor: ARAnchor {}

public final class ARSkeletonDefinition: NSObject {
    public class var defaultBody3D: ARSkeletonDefinition { fatalError() }
    public var jointCount: Int { fatalError() }
    public var jointNames: [String] { fatalError() }
    public var neutralBodySkeleton3D: ARSkeleton3D? { fatalError() }
}

public final class ARSkeleton3D: NSObject {
    public var jointModelTransforms: [simd_float4x4] { fatalError() }
    public func isJointTracked(_ jointIndex: Int) -> Bool { fatalError() }
}

public final class ARBodyAnchor: ARAnchor {
    public var isTracked: Bool { fatalError() }
    public var skeleton: ARSkeleton3D { fatalError() }
}

public final class ARFaceAnchor: ARAnchor {
    public struct BlendShapeLocation: RawRepresentable, Hashable, Sendable {
        public let rawValue: String
        public init(rawValue: String) { self.rawValue = rawValue }
    }
    public var blendShapes: [BlendShapeLocation: NSNumber] { fatalError() }
}

public final class ARCamera: NSObject {
    public func viewMatrix(for orientation: UIInterfaceOrientation) -> simd_float4x4 { fatalError() }
    public func projectionMatrix(
        for orientation: UIInterfaceOrientation, viewportSize: CGSize, zNear: CGFloat, zFar: CGFloat
    ) -> simd_float4x4 { fatalError() }
}

public final class ARFrame: NSObject {
    public var timestamp: TimeInterval { fatalError() }
    public var camera: ARCamera { fatalError() }
    public var anchors: [ARAnchor] { fatalError() }
}

open class ARConfiguration: NSObject {
    open class var isSupported: Bool { fatalError() }
}

public final class ARWorldTrackingConfiguration: ARConfiguration {
    public struct PlaneDetection: OptionSet, Sendable {
        public let rawValue: UInt
        public init(rawValue: UInt) { self.rawValue = rawValue }
        public static let horizontal = PlaneDetection(rawValue: 1)
    }
    public var planeDetection: PlaneDetection { get { fatalError() } set {} }
}

public final class ARBodyTrackingConfiguration: ARConfiguration {
    public var planeDetection: ARWorldTrackingConfiguration.PlaneDetection { get { fatalError() } set {} }
}

public final class ARSession: NSObject {
    public struct RunOptions: OptionSet, Sendable {
        public let rawValue: UInt
        public init(rawValue: UInt) { self.rawValue = rawValue }
        public static let resetTracking = RunOptions(rawValue: 1)
        public static let removeExistingAnchors = RunOptions(rawValue: 2)
    }
    public var currentFrame: ARFrame? { fatalError() }
    public weak var delegate: (any ARSessionDelegate)?
    public func run(_ configuration: ARConfiguration, options: RunOptions = []) {}
    public func pause() {}
}

public protocol ARSessionDelegate: NSObjectProtocol {
    func session(_ session: ARSession, didUpdate frame: ARFrame)
}
