#include <csignal>
#include <iostream>

#include "tools/commands/commands.h"
#include "tools/commands/memory.h"
#include "tools/console/interruption.h"

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error of writing
  orient::WatchForInterruption();
  orient::KeepReleasedMemory();
  orient::BoundBlockCache();
  orient::AllowManyFiles();
  return orient::RunProgram(orient::MakeCommands(), std::vector<std::string>(argv + 1, argv + argc),
                            std::cout, std::cerr);
}
