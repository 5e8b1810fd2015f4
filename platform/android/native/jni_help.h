// SPDX-License-Identifier: Apache-2.0
// What every native method needs: errors as Java exceptions, strings, arrays, direct buffers.
//
// A native method that fails throws org.doppel.DoppelException with a code of DplResult and the library's sentence, and returns 0.
#pragma once

#include <doppel/doppel.h>
#include <jni.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace dpl::android {

/** Finds the classes that native code uses. False: one is missing, and an exception is pending. Called once, by JNI_OnLoad. */
bool findClasses(JNIEnv* env, JavaVM* vm);

void throwDoppel(JNIEnv* env, DplResult code, const std::string& sentence);
/** Throws unless `result` is DPL_OK. True: it was. */
bool check(JNIEnv* env, DplResult result);

/** Java strings are UTF-16, and JNI's own functions take a UTF-8 of their own, on whose absence Android ends the process. These two
 * convert; what is no character becomes U+FFFD. */
jstring toJava(JNIEnv* env, std::string_view utf8);
std::string toUtf8(JNIEnv* env, jstring text);  // "" for null

/** Handles travel as numbers. */
template <class Handle>
Handle handleOf(jlong number) {
    return reinterpret_cast<Handle>(static_cast<intptr_t>(number));
}
template <class Handle>
jlong numberOf(Handle handle) {
    return static_cast<jlong>(reinterpret_cast<intptr_t>(handle));
}

/** Copies of arrays. Null gives an empty one. */
std::vector<float> floatsOf(JNIEnv* env, jfloatArray array);
std::vector<double> doublesOf(JNIEnv* env, jdoubleArray array);
std::vector<jlong> longsOf(JNIEnv* env, jlongArray array);
/** Writes as many values as `array` has room for. */
void write(JNIEnv* env, jfloatArray array, const std::vector<float>& values);
void write(JNIEnv* env, jlongArray array, const std::vector<jlong>& values);
void write(JNIEnv* env, jdoubleArray array, const std::vector<double>& values);

struct Bytes {
    uint8_t* data;
    size_t size;
};
/** `size` bytes at `offset` of a direct ByteBuffer, which must stay reachable while they are used. Nothing, and an exception: no direct
 *  buffer, or not that many bytes. */
std::optional<Bytes> bytesOf(JNIEnv* env, jobject buffer, jlong offset, jlong size);
/** All of a direct FloatBuffer, whatever its position; as bytesOf. */
std::optional<std::span<float>> floatsIn(JNIEnv* env, jobject buffer);
/** A java.lang.String[] of texts. Null, and an exception: out of memory. */
jobjectArray textsOf(JNIEnv* env, const std::vector<std::string>& texts);

/** Keeps a Java object alive until it is destroyed, on any thread. */
class GlobalRef {
public:
    GlobalRef(JNIEnv* env, jobject object) : object_(env->NewGlobalRef(object)) {}
    ~GlobalRef();
    GlobalRef(const GlobalRef&) = delete;
    GlobalRef& operator=(const GlobalRef&) = delete;

private:
    jobject object_;
};

/** The native methods of Native.java, by subject. */
extern const std::vector<JNINativeMethod> kContextMethods, kAvatarMethods, kLoadMethods, kTrackerMethods, kViewMethods;

/** One row of these tables. */
template <class Function>
JNINativeMethod method(const char* name, const char* signature, Function* function) {
    return {const_cast<char*>(name), const_cast<char*>(signature), reinterpret_cast<void*>(function)};
}

}  // namespace dpl::android
