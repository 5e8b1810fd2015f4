# SPDX-License-Identifier: Apache-2.0
# Shared by the scripts in tools/: numbered steps, builds with progress, test runs with a count. Sourced, not run.
export DOPPEL_COMPILER_LAUNCHER="${DOPPEL_COMPILER_LAUNCHER-$(command -v ccache || true)}"
# ccache settings. SLOPPINESS: needed to cache with a precompiled header. BASEDIR, NOHASHDIR: all checkouts share objects. They share
# them by the preprocessor's output alone, because batches of sources (unity builds) include them by absolute paths; so no DEPEND mode.
export CCACHE_SLOPPINESS="pch_defines,time_macros,include_file_mtime,include_file_ctime"
export CCACHE_BASEDIR="${CCACHE_BASEDIR-$PWD}" CCACHE_NOHASHDIR=1
tests_passed=0
tests_skipped=0
tests_failed=0
step_number=0

step() {
    step_number=$((step_number + 1))
    printf '\n[%d] %s\n' "$step_number" "$1"
}

# configure PRESET: prints the output only when configuring fails.
configure() {
    local log
    log=$(mktemp)
    cmake --preset "$1" >"$log" 2>&1 || { cat "$log" >&2; rm -f "$log"; echo "configuring preset '$1' failed" >&2; return 1; }
    rm -f "$log"
}

build() {
    configure "$1"
    NINJA_STATUS="[%f/%t %es] " cmake --build --preset "$1" ${2:+--target "${@:2}"}
}

# build_sanitized PRESET: builds only the programs of tests labelled `sanitize`.
build_sanitized() { build "$1" sanitized_tests; }

# run_tests PRESET [ctest options]: fails when a test fails or none ran; counts cases and repeats the reason of every skip.
run_tests() {
    local preset="$1" status=0 log
    shift
    ctest --preset "$preset" --no-tests=error --parallel "$(nproc)" "$@" || status=$?
    log="build/$preset/Testing/Temporary/LastTest.log"
    local programs_only passed skipped failed
    passed=$(sed -n 's/^\[  PASSED  \] \([0-9]*\) test.*/\1/p' "$log" | awk '{n += $1} END {print n + 0}')
    programs_only=$(grep -c '^Test Passed\.$' "$log" || true)
    skipped=$(grep -c '^\[  SKIPPED \] .*ms)$' "$log" || true)
    failed=$(grep -c '^\[  FAILED  \] .*ms)$' "$log" || true)
    if [ "$skipped" -gt 0 ]; then
        echo "skipped, with the reason each test gave:"
        awk '/: Skipped$/ { wanted = 1; next }
             wanted && NF { reason = $0; wanted = 0 }
             /^\[  SKIPPED \] .*ms\)$/ { print "  " $4 ": " reason }' "$log"
    fi
    if [ "$passed" -eq 0 ]; then passed=$programs_only; fi
    tests_passed=$((tests_passed + passed))
    tests_skipped=$((tests_skipped + skipped))
    if [ "$status" -ne 0 ]; then
        [ "$failed" -gt 0 ] || failed=1
        tests_failed=$((tests_failed + failed))
        echo "$tests_passed passed, $failed failed, $tests_skipped skipped"
        return 1
    fi
}

# as_root COMMAND...: runs it as root.
as_root() {
    if [ "$(id -u)" -eq 0 ]; then "$@"; return; fi
    command -v sudo >/dev/null || { echo "this needs root, and sudo is not installed: $*" >&2; return 1; }
    sudo "$@"
}

