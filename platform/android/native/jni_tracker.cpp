// SPDX-License-Identifier: Apache-2.0
// Native methods of trackers: what platforms tell of a person, as poses of an avatar.
#include "platform/android/native/jni_help.h"

namespace dpl::android {
namespace {

/** The library is told one number of joints, so all arrays must have it. False, and an exception: they have not. Null arrays fit. */
bool sameJoints(JNIEnv* env, size_t joints, jfloatArray rotations, jfloatArray positions, jfloatArray confidence) {
    const auto fits = [&](jfloatArray array, size_t floats) { return !array || size_t(env->GetArrayLength(array)) == floats * joints; };
    if (fits(rotations, 4) && fits(positions, 3) && fits(confidence, 1)) return true;
    throwDoppel(env, DPL_ERROR_INVALID_ARGUMENT, "a joint has 4 numbers of rotation, 3 of position and one of confidence");
    return false;
}

size_t jointsOf(JNIEnv* env, jfloatArray positions) {
    return positions ? size_t(env->GetArrayLength(positions)) / 3 : 0;
}

const float* dataOrNull(jfloatArray array, const std::vector<float>& values) {
    return array ? values.data() : nullptr;
}

jlong createTracker(JNIEnv* env, jclass, jlong avatar, jint format, jint flags, jfloatArray restRotations, jfloatArray restPositions) {
    const size_t joints = jointsOf(env, restPositions);
    if (!sameJoints(env, joints, restRotations, restPositions, nullptr)) return 0;
    const std::vector<float> rotations = floatsOf(env, restRotations), positions = floatsOf(env, restPositions);
    DplTrackerInfo info{};
    info.structSize = sizeof info;
    info.format = DplTrackFormat(format);
    info.flags = uint32_t(flags);
    info.restCount = uint32_t(joints);
    info.restRotations = dataOrNull(restRotations, rotations), info.restPositions = dataOrNull(restPositions, positions);
    DplTracker tracker = nullptr;
    return check(env, dplCreateTracker(handleOf<DplAvatar>(avatar), &info, &tracker)) ? numberOf(tracker) : 0;
}

void destroyTracker(JNIEnv* env, jclass, jlong tracker) {
    check(env, dplDestroyTracker(handleOf<DplTracker>(tracker)));
}

jobjectArray trackJointNames(JNIEnv* env, jclass, jint format) {
    std::vector<std::string> names;
    const char* name = nullptr;
    while (dplGetTrackJointName(DplTrackFormat(format), uint32_t(names.size()), &name) == DPL_OK) names.emplace_back(name);
    return textsOf(env, names);
}

void trackFrame(JNIEnv* env, jclass, jlong tracker, jlong timeNs, jfloatArray rotations, jfloatArray positions, jfloatArray confidence) {
    const size_t joints = jointsOf(env, positions);
    if (positions && !sameJoints(env, joints, rotations, positions, confidence)) return;
    const std::vector<float> turns = floatsOf(env, rotations), places = floatsOf(env, positions), trusted = floatsOf(env, confidence);
    DplTrackFrame frame{};
    frame.structSize = sizeof frame;
    frame.jointCount = uint32_t(joints);
    frame.timeNs = timeNs;
    frame.rotations = dataOrNull(rotations, turns), frame.positions = dataOrNull(positions, places);
    frame.confidence = dataOrNull(confidence, trusted);
    check(env, dplTrackFrame(handleOf<DplTracker>(tracker), &frame));
}

/** counts: state, driven joints, frames taken and dropped. measures: rate in Hz, noise in degrees, delay and extrapolation in seconds. */
void setPoseFromTracker(JNIEnv* env, jclass, jlong tracker, jlong displayTimeNs, jlongArray counts, jfloatArray measures) {
    DplTrackerStatus status{};
    status.structSize = sizeof status;
    if (!check(env, dplSetPoseFromTracker(handleOf<DplTracker>(tracker), displayTimeNs, &status))) return;
    write(env, counts, std::vector<jlong>{status.state, status.drivenJoints, status.framesTaken, status.framesDropped});
    write(env, measures, {status.rateHz, status.noiseDeg, status.delayS, status.predictedS});
}

}  // namespace

const std::vector<JNINativeMethod> kTrackerMethods = {
    method("createTracker", "(JII[F[F)J", createTracker),
    method("destroyTracker", "(J)V", destroyTracker),
    method("trackJointNames", "(I)[Ljava/lang/String;", trackJointNames),
    method("trackFrame", "(JJ[F[F[F)V", trackFrame),
    method("setPoseFromTracker", "(JJ[J[F)V", setPoseFromTracker),
};

}  // namespace dpl::android
