// SPDX-License-Identifier: Apache-2.0
#include "platform/android/native/jni_help.h"

#include <algorithm>

#include "platform/android/native/utf.h"

namespace dpl::android {
namespace {

JavaVM* virtualMachine = nullptr;
jclass exceptionClass = nullptr;
jmethodID exceptionConstructor = nullptr;

}  // namespace

bool findClasses(JNIEnv* env, JavaVM* vm) {
    virtualMachine = vm;
    jclass found = env->FindClass("org/doppel/DoppelException");
    if (!found) return false;
    exceptionClass = static_cast<jclass>(env->NewGlobalRef(found));
    env->DeleteLocalRef(found);
    exceptionConstructor = env->GetMethodID(exceptionClass, "<init>", "(ILjava/lang/String;)V");
    return exceptionConstructor != nullptr;
}

void throwDoppel(JNIEnv* env, DplResult code, const std::string& sentence) {
    if (env->ExceptionCheck()) return;  // the first one tells more
    jstring text = toJava(env, sentence);
    if (!text) return;  // out of memory, which is pending
    jobject exception = env->NewObject(exceptionClass, exceptionConstructor, jint(code), text);
    if (exception) env->Throw(static_cast<jthrowable>(exception));
    env->DeleteLocalRef(exception);
    env->DeleteLocalRef(text);
}

bool check(JNIEnv* env, DplResult result) {
    if (result == DPL_OK) return true;
    throwDoppel(env, result, dplGetLastError());
    return false;
}

jstring toJava(JNIEnv* env, std::string_view utf8) {
    const std::u16string text = utf16Of(utf8);
    return env->NewString(reinterpret_cast<const jchar*>(text.data()), jsize(text.size()));
}

std::string toUtf8(JNIEnv* env, jstring text) {
    if (!text) return {};
    std::u16string units(size_t(env->GetStringLength(text)), u'\0');
    env->GetStringRegion(text, 0, jsize(units.size()), reinterpret_cast<jchar*>(units.data()));
    return utf8Of(units);
}

std::vector<float> floatsOf(JNIEnv* env, jfloatArray array) {
    if (!array) return {};
    std::vector<float> values(size_t(env->GetArrayLength(array)));
    env->GetFloatArrayRegion(array, 0, jsize(values.size()), values.data());
    return values;
}

std::vector<double> doublesOf(JNIEnv* env, jdoubleArray array) {
    if (!array) return {};
    std::vector<double> values(size_t(env->GetArrayLength(array)));
    env->GetDoubleArrayRegion(array, 0, jsize(values.size()), values.data());
    return values;
}

std::vector<jlong> longsOf(JNIEnv* env, jlongArray array) {
    if (!array) return {};
    std::vector<jlong> values(size_t(env->GetArrayLength(array)));
    env->GetLongArrayRegion(array, 0, jsize(values.size()), values.data());
    return values;
}

void write(JNIEnv* env, jfloatArray array, const std::vector<float>& values) {
    if (array) env->SetFloatArrayRegion(array, 0, std::min(env->GetArrayLength(array), jsize(values.size())), values.data());
}

void write(JNIEnv* env, jlongArray array, const std::vector<jlong>& values) {
    if (array) env->SetLongArrayRegion(array, 0, std::min(env->GetArrayLength(array), jsize(values.size())), values.data());
}

void write(JNIEnv* env, jdoubleArray array, const std::vector<double>& values) {
    if (array) env->SetDoubleArrayRegion(array, 0, std::min(env->GetArrayLength(array), jsize(values.size())), values.data());
}

std::optional<Bytes> bytesOf(JNIEnv* env, jobject buffer, jlong offset, jlong size) {
    auto* start = buffer ? static_cast<uint8_t*>(env->GetDirectBufferAddress(buffer)) : nullptr;
    const jlong capacity = start ? env->GetDirectBufferCapacity(buffer) : -1;
    if (!start) {
        throwDoppel(env, DPL_ERROR_INVALID_ARGUMENT, "a direct ByteBuffer is needed: allocateDirect, or a mapped file");
        return std::nullopt;
    }
    if (offset < 0 || size < 0 || offset > capacity || size > capacity - offset) {
        throwDoppel(env, DPL_ERROR_INVALID_ARGUMENT,
                    std::to_string(size) + " bytes at " + std::to_string(offset) + " are not in a buffer of " + std::to_string(capacity));
        return std::nullopt;
    }
    return Bytes{start + offset, size_t(size)};
}

std::optional<std::span<float>> floatsIn(JNIEnv* env, jobject buffer) {
    auto* start = buffer ? env->GetDirectBufferAddress(buffer) : nullptr;
    if (start && reinterpret_cast<uintptr_t>(start) % alignof(float) == 0)
        return std::span(static_cast<float*>(start), size_t(env->GetDirectBufferCapacity(buffer)));
    throwDoppel(env, DPL_ERROR_INVALID_ARGUMENT, "a direct FloatBuffer is needed: allocateDirect, order(nativeOrder()), asFloatBuffer");
    return std::nullopt;
}

jobjectArray textsOf(JNIEnv* env, const std::vector<std::string>& texts) {
    jclass strings = env->FindClass("java/lang/String");
    jobjectArray made = strings ? env->NewObjectArray(jsize(texts.size()), strings, nullptr) : nullptr;
    env->DeleteLocalRef(strings);
    for (size_t i = 0; made && i < texts.size(); ++i) {
        jstring text = toJava(env, texts[i]);
        if (!text) return nullptr;
        env->SetObjectArrayElement(made, jsize(i), text);
        env->DeleteLocalRef(text);  // there may be more texts than a frame of JNI has references
    }
    return made;
}

GlobalRef::~GlobalRef() {
    void* env = nullptr;
    const bool attached = virtualMachine->GetEnv(&env, JNI_VERSION_1_6) == JNI_OK;
    if (!attached) {
        // The two platforms declare the first parameter differently.
#ifdef __ANDROID__
        JNIEnv* made = nullptr;
        if (virtualMachine->AttachCurrentThread(&made, nullptr) != JNI_OK) return;
        env = made;
#else
        if (virtualMachine->AttachCurrentThread(&env, nullptr) != JNI_OK) return;
#endif
    }
    static_cast<JNIEnv*>(env)->DeleteGlobalRef(object_);
    if (!attached) virtualMachine->DetachCurrentThread();
}

}  // namespace dpl::android
