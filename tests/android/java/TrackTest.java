// SPDX-License-Identifier: Apache-2.0
package org.doppel;

import static org.doppel.Checks.expect;
import static org.doppel.Checks.expectError;
import static org.doppel.Checks.floats;

import java.nio.ByteBuffer;
import java.nio.ByteOrder;
import java.nio.FloatBuffer;
import java.nio.file.Path;
import java.util.Arrays;
import java.util.List;

/** Trackers, trust in poses, two views and depth through the natives. */
final class TrackTest {
    private static final int SOFTWARE = 1;
    private static final int QUADS = 1;
    private static final int VRM = 0;
    private static final int ARKIT_BODY = 2;
    private static final int MEDIAPIPE_POSE = 5;
    private static final int RAW = 1;
    private static final int PIXELS = Checks.WIDTH * Checks.HEIGHT;
    private static final long SECOND = 1_000_000_000L;
    private static final int INVALID = DoppelException.INVALID_ARGUMENT;

    private final long context = Native.createContext(SOFTWARE, 1, QUADS, null);
    private final long person;
    private final long tiny;
    private final int elbow;
    // A frame in VRM's T-pose, which is the rest pose of the person of the tests.
    private final List<String> names = Arrays.asList(Native.trackJointNames(VRM));
    private final float[] rotations = new float[4 * names.size()];
    private final float[] positions = new float[3 * names.size()];
    private final float[] confidence = new float[names.size()];

    private TrackTest(Path work) throws Exception {
        ByteBuffer file = Checks.mapped(work.resolve("person.glb"));
        person = Native.loadAvatar(context, file, 0, file.capacity());
        ByteBuffer other = Checks.mapped(work.resolve("avatar.glb"));
        tiny = Native.loadAvatar(context, other, 0, other.capacity());
        elbow = Native.findJoint(person, "leftLowerArm");
        String[] joints = Native.jointNames(person);
        float[] tree = Native.jointTree(person);
        for (int j = 0; j < joints.length / 2; j++) {
            int at = names.indexOf(joints[2 * j + 1]);
            if (at < 0) continue;
            System.arraycopy(tree, 4 * j + 1, positions, 3 * at, 3);
            rotations[4 * at + 3] = 1;
            confidence[at] = 1;
        }
    }

    public static void main(String[] arguments) throws Exception {
        TrackTest test = new TrackTest(Checks.work(arguments));
        test.formatsNameTheirJoints();
        test.aBentElbowReachesTheAvatar();
        test.gapsAndNumbersThatAreNoneDoNoHarm();
        test.mistakesAreExceptions();
        test.trustNamesTheJointThatIsFarAway();
        test.twoViewsAreThoseOfOne();
        test.depthGoesOutAndComesBackAsAScene();
        test.wrongBuffersAreExceptions();
        Native.destroyAvatar(test.person);
        Native.destroyAvatar(test.tiny);
        Native.destroyContext(test.context);
        System.exit(Checks.exitCode());
    }

    private void formatsNameTheirJoints() {
        int[] counts = {55, 55, 91, 70, 53, 33};
        for (int format = 0; format < counts.length; format++) {
            String[] joints = Native.trackJointNames(format);
            expect(joints.length == counts[format],
                    "format " + format + " has " + joints.length + " joints, the last " + joints[joints.length - 1]);
        }
        expect(Native.trackJointNames(99).length == 0, "a format that is not there has none");
    }

    /** The left lower arm and what hangs on it, turned by a right angle about y. */
    private float[] bent(float[] turns) {
        float[] places = positions.clone();
        int pivot = names.indexOf("leftLowerArm");
        float half = (float) Math.sqrt(0.5);
        for (int j = 0; j < names.size(); j++) {
            String name = names.get(j);
            boolean below = j == pivot || name.startsWith("leftHand") || name.matches("left(Thumb|Index|Middle|Ring|Little).*");
            if (!below) continue;
            turns[4 * j + 1] = -half;
            turns[4 * j + 3] = half;
            float x = positions[3 * j] - positions[3 * pivot];
            float z = positions[3 * j + 2] - positions[3 * pivot + 2];
            places[3 * j] = positions[3 * pivot] - z;
            places[3 * j + 2] = positions[3 * pivot + 2] + x;
        }
        return places;
    }

