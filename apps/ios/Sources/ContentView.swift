// SPDX-License-Identifier: Apache-2.0
import DoppelUI
import SwiftUI
import UniformTypeIdentifiers

/// The picture, and below it what can be done.
struct ContentView: View {
    @ObservedObject var studio: Studio
    @State private var choosing = false
    @State private var lastDrag = CGSize.zero
    @State private var lastZoom: CGFloat = 1

    var body: some View {
        ZStack {
            if studio.mode != .studio { CameraPicture(studio: studio) }
            if let stage = studio.stage {
                GeometryReader { geometry in
                    AvatarCanvas(stage: stage, scene: studio, transparent: studio.mode != .studio)
                        .gesture(drag(heightPt: geometry.size.height))
                        .gesture(pinch)
                }
                .id(studio.mode)
            }
            VStack {
                if let text = studio.message { Text(text).padding() }
                if let part = studio.progress { ProgressView(value: Double(part)).padding() }
                Spacer()
                controls.padding()
            }
        }
        .fileImporter(isPresented: $choosing, allowedContentTypes: [UTType.data]) { result in
            if case .success(let file) = result { studio.load(file) }
        }
    }

    private var controls: some View {
        VStack {
            HStack {
                Button("Open") { choosing = true }
                Button(studio.isPlaying ? "Pause" : "Play") { studio.isPlaying.toggle() }
                Button("Cancel") { studio.cancelLoad() }.disabled(studio.progress == nil)
            }
            Picker("Mode", selection: $studio.mode) {
                Text("Studio").tag(Studio.Mode.studio)
                Text("In the room").tag(Studio.Mode.room)
                Text("Drive").tag(Studio.Mode.drive)
            }
            .pickerStyle(.segmented)
        }
    }

    private func drag(heightPt: CGFloat) -> some Gesture {
        DragGesture()
            .onChanged { value in
                let way = CGSize(width: value.translation.width - lastDrag.width, height: value.translation.height - lastDrag.height)
                studio.drag(x: Float(way.width / heightPt), y: Float(way.height / heightPt))
                lastDrag = value.translation
            }
            .onEnded { _ in lastDrag = .zero }
    }

    private var pinch: some Gesture {
        MagnificationGesture()
            .onChanged { value in
                studio.zoom(by: Float(value / lastZoom))
                lastZoom = value
            }
            .onEnded { _ in lastZoom = 1 }
    }
}
