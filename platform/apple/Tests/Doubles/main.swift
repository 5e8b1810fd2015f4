// SPDX-License-Identifier: Apache-2.0
// The frame loop of MetalStage over doubles: Metal objects of this file, and dplMetal... of metal_double.c.
import CDoppel
import Doppel
import DoppelUI
import Foundation
import Metal
import MetalDouble

final class FakeEncoder: MTLRenderCommandEncoder {
    /// Instances and bytes of each draw.
    var draws: [[Int]] = []
    private var bytes = 0
    func endEncoding() {}
    func setRenderPipelineState(_ pipelineState: any MTLRenderPipelineState) {}
    func setViewport(_ viewport: MTLViewport) {}
    func setVertexBytes(_ bytes: UnsafeRawPointer, length: Int, index: Int) { self.bytes = length }
    func setFragmentBytes(_ bytes: UnsafeRawPointer, length: Int, index: Int) {}
    func setFragmentBuffer(_ buffer: (any MTLBuffer)?, offset: Int, index: Int) {}
    func drawPrimitives(type primitiveType: MTLPrimitiveType, vertexStart: Int, vertexCount: Int, instanceCount: Int) {
        draws.append([vertexCount, instanceCount, bytes])
    }
}

final class Fake: MTLLibrary, MTLFunction, MTLRenderPipelineState, MTLBuffer {
    let length = 4096
    func makeFunction(name functionName: String) -> (any MTLFunction)? { self }
}

final class FakeCommands: MTLCommandBuffer {
    var isCommitted = false
    private var handlers: [@Sendable (any MTLCommandBuffer) -> Void] = []
    func makeRenderCommandEncoder(descriptor: MTLRenderPassDescriptor) -> (any MTLRenderCommandEncoder)? { FakeEncoder() }
    func addCompletedHandler(_ block: @escaping @Sendable (any MTLCommandBuffer) -> Void) { handlers.append(block) }
    func present(_ drawable: any MTLDrawable) {}
    func commit() { isCommitted = true }
    /// The GPU has run it.
    func complete() { for handler in handlers { handler(self) } }
}

final class FakeQueue: MTLCommandQueue, @unchecked Sendable {
    func makeCommandBuffer() -> (any MTLCommandBuffer)? { FakeCommands() }
}

final class FakeDevice: MTLDevice, @unchecked Sendable {
    let name = "a double"
    var queues = 0, libraries = 0, pipelines = 0
    func makeLibrary(source: String, options: MTLCompileOptions?) throws -> any MTLLibrary {
        libraries += 1
        return Fake()
    }
    func makeRenderPipelineState(descriptor: MTLRenderPipelineDescriptor) throws -> any MTLRenderPipelineState {
        pipelines += 1
        return Fake()
    }
    func makeBuffer(bytes pointer: UnsafeRawPointer, length: Int, options: MTLResourceOptions) -> (any MTLBuffer)? { Fake() }
    func makeCommandQueue() -> (any MTLCommandQueue)? {
        queues += 1
        return FakeQueue()
    }
}

nonisolated(unsafe) var checks = 0
func expect(_ isTrue: Bool, _ what: @autoclosure () -> String, line: Int = #line) {
    checks += 1
    if !isTrue {
        print("main.swift:\(line): \(what())")
        exit(1)
    }
}

func calls() -> String { String(cString: doubleTakeCalls()) }

func code(_ body: () throws -> Void) -> DoppelError.Code? {
    do {
        try body()
        return nil
    } catch {
        return (error as? DoppelError)?.code
    }
}

let device = FakeDevice()
let stage = try MetalStage(device: device)
let file = try Data(contentsOf: URL(fileURLWithPath: ProcessInfo.processInfo.environment["DOPPEL_TEST_AVATAR"]!))
let avatar = try stage.context.loadAvatar([UInt8](file))
let camera = try Camera(pose: RigidPose(position: SIMD3(0, 1, 3)), fovYRad: 0.8, widthPx: 64, heightPx: 64)
let pass = MetalPass(colour: .bgra8Unorm_srgb, depth: .depth32Float, writesDepth: true)
try stage.make(pass)
try stage.make(pass)
expect(calls() == "create 0; composer 81; ", "a pass is compiled once")

// Three frames fill the slots; the fourth is left out until the first is done.
var flying: [MetalFrame] = []
for _ in 0..<3 {
    let frame = try stage.begin([avatar], from: [camera], nowS: 0)!
    try stage.compose(frame, into: FakeEncoder(), pass: pass, depth: Camera.StoredDepth(scale: 0, offset: 0.1))
    stage.commit(frame)
    flying.append(frame)
}
expect(calls() == "prepare 0; compose 1; depth 1; prepare 1; compose 1; depth 1; prepare 2; compose 1; depth 1; ", "slots in turn")
expect(flying.allSatisfy { ($0.commands as! FakeCommands).isCommitted }, "committed")
expect(try stage.begin([avatar], from: [camera], nowS: 0) == nil, "no slot is free")
expect(calls() == "", "a frame that is left out calls nothing")
for frame in flying { (frame.commands as! FakeCommands).complete() }