    private float elbowY() {
        float[] pose = new float[4 * (Native.jointNames(person).length / 2)];
        Native.getPose(person, pose, null);
        return pose[4 * elbow + 1];
    }

    private void aBentElbowReachesTheAvatar() {
        // With the avatar's own rest pose, turns are taken over as they are. Bones that it lacks are told by numbers that are none.
        float[] restTurns = rotations.clone();
        float[] restPlaces = positions.clone();
        for (int j = 0; j < names.size(); j++) {
            if (confidence[j] != 0) continue;
            Arrays.fill(restTurns, 4 * j, 4 * j + 4, Float.NaN);
            Arrays.fill(restPlaces, 3 * j, 3 * j + 3, Float.NaN);
        }
        long tracker = Native.createTracker(person, VRM, RAW, restTurns, restPlaces);
        long[] counts = new long[4];
        float[] measures = new float[4];
        Native.setPoseFromTracker(tracker, SECOND, counts, measures);
        expect(counts[0] == 0 && counts[1] == 0 && elbowY() == 0, "before the first frame nothing is driven");
        float[] turns = rotations.clone();
        float[] places = bent(turns);
        for (int frame = 1; frame <= 60; frame++) Native.trackFrame(tracker, SECOND + frame * SECOND / 60, turns, places, confidence);
        for (int frame = 1; frame <= 60; frame++) Native.setPoseFromTracker(tracker, SECOND + frame * SECOND / 60, counts, measures);
        expect(counts[0] == 1 && counts[2] == 60 && counts[3] == 0 && counts[1] > 30, "frames are taken: " + Arrays.toString(counts));
        expect(Math.abs(elbowY() + Math.sqrt(0.5)) < 1e-3, "the avatar's elbow is bent by a right angle: y " + elbowY());
        expect(Math.abs(measures[0] - 60) < 1, "the stream's rate: " + measures[0]);
        Native.destroyTracker(tracker);
    }

    private void gapsAndNumbersThatAreNoneDoNoHarm() {
        long tracker = Native.createTracker(person, VRM, 0, null, null);
        long[] counts = new long[4];
        float[] broken = positions.clone();
        for (int i = 0; i < broken.length; i += 7) broken[i] = i % 2 == 0 ? Float.NaN : Float.POSITIVE_INFINITY;
        float[] noTurns = new float[rotations.length];
        for (int frame = 0; frame < 30; frame++) {
            boolean gap = frame % 10 > 6;
            if (!gap) Native.trackFrame(tracker, SECOND + frame * SECOND / 30, frame % 3 == 0 ? noTurns : rotations,
                    frame % 2 == 0 ? broken : positions, null);
            Native.setPoseFromTracker(tracker, SECOND + frame * SECOND / 30, counts, null);
        }
        float[] pose = new float[4 * (Native.jointNames(person).length / 2)];
        Native.getPose(person, pose, null);
        boolean finite = true;
        for (float value : pose) finite &= Float.isFinite(value);
        expect(finite, "numbers that are none do not reach the pose");
        Native.setPoseFromTracker(tracker, 10 * SECOND, counts, null);
        expect(counts[0] == 2, "after seconds without a frame the person is lost");
        Native.destroyTracker(tracker);
    }

