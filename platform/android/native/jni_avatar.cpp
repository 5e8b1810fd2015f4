// SPDX-License-Identifier: Apache-2.0
// Native methods of avatars: what they are, how they stand, what they cost.
#include <algorithm>

#include "platform/android/native/jni_camera.h"
#include "platform/android/native/jni_help.h"

namespace dpl::android {
namespace {

DplAvatar avatarOf(jlong number) {
    return handleOf<DplAvatar>(number);
}

/** The information about an avatar; nothing, and an exception, if it is gone. */
std::optional<DplAvatarInfo> infoOf(JNIEnv* env, jlong avatar) {
    DplAvatarInfo info{};
    info.structSize = sizeof info;
    if (!check(env, dplGetAvatarInfo(avatarOf(avatar), &info))) return std::nullopt;
    return info;
}

/** The same of a layer. */
std::optional<DplLayerInfo> layerOf(JNIEnv* env, jlong avatar, uint32_t layer) {
    DplLayerInfo info{};
    info.structSize = sizeof info;
    if (!check(env, dplGetLayerInfo(avatarOf(avatar), layer, &info))) return std::nullopt;
    return info;
}

jlong loadAvatar(JNIEnv* env, jclass, jlong context, jobject buffer, jlong offset, jlong size) {
    const auto bytes = bytesOf(env, buffer, offset, size);
    if (!bytes) return 0;
    DplAvatar avatar = nullptr;
    return check(env, dplLoadAvatar(handleOf<DplContext>(context), bytes->data, bytes->size, &avatar)) ? numberOf(avatar) : 0;
}

void destroyAvatar(JNIEnv* env, jclass, jlong avatar) {
    check(env, dplDestroyAvatar(avatarOf(avatar)));
}

jstring avatarName(JNIEnv* env, jclass, jlong avatar) {
    const auto info = infoOf(env, avatar);
    return info ? toJava(env, info->name) : nullptr;
}

/** counts: joints, splats, vertices, triangles, layers, clips, SH degree, splats and SH degree of the file, whether its axes are stated.
 *  bounds: least, then most. */
void avatarInfo(JNIEnv* env, jclass, jlong avatar, jlongArray counts, jfloatArray bounds) {
    const auto info = infoOf(env, avatar);
    if (!info) return;
    DplFileAxes axes{};
    axes.structSize = sizeof axes;
    if (!check(env, dplGetFileAxes(avatarOf(avatar), &axes))) return;
    write(env, counts,
          std::vector<jlong>{info->jointCount, info->splatCount, info->vertexCount, info->triangleCount, info->layerCount, info->clipCount,
                             info->shDegree, info->fileSplatCount, info->fileShDegree, axes.stated});
    std::vector<float> box(info->restMin, info->restMin + 3);
    box.insert(box.end(), info->restMax, info->restMax + 3);
    write(env, bounds, box);
}

/** Name, then humanoid bone or "", of each joint. */
jobjectArray jointNames(JNIEnv* env, jclass, jlong avatar) {
    const auto info = infoOf(env, avatar);
    if (!info) return nullptr;
    std::vector<std::string> names;
    for (uint32_t j = 0; j < info->jointCount; ++j) {
        DplJointInfo joint{};
        joint.structSize = sizeof joint;
        if (!check(env, dplGetJointInfo(avatarOf(avatar), j, &joint))) return nullptr;
        names.insert(names.end(), {joint.name, joint.humanoidBone});
    }
    return textsOf(env, names);
}

/** Null, and an exception: out of memory. */
jfloatArray floatsToJava(JNIEnv* env, const std::vector<float>& numbers) {
    jfloatArray made = env->NewFloatArray(jsize(numbers.size()));
    if (made) write(env, made, numbers);
    return made;
}

/** Four numbers a joint: the index of its parent or -1, and its place at rest. */
jfloatArray jointTree(JNIEnv* env, jclass, jlong avatar) {
    const auto info = infoOf(env, avatar);
    if (!info) return nullptr;
    std::vector<float> numbers;
    for (uint32_t j = 0; j < info->jointCount; ++j) {
        DplJointInfo joint{};
        joint.structSize = sizeof joint;
        if (!check(env, dplGetJointInfo(avatarOf(avatar), j, &joint))) return nullptr;
        numbers.push_back(float(joint.parent));
        numbers.insert(numbers.end(), joint.restPosition, joint.restPosition + 3);
    }
    return floatsToJava(env, numbers);
}

jint findJoint(JNIEnv* env, jclass, jlong avatar, jstring name) {
    uint32_t joint = 0;
    return check(env, dplFindJoint(avatarOf(avatar), toUtf8(env, name).c_str(), &joint)) ? jint(joint) : 0;
}

/** set: gives rotations, joint count and root translation to the library. */
template <class Set>
void setPoseBy(JNIEnv* env, jfloatArray rotations, jfloatArray root, const Set& set) {
    const std::vector<float> values = floatsOf(env, rotations), place = floatsOf(env, root);
    if (values.size() % 4 != 0 || (root && place.size() != 3))
        return throwDoppel(env, DPL_ERROR_INVALID_ARGUMENT, "a pose has 4 numbers a joint and a root translation of 3 numbers or none");
    check(env, set(values.data(), uint32_t(values.size() / 4), root ? place.data() : nullptr));
}

void setPose(JNIEnv* env, jclass, jlong avatar, jfloatArray rotations, jfloatArray root) {
    setPoseBy(env, rotations, root,
              [&](const float* r, uint32_t joints, const float* t) { return dplSetPose(avatarOf(avatar), r, joints, t); });
}

void setPoseAtTime(JNIEnv* env, jclass, jlong avatar, jfloatArray rotations, jfloatArray root, jlong timeNs) {
    setPoseBy(env, rotations, root,
              [&](const float* r, uint32_t joints, const float* t) { return dplSetPoseAtTime(avatarOf(avatar), r, joints, t, timeNs); });
}

void settle(JNIEnv* env, jclass, jlong avatar) {
    check(env, dplSettle(avatarOf(avatar)));
}

/** Null, and an exception: out of memory. */
jbyteArray bytesToJava(JNIEnv* env, const std::vector<uint8_t>& bytes) {
    jbyteArray made = env->NewByteArray(jsize(bytes.size()));
    if (made) env->SetByteArrayRegion(made, 0, jsize(bytes.size()), reinterpret_cast<const jbyte*>(bytes.data()));
    return made;
}

jbyteArray motionState(JNIEnv* env, jclass, jlong avatar) {
    size_t size = 0;
    if (!check(env, dplGetMotionState(avatarOf(avatar), nullptr, 0, &size))) return nullptr;
    std::vector<uint8_t> state(size);
    if (!check(env, dplGetMotionState(avatarOf(avatar), state.data(), state.size(), &size))) return nullptr;
    return bytesToJava(env, state);
}

void setMotionState(JNIEnv* env, jclass, jlong avatar, jbyteArray state) {
    std::vector<uint8_t> bytes(state ? size_t(env->GetArrayLength(state)) : 0);
    if (state) env->GetByteArrayRegion(state, 0, jsize(bytes.size()), reinterpret_cast<jbyte*>(bytes.data()));
    check(env, dplSetMotionState(avatarOf(avatar), bytes.data(), bytes.size()));
}

void setClothStiffness(JNIEnv* env, jclass, jlong avatar, jfloat stiffness) {
    check(env, dplSetClothStiffness(avatarOf(avatar), stiffness));
}

std::optional<DplExpressionInfo> expressionOf(JNIEnv* env, jlong avatar, uint32_t expression) {
    DplExpressionInfo info{};
    info.structSize = sizeof info;
    if (!check(env, dplGetExpressionInfo(avatarOf(avatar), expression, &info))) return std::nullopt;
    return info;
}

jobjectArray expressionNames(JNIEnv* env, jclass, jlong avatar) {
    std::vector<std::string> names;
    for (uint32_t e = 0; e < DPL_EXPRESSION_COUNT; ++e) {
        const auto info = expressionOf(env, avatar, e);
        if (!info) return nullptr;
        names.push_back(info->name);
    }
    return textsOf(env, names);
}

jboolean isExpressionDrawn(JNIEnv* env, jclass, jlong avatar, jint expression) {
    const auto info = expressionOf(env, avatar, uint32_t(expression));
    return info && info->drawn ? JNI_TRUE : JNI_FALSE;
}

void setExpression(JNIEnv* env, jclass, jlong avatar, jfloatArray weights) {
    const std::vector<float> values = floatsOf(env, weights);
    check(env, dplSetExpression(avatarOf(avatar), values.data(), uint32_t(values.size())));
}

void setExpressionNamed(JNIEnv* env, jclass, jlong avatar, jobjectArray names, jfloatArray weights) {
    const std::vector<float> values = floatsOf(env, weights);
    const jsize count = names ? env->GetArrayLength(names) : 0;
    if (values.size() != size_t(count)) return throwDoppel(env, DPL_ERROR_INVALID_ARGUMENT, "a weight is needed for each name");
    std::vector<std::string> texts;
    for (jsize i = 0; i < count; ++i) {
        const auto name = static_cast<jstring>(env->GetObjectArrayElement(names, i));
        texts.push_back(toUtf8(env, name));
        env->DeleteLocalRef(name);  // the JVM promises room for sixteen of these
    }
    std::vector<const char*> given;
    for (const std::string& text : texts) given.push_back(text.c_str());
    given.push_back(nullptr);  // an empty list has names too
    check(env, dplSetExpressionNamed(avatarOf(avatar), given.data(), values.data(), uint32_t(count)));
}

jfloatArray expression(JNIEnv* env, jclass, jlong avatar) {
    std::vector<float> weights(DPL_EXPRESSION_COUNT);
    if (!check(env, dplGetExpression(avatarOf(avatar), weights.data(), DPL_EXPRESSION_COUNT))) return nullptr;
    return floatsToJava(env, weights);
}

void getPose(JNIEnv* env, jclass, jlong avatar, jfloatArray rotations, jfloatArray root) {
    const auto info = infoOf(env, avatar);
    if (!info) return;
    std::vector<float> values(4 * size_t(info->jointCount)), place(3);
    if (!check(env, dplGetPose(avatarOf(avatar), values.data(), info->jointCount, place.data()))) return;
    write(env, rotations, values);
    write(env, root, place);
}

void setTransform(JNIEnv* env, jclass, jlong avatar, jfloatArray rows) {
    const std::vector<float> values = floatsOf(env, rows);
    if (values.size() != 12) return throwDoppel(env, DPL_ERROR_INVALID_ARGUMENT, "a transform has 12 numbers, row by row");
    check(env, dplSetTransform(avatarOf(avatar), values.data()));
}

void getTransform(JNIEnv* env, jclass, jlong avatar, jfloatArray rows) {
    std::vector<float> values(12);
    if (check(env, dplGetTransform(avatarOf(avatar), values.data()))) write(env, rows, values);
}

void jointPositions(JNIEnv* env, jclass, jlong avatar, jfloatArray positions) {
    const auto info = infoOf(env, avatar);
    if (!info) return;
    std::vector<float> values(3 * size_t(info->jointCount));
    if (check(env, dplGetJointPositions(avatarOf(avatar), values.data(), info->jointCount))) write(env, positions, values);
}

std::optional<DplClipInfo> clipOf(JNIEnv* env, jlong avatar, jint clip) {
    DplClipInfo info{};
    info.structSize = sizeof info;
    if (!check(env, dplGetClipInfo(avatarOf(avatar), uint32_t(clip), &info))) return std::nullopt;
    return info;
}

jstring clipName(JNIEnv* env, jclass, jlong avatar, jint clip) {
    const auto info = clipOf(env, avatar, clip);
    return info ? toJava(env, info->name) : nullptr;
}

jdouble clipDuration(JNIEnv* env, jclass, jlong avatar, jint clip) {
    const auto info = clipOf(env, avatar, clip);
    return info ? info->durationS : 0;
}

void setPoseFromClip(JNIEnv* env, jclass, jlong avatar, jint clip, jdouble timeS, jboolean loop) {
    check(env, dplSetPoseFromClip(avatarOf(avatar), uint32_t(clip), timeS, loop ? DPL_TRUE : DPL_FALSE));
}

jint loadClip(JNIEnv* env, jclass, jlong avatar, jobject buffer, jlong offset, jlong size, jint flags, jstring name) {
    const auto bytes = bytesOf(env, buffer, offset, size);
    if (!bytes) return 0;
    const std::string text = toUtf8(env, name);
    DplClipOptions options{};
    options.structSize = sizeof options;
    options.flags = uint32_t(flags);
    options.name = name ? text.c_str() : nullptr;
    uint32_t clip = 0;
    return check(env, dplLoadClip(avatarOf(avatar), bytes->data, bytes->size, &options, &clip)) ? jint(clip) : 0;
}

constexpr size_t kLayerNumbers = 8;

/** The numbers of a layer as ClipLayer.kt has them: clip, timeS, weight, joint, flags, heading, shift along x and z. */
DplClipLayer layerOf(const double* numbers) {
    DplClipLayer layer{};
    layer.structSize = sizeof layer;
    layer.clip = uint32_t(int64_t(numbers[0])), layer.timeS = numbers[1], layer.weight = float(numbers[2]);
    layer.joint = uint32_t(int64_t(numbers[3])), layer.flags = uint32_t(int64_t(numbers[4]));
    layer.headingRad = float(numbers[5]), layer.shiftM[0] = float(numbers[6]), layer.shiftM[1] = float(numbers[7]);
    return layer;
}

/** Nothing, and an exception: not kLayerNumbers a layer. */
std::optional<std::vector<DplClipLayer>> layersOf(JNIEnv* env, jdoubleArray layers) {
    const std::vector<double> numbers = doublesOf(env, layers);
    if (numbers.size() % kLayerNumbers != 0) {
        throwDoppel(env, DPL_ERROR_INVALID_ARGUMENT, "a layer of a mix has 8 numbers");
        return std::nullopt;
    }
    std::vector<DplClipLayer> made;
    for (size_t i = 0; i < numbers.size(); i += kLayerNumbers) made.push_back(layerOf(numbers.data() + i));
    return made;
}

void setPoseFromClips(JNIEnv* env, jclass, jlong avatar, jdoubleArray layers, jlong timeNs) {
    if (const auto made = layersOf(env, layers))
        check(env, dplSetPoseFromClips(avatarOf(avatar), made->data(), uint32_t(made->size()), timeNs));
}

/** before, layer: one layer each; heading and shift of `layer` are written. */
void joinClipLayer(JNIEnv* env, jclass, jlong avatar, jdoubleArray before, jdoubleArray layer) {
    const auto first = layersOf(env, before);
    if (!first) return;
    auto second = layersOf(env, layer);
    if (!second) return;
    if (first->size() != 1 || second->size() != 1) return throwDoppel(env, DPL_ERROR_INVALID_ARGUMENT, "one layer is joined to one other");
    if (!check(env, dplJoinClipLayer(avatarOf(avatar), first->data(), second->data()))) return;
    std::vector<double> numbers = doublesOf(env, layer);
    const DplClipLayer& joined = second->front();
    numbers[5] = joined.headingRad, numbers[6] = joined.shiftM[0], numbers[7] = joined.shiftM[1];
    write(env, layer, numbers);
}

/** gaze: the target, the weights of head and eyes, their limits. */
void lookAtPoint(JNIEnv* env, jclass, jlong avatar, jfloatArray gaze) {
    const std::vector<float> numbers = floatsOf(env, gaze);
    if (numbers.size() != 9) return throwDoppel(env, DPL_ERROR_INVALID_ARGUMENT, "a gaze has 9 numbers");
    DplGaze made{};
    made.structSize = sizeof made;
    std::copy_n(numbers.begin(), 3, made.target);
    made.headWeight = numbers[3], made.eyeWeight = numbers[4];
    std::copy_n(numbers.begin() + 5, 2, made.headLimitRad);
    std::copy_n(numbers.begin() + 7, 2, made.eyeLimitRad);
    check(env, dplLookAtPoint(avatarOf(avatar), &made));
}

/** motion: blinks, glances, holdS. */
void setFaceMotion(JNIEnv* env, jclass, jlong avatar, jlong timeNs, jint seed, jfloatArray motion, jlong heardNs) {
    const std::vector<float> numbers = floatsOf(env, motion);
    if (numbers.size() != 3) return throwDoppel(env, DPL_ERROR_INVALID_ARGUMENT, "a face's motion has 3 numbers");
    DplFaceMotion made{};
    made.structSize = sizeof made, made.seed = uint32_t(seed), made.heardNs = heardNs;
    made.blinks = numbers[0], made.glances = numbers[1], made.holdS = numbers[2];
    check(env, dplSetFaceMotion(avatarOf(avatar), &made, timeNs));
}

/** Alpha, row by row. onFloor: on the app's floor at floorM. place: corner, across, along, and the largest alpha. */
jbyteArray contactShadow(JNIEnv* env, jclass, jlong avatar, jboolean onFloor, jfloat floorM, jfloatArray place) {
    std::vector<uint8_t> alpha(size_t(DPL_CONTACT_SHADOW_PX) * DPL_CONTACT_SHADOW_PX);
    DplContactShadow made{};
    made.structSize = sizeof made;
    if (!check(env, dplGetContactShadow(avatarOf(avatar), onFloor ? &floorM : nullptr, alpha.data(), alpha.size(), &made))) return nullptr;
    std::vector<float> numbers(made.corner, made.corner + 3);
    numbers.insert(numbers.end(), made.across, made.across + 3);
    numbers.insert(numbers.end(), made.along, made.along + 3);
    numbers.push_back(float(made.darkest));
    write(env, place, numbers);
    return bytesToJava(env, alpha);
}

/** Name, then role, of each layer. */
jobjectArray layerNames(JNIEnv* env, jclass, jlong avatar) {
    const auto info = infoOf(env, avatar);
    if (!info) return nullptr;
    std::vector<std::string> names;
    for (uint32_t l = 0; l < info->layerCount; ++l) {
        const auto layer = layerOf(env, avatar, l);
        if (!layer) return nullptr;
        names.insert(names.end(), {layer->name, layer->role});
    }
    return textsOf(env, names);
}

jboolean isLayerHidden(JNIEnv* env, jclass, jlong avatar, jint layer) {
    const auto told = layerOf(env, avatar, uint32_t(layer));
    return told && told->hidden != DPL_FALSE ? JNI_TRUE : JNI_FALSE;
}

void hideLayer(JNIEnv* env, jclass, jlong avatar, jint layer, jboolean hidden) {
    check(env, dplHideLayer(avatarOf(avatar), uint32_t(layer), hidden ? DPL_TRUE : DPL_FALSE));
}

/** ray: origin, direction. Whether it meets one; then indices: avatar, layer, joint; place: distance, point, normal. */
jboolean pick(JNIEnv* env, jclass, jlongArray avatars, jfloatArray ray, jintArray indices, jfloatArray place) {
    const std::vector<float> numbers = floatsOf(env, ray);
    if (numbers.size() != 6) return throwDoppel(env, DPL_ERROR_INVALID_ARGUMENT, "a ray has 6 numbers"), JNI_FALSE;
    const std::vector<DplAvatar> handles = avatarsOf(env, avatars);
    DplPick found{};
    found.structSize = sizeof found;
    if (!check(env, dplPick(handles.data(), uint32_t(handles.size()), numbers.data(), numbers.data() + 3, &found))) return JNI_FALSE;
    const jint which[] = {jint(found.avatar), jint(found.layer), jint(found.joint)};
    env->SetIntArrayRegion(indices, 0, std::min<jsize>(3, env->GetArrayLength(indices)), which);
    std::vector<float> where{found.distanceM};
    where.insert(where.end(), found.point, found.point + 3);
    where.insert(where.end(), found.normal, found.normal + 3);
    write(env, place, where);
    return found.hit != DPL_FALSE ? JNI_TRUE : JNI_FALSE;
}

/** A buffer of the app, and where each property lies in it: property, 1 for halves, offset and stride. */
struct GivenBuffer {
    std::vector<DplBufferElement> elements;
    DplBuffer buffer{};
};

/** Nothing, and an exception: no direct buffer, or other numbers. */
std::optional<GivenBuffer> bufferOf(JNIEnv* env, jlongArray layout, jobject buffer) {
    constexpr size_t kNumbers = 4;
    const std::vector<jlong> numbers = longsOf(env, layout);
    if (numbers.empty() || numbers.size() % kNumbers || std::any_of(numbers.begin(), numbers.end(), [](jlong n) { return n < 0; })) {
        throwDoppel(env, DPL_ERROR_INVALID_ARGUMENT, "a layout has one element or more, of 4 numbers that are not negative");
        return std::nullopt;
    }
    const auto bytes = bytesOf(env, buffer, 0, buffer ? env->GetDirectBufferCapacity(buffer) : 0);
    if (!bytes) return std::nullopt;
    GivenBuffer given;
    for (size_t i = 0; i < numbers.size(); i += kNumbers)
        given.elements.push_back({sizeof(DplBufferElement), uint32_t(numbers[i]), numbers[i + 1] != 0 ? DPL_NUMBER_HALF : DPL_NUMBER_FLOAT,
                                  0, uint64_t(numbers[i + 2]), uint64_t(numbers[i + 3])});
    given.buffer = {sizeof given.buffer, uint32_t(given.elements.size()), given.elements.data(), bytes->data, bytes->size};
    return given;
}

/** How many, and how many numbers were too large for a half. Without a layout they are only counted. */
template <class Write>
jlongArray writePosed(JNIEnv* env, jlongArray layout, jobject buffer, Write&& call) {
    std::optional<GivenBuffer> given;
    if (layout && !(given = bufferOf(env, layout, buffer))) return nullptr;
    DplWritten written{};
    written.structSize = sizeof written;
    if (!check(env, call(given ? &given->buffer : nullptr, &written))) return nullptr;
    jlongArray out = env->NewLongArray(2);
    write(env, out, std::vector<jlong>{written.count, jlong(written.saturated)});
    return out;
}

/** eye: 3 numbers, or null. */
jlongArray writeSplats(JNIEnv* env, jclass, jlong avatar, jlongArray layout, jobject buffer, jint splatBudget, jfloatArray eye,
                       jint shDegree) {
    const std::vector<float> place = floatsOf(env, eye);
    if (eye && place.size() != 3) return throwDoppel(env, DPL_ERROR_INVALID_ARGUMENT, "an eye has 3 numbers"), nullptr;
    const DplSplatOptions options{sizeof options, uint32_t(splatBudget), eye ? place.data() : nullptr, uint32_t(shDegree)};
    return writePosed(env, layout, buffer,
                      [&](const DplBuffer* to, DplWritten* written) { return dplWriteSplats(avatarOf(avatar), &options, to, written); });
}

jlongArray writeMesh(JNIEnv* env, jclass, jlong avatar, jlongArray layout, jobject buffer) {
    return writePosed(env, layout, buffer,
                      [&](const DplBuffer* to, DplWritten* written) { return dplWriteMesh(avatarOf(avatar), to, written); });
}

/** trust: the shares and distances of DplPoseTrust, with the farthest joint as a number. distances: one for each joint, or null. */
void poseTrust(JNIEnv* env, jclass, jlong avatar, jfloatArray trust, jfloatArray distances) {
    std::vector<float> values(distances ? size_t(env->GetArrayLength(distances)) : 0);
    DplPoseTrust told{};
    told.structSize = sizeof told;
    if (!check(env, dplGetPoseTrust(avatarOf(avatar), &told, distances ? values.data() : nullptr, uint32_t(values.size())))) return;
    write(env, trust, {told.offsets, told.away, told.offModes, float(told.farthestJoint), told.farthestDistance});
    write(env, distances, values);
}

void holdPose(JNIEnv* env, jclass, jlong avatar, jfloat limit) {
    check(env, dplHoldPose(avatarOf(avatar), limit));
}

/** counts: splats drawn, splats allowed, bytes of the context, bytes of the avatar, budget state, frames over budget. times: ms of the GPU
 *  and of the frame, and the share of splats that level of detail kept. */
void frameStats(JNIEnv* env, jclass, jlong avatar, jlongArray counts, jdoubleArray times) {
    DplFrameStats stats{};
    stats.structSize = sizeof stats;
    if (!check(env, dplGetFrameStats(avatarOf(avatar), &stats))) return;
    write(env, counts,
          std::vector<jlong>{stats.splatsDrawn, stats.splatsAllowed, jlong(stats.residentBytes), jlong(stats.avatarBytes),
                             stats.budgetState, stats.framesOver});
    write(env, times, std::vector<double>{stats.gpuMs, stats.frameMs, stats.detailShare});
}

}  // namespace

const std::vector<JNINativeMethod> kAvatarMethods = {
    method("loadAvatar", "(JLjava/nio/ByteBuffer;JJ)J", loadAvatar),
    method("destroyAvatar", "(J)V", destroyAvatar),
    method("avatarName", "(J)Ljava/lang/String;", avatarName),
    method("avatarInfo", "(J[J[F)V", avatarInfo),
    method("jointNames", "(J)[Ljava/lang/String;", jointNames),
    method("jointTree", "(J)[F", jointTree),
    method("findJoint", "(JLjava/lang/String;)I", findJoint),
    method("setPose", "(J[F[F)V", setPose),
    method("setPoseAtTime", "(J[F[FJ)V", setPoseAtTime),
    method("setTransform", "(J[F)V", setTransform),
    method("getTransform", "(J[F)V", getTransform),
    method("settle", "(J)V", settle),
    method("motionState", "(J)[B", motionState),
    method("setMotionState", "(J[B)V", setMotionState),
    method("setClothStiffness", "(JF)V", setClothStiffness),
    method("expressionNames", "(J)[Ljava/lang/String;", expressionNames),
    method("isExpressionDrawn", "(JI)Z", isExpressionDrawn),
    method("setExpression", "(J[F)V", setExpression),
    method("setExpressionNamed", "(J[Ljava/lang/String;[F)V", setExpressionNamed),
    method("expression", "(J)[F", expression),
    method("getPose", "(J[F[F)V", getPose),
    method("jointPositions", "(J[F)V", jointPositions),
    method("clipName", "(JI)Ljava/lang/String;", clipName),
    method("clipDuration", "(JI)D", clipDuration),
    method("setPoseFromClip", "(JIDZ)V", setPoseFromClip),
    method("loadClip", "(JLjava/nio/ByteBuffer;JJILjava/lang/String;)I", loadClip),
    method("setPoseFromClips", "(J[DJ)V", setPoseFromClips),
    method("joinClipLayer", "(J[D[D)V", joinClipLayer),
    method("lookAtPoint", "(J[F)V", lookAtPoint),
    method("setFaceMotion", "(JJI[FJ)V", setFaceMotion),
    method("contactShadow", "(JZF[F)[B", contactShadow),
    method("layerNames", "(J)[Ljava/lang/String;", layerNames),
    method("isLayerHidden", "(JI)Z", isLayerHidden),
    method("hideLayer", "(JIZ)V", hideLayer),
    method("pick", "([J[F[I[F)Z", pick),
    method("writeSplats", "(J[JLjava/nio/ByteBuffer;I[FI)[J", writeSplats),
    method("writeMesh", "(J[JLjava/nio/ByteBuffer;)[J", writeMesh),
    method("poseTrust", "(J[F[F)V", poseTrust),
    method("holdPose", "(JF)V", holdPose),
    method("frameStats", "(J[J[D)V", frameStats),
};

}  // namespace dpl::android