/// A whole frame of which the GPU is done.
func draw(_ avatars: [Avatar], nowS: Double) throws -> Bool {
    guard let frame = try stage.begin(avatars, from: [camera], nowS: nowS) else { return false }
    try stage.compose(frame, into: FakeEncoder(), pass: pass)
    stage.commit(frame)
    (frame.commands as! FakeCommands).complete()
    return true
}
expect(try draw([], nowS: 0), "a frame without avatars")
expect(calls() == "upload 0; ", "carries uploads and composes nothing")

// Another error than a lost device: the slot comes back.
doubleFail("prepare", -6, 1)
expect(code { _ = try draw([avatar], nowS: 0) } == .outOfMemory, "the error comes out")
expect(calls() == "prepare 1; drop 1; ", "and the slot is dropped")

// One lost frame is left out; the second failure in a row rebuilds on a new queue, with composers made again.
doubleFail("prepare", -8, 1)
expect(code { _ = try draw([avatar], nowS: 0) } == .device, "lost")
expect(try draw([avatar], nowS: 0), "drawn again")
expect(calls() == "prepare 2; drop 2; prepare 0; compose 1; ", "nothing is rebuilt for one lost frame")
doubleFail("prepare", -8, 2)
expect(code { _ = try draw([avatar], nowS: 0) } == .device, "lost")
expect(code { _ = try draw([avatar], nowS: 0) } == .device, "lost again")
expect(calls() == "prepare 1; drop 1; prepare 2; drop 2; rebuild 0; composer 81; ", "rebuilt")
expect(device.queues == 2, "a new queue")
expect(try draw([avatar], nowS: 0), "drawn by the new one")
expect(calls() == "prepare 0; compose 2; ", "with the new composer")

// A rebuild that fails is tried again a second later; no frame is tried before.
doubleFail("prepare", -8, 3)
doubleFail("rebuild", -8, 1)
expect(code { _ = try draw([avatar], nowS: 10) } == .device, "lost")
expect(code { _ = try draw([avatar], nowS: 10) } == .device, "lost again")
expect(calls() == "prepare 1; drop 1; prepare 2; drop 2; rebuild 0; ", "the rebuild failed")
expect(try !draw([avatar], nowS: 10.9), "left out")
expect(calls() == "", "without a call")
expect(code { _ = try draw([avatar], nowS: 11) } == .device, "still lost")
expect(calls() == "prepare 0; drop 0; rebuild 0; composer 81; ", "rebuilt")
expect(try draw([avatar], nowS: 11), "drawn")
expect(calls().hasPrefix("prepare 1; compose"), "by the new device")

// Splats in a buffer of the app's.
let writing = try stage.begin([], from: [], nowS: 12)!
let layout: [BufferElement<SplatProperty>] = [
    BufferElement(.position, strideBytes: 16), BufferElement(.opacity, offsetBytes: 12, strideBytes: 16),
]
let seen = SplatOptions(splatBudget: 5, eye: SIMD3(1, 2, 3), shDegree: 1)
expect(try stage.writeSplats(of: avatar, layout, into: Fake(), in: writing, seen).count == 4096 / 16, "the rows of the buffer")
expect(try stage.splatCount(of: avatar, seen) == 5, "counted")
expect(calls() == "upload \(writing.slot); write 2; count 5; ", "the layout, eye and budget arrive")
stage.commit(writing)
(writing.commands as! FakeCommands).complete()

// Shadows: a pipeline for each kind of pass, a draw for each shadow that is not empty, and one instance a layer.
let turned = Float(0.5).squareRoot()
try avatar.setPose(Avatar.Pose(rotations: [SIMD4(turned, 0, 0, turned), SIMD4(0, 0, 0, 1)]))  // the square lies at a height of 1 m
let air = try avatar.contactShadow(), floor = try avatar.contactShadow(floorM: 1)
expect(air.darkest == 0 && floor.darkest > 200, "what lies on the floor casts a shadow, and nothing else")
let painted = FakeEncoder()
try stage.drawShadows([air], from: [camera], into: painted, pass: pass)
expect(painted.draws.isEmpty && device.pipelines == 0, "an empty shadow costs nothing")
try stage.drawShadows([floor, air, floor], from: [camera], into: painted, pass: pass)
let layered = MetalPass(colour: .bgra8Unorm_srgb, depth: .depth32Float, layers: 2)
try stage.drawShadows([floor], from: [camera, camera], into: painted, pass: layered)
try stage.drawShadows([floor], from: [camera], into: painted, pass: pass)
expect(painted.draws == [[6, 1, 192], [6, 1, 192], [6, 2, 192], [6, 1, 192]], "\(painted.draws)")
expect(device.libraries == 1 && device.pipelines == 2, "compiled once")

// A format that cannot be drawn into.
doubleFail("composer", -5, 1)
expect(code { try stage.make(MetalPass(colour: .rgba8Unorm)) } == .unsupported, "named by the library")
print("\(checks) checks of the frame loop passed")
