#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# run_java.sh JAVA CLASSES CLASS LIBRARY DRAW_WITH_C MAKE_AVATAR: runs a test class. -Xcheck:jni makes the JVM check every call of native code;
# what it says fails the test. With DOPPEL_SANITIZE=address the sanitizers of GCC are loaded first, as
# the JVM is built without them. Validation is on if VK_INSTANCE_LAYERS names the layer.
set -eu
java="$1" classes="$2" class="$3" library="$4" draw="$5" make="$6"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
"$make" "$work/avatar.glb"
"$make" "$work/person.glb" --person
"$draw" "$work/avatar.glb" 1 "$work/software.rgba"
"$draw" "$work/avatar.glb" 2 "$work/vulkan.rgba" || rm -f "$work/vulkan.rgba"
preload=""
case "${DOPPEL_SANITIZE-}" in
    *address*)
        # The JVM itself uses SIGSEGV and frees nothing at its end; leaks of native code are counted by the tests.
        preload="$(gcc -print-file-name=libasan.so):$(gcc -print-file-name=libubsan.so)" ;;
esac
validation=false
case "${VK_INSTANCE_LAYERS-}" in *validation*) validation=true ;; esac
status=0
LD_PRELOAD="$preload" ASAN_OPTIONS="handle_segv=0:detect_leaks=0" \
    "$java" -Xcheck:jni -Xmx256m -Dorg.doppel.validation=$validation -Dorg.doppel.library="$library" -cp "$classes" "$class" "$work" >"$work/out" 2>&1 || status=$?
cat "$work/out"
if [ $status = 0 ] && grep -E "^WARNING|^FATAL ERROR in native" "$work/out"; then
    echo "FAILED: the JVM complains about native code"
    status=1
fi
exit $status
