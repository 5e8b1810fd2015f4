// SPDX-License-Identifier: Apache-2.0
import SwiftUI

@main
struct DoppelDemoApp: App {
    @StateObject private var studio = Studio()

    var body: some Scene {
        WindowGroup { ContentView(studio: studio) }
    }
}
