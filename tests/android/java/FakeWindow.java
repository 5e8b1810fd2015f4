// SPDX-License-Identifier: Apache-2.0
package org.doppel;

/** A window of tests, given to native code as if it were an android.view.Surface. */
final class FakeWindow implements AutoCloseable {
    // Results of Vulkan that tests ask for.
    static final int OUT_OF_DATE = -1000001004;
    static final int SURFACE_LOST = -1000000000;
    static final int DEVICE_LOST = -4;
    static final int OUT_OF_HOST_MEMORY = -1;
    // Transforms and formats.
    static final int UPRIGHT = 1;
    static final int QUARTER_TURN = 2;
    static final int RGBA8 = 37;
    static final int RGB565 = 4;

    long number; // read by host_platform.cpp

    FakeWindow(int width, int height) {
        number = make(width, height);
    }

    void set(String name, int value) {
        set(number, name, value);
    }

    long users() { return state()[0]; }
    long surfaces() { return state()[1]; }
    long swapchains() { return state()[2]; }
    long shownCount() { return state()[3]; }
    int shownWidth() { return (int) state()[4]; }
    int shownHeight() { return (int) state()[5]; }
    long wrong() { return state()[6]; }

    byte[] shown() {
        return shown(number);
    }

    private long[] state() {
        long[] out = new long[7];
        state(number, out);
        return out;
    }

    @Override
    public void close() {
        destroy(number);
        number = 0;
    }

    private static native long make(int width, int height);
    private static native void destroy(long number);
    private static native void set(long number, String name, int value);
    private static native void state(long number, long[] out);
    private static native byte[] shown(long number);
}
