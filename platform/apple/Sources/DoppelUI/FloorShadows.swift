// SPDX-License-Identifier: Apache-2.0
#if canImport(Metal)
    import CDoppel
    import Doppel
    import Metal

    /// Draws contact shadows into a render pass, before the avatars are composed: black of their alpha, premultiplied, without depth. One
    /// thread.
    final class FloorShadows {
        /// Part of the light on a floor that comes evenly from above and that a contact shadow may take.
        static let strength: Float = 0.7

        private static let source = """
            #include <metal_stdlib>
            using namespace metal;
            struct Placed { float4x4 clipFromWorld[2]; float4 corner, across, along; float4 strength; };
            struct Corner { float4 position [[position]]; float2 place [[user(place)]]; };
            struct LayerCorner { float4 position [[position]]; float2 place [[user(place)]]; uint layer [[render_target_array_index]]; };

            static float2 placeOf(uint v) { return float2(v == 1 || v == 4 || v == 5 ? 1 : 0, v == 2 || v == 3 || v == 5 ? 1 : 0); }
            static float4 project(constant Placed& p, float2 at, uint view) {
                return p.clipFromWorld[view] * float4((p.corner + at.x * p.across + at.y * p.along).xyz, 1);
            }
            vertex Corner shadowCorner(uint v [[vertex_id]], constant Placed& p [[buffer(0)]]) {
                return { project(p, placeOf(v), 0), placeOf(v) };
            }
            vertex LayerCorner shadowLayerCorner(uint v [[vertex_id]], uint view [[instance_id]], constant Placed& p [[buffer(0)]]) {
                return { project(p, placeOf(v), view), placeOf(v), view };
            }
            struct Seen { float2 place [[user(place)]]; };
            fragment float4 shadowAlpha(Seen seen [[stage_in]], constant Placed& p [[buffer(0)]], constant uchar* alpha [[buffer(1)]]) {
                const float side = 64;
                float2 at = clamp(seen.place * side - 0.5, 0.0, side - 1.001);
                uint2 first = uint2(at);
                float2 part = at - float2(first);
                constant uchar* row = alpha + first.y * uint(side) + first.x;
                float top = mix(float(row[0]), float(row[1]), part.x), bottom = mix(float(row[64]), float(row[65]), part.x);
                return float4(0, 0, 0, p.strength.x * mix(top, bottom, part.y) / 255);
            }
            """

        private var library: (any MTLLibrary)?
        private var pipelines: [MetalPass: any MTLRenderPipelineState] = [:]

        /// cameras: one; with layers one for each. x, y: of the picture's top left corner, pixels.
        func draw(
            _ shadows: [ContactShadow], from cameras: [Camera], on device: any MTLDevice, into encoder: any MTLRenderCommandEncoder,
            pass: MetalPass, x: Int, y: Int
        ) throws(DoppelError) {
            guard let first = cameras.first, shadows.contains(where: { $0.darkest > 0 }) else { return }
            encoder.setRenderPipelineState(try pipeline(pass, device))
            encoder.setViewport(
                MTLViewport(
                    originX: Double(x), originY: Double(y), width: Double(first.raw.widthPx), height: Double(first.raw.heightPx), znear: 0,
                    zfar: 1))
            for shadow in shadows where shadow.darkest > 0 {
                var placed = FloorShadows.clipFromWorld(first.raw) + FloorShadows.clipFromWorld((cameras.last ?? first).raw)
                for v in [shadow.corner, shadow.across, shadow.along, SIMD3(FloorShadows.strength, 0, 0)] { placed += [v.x, v.y, v.z, 0] }
                let bytes = placed.count * MemoryLayout<Float>.stride
                guard let alpha = device.makeBuffer(bytes: shadow.alpha, length: shadow.alpha.count, options: []) else {
                    throw DoppelError(.outOfMemory, "\(device.name) gives no buffer")
                }
                encoder.setVertexBytes(placed, length: bytes, index: 0)
                encoder.setFragmentBytes(placed, length: bytes, index: 0)
                encoder.setFragmentBuffer(alpha, offset: 0, index: 1)
                encoder.drawPrimitives(type: .triangle, vertexStart: 0, vertexCount: 6, instanceCount: max(pass.layers, 1))
            }
        }

        private func pipeline(_ pass: MetalPass, _ device: any MTLDevice) throws(DoppelError) -> any MTLRenderPipelineState {
            if let known = pipelines[pass] { return known }
            do {
                let library = try self.library ?? device.makeLibrary(source: FloorShadows.source, options: nil)
                self.library = library
                let descriptor = MTLRenderPipelineDescriptor()
                descriptor.vertexFunction = library.makeFunction(name: pass.layers > 0 ? "shadowLayerCorner" : "shadowCorner")
                descriptor.fragmentFunction = library.makeFunction(name: "shadowAlpha")
                descriptor.rasterSampleCount = pass.samples
                descriptor.inputPrimitiveTopology = .triangle
                descriptor.depthAttachmentPixelFormat = pass.depth
                let colour = descriptor.colorAttachments[0]!
                colour.pixelFormat = pass.colour
                colour.isBlendingEnabled = true
                colour.sourceRGBBlendFactor = .one
                colour.sourceAlphaBlendFactor = .one
                colour.destinationRGBBlendFactor = .oneMinusSourceAlpha
                colour.destinationAlphaBlendFactor = .oneMinusSourceAlpha
                let made = try device.makeRenderPipelineState(descriptor: descriptor)
                pipelines[pass] = made
                return made
            } catch {
                throw DoppelError(.unsupported, "\(device.name) cannot draw shadows: \(error)")
            }
        }

        /// clip = (2 fx/w x + (2 cx/w - 1) z, -(2 fy/h y + (2 cy/h - 1) z), near, z) of view coordinates, column by column. Metal's y
        /// points up.
        private static func clipFromWorld(_ view: DplCamera) -> [Float] {
            let m = withUnsafeBytes(of: view.viewFromWorld) { Array($0.bindMemory(to: Float.self)) }
            let width = Float(view.widthPx), height = Float(view.heightPx)
            let sx = 2 * view.fx / width, ox = 2 * view.cx / width - 1
            let sy = 2 * view.fy / height, oy = 2 * view.cy / height - 1
            return (0..<4).flatMap { column -> [Float] in
                [sx * m[column] + ox * m[8 + column], -(sy * m[4 + column] + oy * m[8 + column]), column == 3 ? 0.05 : 0, m[8 + column]]
            }
        }
    }
#endif