# unpack_packages FOLDER PACKAGE...: downloads Debian packages and unpacks them into FOLDER. Installs nothing. Prints what it got.
unpack_packages() {
    local folder="$1" work package
    shift
    command -v apt-get >/dev/null || { echo "needs apt-get to fetch $*" >&2; return 1; }
    work=$(mktemp -d)
    chmod 755 "$work"
    # The mirror keeps only the newest versions, so update the lists and try again if the download fails.
    (cd "$work" && { apt-get download "$@" || { apt-get update && apt-get download "$@"; }; }) >"$work/log" 2>&1 ||
        { cat "$work/log" >&2; rm -rf "$work"; return 1; }
    for package in "$work"/*.deb; do
        dpkg-deb -x "$package" "$folder"
        basename "$package"
    done
    rm -rf "$work"
}

# debian_mirror: prints a Debian mirror, that of this machine's apt sources if they name one.
debian_mirror() {
    local mirror
    mirror=$(apt-cache policy 2>/dev/null | grep -oE 'https?://[^ ]+/debian/? ' | tr -d ' ' | sort | uniq -c | sort -rn | awk 'NR == 1 {print $2}') || true
    echo "${mirror:-http://deb.debian.org/debian}"
}

# apt_apart FOLDER ARGUMENT...: runs apt-get with FOLDER/sources.list and lists of its own, so that the machine's apt sources stay
# unchanged.
apt_apart() {
    local folder="$1"
    shift
    mkdir -p "$folder/lists/partial"
    apt-get -q -o "Dir::Etc::sourcelist=$folder/sources.list" -o Dir::Etc::sourceparts=/dev/null \
        -o "Dir::State::lists=$folder/lists" -o APT::Sandbox::User=root "$@"
}

# ubuntu_keyring FOLDER: puts Ubuntu's archive keys into FOLDER and prints their path. Debian signs the package that holds them.
ubuntu_keyring() {
    local folder="$1" package
    mkdir -p "$folder"
    echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] $(debian_mirror) trixie main" >"$folder/sources.list"
    (cd "$folder" && apt_apart "$folder" update && apt_apart "$folder" download ubuntu-archive-keyring ubuntu-keyring) \
        >"$folder/log" 2>&1 || { cat "$folder/log" >&2; return 1; }
    for package in "$folder"/*.deb; do dpkg-deb -x "$package" "$folder"; done
    find "$folder/usr" -name ubuntu-archive-keyring.gpg -not -type l | head -n 1
}

# bare_root SUITE FOLDER: makes a bare Debian (bookworm, trixie) or Ubuntu (noble) in FOLDER with debootstrap, unless it is there. No
# service starts in it. Needs root and a mirror: for Debian that of this machine's apt sources, for Ubuntu archive.ubuntu.com.
bare_root() {
    local suite="$1" root="$2" f source
    [ "$(id -u)" -eq 0 ] || { echo "needs root (debootstrap, chroot)" >&2; return 1; }
    command -v debootstrap >/dev/null || apt-get install -y --no-install-recommends debootstrap >/dev/null
    if [ ! -e "$root/.debootstrapped" ]; then
        rm -rf "$root"
        mkdir -p "$root"
        if [ "$suite" = noble ]; then  # Debian 12's debootstrap has no script of that name; all of Ubuntu share gutsy's
            source=(--components=main,universe "--keyring=$(ubuntu_keyring "$root.keys")" "$suite" "$root" \
                http://archive.ubuntu.com/ubuntu /usr/share/debootstrap/scripts/gutsy)
        else
            source=("$suite" "$root" "$(debian_mirror)")
        fi
        echo "debootstrap $suite into $root"
        debootstrap --variant=minbase "${source[@]}" >"$root.log" 2>&1 || { tail -n 20 "$root.log" >&2; return 1; }
        rm -rf "$root.keys"
        touch "$root/.debootstrapped"
    fi
    printf '#!/bin/sh\nexit 101\n' >"$root/usr/sbin/policy-rc.d"  # no service starts in the root
    chmod +x "$root/usr/sbin/policy-rc.d"
    echo force-unsafe-io >"$root/etc/dpkg/dpkg.cfg.d/unsafe-io"  # faster; a root need not survive a power cut
    cp /etc/resolv.conf "$root/etc/resolv.conf" 2>/dev/null || true
    # Behind a proxy that signs for others, programs need the certificates that this machine was told to trust.
    [ ! -f "${SSL_CERT_FILE:-}" ] || cp "$SSL_CERT_FILE" "$root/etc/machine-certificates.pem"
    for f in /etc/apt/apt.conf.d/*proxy* /etc/apt/apt.conf; do [ -f "$f" ] && cp "$f" "$root/etc/apt/apt.conf.d/" || true; done
}

# in_root ROOT FOLDER COMMAND: runs it in a root of bare_root, in a private mount namespace, so that nothing stays mounted afterwards,
# whatever happens inside. $cache and $archives, if set, are folders for ccache and for the packages that apt downloads.
in_root() {
    local certificates=""
    mkdir -p "$1/ccache"
    [ ! -f "$1/etc/machine-certificates.pem" ] ||
        certificates="SSL_CERT_FILE=/etc/machine-certificates.pem NODE_EXTRA_CA_CERTS=/etc/machine-certificates.pem"
    ROOT="$1" FOLDER="$2" COMMAND="$3" CACHE="${cache:-}" ARCHIVES="${archives:-}" CERTIFICATES="$certificates" unshare --mount bash -c '
        set -e
        mount -t proc proc "$ROOT/proc"
        mount --rbind /dev "$ROOT/dev"
        if [ -n "$CACHE" ]; then mkdir -p "$CACHE"; mount --bind "$CACHE" "$ROOT/ccache"; fi
        if [ -n "$ARCHIVES" ]; then mkdir -p "$ARCHIVES/partial"; mount --bind "$ARCHIVES" "$ROOT/var/cache/apt/archives"; fi
        exec chroot "$ROOT" /usr/bin/env -i HOME=/root PATH=/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin TERM=dumb CCACHE_DIR=/ccache \
            ${http_proxy:+http_proxy="$http_proxy"} ${https_proxy:+https_proxy="$https_proxy"} $CERTIFICATES \
            bash -c "cd $FOLDER && $COMMAND"' </dev/null
}

# doppel_version: prints the version, DPL_VERSION_TEXT of doppel.h (tools/cmake/DoppelVersion.cmake).
doppel_version() { sed -n 's/^#define DPL_VERSION_TEXT "\([^"]*\)".*/\1/p' sdk/include/doppel/doppel.h; }

finish_tests() { [ "$tests_passed" -gt 0 ] || { echo "no test ran" >&2; return 1; }; }

# npm_package FOLDER NAME@VERSION: unpacks a package, without what it depends on, into a folder of build/web/npm.
npm_package() {
    local folder="build/web/npm/$1" work
    [ -e "$folder/package.json" ] && return
    work=$(mktemp -d)
    (cd "$work" && npm pack --silent "$2" >/dev/null && tar -xzf ./*.tgz)
    mkdir -p build/web/npm
    rm -rf "$folder"
    mv "$work/package" "$folder"
    rm -rf "$work"
}
