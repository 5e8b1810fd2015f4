// SPDX-License-Identifier: Apache-2.0
#include "sdk/core/files.h"

#include <fcntl.h>
#include <sys/stat.h>

#if defined(_WIN32)
#include <io.h>
#include <process.h>
#else
#include <unistd.h>
#endif

#include <algorithm>
#include <cerrno>

namespace dpl {
namespace {

// The system's calls, which have other names on Windows: paths are UTF-16 there, and a file is text unless it is opened as binary. All set
// errno.
namespace sys {
#if defined(_WIN32)
using FileInfo = struct _stat64;
constexpr int kRead = _O_RDONLY, kWrite = _O_WRONLY, kReplace = _O_WRONLY | _O_CREAT | _O_TRUNC;
int open(const std::filesystem::path& path, int mode) {
    return ::_wopen(path.c_str(), mode | _O_BINARY | _O_NOINHERIT, _S_IREAD | _S_IWRITE);
}
int64_t read(int fd, std::span<uint8_t> bytes) {
    return ::_read(fd, bytes.data(), unsigned(std::min<size_t>(bytes.size(), 1u << 30)));
}
int64_t write(int fd, std::span<const uint8_t> bytes) {
    return ::_write(fd, bytes.data(), unsigned(std::min<size_t>(bytes.size(), 1u << 30)));
}
int flush(int fd) {
    return ::_commit(fd);
}
int info(int fd, FileInfo& out) {
    return ::_fstat64(fd, &out);
}
void close(int fd) {
    ::_close(fd);
}
int processId() {
    return ::_getpid();
}
#else
using FileInfo = struct stat;
constexpr int kRead = O_RDONLY | O_NONBLOCK | O_NOCTTY;  // opening a pipe that nobody writes to would wait
constexpr int kWrite = O_WRONLY, kReplace = O_WRONLY | O_CREAT | O_TRUNC;
int open(const std::filesystem::path& path, int mode) {
    return ::open(path.c_str(), mode | O_CLOEXEC, 0644);
}
int64_t read(int fd, std::span<uint8_t> bytes) {
    return ::read(fd, bytes.data(), bytes.size());
}
int64_t write(int fd, std::span<const uint8_t> bytes) {
    return ::write(fd, bytes.data(), bytes.size());
}
int flush(int fd) {
    return ::fsync(fd);
}
int info(int fd, FileInfo& out) {
    return ::fstat(fd, &out);
}
void close(int fd) {
    ::close(fd);
}
int processId() {
    return ::getpid();
}
#endif
}  // namespace sys

/** For messages, which are UTF-8. */
std::string pathText(const std::filesystem::path& path) {
    const std::u8string utf8 = path.u8string();
    return {utf8.begin(), utf8.end()};
}

Error ioError(const char* what, const std::filesystem::path& path, std::error_condition reason) {
    const bool absent = reason == std::errc::no_such_file_or_directory;
    const char* remedy = reason == std::errc::no_space_on_device  ? "; free some disk space and run again"
                         : reason == std::errc::permission_denied ? "; check the permissions"
                         : absent                                 ? "; check the path"
                                                                  : "";
    return fail(absent ? Code::NotFound : Code::Io, "cannot {} {}: {}{}", what, pathText(path), reason.message(), remedy);
}

Error ioError(const char* what, const std::filesystem::path& path) {
    return ioError(what, path, std::error_condition(errno, std::generic_category()));
}

struct Descriptor {
    int fd = -1;
    ~Descriptor() {
        if (fd >= 0) sys::close(fd);
    }
};

Status readFully(int fd, std::span<uint8_t> bytes, const std::filesystem::path& path) {
    while (!bytes.empty()) {
        const int64_t got = sys::read(fd, bytes);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return ioError("read", path);
        if (got == 0) return fail(Code::CorruptData, "{} became shorter while it was read; run again", pathText(path));
        bytes = bytes.subspan(size_t(got));
    }
    return {};
}

/** A file that grows is being written, so what was read is a part of it. */
Status checkEnd(int fd, const std::filesystem::path& path) {
    uint8_t more = 0;
    if (sys::read(fd, {&more, 1}) <= 0) return {};
    return fail(Code::CorruptData, "{} became longer while it was read; run again when it is complete", pathText(path));
}

Status writeFully(int fd, std::span<const uint8_t> bytes, const std::filesystem::path& path) {
    while (!bytes.empty()) {
        const int64_t put = sys::write(fd, bytes);
        if (put < 0 && errno == EINTR) continue;
        if (put < 0) return ioError("write", path);
        bytes = bytes.subspan(size_t(put));
    }
    if (sys::flush(fd) != 0 && errno != EINVAL && errno != EROFS) return ioError("write", path);
    return {};
}

}  // namespace

std::filesystem::path endOfLinks(std::filesystem::path path) {
    constexpr int kMaxLinks = 40;  // limit of the Linux kernel; opening a longer chain fails
    std::error_code error;
    for (int i = 0; i < kMaxLinks && std::filesystem::is_symlink(path, error); ++i) {
        const std::filesystem::path next = std::filesystem::read_symlink(path, error);
        if (error) break;
        path = path.parent_path() / next;  // an absolute `next` replaces the whole path
    }
    return path;
}

Result<std::vector<uint8_t>> readFile(const std::filesystem::path& path, uint64_t maxBytes, CheckFileHead check) {
    Descriptor file{sys::open(path, sys::kRead)};
    if (file.fd < 0) return ioError("open", path);
    sys::FileInfo info{};
    if (sys::info(file.fd, info) != 0) return ioError("read", path);
    if ((info.st_mode & S_IFMT) != S_IFREG) return fail(Code::InvalidArgument, "{} is not a file", pathText(path));
    const uint64_t fileBytes = uint64_t(info.st_size);
    std::vector<uint8_t> bytes;
    if (check) {  // what the file is tells more than its size
        bytes.resize(size_t(std::min<uint64_t>(fileBytes, kFileHeadBytes)));
        DPL_RETURN_IF_ERROR(readFully(file.fd, bytes, path));
        if (const Status accepted = check(bytes, fileBytes); !accepted)
            return fail(accepted.error().code, "{}: {}", pathText(path), accepted.error().message);
    }
    if (fileBytes > maxBytes)
        return fail(Code::Unsupported, "{} has {} bytes, more than the {} that are read; is it the right file?", pathText(path), fileBytes,
                    maxBytes);
    const size_t headBytes = bytes.size();
    bytes.resize(size_t(fileBytes));
    DPL_RETURN_IF_ERROR(readFully(file.fd, std::span(bytes).subspan(headBytes), path));
    DPL_RETURN_IF_ERROR(checkEnd(file.fd, path));
    return bytes;
}

Status writeFileAtomically(const std::filesystem::path& path, std::span<const uint8_t> bytes) {
    const std::filesystem::path target = endOfLinks(path);
    std::error_code error;
    const std::filesystem::file_status there = std::filesystem::status(target, error);
    if (std::filesystem::exists(there) && !std::filesystem::is_regular_file(there) && !std::filesystem::is_directory(there)) {
        const Descriptor device{sys::open(target, sys::kWrite)};
        return device.fd < 0 ? ioError("open", target) : writeFully(device.fd, bytes, path);
    }
    std::filesystem::path temporary = target;
    temporary += ".part" + std::to_string(sys::processId());
    Status written = [&]() -> Status {
        const Descriptor file{sys::open(temporary, sys::kReplace)};
        return file.fd < 0 ? ioError("create", temporary) : writeFully(file.fd, bytes, path);
    }();
    if (written) {
        std::filesystem::rename(temporary, target, error);  // in one step also on Windows: MoveFileEx, which replaces
        if (error) written = ioError("rename to", target, error.default_error_condition());
    }
    if (!written) std::filesystem::remove(temporary, error);
    return written;
}

Status writeFileAtomically(const std::filesystem::path& path, std::string_view text) {
    return writeFileAtomically(path, std::span(reinterpret_cast<const uint8_t*>(text.data()), text.size()));
}

}  // namespace dpl
