// SPDX-License-Identifier: Apache-2.0
package org.doppel;

import java.nio.ByteBuffer;
import java.nio.FloatBuffer;

/**
 * The functions of the C API as they cross to native code, where JNI_OnLoad registers them. Apps use the Kotlin classes.
 * Handles are numbers, which the library checks; buffers are direct. Every method throws DoppelException.
 */
final class Native {
    private Native() {}

    static {
        // The property names a file for tests on a desktop.
        String file = System.getProperty("org.doppel.library");
        if (file != null) {
            System.load(file);
        } else {
            System.loadLibrary("doppel_jni");
        }
    }

    static native int version();

    static native long createContext(int renderer, int threads, int fill, String cacheFolder);
    static native void destroyContext(long context);
    static native String rendererName(long context);
    static native void setDetail(long context, float splatsPerPixel, int splatBudget);
    static native void setFrameBudget(long context, double milliseconds);
    static native void setMemoryLimit(long context, long bytes);
    static native void render(long context, long[] avatars, float[] cameras, FloatBuffer[] sceneDepths, ByteBuffer[] rgbas,
            FloatBuffer[] depths);

    static native long loadAvatar(long context, ByteBuffer buffer, long offset, long size);
    static native void destroyAvatar(long avatar);
    static native String avatarName(long avatar);
    static native void avatarInfo(long avatar, long[] counts, float[] bounds);
    static native String[] jointNames(long avatar);
    static native float[] jointTree(long avatar);
    static native int findJoint(long avatar, String name);
    static native void setPose(long avatar, float[] rotations, float[] root);
    static native void setPoseAtTime(long avatar, float[] rotations, float[] root, long timeNs);
    static native void setTransform(long avatar, float[] rows);
    static native void getTransform(long avatar, float[] rows);
    static native void settle(long avatar);
    static native byte[] motionState(long avatar);
    static native void setMotionState(long avatar, byte[] state);
    static native void setClothStiffness(long avatar, float stiffness);
    static native String[] expressionNames(long avatar);
    static native boolean isExpressionDrawn(long avatar, int expression);
    static native void setExpression(long avatar, float[] weights);
    static native void setExpressionNamed(long avatar, String[] names, float[] weights);
    static native float[] expression(long avatar);
    static native void getPose(long avatar, float[] rotations, float[] root);
    static native void jointPositions(long avatar, float[] positions);
    static native String clipName(long avatar, int clip);
    static native double clipDuration(long avatar, int clip);
    static native void setPoseFromClip(long avatar, int clip, double timeS, boolean loop);
    static native int loadClip(long avatar, ByteBuffer buffer, long offset, long size, int flags, String name);
    static native void setPoseFromClips(long avatar, double[] layers, long timeNs);
    static native void joinClipLayer(long avatar, double[] before, double[] layer);
    static native void lookAtPoint(long avatar, float[] gaze);
    static native void setFaceMotion(long avatar, long timeNs, int seed, float[] motion, long heardNs);
    static native byte[] contactShadow(long avatar, boolean onFloor, float floorM, float[] place);
    static native String[] layerNames(long avatar);
    static native boolean isLayerHidden(long avatar, int layer);
    static native void hideLayer(long avatar, int layer, boolean hidden);
    static native boolean pick(long[] avatars, float[] ray, int[] indices, float[] place);
    static native long[] writeSplats(long avatar, long[] layout, ByteBuffer buffer, int splatBudget, float[] eye, int shDegree);
    static native long[] writeMesh(long avatar, long[] layout, ByteBuffer buffer);
    static native void poseTrust(long avatar, float[] trust, float[] distances);
    static native void holdPose(long avatar, float limit);
    static native void frameStats(long avatar, long[] counts, double[] times);

    static native long startLoad(long context, ByteBuffer buffer, long offset, long size);
    static native void loadStatus(long load, float[] status);
    static native long finishLoad(long load);
    static native void cancelLoad(long load);

    static native long createTracker(long avatar, int format, int flags, float[] restRotations, float[] restPositions);
    static native void destroyTracker(long tracker);
    static native String[] trackJointNames(int format);
    static native void trackFrame(long tracker, long timeNs, float[] rotations, float[] positions, float[] confidence);
    static native void setPoseFromTracker(long tracker, long displayTimeNs, long[] counts, float[] measures);

    static native long createView(int fill, String cacheFolder, boolean validation);
    static native void destroyView(long view);
    static native long viewContext(long view);
    static native void setWindow(long view, Object surface, int width, int height);
    static native int drawView(long view, long[] avatars, float[] camera, FloatBuffer sceneDepth, float red, float green,
            float blue, boolean shadows);
    static native String[] viewComplaints(long view);
}
