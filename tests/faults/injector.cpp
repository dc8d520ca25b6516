// Preloaded into the program (LD_PRELOAD): makes the n-th call of a kind to the operating system
// fail, from whatever library, or kills the program there. Deterministic on one thread.
//
//   ORIENT_FAULT_FOLDER  only files below it count
//   ORIENT_FAULT_KIND    write: open for writing, write, truncate, flush, close, rename, make a
//                        folder; read: open for reading, read, list a folder; memory: allocations
//                        of 1 MB and more; kill: as write, and remove. The program dies there, with
//                        half of what it writes in the file.
//   ORIENT_FAULT_AT      number of the call that fails, from 1; 0: none
//   ORIENT_FAULT_ON      1: all later calls fail, too
//   ORIENT_FAULT_TRACE   set: the call stack of a failing call is printed on standard error
//   ORIENT_FAULT_COUNT   file to which the number of calls of each kind is written at the end
//   ORIENT_FAULT_PLACES  file to which a line per call is written, "kind place"; calls with equal
//                        call stacks have the same place
//   ORIENT_FAULT_UNFLUSHED file to which a line per file is written that a power cut could lose: it
//                        was renamed before its contents were flushed, or its folder was not
//                        flushed after the last rename
//   ORIENT_FAULT_NO_LOCKS  set: the file system has no locks, like NFS without its lock daemon
//
// Nothing is really flushed to the disk: this would only take time, as the machine does not fail.
#include <dirent.h>
#include <dlfcn.h>
#include <execinfo.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <utility>

extern "C" {
// NOLINTBEGIN(bugprone-reserved-identifier): glibc's own
void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* memory, size_t size);
void* __libc_memalign(size_t alignment, size_t size);
// NOLINTEND(bugprone-reserved-identifier)
}

namespace {

constexpr int kMostFiles = 4096;
constexpr size_t kMostPlaces = 1 << 16;  // per kind; later calls are not recorded
constexpr size_t kLarge = size_t{1} << 20;
enum Kind : char { kWrite, kRead, kMemory, kKill, kNone };
constexpr std::array kNames = {"write", "read", "memory", "kill"};
enum Watch : char { kNot, kForReading, kForWriting };

struct Plan {
  Kind kind = kNone;
  long at = 0;
  bool on = false;
  bool tells_places = false, tells_losses = false;
  const char* folder = nullptr;
};

Plan plan;
std::array<std::atomic<long>, kNames.size()> calls{};
std::array<std::atomic<Watch>, kMostFiles> watched{};
std::array<std::array<size_t, kMostPlaces>, kNames.size()> places{};

// What a power cut could lose. Files and folders are known by device and inode.
struct Unflushed {
  using Id = std::pair<dev_t, ino_t>;

  std::mutex mutex;
  std::set<Id> files;                   // written since they were flushed
  std::map<Id, std::string> folders;    // with the file that was renamed last
  std::set<std::string> renamed_early;  // before their contents were flushed

  static Id IdOf(const struct stat& status) { return {status.st_dev, status.st_ino}; }

