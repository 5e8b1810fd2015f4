// SPDX-License-Identifier: Apache-2.0
package org.doppel

/** How a frame ended. The order is that of Outcome in surface_renderer.h, where each is explained. */
enum class Outcome {
    SHOWN,

    /** There is no window. Nothing was drawn, and loads wait. */
    NO_WINDOW,

    /** The display gave no image in time. */
    SKIPPED,

    /** The surface was lost in this frame. The next one tries again; Android tells surfaceDestroyed if it is gone for good. */
    SURFACE_LOST,

    /** The GPU was lost in this frame. The next one opens it again and moves the avatars there. */
    DEVICE_LOST
}
