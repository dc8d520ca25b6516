#include "tools/console/interruption.h"

#include <fmt/format.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

#include "tools/console/run_output.h"

namespace orient {
namespace {

std::mutex advice_mutex;
std::string advice;

bool IsIgnored(int signal) {
  struct sigaction now = {};
  return sigaction(signal, nullptr, &now) == 0 && now.sa_handler == SIG_IGN;
}

void Tell() {
  std::string text;
  {
    const std::lock_guard lock(advice_mutex);
    if (advice.empty()) return;
    text = "interrupted; " + advice;
  }
  const char* line_start = isatty(STDERR_FILENO) == 1 ? kEraseLine : "";
  std::fprintf(stderr, "%sorient: %s\n", line_start, text.c_str());
  std::fflush(stderr);
  LogLine(text);
}

// In a thread of its own, where anything may be called, unlike in a handler.
void Wait(sigset_t awaited) {
  int signal = 0;
  if (sigwait(&awaited, &signal) != 0) return;
  Tell();
  std::signal(signal, SIG_DFL);
  pthread_sigmask(SIG_UNBLOCK, &awaited, nullptr);
  std::raise(signal);
}

}  // namespace

void WatchForInterruption() {
  sigset_t awaited;
  sigemptyset(&awaited);
  for (const int signal : {SIGINT, SIGTERM})
    if (!IsIgnored(signal)) sigaddset(&awaited, signal);
  sigset_t before;
  if (pthread_sigmask(SIG_BLOCK, &awaited, &before) != 0) return;
  try {
    std::thread(Wait, awaited).detach();
  } catch (const std::exception&) {  // no thread: the signals end the program without a word
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
  }
}

void SetWhatToDoAfterInterruption(std::string what) {
  const std::lock_guard lock(advice_mutex);
  advice = std::move(what);
}

}  // namespace orient