    private void mistakesAreExceptions() {
        expectError(INVALID, "91 joints", "a format that needs a rest", () -> Native.createTracker(person, ARKIT_BODY, 0, null, null));
        expectError(INVALID, "restCount", "a rest of too few joints",
                () -> Native.createTracker(person, VRM, 0, new float[4], new float[3]));
        expectError(INVALID, "4 numbers of rotation", "a rest without the same joints",
                () -> Native.createTracker(person, VRM, 0, new float[4], new float[6]));
        expectError(INVALID, "flags", "flags that are not there", () -> Native.createTracker(person, VRM, 64, null, null));
        expectError(INVALID, "", "a format that is not there", () -> Native.createTracker(person, 99, 0, null, null));
        expectError(DoppelException.UNSUPPORTED, "", "an avatar without a humanoid", () -> Native.createTracker(tiny, VRM, 0, null, null));
        expectError(INVALID, "", "a tracker of a context", () -> Native.createTracker(context, VRM, 0, null, null));
        long tracker = Native.createTracker(person, VRM, 0, null, null);
        expectError(INVALID, "has 55 joints", "a frame of another format",
                () -> Native.trackFrame(tracker, 1, new float[4 * 33], new float[3 * 33], null));
        expectError(INVALID, "4 numbers of rotation", "too few rotations",
                () -> Native.trackFrame(tracker, 1, new float[8], positions, null));
        expectError(INVALID, "one of confidence", "too few values of confidence",
                () -> Native.trackFrame(tracker, 1, rotations, positions, new float[3]));
        expectError(INVALID, "4 numbers of rotation", "a position that is cut",
                () -> Native.trackFrame(tracker, 1, rotations, new float[3 * 55 + 1], null));
        expectError(INVALID, "", "no positions", () -> Native.trackFrame(tracker, 1, rotations, null, null));
        expectError(INVALID, "", "no rotations", () -> Native.trackFrame(tracker, 1, null, positions, null));
        float[] swapped = positions.clone();
        for (int i = 0; i < swapped.length; i += 3) swapped[i] = -swapped[i];
        expectError(DoppelException.CORRUPT_DATA, "", "left and right swapped",
                () -> Native.trackFrame(tracker, 1, rotations, swapped, confidence));
        Native.destroyTracker(tracker);
        expectError(INVALID, "not a live tracker", "a tracker that was destroyed",
                () -> Native.trackFrame(tracker, 1, rotations, positions, null));
        expectError(INVALID, "not a live tracker", "and poses no more", () -> Native.setPoseFromTracker(tracker, 1, null, null));
        expectError(INVALID, "", "and is not destroyed twice", () -> Native.destroyTracker(tracker));
        long points = Native.createTracker(person, MEDIAPIPE_POSE, 0, null, null);
        expectError(INVALID, "has 33 joints", "points of another format", () -> Native.trackFrame(points, 1, null, positions, null));
        Native.destroyTracker(points);
    }

    private void trustNamesTheJointThatIsFarAway() {
        float[] trust = new float[5];
        int joints = Native.jointNames(person).length / 2;
        float[] distances = new float[joints];
        float[] pose = new float[4 * joints];
        for (int j = 0; j < joints; j++) pose[4 * j + 3] = 1;
        Native.setPose(person, pose, null);
        Native.poseTrust(person, trust, distances);
        expect(trust[0] == 1, "the mean of training is trusted: " + Arrays.toString(trust));
        pose[4 * elbow + 1] = 1;
        pose[4 * elbow + 3] = 0;
        Native.setPose(person, pose, null);
        Native.poseTrust(person, trust, distances);
        expect(trust[0] < 0.5f && trust[3] == elbow && trust[4] == distances[elbow] && trust[4] > 4,
                "a joint that is turned by 180 degrees: " + Arrays.toString(trust));
        Native.poseTrust(person, trust, null);
        expect(trust[3] == elbow, "distances may be left out");
        Native.holdPose(person, 4);
        Native.poseTrust(person, trust, distances);
        expect(trust[4] < 4.01f, "a pose that is held stays near: " + trust[4]);
        expectError(INVALID, "", "distances of another rig", () -> Native.poseTrust(person, trust, new float[3]));
        expectError(INVALID, "", "a limit that is not a number", () -> Native.holdPose(person, Float.NaN));
        expectError(INVALID, "", "a limit of 0", () -> Native.holdPose(person, 0));
        expectError(DoppelException.UNSUPPORTED, "", "an avatar that knows no trained poses", () -> Native.poseTrust(tiny, trust, null));
    }

    private static byte[] bytes(ByteBuffer buffer) {
        byte[] all = new byte[buffer.capacity()];
        buffer.duplicate().get(all);
        return all;
    }

    private static ByteBuffer image() {
        return ByteBuffer.allocateDirect(4 * PIXELS);
    }

