#include <iostream>

#include "tools/commands.h"
#include "tools/memory.h"

int main(int argc, char** argv) {
  orient::KeepFreedMemory();
  return orient::RunProgram(orient::MakeCommands(), std::vector<std::string>(argv + 1, argv + argc),
                            std::cout, std::cerr);
}