  void Wrote(int file) {
    struct stat status {};
    if (fstat(file, &status) != 0 || !S_ISREG(status.st_mode)) return;
    const std::lock_guard lock(mutex);
    files.insert(IdOf(status));
  }
  void Flushed(int file) {
    struct stat status {};
    if (fstat(file, &status) != 0) return;
    const std::lock_guard lock(mutex);
    files.erase(IdOf(status));
    folders.erase(IdOf(status));
  }
  // Its inode may become another file's.
  void Removed(const char* path) {
    struct stat status {};
    if (lstat(path, &status) != 0 || status.st_nlink > 1) return;
    const std::lock_guard lock(mutex);
    files.erase(IdOf(status));
  }
  void Renamed(const char* to) {
    struct stat file {
    }, folder{};
    if (stat(to, &file) != 0 || !S_ISREG(file.st_mode)) return;
    if (stat(std::filesystem::path(to).parent_path().c_str(), &folder) != 0) return;
    const std::lock_guard lock(mutex);
    if (files.contains(IdOf(file))) renamed_early.insert(to);
    folders[IdOf(folder)] = to;
  }
};

// Never destroyed: files are written until the very end.
Unflushed& Losses() {
  static Unflushed& losses = *new Unflushed;
  return losses;
}

template <class Function>
Function Real(Function, const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}
#define REAL(function) Real(&(function), #function)

bool Below(const char* path) {
  return plan.folder != nullptr && path != nullptr &&
         std::strncmp(path, plan.folder, std::strlen(plan.folder)) == 0;
}

Watch WatchOf(int file) {
  return file >= 0 && file < kMostFiles ? watched[static_cast<size_t>(file)].load() : kNot;
}

void SetWatch(int file, bool below, bool writes) {
  if (file >= 0 && file < kMostFiles)
    watched[static_cast<size_t>(file)] = !below ? kNot : writes ? kForWriting : kForReading;
}

// Hash of the return addresses on the stack (FNV-1a).
size_t Place() {
  std::array<void*, 64> frames{};
  const int depth = backtrace(frames.data(), frames.size());
  size_t place = 14695981039346656037U;
  for (int i = 0; i < depth; ++i)
    place = (place ^ reinterpret_cast<size_t>(frames[static_cast<size_t>(i)])) * 1099511628211U;
  return place;
}

bool IsTurn(Kind kind) {
  const long call = ++calls[kind];
  if (plan.tells_places && static_cast<size_t>(call) <= kMostPlaces)
    places[kind][static_cast<size_t>(call) - 1] = Place();
  if (plan.kind != kind || plan.at <= 0 || (plan.on ? call < plan.at : call != plan.at))
    return false;
  if (std::getenv("ORIENT_FAULT_TRACE") != nullptr) {
    std::array<void*, 40> frames{};
    backtrace_symbols_fd(frames.data(), backtrace(frames.data(), frames.size()), STDERR_FILENO);
  }
  return true;
}

// `half`: does what a program that is killed in the middle of the call has done.
template <class Half>
bool FailsWriting(bool concerned, const Half& half) {
  if (!concerned) return false;
  if (IsTurn(kKill)) {
    half();
    kill(getpid(), SIGKILL);
  }
  if (!IsTurn(kWrite)) return false;
  errno = ENOSPC;
  return true;
}

bool FailsWriting(bool concerned) {
  return FailsWriting(concerned, [] {});
}

bool FailsReading(bool concerned) {
  if (!concerned || !IsTurn(kRead)) return false;
  errno = EIO;
  return true;
}

bool FailsAllocating(size_t size) {
  if (size < kLarge || !IsTurn(kMemory)) return false;
  errno = ENOMEM;
  return true;
}

template <class Open>
int OpenFile(const Open& open, const char* path, int flags) {
  const bool below = Below(path), writes = (flags & O_ACCMODE) != O_RDONLY;
  if (writes ? FailsWriting(below && (flags & O_CREAT) != 0) : FailsReading(below)) return -1;
  const int file = open();
  SetWatch(file, below, writes);
  return file;
}

mode_t ModeOf(int flags, va_list arguments) {
  return (flags & O_CREAT) != 0 ? static_cast<mode_t>(va_arg(arguments, int)) : 0;
}

template <class Open>
FILE* OpenStream(const Open& open, const char* path, const char* mode) {
  const bool below = Below(path), writes = std::strpbrk(mode, "wa+") != nullptr;
  if (writes ? FailsWriting(below) : FailsReading(below)) return nullptr;
  FILE* stream = open(path, mode);
  if (stream != nullptr) SetWatch(fileno(stream), below, writes);
  return stream;
}

void NoteWriting(int file) {
  if (plan.tells_losses && WatchOf(file) != kNot) Losses().Wrote(file);
}

int Flush(int file) {
  if (FailsWriting(WatchOf(file) != kNot)) return -1;
  if (plan.tells_losses) Losses().Flushed(file);
  return 0;
}

int NoteRename(int result, const char* to) {
  if (plan.tells_losses && result == 0 && Below(to)) Losses().Renamed(to);
  return result;
}

// Makes ferror() report an error. Returns the number of bytes.
size_t SetError(FILE* stream) {
  stream->_flags |= 0x20;  // glibc's _IO_ERR_SEEN
  return 0;
}

__attribute__((constructor)) void Read() {
  const char* kind = std::getenv("ORIENT_FAULT_KIND");
  const char* at = std::getenv("ORIENT_FAULT_AT");
  const char* on = std::getenv("ORIENT_FAULT_ON");
  plan.folder = std::getenv("ORIENT_FAULT_FOLDER");
  plan.at = at == nullptr ? 0 : std::atol(at);
  plan.on = on != nullptr && on[0] == '1';
  plan.tells_places = std::getenv("ORIENT_FAULT_PLACES") != nullptr;
  plan.tells_losses = std::getenv("ORIENT_FAULT_UNFLUSHED") != nullptr;
  if (kind == nullptr) return;
  for (size_t i = 0; i < kNames.size(); ++i)
    if (std::strcmp(kind, kNames[i]) == 0) plan.kind = static_cast<Kind>(i);
}

void TellCounts(FILE* file) {
  for (size_t i = 0; i < kNames.size(); ++i)
    std::fprintf(file, "%s %ld\n", kNames[i], calls[i].load());
}

void TellPlaces(FILE* file) {
  for (size_t i = 0; i < kNames.size(); ++i)
    for (size_t call = 0; call < std::min(kMostPlaces, static_cast<size_t>(calls[i])); ++call)
      std::fprintf(file, "%s %zx\n", kNames[i], places[i][call]);
}

void TellLosses(FILE* file) {
  for (const std::string& name : Losses().renamed_early)
    std::fprintf(file, "%s: renamed before it was flushed\n", name.c_str());
  for (const auto& [id, name] : Losses().folders)
    std::fprintf(file, "%s: its folder was not flushed\n", name.c_str());
}

void TellTo(const char* name, void (*tell)(FILE*)) {
  const char* path = std::getenv(name);
  if (path == nullptr) return;
  if (FILE* file = std::fopen(path, "w")) {
    tell(file);
    std::fclose(file);
  }
}

__attribute__((destructor)) void Tell() {
  plan.kind = kNone;
  TellTo("ORIENT_FAULT_COUNT", TellCounts);
  TellTo("ORIENT_FAULT_PLACES", TellPlaces);
  TellTo("ORIENT_FAULT_UNFLUSHED", TellLosses);
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = ModeOf(flags, arguments);
  va_end(arguments);
  return OpenFile([&] { return REAL(open)(path, flags, mode); }, path, flags);
}

int open64(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = ModeOf(flags, arguments);
  va_end(arguments);
  return OpenFile([&] { return REAL(open64)(path, flags, mode); }, path, flags);
}

FILE* fopen(const char* path, const char* mode) { return OpenStream(REAL(fopen), path, mode); }
FILE* fopen64(const char* path, const char* mode) { return OpenStream(REAL(fopen64), path, mode); }

DIR* opendir(const char* path) { return FailsReading(Below(path)) ? nullptr : REAL(opendir)(path); }

int close(int file) {
  const bool fails = FailsWriting(WatchOf(file) == kForWriting);
  SetWatch(file, false, false);
  const int result = REAL(close)(file);
  if (fails) errno = ENOSPC;
  return fails ? -1 : result;
}

int fclose(FILE* stream) {
  const bool fails = FailsWriting(WatchOf(fileno(stream)) == kForWriting);
  SetWatch(fileno(stream), false, false);
  const int result = REAL(fclose)(stream);
  if (fails) errno = ENOSPC;
  return fails ? EOF : result;
}

ssize_t write(int file, const void* bytes, size_t size) {
  const auto real = REAL(write);
  if (FailsWriting(WatchOf(file) != kNot, [&] { real(file, bytes, size / 2); })) return -1;
  NoteWriting(file);
  return real(file, bytes, size);
}

ssize_t pwrite64(int file, const void* bytes, size_t size, off64_t at) {
  const auto real = REAL(pwrite64);
  if (FailsWriting(WatchOf(file) != kNot, [&] { real(file, bytes, size / 2, at); })) return -1;
  NoteWriting(file);
  return real(file, bytes, size, at);
}

size_t fwrite(const void* bytes, size_t size, size_t count, FILE* stream) {
  if (FailsWriting(WatchOf(fileno(stream)) != kNot)) return SetError(stream);
  NoteWriting(fileno(stream));
  return REAL(fwrite)(bytes, size, count, stream);
}

int fflush(FILE* stream) {
  if (FailsWriting(stream != nullptr && WatchOf(fileno(stream)) == kForWriting)) return EOF;
  return REAL(fflush)(stream);
}

ssize_t read(int file, void* bytes, size_t size) {
  if (FailsReading(WatchOf(file) != kNot)) return -1;
  return REAL(read)(file, bytes, size);
}

ssize_t pread64(int file, void* bytes, size_t size, off64_t at) {
  if (FailsReading(WatchOf(file) != kNot)) return -1;
  return REAL(pread64)(file, bytes, size, at);
}

size_t fread(void* bytes, size_t size, size_t count, FILE* stream) {
  if (FailsReading(WatchOf(fileno(stream)) != kNot)) return SetError(stream);
  return REAL(fread)(bytes, size, count, stream);
}

int ftruncate64(int file, off64_t size) {
  if (FailsWriting(WatchOf(file) != kNot)) return -1;
  NoteWriting(file);
  return REAL(ftruncate64)(file, size);
}

int fsync(int file) { return Flush(file); }
int fdatasync(int file) { return Flush(file); }

int rename(const char* from, const char* to) {
  if (FailsWriting(Below(to))) return -1;
  return NoteRename(REAL(rename)(from, to), to);
}

int renameat2(int from_folder, const char* from, int to_folder, const char* to,
              unsigned int flags) {
  if (FailsWriting(Below(to))) return -1;
  return NoteRename(REAL(renameat2)(from_folder, from, to_folder, to, flags), to);
}

int mkdir(const char* path, mode_t mode) {
  if (FailsWriting(Below(path))) return -1;
  return REAL(mkdir)(path, mode);
}

int flock(int file, int operation) {
  if (std::getenv("ORIENT_FAULT_NO_LOCKS") == nullptr) return REAL(flock)(file, operation);
  errno = ENOLCK;
  return -1;
}

int unlink(const char* path) {
  if (Below(path) && IsTurn(kKill)) kill(getpid(), SIGKILL);
  if (plan.tells_losses && Below(path)) Losses().Removed(path);
  return REAL(unlink)(path);
}

void* malloc(size_t size) { return FailsAllocating(size) ? nullptr : __libc_malloc(size); }

void* calloc(size_t count, size_t size) {
  return FailsAllocating(count * size) ? nullptr : __libc_calloc(count, size);
}

void* realloc(void* memory, size_t size) {
  return FailsAllocating(size) ? nullptr : __libc_realloc(memory, size);
}

void* aligned_alloc(size_t alignment, size_t size) {
  return FailsAllocating(size) ? nullptr : __libc_memalign(alignment, size);
}

int posix_memalign(void** memory, size_t alignment, size_t size) {
  if (FailsAllocating(size)) return ENOMEM;
  *memory = __libc_memalign(alignment, size);
  return *memory == nullptr ? ENOMEM : 0;
}

}  // extern "C"