    private void twoViewsAreThoseOfOne() {
        float[] right = Checks.CAMERA.clone();
        right[9] -= 0.064f;
        float[] both = Arrays.copyOf(Checks.CAMERA, 36);
        System.arraycopy(right, 0, both, 18, 18);
        ByteBuffer[] eyes = {image(), image()};
        Native.render(context, new long[] {tiny}, both, null, eyes, null);
        ByteBuffer alone = image();
        Checks.render(context, new long[] {tiny}, Checks.CAMERA, alone);
        expect(Arrays.equals(bytes(eyes[0]), bytes(alone)), "the left eye sees what one view sees");
        Checks.render(context, new long[] {tiny}, right, alone);
        expect(Arrays.equals(bytes(eyes[1]), bytes(alone)) && !Arrays.equals(bytes(eyes[0]), bytes(eyes[1])),
                "and the right one what its view sees");
    }

    private void depthGoesOutAndComesBackAsAScene() {
        FloatBuffer depth = floats(PIXELS);
        ByteBuffer whole = image();
        Native.render(context, new long[] {tiny}, Checks.CAMERA, null, new ByteBuffer[] {whole}, new FloatBuffer[] {depth});
        int drawn = Checks.redPixels(bytes(whole));
        float middle = depth.get(Checks.HEIGHT / 2 * Checks.WIDTH + Checks.WIDTH / 2);
        expect(drawn > 500 && Math.abs(middle - 2) < 0.01f && depth.get(0) == 0, "the depth of a square two metres away: " + middle);
        FloatBuffer scene = floats(PIXELS);
        for (int y = 0; y < Checks.HEIGHT; y++)
            for (int x = 0; x < Checks.WIDTH; x++) scene.put(y * Checks.WIDTH + x, x < Checks.WIDTH / 2 ? 1.5f : 2.5f);
        ByteBuffer half = image();
        Native.render(context, new long[] {tiny}, Checks.CAMERA, new FloatBuffer[] {scene}, new ByteBuffer[] {half}, null);
        int left = Checks.redPixels(bytes(half));
        expect(Math.abs(left - drawn / 2) < drawn / 20, "a wall before its left half hides that: " + left + " of " + drawn + " pixels");
        byte[] pixels = bytes(half);
        int at = 4 * (Checks.HEIGHT / 2 * Checks.WIDTH + Checks.WIDTH / 2 - 8);
        expect(pixels[at + 3] == 0 && pixels[at + 4 * 16 + 3] != 0, "and shows the right half");
    }

    private void wrongBuffersAreExceptions() {
        long[] avatars = {tiny};
        ByteBuffer[] one = {image()};
        expectError(INVALID, "as many buffers", "one image for two views",
                () -> Native.render(context, avatars, new float[36], null, one, null));
        expectError(INVALID, "one or two cameras", "three views", () -> Native.render(context, avatars, new float[54], null, one, null));
        expectError(INVALID, "one or two cameras", "no view", () -> Native.render(context, avatars, new float[0], null, null, null));
        expectError(INVALID, "FloatBuffer", "depth on the heap",
                () -> Native.render(context, avatars, Checks.CAMERA, null, one, new FloatBuffer[] {FloatBuffer.allocate(PIXELS)}));
        expectError(INVALID, "", "depth that is too small",
                () -> Native.render(context, avatars, Checks.CAMERA, null, one, new FloatBuffer[] {floats(9)}));
        expectError(INVALID, "", "a scene that is too small",
                () -> Native.render(context, avatars, Checks.CAMERA, new FloatBuffer[] {floats(9)}, one, null));
        expectError(INVALID, "FloatBuffer", "a scene on the heap",
                () -> Native.render(context, avatars, Checks.CAMERA, new FloatBuffer[] {FloatBuffer.allocate(PIXELS)}, one, null));
        ByteBuffer odd = ByteBuffer.allocateDirect(4 * PIXELS + 1);
        odd.position(1);
        FloatBuffer oddFloats = odd.slice().order(ByteOrder.nativeOrder()).asFloatBuffer();
        expectError(INVALID, "FloatBuffer", "a scene at an odd address",
                () -> Native.render(context, avatars, Checks.CAMERA, new FloatBuffer[] {oddFloats}, one, null));
    }
}
