#include <iostream>

#include "tools/commands.h"

int main(int argc, char** argv) {
  return orient::RunProgram(orient::MakeCommands(), std::vector<std::string>(argv + 1, argv + argc),
                            std::cout, std::cerr);
}
