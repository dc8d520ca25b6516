// Ctrl-C (SIGINT) and SIGTERM: the program says how to go on, and ends by the signal as it would
// have without a word.
#pragma once

#include <string>

namespace orient {

// To be called once, by main, before any other thread begins. A signal that the process was started
// to ignore stays ignored.
void WatchForInterruption();

// What is said if one comes from now on, after "interrupted; "; empty: nothing is.
void SetWhatToDoAfterInterruption(std::string advice);

}  // namespace orient
