/* Lets one system call on files of a folder fail: put before libc by LD_PRELOAD, so that calls of Python, SQLite and
   pyarrow go through it. Nothing fails and nothing is counted until fail_call() is called.

   Each call is written to the log before it is made, a line `NAME PATH`; the nth returns the error instead. One that
   `stays` is returned by all later calls that need space, too, as on a disk that is full. */

#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/sendfile.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

static char folder[PATH_MAX];
static size_t folder_length;
static int log_descriptor = -1, wanted_error, stays;
static long wanted;
static atomic_long calls;

int fail_call(long number, int error, int does_stay, const char *below, const char *log) {
    snprintf(folder, sizeof folder, "%s", below);
    wanted = number, wanted_error = error, stays = does_stay;
    log_descriptor = (int)syscall(SYS_openat, AT_FDCWD, log, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
    folder_length = strlen(folder);
    return log_descriptor;
}

static int fails(const char *name, const char *path, int needs_space) {
    char line[PATH_MAX + 64];
    long number = atomic_fetch_add(&calls, 1) + 1;
    int length = snprintf(line, sizeof line, "%s %s\n", name, path);
    syscall(SYS_write, log_descriptor, line, (size_t)length);
    if (number == wanted || (stays && wanted && number > wanted && needs_space)) {
        errno = wanted_error;
        return 1;
    }
    return 0;
}

static int of_descriptor(char *path, int descriptor) {
    char link[64];
    snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
    ssize_t length = readlink(link, path, PATH_MAX - 1);
    path[length > 0 ? length : 0] = '\0';
    return length > 0 && path[0] == '/';
}

static int is_below(const char *path) { return strncmp(path, folder, folder_length) == 0; }

static int fails_descriptor(const char *name, int descriptor, int needs_space) {
    char path[PATH_MAX];
    return folder_length && of_descriptor(path, descriptor) && is_below(path) && fails(name, path, needs_space);
}

static int fails_path(const char *name, int at, const char *path, int needs_space) {
    char whole[2 * PATH_MAX] = "";
    if (!folder_length) return 0;
    if (path[0] != '/') {
        if (at == AT_FDCWD ? !getcwd(whole, PATH_MAX) : !of_descriptor(whole, at)) return 0;
        strcat(whole, "/");
    }
    strncat(whole, path, PATH_MAX - 1);
    return is_below(whole) && fails(name, whole, needs_space);
}

#define REAL(result, name, ...)                                                                                        \
    static result (*real)(__VA_ARGS__);                                                                                \
    if (!real) real = (result(*)(__VA_ARGS__))dlsym(RTLD_NEXT, #name)

#define MODE(mode, flags)                                                                                              \
    mode_t mode = 0;                                                                                                   \
    if ((flags) & (O_CREAT | O_TMPFILE)) {                                                                             \
        va_list rest;                                                                                                  \
        va_start(rest, flags);                                                                                         \
        mode = va_arg(rest, mode_t);                                                                                   \
        va_end(rest);                                                                                                  \
    }

#define NAME_OF_OPEN(flags) ((flags) & O_CREAT ? "create" : "open")

#define OPEN(name)                                                                                                     \
    int name(const char *path, int flags, ...) {                                                                       \
        REAL(int, name, const char *, int, ...);                                                                       \
        MODE(mode, flags)                                                                                              \
        return fails_path(NAME_OF_OPEN(flags), AT_FDCWD, path, flags & O_CREAT) ? -1 : real(path, flags, mode);        \
    }
OPEN(open)
OPEN(open64)

#define OPENAT(name)                                                                                                   \
    int name(int at, const char *path, int flags, ...) {                                                               \
        REAL(int, name, int, const char *, int, ...);                                                                  \
        MODE(mode, flags)                                                                                              \
        return fails_path(NAME_OF_OPEN(flags), at, path, flags & O_CREAT) ? -1 : real(at, path, flags, mode);          \
    }
OPENAT(openat)
OPENAT(openat64)

#define FOPEN(name)                                                                                                    \
    FILE *name(const char *path, const char *mode) {                                                                   \
        REAL(FILE *, name, const char *, const char *);                                                                \
        return fails_path(mode[0] == 'r' ? "open" : "create", AT_FDCWD, path, mode[0] != 'r') ? NULL                   \
                                                                                              : real(path, mode);      \
    }
FOPEN(fopen)
FOPEN(fopen64)

DIR *opendir(const char *path) {
    REAL(DIR *, opendir, const char *);
    return fails_path("opendir", AT_FDCWD, path, 0) ? NULL : real(path);
}

#define WITH_DESCRIPTOR(call, result, name, space, parameters, ...)                                                    \
    result name parameters {                                                                                           \
        static result(*real) parameters;                                                                               \
        if (!real) real = (result(*) parameters)dlsym(RTLD_NEXT, #name);                                               \
        return fails_descriptor(call, fd, space) ? -1 : real(__VA_ARGS__);                                             \
    }
WITH_DESCRIPTOR("read", ssize_t, read, 0, (int fd, void *to, size_t size), fd, to, size)
WITH_DESCRIPTOR("read", ssize_t, pread, 0, (int fd, void *to, size_t size, off_t at), fd, to, size, at)
WITH_DESCRIPTOR("read", ssize_t, pread64, 0, (int fd, void *to, size_t size, off64_t at), fd, to, size, at)
WITH_DESCRIPTOR("read", ssize_t, readv, 0, (int fd, const struct iovec *to, int count), fd, to, count)
WITH_DESCRIPTOR("write", ssize_t, write, 1, (int fd, const void *from, size_t size), fd, from, size)
WITH_DESCRIPTOR("write", ssize_t, pwrite, 1, (int fd, const void *from, size_t size, off_t at), fd, from, size, at)
WITH_DESCRIPTOR("write", ssize_t, pwrite64, 1, (int fd, const void *from, size_t size, off64_t at), fd, from, size, at)
WITH_DESCRIPTOR("write", ssize_t, writev, 1, (int fd, const struct iovec *from, int count), fd, from, count)
WITH_DESCRIPTOR("write", ssize_t, sendfile, 1, (int fd, int from, off_t *at, size_t size), fd, from, at, size)
WITH_DESCRIPTOR("write", ssize_t, sendfile64, 1, (int fd, int from, off64_t *at, size_t size), fd, from, at, size)
WITH_DESCRIPTOR("fsync", int, fsync, 1, (int fd), fd)
WITH_DESCRIPTOR("fsync", int, fdatasync, 1, (int fd), fd)
WITH_DESCRIPTOR("ftruncate", int, ftruncate, 1, (int fd, off_t size), fd, size)
WITH_DESCRIPTOR("ftruncate", int, ftruncate64, 1, (int fd, off64_t size), fd, size)
WITH_DESCRIPTOR("ftruncate", int, fallocate, 1, (int fd, int how, off_t at, off_t size), fd, how, at, size)
WITH_DESCRIPTOR("ftruncate", int, fallocate64, 1, (int fd, int how, off64_t at, off64_t size), fd, how, at, size)
WITH_DESCRIPTOR("lock", int, flock, 0, (int fd, int how), fd, how)
WITH_DESCRIPTOR("chmod", int, fchmod, 0, (int fd, mode_t mode), fd, mode)
WITH_DESCRIPTOR("utime", int, futimens, 0, (int fd, const struct timespec times[2]), fd, times)

ssize_t copy_file_range(int from, off64_t *at, int fd, off64_t *to, size_t size, unsigned flags) {
    REAL(ssize_t, copy_file_range, int, off64_t *, int, off64_t *, size_t, unsigned);
    return fails_descriptor("write", fd, 1) ? -1 : real(from, at, fd, to, size, flags);
}

#define MMAP(name)                                                                                                     \
    void *name(void *at, size_t size, int how, int flags, int fd, off_t offset) {                                      \
        REAL(void *, name, void *, size_t, int, int, int, off_t);                                                      \
        return fd >= 0 && fails_descriptor("mmap", fd, 0) ? MAP_FAILED : real(at, size, how, flags, fd, offset);       \
    }
MMAP(mmap)
MMAP(mmap64)

#define WITH_PATH(call, name, space, parameters, at, path, ...)                                                        \
    int name parameters {                                                                                              \
        static int(*real) parameters;                                                                                  \
        if (!real) real = (int(*) parameters)dlsym(RTLD_NEXT, #name);                                                  \
        return fails_path(call, at, path, space) ? -1 : real(__VA_ARGS__);                                             \
    }
WITH_PATH("rename", rename, 1, (const char *from, const char *to), AT_FDCWD, to, from, to)
WITH_PATH("rename", renameat, 1, (int a, const char *from, int b, const char *to), b, to, a, from, b, to)
WITH_PATH("link", link, 1, (const char *from, const char *to), AT_FDCWD, to, from, to)
WITH_PATH("link", symlink, 1, (const char *from, const char *to), AT_FDCWD, to, from, to)
WITH_PATH("unlink", unlink, 0, (const char *path), AT_FDCWD, path, path)
WITH_PATH("unlink", remove, 0, (const char *path), AT_FDCWD, path, path)
WITH_PATH("unlink", unlinkat, 0, (int at, const char *path, int flags), at, path, at, path, flags)
WITH_PATH("unlink", rmdir, 0, (const char *path), AT_FDCWD, path, path)
WITH_PATH("mkdir", mkdir, 1, (const char *path, mode_t mode), AT_FDCWD, path, path, mode)
WITH_PATH("mkdir", mkdirat, 1, (int at, const char *path, mode_t mode), at, path, at, path, mode)
WITH_PATH("truncate", truncate, 1, (const char *path, off_t size), AT_FDCWD, path, path, size)
WITH_PATH("truncate", truncate64, 1, (const char *path, off64_t size), AT_FDCWD, path, path, size)
WITH_PATH("chmod", chmod, 0, (const char *path, mode_t mode), AT_FDCWD, path, path, mode)
WITH_PATH("stat", stat, 0, (const char *path, struct stat *found), AT_FDCWD, path, path, found)
WITH_PATH("stat", stat64, 0, (const char *path, struct stat64 *found), AT_FDCWD, path, path, found)
WITH_PATH("stat", lstat, 0, (const char *path, struct stat *found), AT_FDCWD, path, path, found)
WITH_PATH("stat", lstat64, 0, (const char *path, struct stat64 *found), AT_FDCWD, path, path, found)
